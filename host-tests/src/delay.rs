//! The delay of the angle of an IMS360, from the motion to the start of the frame: on a ramp, with requests at all times between two
//! samples. The tests compare a sensor built for the PC and the flashed image with the stated delay.

use bench::motion::Motion;
use bench::{AdapterId, Bus, BusRate};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::measure::low_pass::Kind;
use plumbline::measure::{I32x3, ONE_G, PATH_DELAY, Reading, fusion};
use plumbline::time::{Duration, Instant, after, millis};

/// The rate of the ramp about Y in deg/s, and its first angle in deg.
const SLOPE: f64 = 20.0;
const FIRST: f64 = -40.0;

/// The start of the ramp in s: the sensor is operational.
const START: f64 = 1.0;

/// The first request, in s: the low-pass has settled on the ramp.
const REQUESTS: f64 = 2.2;

/// The number of requests, and the time between two of them: all tenths of a millisecond between two samples.
const NUMBER: u32 = 300;
const PERIOD: Duration = Duration::from_ticks(7_300);

/// Node 50 with its factory identifiers.
const SDO: u16 = 0x632;
const TPDO: u16 = 0x1B2;

/// A second in picoseconds.
const SECOND: f64 = 1e12;

/// The angle in deg at a time in s.
fn angle(time: f64) -> f64 {
    FIRST + SLOPE * (time - START).max(0.0)
}

/// The ramp.
struct Ramp;

impl Motion for Ramp {
    fn reading(&mut self, now: Instant) -> Reading {
        let time = now.ticks() as f64 / 1e6;
        let (x, z) = angle(time).to_radians().sin_cos();
        let one_g = |part: f64| (part * f64::from(ONE_G)).round() as i32;
        let rate = if time < START { 0.0 } else { SLOPE };
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

/// A setting: 3110h:01, 3111h and 3110h:02.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// The type of the low-pass.
    pub kind: u8,
    /// Its cut-off frequency in mHz.
    pub cutoff: u16,
    /// Whether the Kalman filter is on.
    pub fuses: bool,
}

impl Setting {
    const fn low_pass(kind: u8, cutoff: u16) -> Self {
        Self {
            kind,
            cutoff,
            fuses: false,
        }
    }

    /// The stated delay in ms.
    fn stated(self) -> f64 {
        let kind = match self.kind {
            0 => Kind::Off,
            1 => Kind::Butterworth,
            _ => Kind::CriticallyDamped,
        };
        let stated = match self.fuses {
            true => fusion::LAG,
            false => PATH_DELAY + kind.delay(self.cutoff),
        };
        f64::from(stated) / 1e3
    }
}

/// Without a low-pass: the delay of the path.
pub const OFF: Setting = Setting::low_pass(0, 2_000);

/// The Kalman filter.
pub const FUSION: Setting = Setting { fuses: true, ..OFF };

/// All settings whose delays are measured.
pub const SETTINGS: [Setting; 6] = [
    OFF,
    FUSION,
    Setting::low_pass(1, 10_000),
    Setting::low_pass(1, 25_000),
    Setting::low_pass(2, 2_000),
    Setting::low_pass(2, 8_000),
];

/// The largest difference in ms from the stated delay: the sensor for the PC and the image differ a little.
const TOLERANCE: f64 = 1.0;

/// Asserts that a delay is the stated one.
///
/// # Panics
/// It is not.
pub fn check(setting: Setting, measured: f64) {
    let stated = setting.stated();
    println!("{setting:?}: {measured:.2} ms, stated {stated:.2} ms");
    let error = measured - stated;
    assert!(
        error.abs() < TOLERANCE,
        "{setting:?}: {measured} ms, stated {stated} ms"
    );
}

/// The mean delay in ms with a setting. `attach` attaches an IMS360 with blank memory.
///
/// # Panics
/// It does not answer.
pub fn delay(setting: Setting, attach: impl FnOnce(&mut Bus, Box<dyn Motion>)) -> f64 {
    let mut bus = Bus::new(BusRate::Fixed(BitRate::K125));
    attach(&mut bus, Box::new(Ramp));
    let tester = bus.adapter();
    bus.open(tester, None, false);
    run(&mut bus, millis(300));
    let [low, high] = setting.cutoff.to_le_bytes();
    write(
        &mut bus,
        tester,
        [0x2F, 0x10, 0x31, 1, setting.kind, 0, 0, 0],
    );
    write(&mut bus, tester, [0x2B, 0x11, 0x31, 0, low, high, 0, 0]);
    write(
        &mut bus,
        tester,
        [0x2F, 0x10, 0x31, 2, setting.fuses.into(), 0, 0, 0],
    );
    let operational = Frame::data(standard(0), &[1, 50]).expect("two bytes");
    bus.send(tester, operational);
    bus.run_until(Instant::from_ticks((REQUESTS * 1e6) as u64));
    bus.take_log();
    for _ in 0..NUMBER {
        let request = Frame::remote(standard(TPDO), 8).expect("a DLC of 8");
        bus.send(tester, request);
        run(&mut bus, PERIOD);
    }
    let delays: Vec<f64> = bus
        .take_log()
        .into_iter()
        .filter(|logged| logged.frame.id() == standard(TPDO) && !logged.frame.is_remote())
        .map(|logged| {
            let &[a, b, c, d, ..] = logged.frame.bytes() else {
                panic!("{:?}", logged.frame)
            };
            let sent = f64::from(i32::from_le_bytes([a, b, c, d])) / 100.0;
            let time = logged.start as f64 / SECOND;
            (angle(time) - sent) / SLOPE * 1e3
        })
        .collect();
    assert_eq!(delays.len(), NUMBER as usize);
    delays.iter().sum::<f64>() / f64::from(NUMBER)
}

fn run(bus: &mut Bus, time: Duration) {
    let end = after(bus.now(), time);
    bus.run_until(end);
}

/// Writes an object.
fn write(bus: &mut Bus, tester: AdapterId, request: [u8; 8]) {
    bus.take_received(tester);
    let frame = Frame::data(standard(SDO), &request).expect("eight bytes");
    bus.send(tester, frame);
    run(bus, millis(20));
    let replies = bus.take_received(tester);
    let is_done = |(_, frame): &(Instant, Frame)| frame.bytes().first() == Some(&0x60);
    assert!(replies.iter().any(is_done), "{request:02X?}: {replies:?}");
}
