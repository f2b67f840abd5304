//! An article of your own, outside of Plumbline: an IS2 that reports a sensor error beyond 30 deg instead of 85 deg.
//! Run it with `cargo run -p core --example new_article`.

use plumbline::can::{Frame, standard};
use plumbline::fsc::{Article, ArticleNumber, Version};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::model::gemac::is2::{BP_CL, Is2};
use plumbline::node::{Boot, Node};
use plumbline::time::{Instant, after, millis};

/// What 03h and 04h answer, and the range; everything else is as in the article of the classic line.
const MAST_LEVEL: Article = Article {
    name: "mast level",
    number: ArticleNumber::new("XX-00030-01"),
    revision: 2,
    version: Version::Digits {
        major: 0x01,
        minor: 0x00,
    },
    limit: 30_00,
    ..BP_CL
};

/// Bit 4 of the status byte.
const SENSOR_ERROR_X: u8 = 1 << 4;

/// Sends a request and returns the reply.
fn request(sensor: &mut Is2, now: Instant, data: &[u8]) -> Vec<u8> {
    let frame = Frame::data(standard(0x300), data).expect("at most eight bytes");
    sensor.receive(now, &frame);
    while sensor.poll(now).is_some() {}
    let reply = sensor.transmit(now).expect("a reply");
    reply.bytes().to_vec()
}

/// Two seconds at rest, until the low-pass has settled.
fn rest(sensor: &mut Is2, mut now: Instant, acceleration: I32x3) -> Instant {
    let reading = Reading {
        acceleration,
        ..Reading::default()
    };
    for _ in 0..400 {
        now = after(now, millis(5));
        sensor.sample(now, &reading);
        while sensor.poll(now).is_some() {}
    }
    now
}

fn main() {
    let now = Instant::from_ticks(0);
    let mut sensor = Is2::new(&MAST_LEVEL, now, &Boot::default());
    // 31 deg about one axis: sine and cosine in units of 1 g.
    let (sine, cosine) = (31_f64.to_radians().sin(), 31_f64.to_radians().cos());
    let tilted = I32x3 {
        x: (sine * f64::from(ONE_G)) as i32,
        y: 0,
        z: (cosine * f64::from(ONE_G)) as i32,
    };
    let now = rest(&mut sensor, now, tilted);
    // After the first reading, the first frame tells the bit rate; two boot-up messages answer it.
    let boot_up = request(&mut sensor, now, &[0x00]);
    assert_eq!(boot_up[0], 0xFF);
    sensor.transmit(now).expect("the second boot-up message");
    let reply = request(&mut sensor, now, &[0x00]);
    println!("FSC 00h at 31 deg: {reply:02X?}");
    assert_ne!(reply[1] & SENSOR_ERROR_X, 0, "beyond the range");

    let identity = request(&mut sensor, now, &[0x03]);
    println!("FSC 03h, article number and revision: {identity:02X?}");
    assert_eq!(identity[2..6], 3001_u32.to_le_bytes());
}
