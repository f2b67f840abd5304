//! The time of the answer to SYNC, and the period of cyclic mode over a long time.

use crate::rig::*;
use bench::{BusRate, Logged, Source};
use can_wire::frame_length::frame_bits;
use host_tests::effort;
use plumbline::can::BitRate;

/// Picoseconds in a microsecond, which is a bit at 1 Mbit/s.
const US: u64 = 1_000_000;

/// Seconds of cyclic mode in the normal run, and in the long one.
const SECONDS: [u64; 2] = [10, 900];

/// The period of cyclic mode in ms.
const PERIOD: u64 = 10;

/// The largest difference between the time errors of two frames in us: the alarm of the program has steps of 1 ms, and a frame
/// leaves earlier if another event wakes the program.
const JITTER: i64 = 1000;

/// The largest drift in us in a run: 1 ppm in the normal one. An error of one cycle in the period of the clock is 8 ppm and more.
const DRIFT: i64 = 10;

/// The drift is the difference between the latest time errors of this many frames at the end and at the start.
const GROUP: usize = 200;

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
pub fn sync_is_answered_within_15_us() {
    let loads: [&[&[u8]]; 2] = [
        &[],
        &[
            // Butterworth, 10 Hz; cyclic mode every 7 ms.
            &[fsc::WRITE_FILTER, 0x10, 0x27, 1],
            &[fsc::WRITE_CYCLIC_TIME, 7, 0],
            &[fsc::WRITE_CYCLIC_MODE, 1],
        ],
    ];
    for parameters in loads {
        let mut rig = Rig::booted_with("is2", BitRate::M1, parameters);
        rig.run(20);
        let times = answer_times(&mut rig, 300);
        assert_eq!(times.len(), 300);
        let longest = times.iter().max().expect("300");
        let shortest = times.iter().min().expect("300");
        println!("SYNC is answered after {shortest} to {longest} ns");
        assert!(*longest <= 15_000, "{longest} ns");
        assert!(*shortest >= 3_000, "not within the intermission");
    }
}

/// Runs cyclic mode for this many simulated seconds: every counter is sent once and in time.
fn cyclic(rig: &mut Rig, seconds: u64, error_bits: u8) {
    let [low, high] = (PERIOD as u16).to_le_bytes();
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
            errors.push(start - begin - errors.len() as i64 * PERIOD as i64 * 1000);
        }
    }
    let frames = errors.len();
    let latest = |errors: &[i64]| *errors.iter().max().expect("frames");
    let span = latest(&errors) - errors.iter().min().expect("frames");
    let drift = latest(&errors[frames - GROUP..]) - latest(&errors[..GROUP]);
    println!("{frames} frames in {seconds} s, jitter {span} us, drift {drift} us");
    assert!(span <= JITTER, "{span} us");
    assert!(drift.abs() <= DRIFT, "{drift} us in {seconds} s");
    assert!((frames as u64).abs_diff(seconds * 1000 / PERIOD) <= 1);
    assert_eq!(rig.microcontroller().can().overruns(), 0);
}

#[test]
pub fn cyclic_mode_keeps_its_period() {
    let mut rig = Rig::booted("is2", BitRate::K125);
    let [normal, long] = SECONDS;
    cyclic(&mut rig, effort::choose(normal, long), 0);
    assert_eq!(rig.device().error_counters(), Some((0, 0)));
}

/// The clock passes 2^32 us, after 71 minutes, within the run. Without the accelerometer the program sleeps from frame to frame.
#[test]
fn cyclic_mode_keeps_its_period_for_hours_without_an_accelerometer() {
    const BEFORE: u64 = 4_000_000;
    let mut rig = Rig::with(
        "is2",
        BusRate::Fixed(BitRate::K125),
        fixed("is2", BitRate::K125),
    );
    rig.io().0.imu.unmount();
    let clock = rig.microcontroller().image().address_of("TICKED");
    let clock = clock.expect("the time of the last interrupt");
    rig.wait_until(100, 100, |rig| {
        rig.microcontroller().core().word(clock) == Some(1000)
    });
    let time = (1 << 32) - BEFORE;
    let core = rig.microcontroller_mut().core_mut();
    assert!(core.load(clock, &time.to_le_bytes()));
    rig.boot_up();
    rig.run(300);
    let errors = status::SENSOR_ERROR_X | status::SENSOR_ERROR_Y;
    cyclic(&mut rig, 2 * BEFORE / 1_000_000, errors);
    assert!(rig.microcontroller().core().word(clock) < Some(BEFORE as u32 * 2));
}
