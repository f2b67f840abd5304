//! A GEMAC sensor of two axes on a bus, shaken with a sine: the remaining vibration in its angle, and the gain of its filter.

use bench::motion::Motion;
use bench::{AdapterId, Bus, BusRate};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading, SAMPLE_PERIOD};
use plumbline::time::{Duration, Instant, after};
use std::cell::Cell;
use std::f64::consts::TAU;
use std::rc::Rc;

/// The bit rate of the bus and of the sensor.
pub const RATE: BitRate = BitRate::M1;

/// The identifiers of the factory (manual, table 17).
const SYNC: u16 = 0x100;
const SET: u16 = 0x300;
const REPLY: u16 = 0x301;

/// The function select code of the inclination.
const INCLINATION: u8 = 0x00;

/// The bits of the status byte that are errors (manual, tables 14 and 15): EEPROM, parameter, sensor X and Y.
const ERRORS: u8 = 0b0011_1100;

/// The time between two polls: two samples.
const POLL_PERIOD: Duration = Duration::from_ticks(10_000);

/// The longest time from the transmission of a request to the end of its reply.
const REPLY_TIME: Duration = Duration::from_ticks(250);

/// A vibration along X, in addition to gravity along Z.
#[derive(Clone, Default)]
struct Vibration(Rc<Cell<State>>);

#[derive(Clone, Copy, Default)]
struct State {
    /// The amplitude of the acceleration in g.
    amplitude: f64,
    /// The frequency in Hz. The phase continues when it changes.
    frequency: f64,
    /// The phase at the time of the last reading, in periods.
    phase: f64,
    /// The time of the last reading in s.
    time: f64,
}

impl Motion for Vibration {
    fn reading(&mut self, now: Instant) -> Reading {
        let mut state = self.0.get();
        let time = now.ticks() as f64 / 1e6;
        state.phase = (state.phase + (time - state.time) * state.frequency).fract();
        state.time = time;
        self.0.set(state);
        let x = state.amplitude * (TAU * state.phase).sin() * f64::from(ONE_G);
        Reading {
            acceleration: I32x3 {
                x: x.round() as i32,
                y: 0,
                z: ONE_G,
            },
            temperature: 2500,
            ..Reading::default()
        }
    }
}

/// A sensor on a shaker.
pub struct Shaker {
    bus: Bus,
    tester: AdapterId,
    vibration: Vibration,
    /// The time of the first poll, modulo [`SAMPLE_PERIOD`]. A poll at the time of a new value could return the new value or the previous
    /// one.
    phase: u64,
}

impl Shaker {
    /// Attaches a sensor, which must have the bit rate [`RATE`], and waits until it has started.
    pub fn new(attach: impl FnOnce(&mut Bus, Box<dyn Motion>)) -> Self {
        let vibration = Vibration::default();
        let mut bus = Bus::new(BusRate::Fixed(RATE));
        attach(&mut bus, Box::new(vibration.clone()));
        let tester = bus.adapter();
        bus.open(tester, None, false);
        let mut shaker = Self {
            bus,
            tester,
            vibration,
            phase: 0,
        };
        // With this frame, a sensor that detects the bit rate finds it.
        shaker.run(Duration::from_ticks(200_000));
        let frame = Frame::data(standard(SYNC), &[]).expect("no data");
        shaker.bus.send(tester, frame);
        shaker.run(Duration::from_ticks(300_000));
        shaker
    }

    /// Waits until the resampler follows the clock of the accelerometer. Before, the times of the readings change, and polls could miss one or
    /// read one twice.
    pub fn settle(&mut self) {
        self.run(Duration::from_ticks(15_000_000));
    }

    fn run(&mut self, time: Duration) {
        let end = after(self.bus.now(), time);
        self.bus.run_until(end);
    }

    /// Sends a request and returns the data of the reply.
    ///
    /// # Panics
    ///
    /// Panics if there is no reply, or if it reports an error.
    pub fn request(&mut self, data: &[u8]) -> Vec<u8> {
        let frame = Frame::data(standard(SET), data).expect("at most eight bytes");
        self.bus.take_received(self.tester);
        self.bus.send(self.tester, frame);
        self.run(REPLY_TIME);
        let received = self.bus.take_received(self.tester);
        let is_reply = |(_, frame): &&(Instant, Frame)| frame.id() == standard(REPLY);
        let (_, reply) = received.iter().rfind(is_reply).expect("a reply");
        let bytes = reply.bytes().to_vec();
        assert_eq!(bytes[0], data[0], "{bytes:02X?}");
        assert_eq!(bytes[1] & ERRORS, 0, "{bytes:02X?}");
        bytes
    }

    /// Shakes the sensor with this amplitude in g and frequency in Hz for `settling` ms. Then polls its X angle for `time` ms.
    /// Returns the angles in degrees and their times in s.
    fn shake(
        &mut self,
        amplitude: f64,
        frequency: f64,
        settling: u64,
        time: u64,
    ) -> Vec<(f64, f64)> {
        let state = self.vibration.0.get();
        self.vibration.0.set(State {
            amplitude,
            frequency,
            ..state
        });
        self.run(Duration::from_ticks(settling * 1000));
        let period = SAMPLE_PERIOD.ticks();
        let late = (self.bus.now().ticks() + period - self.phase) % period;
        let start = Instant::from_ticks(self.bus.now().ticks() + period - late);
        let mut polled = Vec::new();
        for number in 0..time * 1000 / POLL_PERIOD.ticks() {
            let due = Instant::from_ticks(start.ticks() + number * POLL_PERIOD.ticks());
            self.bus.run_until(due);
            polled.push((due.ticks() as f64 / 1e6, f64::from(self.angle()) / 100.0));
        }
        polled
    }

    /// Polls the X angle, in 0.01 degrees.
    fn angle(&mut self) -> i16 {
        let reply = self.request(&[INCLINATION]);
        i16::from_le_bytes([reply[2], reply[3]])
    }

    /// Sets the time of the polls to the middle between two new values.
    fn align(&mut self) {
        // The vibration is so fast that each value differs from the previous one.
        self.shake(0.2, 20.0, 300, 0);
        let end = after(
            self.bus.now(),
            Duration::from_ticks(10 * SAMPLE_PERIOD.ticks()),
        );
        let mut last = self.angle();
        while self.bus.now() < end {
            let angle = self.angle();
            if angle != last {
                self.phase =
                    (self.bus.now().ticks() + SAMPLE_PERIOD.ticks() / 2) % SAMPLE_PERIOD.ticks();
            }
            last = angle;
        }
    }

    /// The largest angle in degrees during a vibration of 0.3 g at this frequency in Hz, after it has settled.
    pub fn residue(&mut self, frequency: f64) -> f64 {
        let angles = self.shake(0.3, frequency, 1200, 700);
        angles
            .iter()
            .fold(0.0, |largest: f64, (_, angle)| largest.max(angle.abs()))
    }

    /// The amplitude of the filtered acceleration in g during a vibration of 0.2 g at this frequency in Hz, in the settled state of this
    /// filter.
    fn amplitude(&mut self, frequency: f64, filter: &Cutoff) -> f64 {
        self.align();
        let angles = self.shake(0.2, frequency, filter.settling, filter.time);
        // A second is a multiple of half a period of each frequency above 2 Hz. A longer block would contain the drift of the two clocks:
        // 0.07 % of a sample.
        let block = if frequency < 2.0 { angles.len() } else { 100 };
        let amplitudes = angles.chunks(block).map(|angles| {
            let (mut sine, mut cosine) = (0.0, 0.0);
            for (time, angle) in angles {
                let phase = TAU * frequency * time;
                // The tangent is proportional to the acceleration along X.
                let acceleration = angle.to_radians().tan();
                sine += acceleration * phase.sin();
                cosine += acceleration * phase.cos();
            }
            2.0 * f64::hypot(sine, cosine) / angles.len() as f64
        });
        amplitudes.sum::<f64>() / (angles.len() / block) as f64
    }
}

/// The lowest and the highest frequency, in Hz, of the vibration that a filter of 2 Hz must suppress. Above is the range of the
/// low-pass in the accelerometer.
pub const FREQUENCIES: std::ops::RangeInclusive<u32> = 8..=400;

/// The errors of the oscillator of the accelerometer in percent: none, and the largest ones.
pub const CLOCKS: [i32; 3] = [-5, 0, 5];

/// The largest angle in degrees during a vibration of 0.3 g behind a Butterworth filter of 2 Hz.
pub const RESIDUE: f64 = 0.02;

/// A selection of [`FREQUENCIES`], with those beside multiples of the data rate of 200 Hz. The change from one to the next is not larger than
/// from 8 to 9 Hz, after which the filter settles in time.
pub const SELECTED: [u32; 20] = [
    8, 9, 10, 11, 12, 14, 16, 20, 27, 40, 80, 150, 198, 199, 200, 201, 202, 300, 399, 400,
];

/// Checks a vibration at each of the frequencies behind a Butterworth filter of 2 Hz.
///
/// # Panics
///
/// Panics if the angle exceeds [`RESIDUE`].
pub fn check_residue(shaker: &mut Shaker, frequencies: &[u32]) {
    shaker.request(&[0x27, 0xD0, 0x07, 1]);
    // The start of the vibration is a step.
    shaker.shake(0.3, frequencies[0].into(), 3000, 0);
    let mut failed = Vec::new();
    let mut worst = 0.0_f64;
    for &frequency in frequencies {
        let residue = shaker.residue(frequency.into());
        worst = worst.max(residue);
        if residue > RESIDUE {
            failed.push((frequency, residue));
        }
    }
    println!("largest angle: {worst:.2} deg");
    assert!(failed.is_empty(), "(Hz, deg): {failed:?}");
}

/// A filter whose cut-off frequency is measured.
#[derive(Clone, Copy)]
pub struct Cutoff {
    /// The type of the manual (9.10.7).
    kind: u8,
    /// The cut-off frequency in mHz.
    frequency: u16,
    /// The largest error of the gain at the cut-off frequency: that of an error of the cut-off frequency of 0.15 %.
    tolerance: f64,
    /// The time until the vibration has settled, in ms.
    settling: u64,
    /// The time of a measurement in ms: a multiple of half a period of a twentieth of the cut-off frequency.
    time: u64,
}

impl Cutoff {
    const fn new(kind: u8, frequency: u16, tolerance: f64) -> Self {
        Self {
            kind,
            frequency,
            tolerance,
            settling: 2000,
            time: 5000,
        }
    }
}

/// The filter that settles first.
pub const SHORTEST: Cutoff = Cutoff {
    settling: 500,
    time: 2000,
    ..Cutoff::new(1, 25_000, 0.006)
};

/// All filters whose cut-off frequencies are measured.
pub const CUTOFFS: [Cutoff; 5] = [
    Cutoff::new(1, 2_000, 0.006),
    Cutoff::new(1, 8_000, 0.006),
    SHORTEST,
    Cutoff::new(2, 2_000, 0.001),
    Cutoff::new(2, 8_000, 0.001),
];

/// Checks the cut-off frequencies of these filters: there the gain is -3 dB.
///
/// # Panics
///
/// Panics if a cut-off frequency differs by more than 0.15 %.
pub fn check_cutoffs(shaker: &mut Shaker, filters: &[Cutoff]) {
    for filter in filters {
        let &Cutoff {
            kind, tolerance, ..
        } = filter;
        let [low, high] = filter.frequency.to_le_bytes();
        shaker.request(&[0x27, low, high, kind]);
        let cutoff = f64::from(filter.frequency) / 1000.0;
        let gain = shaker.amplitude(cutoff, filter) / shaker.amplitude(cutoff / 20.0, filter);
        let slow = match kind {
            1 => 1.0,
            _ => (1.0 + (2f64.powf(0.125) - 1.0) / 400.0).powi(-4),
        };
        let error = gain * slow / 0.5f64.sqrt() - 1.0;
        println!(
            "type {kind}, {cutoff} Hz: gain error {:.2} %",
            error * 100.0
        );
        assert!(error.abs() < tolerance, "type {kind}, {cutoff} Hz: {error}");
    }
}
