//! Bit rate detection of a GEMAC sensor on a real wire: a master polls it, and another node acknowledges.

use bench::{Bus, BusRate, Sensor, Source};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::node::BusMode;
use plumbline::time::{Duration, Instant, after};

/// The number of frames after which a test gives up.
const FRAMES_MAX: usize = 12;

/// The maximum number of attempts of a master that is alone with the sensor. It is error passive after 16 attempts; from then on its
/// error flags do not disturb the frame. At 1 Mbit/s, a sensor on a board misses some more while it calculates a sample.
const ATTEMPTS_MAX: u64 = 36;

/// The time between the starts of two polls in us; 0: back to back.
const PERIODS: [u64; 16] = [
    0, 100, 500, 1_000, 2_000, 3_000, 5_000, 10_000, 20_000, 50_000, 100_000, 200_000, 250_000,
    500_000, 1_000_000, 2_000_000,
];

/// The frames of the master. The shortest dominant pulse that the master itself sends has 1, 2, 3 and 4 bits.
const FRAMES: [(u16, &[u8]); 4] = [
    (0x300, &[0x00]),
    (0x300, &[0x13]),
    (0x0C4, &[0x08]),
    (0x000, &[]),
];

/// The time in which a sensor has its first reading. Before it, the sensor only listens.
const MEASURES: Instant = Instant::from_ticks(65_000);

/// The longest wait for a sensor that boots.
const BOOT_MAX: Instant = Instant::from_ticks(200_000);

/// Checks that a sensor detects each bit rate within `limit` frames of a master that polls it, back to back or with a period of up to 2 s.
/// It prints the largest number of frames.
///
/// `phases` returns the times of the first poll after the first reading in us, for a bit rate and a period in us. Each time is tried with a new sensor. The
/// runs use frames of four shapes in turn.
///
/// # Panics
///
/// The sensor needs more frames, disturbs the bus, or sends before it has detected the bit rate.
pub fn check_detection<S: Sensor>(
    sensor: impl Fn() -> S,
    limit: usize,
    mut phases: impl FnMut(BitRate, u64) -> Vec<u64>,
) {
    let mut polls = FRAMES.into_iter().cycle();
    let mut most = 0;
    for rate in BitRate::ALL {
        for period in PERIODS {
            for (phase, poll) in phases(rate, period).into_iter().zip(&mut polls) {
                let frames = frames_until_detected(sensor(), rate, poll, period, phase);
                assert!(
                    frames <= limit,
                    "{frames} frames: {rate:?}, {poll:X?} every {period} us from {phase} us on"
                );
                most = most.max(frames);
            }
        }
    }
    println!("at most {most} frames");
}

/// Checks that a sensor that is alone with a master acknowledges its frame within 36 attempts, at each bit rate and with frames of
/// four shapes.
///
/// # Panics
///
/// The master needs more attempts, or the sensor does not detect the bit rate within 5 s.
pub fn check_lone_master<S: Sensor>(sensor: impl Fn() -> S) {
    for rate in BitRate::ALL {
        for frame in FRAMES {
            let attempts = attempts_of_lone_master(sensor(), rate, frame);
            assert!(
                attempts <= ATTEMPTS_MAX,
                "{attempts} at {rate:?}, {frame:X?}"
            );
        }
    }
}

/// Switches the sensor on, sends the frame with this period (the first time `phase` us after the first reading), and returns the number of complete
/// frames that were on the bus since the sensor has listened for the first time.
///
/// # Panics
///
/// The sensor disturbs the bus, sends before it has detected the bit rate, or does not detect it within twice [`FRAMES_MAX`] frames.
fn frames_until_detected(
    sensor: impl Sensor,
    rate: BitRate,
    (id, data): (u16, &[u8]),
    period: u64,
    phase: u64,
) -> usize {
    let mut bus = Bus::new(BusRate::Wire);
    let device = bus.attach(sensor);
    let (master, other) = (bus.adapter(), bus.adapter());
    bus.open(master, Some(rate), false);
    bus.open(other, Some(rate), false);
    let poll = Frame::data(standard(id), data).expect("at most eight bytes");
    let mut next = after(MEASURES, Duration::from_ticks(phase));
    let mut frames = 0;
    let mut listens = false;
    loop {
        while next <= bus.now() && bus.queued(master) < 2 {
            bus.send(master, poll);
            next = after(next, Duration::from_ticks(period.max(1)));
        }
        let step = if period == 0 { 10 } else { 100 };
        bus.run_until(after(bus.now(), Duration::from_ticks(step)));
        let log = bus.take_log();
        let sensor = bus.device(device);
        listens |= sensor.mode() == Some(BusMode::Listen);
        assert!(
            listens || bus.now() < BOOT_MAX,
            "the sensor does not listen"
        );
        if sensor.mode() == Some(BusMode::Normal) {
            break;
        }
        if listens {
            frames += log.len();
        }
        let sender = Source::Adapter(master);
        assert!(log.iter().all(|one| one.source == sender), "it has sent");
        assert!(
            frames <= 2 * FRAMES_MAX,
            "{rate:?} is not detected with a poll every {period} us from {phase} us on"
        );
    }
    assert_eq!(bus.device(device).rate(), Some(rate));
    for adapter in [master, other] {
        assert_eq!(bus.disturbed(Source::Adapter(adapter)), 0);
    }
    frames
}

/// Connects the sensor to a master that is the only other node, so that nobody acknowledges its frame, and returns the number of
/// attempts of the master until the sensor has acknowledged the frame.
///
/// # Panics
///
/// The sensor does not detect the bit rate within 5 s.
fn attempts_of_lone_master(sensor: impl Sensor, rate: BitRate, (id, data): (u16, &[u8])) -> u64 {
    let mut bus = Bus::new(BusRate::Wire);
    let device = bus.attach(sensor);
    bus.run_until(BOOT_MAX);
    let master = bus.adapter();
    bus.open(master, Some(rate), false);
    bus.send(
        master,
        Frame::data(standard(id), data).expect("at most eight bytes"),
    );
    while bus.queued(master) > 0 {
        bus.run_until(after(bus.now(), Duration::from_ticks(100)));
        assert!(bus.now() < Instant::from_ticks(5_000_000), "{rate:?}");
    }
    assert_eq!(bus.device(device).rate(), Some(rate));
    bus.disturbed(Source::Adapter(master))
}
