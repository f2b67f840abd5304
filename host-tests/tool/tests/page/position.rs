//! What the page shows of a sensor in a known position: the large angles, the status in words, the drawing.

use crate::browser::Browser;
use crate::server::Running;
use bench::motion::Motion;
use bench::scene::{Axes, Scene};
use bench::{Bus, BusRate, Device, Flash, Geometry, NodeType};
use plumbline::measure::Reading;
use plumbline::time::Instant;
use std::net::TcpListener;
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use virtual_sensor::server::{Clock, Events, Server, tcp};

/// The corners of the faces that are drawn.
const POINTS: &str = "[...document.querySelectorAll('#box polygon')].map((face) => face.getAttribute('points') ?? '')";

/// A motion that rests in the position that a test says: X and Y in degrees.
#[derive(Clone)]
struct Held(Arc<Mutex<(f64, f64)>>);

impl Held {
    fn turn(&self, x: f64, y: f64) {
        *self.0.lock().expect("no panic") = (x, y);
    }
}

impl Motion for Held {
    fn reading(&mut self, now: Instant) -> Reading {
        let (x, y) = *self.0.lock().expect("no panic");
        let mut scene = Scene::tilt(x, y, Axes::Two).expect("a position");
        scene.reading(now)
    }
}

/// An IS2 in real time, which a test turns.
struct Sensor {
    port: String,
    position: Held,
    events: Events,
    thread: Option<JoinHandle<()>>,
}

impl Sensor {
    fn at(x: f64, y: f64) -> Self {
        let position = Held(Arc::new(Mutex::new((x, y))));
        let motion = Box::new(position.clone());
        let (sender, started) = channel();
        let thread = thread::spawn(move || {
            let node_type = NodeType::find("is2").expect("a product");
            let mut bus = Bus::new(BusRate::Follow);
            let flash = Flash::blank(Geometry::STM32F103);
            let id = bus.attach(Device::new(&node_type, 1, flash, motion));
            let (server, events) = Server::new(bus, id, Clock::Computer, None, None);
            let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
            let address = listener.local_addr().expect("an address");
            tcp::serve(listener, events.clone()).expect("a thread");
            let port = format!("slcan://{address}");
            sender.send((port, events)).expect("the test waits");
            server.run().expect("the server runs");
        });
        let (port, events) = started.recv().expect("the sensor starts");
        Self {
            port,
            position,
            events,
            thread: Some(thread),
        }
    }

    /// A page that is connected to it.
    fn connected(&self, server: &Running) -> Option<Browser> {
        let browser = Browser::open(&server.url)?;
        browser.wait("document.getElementById('rate').options.length > 10");
        browser.write("#port", &self.port);
        browser.choose("#rate", "125");
        browser.choose("#protocol", "fsc");
        browser.write("#address", "300");
        browser.connect();
        Some(browser)
    }
}

impl Drop for Sensor {
    fn drop(&mut self) {
        self.events.stop();
        let ended = self.thread.take().expect("it runs").join();
        assert!(ended.is_ok() || thread::panicking(), "the sensor ends");
    }
}

#[track_caller]
fn shows_angles(browser: &Browser, x: &str, y: &str) {
    for (id, angle) in [("angle-0", x), ("angle-1", y)] {
        browser.wait(&format!(
            "document.getElementById('{id}')?.textContent === '{angle}'"
        ));
    }
}

#[test]
fn page_shows_angles_with_two_decimals_and_the_error_in_words() {
    let sensor = Sensor::at(12.5, -5.0);
    let server = Running::new("");
    let Some(browser) = sensor.connected(&server) else {
        return;
    };
    shows_angles(&browser, "12.50", "-5.00");
    let condition = "document.getElementById('condition')";
    let is_bad = format!("{condition}.classList.contains('bad')");
    browser.wait(&format!("{condition}.textContent.includes('no error')"));
    assert_eq!(browser.value(&is_bad), false);
    // Beyond the range of X.
    sensor.position.turn(89.0, 0.0);
    for (language, words) in [
        ("en", "the X axis failed or is out of range (SensorErrorX)"),
        (
            "de",
            "die X-Achse ist gestört oder außerhalb ihres Bereichs (SensorErrorX)",
        ),
    ] {
        browser.choose("#language", language);
        browser.wait(&format!("{condition}.textContent.includes('{words}')"));
        assert_eq!(browser.value(&is_bad), true, "{language}");
    }
    sensor.position.turn(0.0, 7.25);
    shows_angles(&browser, "0.00", "7.25");
    browser.wait(&format!("{condition}.textContent.includes('kein Fehler')"));
    assert_eq!(browser.value(&is_bad), false);
}

#[test]
fn drawing_turns_with_the_sensor() {
    let sensor = Sensor::at(20.0, 10.0);
    let server = Running::new("");
    let Some(browser) = sensor.connected(&server) else {
        return;
    };
    let faces = format!("{POINTS}.filter((points) => points.split(' ').length === 4)");
    let mut pictures = Vec::new();
    for (x, y) in [(20.0, 10.0), (-20.0, 10.0), (-20.0, -10.0)] {
        sensor.position.turn(x, y);
        shows_angles(&browser, &format!("{x:.2}"), &format!("{y:.2}"));
        browser.wait(&format!(
            "document.getElementById('box-title').textContent.includes('angle-x {x:.1} deg, angle-y {y:.1} deg')"
        ));
        assert_eq!(browser.value(&format!("{faces}.length")), 6);
        let picture = browser.text(&format!("{POINTS}.join(' / ')"));
        assert!(!pictures.contains(&picture), "{x} {y}: {picture}");
        pictures.push(picture);
    }
}

#[test]
fn drawing_shows_a_turned_corner_at_its_place() {
    let server = Running::new("");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    let (turn, tilt) = (35_f64.to_radians(), 20_f64.to_radians());
    let (sine, cosine) = 30_f64.to_radians().sin_cos();
    // The viewer looks along `ahead`, 35 deg to the left of the Y axis and 20 deg down; right, down and ahead are the axes of the picture.
    let level = [-turn.sin(), turn.cos()];
    let right = [turn.cos(), turn.sin(), 0.0];
    let down = [-tilt.sin() * level[0], -tilt.sin() * level[1], -tilt.cos()];
    let ahead = [tilt.cos() * level[0], tilt.cos() * level[1], -tilt.sin()];
    for (corner, angles, place) in [
        // The X axis moves down, the Y axis moves up.
        ("[1, 0, 0]", "[30, 0]", [cosine, 0.0, -sine]),
        ("[0, 1, 0]", "[30, 0]", [0.0, 1.0, 0.0]),
        ("[0, 0, 1]", "[30, 0]", [sine, 0.0, cosine]),
        ("[1, 0, 0]", "[0, 30]", [1.0, 0.0, 0.0]),
        ("[0, 1, 0]", "[0, 30]", [0.0, cosine, sine]),
        ("[0, 0, 1]", "[0, 30]", [0.0, -sine, cosine]),
        ("[1, 0, 0]", "[30]", [cosine, 0.0, sine]),
        ("[0, 1, 0]", "[30]", [0.0, 1.0, 0.0]),
    ] {
        let shown = browser.script(&format!(
            "return import('/attitude.js').then(({{ project }}) => project({corner}, {angles}))"
        ));
        for (number, axis) in [right, down, ahead].iter().enumerate() {
            let along: f64 = axis.iter().zip(place).map(|(one, other)| one * other).sum();
            let shown = shown[number].as_f64().expect("a number");
            assert!(
                (shown - along).abs() < 1e-9,
                "{corner} {angles} {number}: {shown}, not {along}"
            );
        }
    }
}
