//! The delay of the angle, from the motion to the start of the frame: on a ramp, with requests at all times between two samples. The tests
//! compare sensors built for the PC and a flashed image with the delay that the page of the product states.

use bench::motion::Motion;
use bench::{AdapterId, Bus, BusRate};
use can_wire::text::frame;
use plumbline::can::{BitRate, Frame, standard};
use plumbline::measure::low_pass::Kind;
use plumbline::measure::{I32x3, ONE_G, PATH_DELAY, Reading, fusion};
use plumbline::time::{Duration, Instant, after, millis};

/// The rate of the ramp about Y in deg/s, and its first angle in deg.
const SLOPE: f64 = 20.0;
const FIRST: f64 = -40.0;

/// The number of requests, and the time between two of them: all tenths of a millisecond between two samples.
const NUMBER: u32 = 300;
const PERIOD: Duration = Duration::from_ticks(7_300);

/// A second in picoseconds.
const SECOND: f64 = 1e12;

/// The ramp, with its start in s.
#[derive(Clone, Copy)]
struct Ramp(f64);

impl Ramp {
    /// The angle in deg at a time in s.
    fn angle(self, time: f64) -> f64 {
        FIRST + SLOPE * (time - self.0).max(0.0)
    }
}

impl Motion for Ramp {
    fn reading(&mut self, now: Instant) -> Reading {
        let time = now.ticks() as f64 / 1e6;
        let (x, z) = self.angle(time).to_radians().sin_cos();
        let one_g = |part: f64| (part * f64::from(ONE_G)).round() as i32;
        let rate = if time < self.0 { 0.0 } else { SLOPE };
        Reading {
            acceleration: I32x3 {
                x: one_g(-x),
                y: 0,
                z: one_g(z),
            },
            angular_rate: I32x3 {
                x: 0,
                y: (rate * 65_536.0) as i32,
                z: 0,
            },
            temperature: 25_00,
            ..Reading::default()
        }
    }
}

/// How a product tells its angle about Y.
pub struct Product {
    /// The name of the product in the catalogue.
    pub name: &'static str,
    /// The start of the ramp in s: the sensor is on-line, and its parameters are written.
    ready: f64,
    /// The first request in s: the slowest filter has settled on the ramp.
    settled: f64,
    /// The frames of the master before the parameters are written.
    start: &'static [&'static str],
    /// The answer to a write begins with this.
    written: &'static str,
    /// The frames of the master behind it.
    operate: &'static [&'static str],
    /// The request of an angle, and the place of the angle in the answer, an i16 or i32 in 0.01 deg.
    request: &'static str,
    answer: u16,
    place: std::ops::Range<usize>,
}

/// It detects the bit rate, so the status is 02h (AutobaudDetection).
const IS2: Product = Product {
    name: "is2",
    ready: 1.0,
    settled: 2.2,
    start: &["300#"],
    written: "301#2702",
    operate: &[],
    request: "300#00",
    answer: 0x301,
    place: 2..4,
};

const JN2101: Product = Product {
    name: "jn2101",
    ready: 1.0,
    settled: 2.7,
    start: &[],
    written: "58A#60",
    operate: &["000#010A"],
    request: "080#",
    answer: 0x18A,
    place: 0..2,
};

const IMS360: Product = Product {
    name: "ims360",
    ready: 1.0,
    settled: 2.2,
    start: &[],
    written: "5B2#60",
    operate: &["000#0132"],
    request: "1B2#R8",
    answer: 0x1B2,
    place: 0..4,
};

/// Explicit and poll, without limits of time.
const TILTIX080: Product = Product {
    name: "tiltix080",
    ready: 3.0,
    settled: 4.2,
    start: &[
        "5FE#0A4B0301030A",
        "5FC#0A100501090000",
        "5FC#0A100502090000",
    ],
    written: "5FB#0A90",
    operate: &[],
    request: "5FD#",
    answer: 0x3FF,
    place: 0..2,
};

/// A product with some parameters.
pub struct Setting {
    /// The product that is set.
    pub product: &'static Product,
    /// The requests that write the parameters.
    writes: &'static [&'static str],
    /// The delay in ms that the page of the product states.
    stated: f64,
}

/// The stated delay of a low-pass in ms.
const fn low_pass(kind: Kind, cutoff: u16) -> f64 {
    (PATH_DELAY + kind.delay(cutoff)) as f64 / 1e3
}

const fn setting(
    product: &'static Product,
    writes: &'static [&'static str],
    stated: f64,
) -> Setting {
    Setting {
        product,
        writes,
        stated,
    }
}

/// Without a low-pass: the delay of the path.
pub const OFF: Setting = setting(&IMS360, &["632#2F10310100000000"], 16.7);

/// The Kalman filter as delivered.
pub const FUSION: Setting = setting(&IMS360, &["632#2F10310201000000"], fusion::LAG as f64 / 1e3);

/// IS2 without digital filter.
pub const IS2_OFF: Setting = setting(&IS2, &["300#27E80300"], 27.6);
/// JN2101 without filter.
pub const JN2101_OFF: Setting = setting(&JN2101, &["60A#2F43200000000000"], 17.0);
/// TILTIX without filters.
pub const TILTIX080_OFF: Setting = setting(
    &TILTIX080,
    &["5FC#0A1065018400", "5FC#0A106501850000"],
    16.7,
);

/// All settings whose delays are measured.
pub const SETTINGS: [Setting; 18] = [
    OFF,
    FUSION,
    // 3110h:01 and 3111h
    setting(
        &IMS360,
        &["632#2F10310101000000", "632#2B11310010270000"],
        low_pass(Kind::Butterworth, 10_000),
    ),
    setting(
        &IMS360,
        &["632#2F10310101000000", "632#2B113100A8610000"],
        low_pass(Kind::Butterworth, 25_000),
    ),
    setting(
        &IMS360,
        &["632#2F10310102000000", "632#2B113100D0070000"],
        low_pass(Kind::CriticallyDamped, 2_000),
    ),
    setting(
        &IMS360,
        &["632#2F10310102000000", "632#2B113100401F0000"],
        low_pass(Kind::CriticallyDamped, 8_000),
    ),
    // 27h
    IS2_OFF,
    setting(&IS2, &["300#27102701"], 16.7 + 816.0 / 10.0),
    setting(&IS2, &[], 208.0),
    // 2043h
    JN2101_OFF,
    setting(&JN2101, &["60A#2F43200001000000"], 47.0),
    setting(&JN2101, &["60A#2F43200002000000"], 87.0),
    setting(&JN2101, &["60A#2F43200003000000"], 407.0),
    setting(&JN2101, &["60A#2F43200004000000"], 807.0),
    // 84h and 85h
    TILTIX080_OFF,
    setting(
        &TILTIX080,
        &["5FC#0A1065018464", "5FC#0A106501850000"],
        49.0,
    ),
    setting(
        &TILTIX080,
        &["5FC#0A10650184FA", "5FC#0A106501850000"],
        14.2 + 0.35 * 250.0,
    ),
    setting(
        &TILTIX080,
        &["5FC#0A1065018400", "5FC#0A10650185DE03"],
        84.0,
    ),
];

/// The largest difference in ms from the stated delay: the sensor for the PC and the image differ a little.
const TOLERANCE: f64 = 1.0;

/// The largest difference in ms between the delay of a frame and the stated one: half of the 5 ms between two samples, 3 ms for the
/// conversion of the data rate, which follows the clock of the accelerometer some seconds after the start, the resolution of the angle
/// (0.5 ms on the ramp), and the tolerance.
const SPREAD: f64 = 7.0;

/// The delays of the frames in ms.
#[derive(Clone, Copy, Debug)]
pub struct Delays {
    /// The mean of all frames.
    pub mean: f64,
    /// That of the frame with the newest angle.
    pub shortest: f64,
    /// That of the frame with the oldest angle.
    pub longest: f64,
}

/// Asserts that the delays are the stated one.
///
/// # Panics
/// They are not.
pub fn check(setting: &Setting, measured: Delays) {
    let Setting {
        product,
        writes,
        stated,
    } = setting;
    let name = product.name;
    let Delays {
        mean,
        shortest,
        longest,
    } = measured;
    println!(
        "{name} {writes:?}: {mean:.2} ms ({shortest:.2} to {longest:.2}), stated {stated:.2} ms"
    );
    let is_stated = |delay: f64, tolerance: f64| (delay - stated).abs() < tolerance;
    assert!(
        is_stated(mean, TOLERANCE) && is_stated(shortest, SPREAD) && is_stated(longest, SPREAD),
        "{name} {writes:?}: {measured:?}, stated {stated} ms"
    );
}

/// The delays with a setting. `attach` attaches the product with blank memory.
///
/// # Panics
/// It does not answer.
pub fn delay(setting: &Setting, attach: impl FnOnce(&mut Bus, Box<dyn Motion>)) -> Delays {
    let product = setting.product;
    let ramp = Ramp(product.ready);
    let mut bus = Bus::new(BusRate::Fixed(BitRate::K125));
    attach(&mut bus, Box::new(ramp));
    let tester = bus.adapter();
    bus.open(tester, None, false);
    bus.lead_detection();
    run_until(&mut bus, product.ready - 0.7);
    for request in product.start {
        exchange(&mut bus, tester, request);
    }
    for request in setting.writes {
        let replies = exchange(&mut bus, tester, request);
        let written = replies.iter().any(|it| it.starts_with(product.written));
        assert!(written, "{request}: {replies:?}");
    }
    for request in product.operate {
        exchange(&mut bus, tester, request);
    }
    run_until(&mut bus, product.settled);
    bus.take_log();
    for _ in 0..NUMBER {
        bus.send(tester, frame(product.request));
        run(&mut bus, PERIOD);
    }
    let answer = standard(product.answer);
    let delays: Vec<f64> = bus
        .take_log()
        .into_iter()
        .filter(|logged| logged.frame.id() == answer && !logged.frame.is_remote())
        .map(|logged| {
            let sent = number(&logged.frame.bytes()[product.place.clone()]) / 100.0;
            let time = logged.start as f64 / SECOND;
            (ramp.angle(time) - sent) / SLOPE * 1e3
        })
        .collect();
    assert_eq!(delays.len(), NUMBER as usize);
    Delays {
        mean: delays.iter().sum::<f64>() / f64::from(NUMBER),
        shortest: delays.iter().copied().fold(f64::INFINITY, f64::min),
        longest: delays.iter().copied().fold(0.0, f64::max),
    }
}

/// A signed number, with the lowest byte first.
fn number(bytes: &[u8]) -> f64 {
    match *bytes {
        [a, b] => i16::from_le_bytes([a, b]).into(),
        [a, b, c, d] => i32::from_le_bytes([a, b, c, d]).into(),
        _ => panic!("two or four bytes"),
    }
}

fn run(bus: &mut Bus, time: Duration) {
    let end = after(bus.now(), time);
    bus.run_until(end);
}

fn run_until(bus: &mut Bus, seconds: f64) {
    bus.run_until(Instant::from_ticks((seconds * 1e6) as u64));
}

/// Sends a frame; returns the frames received within 20 ms.
fn exchange(bus: &mut Bus, tester: AdapterId, request: &str) -> Vec<String> {
    bus.take_received(tester);
    bus.send(tester, frame(request));
    run(bus, millis(20));
    let text = |(_, frame): (Instant, Frame)| format!("{frame:?}");
    bus.take_received(tester).into_iter().map(text).collect()
}
