//! The rise time of a TILTIX after a step of the angle, from its change-of-state messages. The tests compare a sensor built for the PC and
//! the flashed image with the formulas of the manual.

use bench::motion::Motion;
use bench::{AdapterId, Bus, BusRate};
use plumbline::can::{Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::{Instant, after, millis, reached};

/// The angle after the step, in 0.01 deg.
const STEP: f64 = 2000.0;

/// The time of the step: the sensor is on-line, and its filter has settled.
const AT: Instant = Instant::from_ticks(4_000_000);

/// The program cycles of the manual per second.
const CYCLES: f64 = 1428.0;

/// A filter of the TILTIX.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    /// The weight of the recursive filter in 1/1000 (85h).
    pub weight: u16,
    /// The size of the moving average (84h).
    pub size: u8,
}

/// The filters whose rise times are measured.
pub const FILTERS: [Filter; 4] = [
    Filter {
        weight: 0,
        size: 250,
    },
    Filter {
        weight: 0,
        size: 100,
    },
    Filter {
        weight: 990,
        size: 0,
    },
    Filter {
        weight: 998,
        size: 0,
    },
];

impl Filter {
    /// The time from 10 to 90 % of a step in s, of a filter that is alone.
    pub fn rise_time(self) -> f64 {
        if self.weight == 0 {
            return 0.8 * f64::from(self.size) / CYCLES;
        }
        9_f64.ln() / (-(f64::from(self.weight) / 1000.0).ln() * CYCLES)
    }
}

/// A sensor that is level, then inclined.
struct Tipped;

impl Motion for Tipped {
    fn reading(&mut self, now: Instant) -> Reading {
        let degrees = if reached(now, AT) { STEP / 100.0 } else { 0.0 };
        let (x, z) = f64::to_radians(degrees).sin_cos();
        let one_g = |part: f64| (part * f64::from(ONE_G)) as i32;
        Reading {
            acceleration: I32x3 {
                x: one_g(-x),
                y: 0,
                z: one_g(z),
            },
            temperature: 25_00,
            ..Reading::default()
        }
    }
}

/// A master and a TILTIX 080 with the factory MAC ID.
struct Bench {
    bus: Bus,
    master: AdapterId,
}

impl Bench {
    fn run_until(&mut self, end: Instant) {
        self.bus.run_until(end);
    }

    /// Sends a request of the master 0Ah with this message ID; it must succeed.
    fn ask(&mut self, message: u16, request: &[u8]) {
        self.bus.take_received(self.master);
        let bytes = [&[0x0A], request].concat();
        let id = standard(0x5F8 | message);
        let frame = Frame::data(id, &bytes).expect("at most eight bytes");
        self.bus.send(self.master, frame);
        self.run_until(after(self.bus.now(), millis(5)));
        let received = self.bus.take_received(self.master);
        let mut answers = received.iter().map(|(_, frame)| frame.bytes());
        let succeeded = |answer: &[u8]| answer.get(1) == Some(&(request[0] | 0x80));
        assert!(answers.any(succeeded), "{request:02X?}: {received:?}");
    }
}

/// The time in s in which the longitudinal slope goes from 10 to 90 % of a step. `attach` attaches a TILTIX 080 with blank memory.
///
/// # Panics
/// The sensor refuses a request, or does not reach the angle.
pub fn rise_time(filter: Filter, attach: impl FnOnce(&mut Bus, Box<dyn Motion>)) -> f64 {
    let mut bus = Bus::new(BusRate::Follow);
    attach(&mut bus, Box::new(Tipped));
    let master = bus.adapter();
    bus.open(master, None, false);
    let mut bench = Bench { bus, master };
    bench.run_until(Instant::from_ticks(2_500_000));
    // Explicit and COS, without acknowledgement; only slope long16.
    bench.ask(6, &[0x4B, 3, 1, 0x01, 0x0A]);
    bench.ask(4, &[0x10, 5, 1, 9, 0, 0]);
    bench.ask(4, &[0x10, 0x65, 1, 0x82, 101]);
    bench.ask(4, &[0x10, 0x65, 1, 0x84, filter.size]);
    let [low, high] = filter.weight.to_le_bytes();
    bench.ask(4, &[0x10, 0x65, 1, 0x85, low, high]);
    bench.ask(4, &[0x4B, 3, 1, 0x50, 0x0A]);
    bench.ask(4, &[0x10, 5, 4, 9, 0, 0]);
    bench.run_until(AT);
    let before = bench.bus.take_received(master);
    assert!(before.len() < 100, "at rest there are few changes");
    bench.run_until(after(AT, millis(5000)));
    let slopes: Vec<(f64, f64)> = bench
        .bus
        .take_received(master)
        .iter()
        .filter_map(|(time, frame)| {
            let &[low, high] = frame.bytes() else {
                return None;
            };
            let slope = f64::from(i16::from_le_bytes([low, high]));
            Some((time.ticks() as f64 / 1e6, slope))
        })
        .collect();
    crossing(&slopes, 0.9) - crossing(&slopes, 0.1)
}

/// The time at which the slope crosses this part of the step.
fn crossing(slopes: &[(f64, f64)], part: f64) -> f64 {
    let level = part * STEP;
    let pairs = slopes.iter().zip(&slopes[1..]);
    let crosses = |pair: &(&(f64, f64), &(f64, f64))| pair.0.1 < level && pair.1.1 >= level;
    let mut crossings = pairs.filter(crosses);
    let Some(((from, low), (to, high))) = crossings.next() else {
        panic!("the slope does not reach {level}: {slopes:?}")
    };
    from + (to - from) * (level - low) / (high - low)
}

/// Asserts that a rise time is that of the manual within 2 %.
///
/// # Panics
/// It is not.
pub fn check(filter: Filter, measured: f64) {
    let error = measured / filter.rise_time() - 1.0;
    assert!(error.abs() < 0.02, "{filter:?}: {measured} s, {error:+.4}");
}
