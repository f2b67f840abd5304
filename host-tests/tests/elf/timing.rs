//! The time of the answer to SYNC, and the period of cyclic mode over a long time.

use crate::rig::*;
use bench::{Logged, Source};
use can_wire::frame_length::frame_bits;
use plumbline::can::BitRate;

/// Picoseconds in a microsecond, which is a bit at 1 Mbit/s.
const US: u64 = 1_000_000;

/// Simulated seconds of cyclic mode with and without the accelerometer. The accelerometer needs most of the processor time, so
/// the test without it can last six hours: 86,400 frames, more than the counter has values.
const MOUNTED: u64 = 900;
const UNMOUNTED: u64 = 6 * 3600;

/// The largest difference between the time errors of two frames in us: the alarm of the program has steps of 1 ms, and a frame
/// leaves earlier if another event wakes the program.
const JITTER: i64 = 1000;

/// The largest drift in us a day.
const DRIFT: i64 = 1000;

/// The drift is the difference between the latest time errors of this many frames at the end and at the start.
const GROUP: usize = 500;

/// The times in ns from the end of each SYNC to the start of the answer.
fn answer_times(rig: &mut Rig, count: usize) -> Vec<u64> {
    let mut random = 0x2545_F491_4F6C_DD1D_u64;
    let start = rig.log.len();
    for _ in 0..count {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        rig.run_us(2_000 + random % 5_000);
        rig.bus.send(rig.tester, data(SYNC, &[]));
    }
    rig.run(5);
    let own = Source::Device(rig.sensor);
    let log = &rig.log[start..];
    let is_sync = |logged: &&Logged| logged.frame == data(SYNC, &[]);
    log.iter()
        .filter(is_sync)
        .map(|sync| {
            let end = sync.start + u64::from(frame_bits(&sync.frame)) * US;
            let answer = log.iter().find(|one| one.source == own && one.start > end);
            (answer.expect("an answer").start - end) / 1000
        })
        .collect()
}

#[test]
fn sync_is_answered_within_15_us() {
    let loads: [&[&[u8]]; 2] = [
        &[],
        &[
            // Butterworth, 10 Hz; cyclic mode every 7 ms.
            &[fsc::WRITE_FILTER, 0x10, 0x27, 1],
            &[fsc::WRITE_CYCLIC_TIME, 7, 0],
            &[fsc::WRITE_CYCLIC_MODE, 1],
        ],
    ];
    for name in MODELS {
        for parameters in loads {
            let mut rig = Rig::booted_with(name, BitRate::M1, parameters);
            rig.run(20);
            let times = answer_times(&mut rig, 300);
            assert_eq!(times.len(), 300);
            let longest = times.iter().max().expect("300");
            let shortest = times.iter().min().expect("300");
            println!("{name}: SYNC is answered after {shortest} to {longest} ns");
            assert!(*longest <= 15_000, "{name}: {longest} ns");
            assert!(*shortest >= 3_000, "not within the intermission");
        }
    }
}

/// Runs cyclic mode for this many simulated seconds: every counter is sent once and in time.
fn cyclic(rig: &mut Rig, period: u64, seconds: u64, error_bits: u8) {
    let [low, high] = (period as u16).to_le_bytes();
    rig.write(&[fsc::WRITE_CYCLIC_TIME, low, high]);
    rig.write(&[fsc::WRITE_CYCLIC_MODE, 1]);
    rig.run(1);
    rig.frames();
    rig.log.clear();
    let own = Source::Device(rig.sensor);
    let mut counter: u16 = 0;
    let mut first = None;
    let mut errors = Vec::new();
    for _ in 0..seconds {
        let end = rig.bus.now().ticks() + 1_000_000;
        rig.bus.run_until(plumbline::time::Instant::from_ticks(end));
        for logged in rig.bus.take_log() {
            assert_eq!(logged.source, own);
            let bytes = logged.frame.bytes();
            counter = counter.wrapping_add(1);
            let [.., a, b] = *bytes else {
                panic!("{bytes:?}")
            };
            assert_eq!(u16::from_le_bytes([a, b]), counter);
            assert_eq!(bytes[..2], [fsc::INCLINATION, error_bits]);
            let start = (logged.start / US) as i64;
            let begin = *first.get_or_insert(start);
            errors.push(start - begin - errors.len() as i64 * period as i64 * 1000);
        }
    }
    let frames = errors.len();
    let latest = |errors: &[i64]| *errors.iter().max().expect("frames");
    let span = latest(&errors) - errors.iter().min().expect("frames");
    let drift = latest(&errors[frames - GROUP..]) - latest(&errors[..GROUP]);
    println!("{frames} frames in {seconds} s, jitter {span} us, drift {drift} us");
    assert!(span <= JITTER, "{span} us");
    assert!(
        drift.abs() * 86_400 <= DRIFT * seconds as i64,
        "{drift} us in {seconds} s"
    );
    assert!((frames as u64).abs_diff(seconds * 1000 / period) <= 1);
    assert_eq!(rig.microcontroller().can().overruns(), 0);
}

blue_pill_only! {
#[test]
fn cyclic_mode_keeps_its_period() {
    let mut rig = Rig::booted("is2", BitRate::K125);
    cyclic(&mut rig, 100, MOUNTED, 0);
    assert_eq!(rig.device().error_counters(), Some((0, 0)));
}

#[test]
fn cyclic_counter_wraps_after_65535() {
    let mut rig = Rig::booted("is1", BitRate::K500);
    cyclic(&mut rig, 10, 660, 0);
}

#[test]
fn cyclic_mode_runs_without_an_accelerometer() {
    let mut rig = Rig::booted("is2", BitRate::K125);
    rig.io().0.imu.unmount();
    rig.run(300);
    let errors = status::SENSOR_ERROR_X | status::SENSOR_ERROR_Y;
    cyclic(&mut rig, 250, UNMOUNTED, errors);
}
}
