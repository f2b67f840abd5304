//! Automatic bit rate detection (manual, section 9.10.3): it finds each of the ten rates, does not disturb the bus, and sends
//! nothing before it has found the rate.

use crate::rig::*;
use bench::{AdapterId, BusRate, Source};
use host_tests::bit_rate::{check_detection, check_lone_master};
use host_tests::effort;
use plumbline::can::BitRate;
use plumbline::node::BusMode;
use stm32_sim::Microcontroller;

/// The silent bit of CAN_BTR (SILM).
const SILENT: u32 = 1 << 31;

/// What CAN_BTR must hold (RM0008, section 24.9.2) for a sample point of 87.5 % with 32 MHz: 16 time quanta, 13 of them in
/// segment 1 and 2 in segment 2, a jump width of 2. At 800 kbit/s: 8 time quanta, 6 and 1, a jump width of 1.
const BIT_TIMING: [(BitRate, u32); 10] = [
    (BitRate::K10, 0x011C_0000 | (200 - 1)),
    (BitRate::K20, 0x011C_0000 | (100 - 1)),
    (BitRate::K50, 0x011C_0000 | (40 - 1)),
    (BitRate::K62_5, 0x011C_0000 | (32 - 1)),
    (BitRate::K100, 0x011C_0000 | (20 - 1)),
    (BitRate::K125, 0x011C_0000 | (16 - 1)),
    (BitRate::K250, 0x011C_0000 | (8 - 1)),
    (BitRate::K500, 0x011C_0000 | (4 - 1)),
    (BitRate::K800, 0x0005_0004),
    (BitRate::M1, 0x011C_0000 | (2 - 1)),
];

/// An is2 with blank memory.
fn sensor() -> Microcontroller {
    microcontroller("is2", blank())
}

/// Two nodes that send frames with periods of 20 and 33 ms.
pub struct Traffic {
    ends: [AdapterId; 2],
    number: u8,
}

impl Traffic {
    pub fn at(rig: &mut Rig, rate: BitRate) -> Self {
        let ends = [rig.tester, rig.bus.adapter()];
        for end in ends {
            rig.bus.open(end, Some(rate), false);
        }
        Self { ends, number: 0 }
    }

    pub fn millisecond(&mut self, rig: &mut Rig) {
        self.number = self.number.wrapping_add(1);
        let [first, second] = self.ends;
        if self.number.is_multiple_of(20) {
            let bytes = [self.number; 8];
            rig.bus.send(first, data(0x1A5, &bytes));
        }
        if self.number.is_multiple_of(33) {
            rig.bus.send(second, data(0x055, &[0x55, self.number]));
        }
        rig.run(1);
    }

    fn assert_undisturbed(&self, rig: &Rig) {
        for end in self.ends {
            assert_eq!(rig.bus.disturbed(Source::Adapter(end)), 0);
        }
    }
}

#[test]
pub fn each_of_the_ten_rates_is_detected_without_disturbing_the_bus() {
    for (rate, btr) in BIT_TIMING {
        let mut rig = Rig::with("is2", BusRate::Wire, blank());
        let mut traffic = Traffic::at(&mut rig, rate);
        for _ in 0..20_000 {
            traffic.millisecond(&mut rig);
            if rig.device().mode() == Some(BusMode::Normal) {
                break;
            }
            assert!(rig.frames().is_empty(), "{rate:?}: not silent");
        }
        // Time for two frames of 160 bits at the slowest rate, with frames of the other nodes between them.
        for _ in 0..150 {
            traffic.millisecond(&mut rig);
        }
        let boot_up = rig.frames();
        assert_eq!(boot_up.len(), 2, "{rate:?}: {boot_up:?}");
        // Table 16: the alive code, the status (default parameters, automatic detection), the Set-Parameter-ID, the version.
        let alive = data(REPLY, &[fsc::ALIVE, 3, 0x00, 0x03, 0, 0, 0x44, 0x03]);
        assert_eq!(boot_up, [alive, alive], "{rate:?}");
        assert_eq!(rig.device().rate(), Some(rate));
        traffic.assert_undisturbed(&rig);

        let history = rig.microcontroller().can().btr_history();
        let mut listened: Vec<_> = history.iter().copied().collect();
        let locked = listened.pop().map(|(_, btr)| btr);
        assert_eq!(locked, Some(btr), "{rate:?}");
        assert!(!listened.is_empty());
        assert!(listened.iter().all(|(_, btr)| btr & SILENT != 0));
        let (_, last) = listened[listened.len() - 1];
        assert_eq!(last, btr | SILENT, "the last rate on which it listened");
    }
}

/// At a wrong rate there are errors until the controller has left the bus. An error of one rate must not count at the next rate: the
/// sensor would leave the right rate.
#[test]
fn each_rate_on_a_full_bus_is_detected_at_the_first_try() {
    for (rate, btr) in BIT_TIMING {
        let tries = [0, 41, 82].map(|phase| tries_on_a_full_bus(rate, btr, phase));
        assert_eq!(tries, [1; 3], "{rate:?}");
    }
}

/// How often the sensor listens at the right rate on a bus that is full from this time in us on.
fn tries_on_a_full_bus(rate: BitRate, btr: u32, phase: u64) -> usize {
    let mut rig = Rig::with("is2", BusRate::Wire, blank());
    let traffic = Traffic::at(&mut rig, rate);
    rig.run_us(phase);
    for number in 0..5_000_u16 {
        while rig.bus.queued(traffic.ends[0]) < 20 {
            let [low, high] = number.to_le_bytes();
            rig.bus
                .send(traffic.ends[0], data(0x1A5, &[low, high, 0, 0xFF]));
        }
        rig.run(1);
        if rig.device().mode() == Some(BusMode::Normal) {
            break;
        }
    }
    assert_eq!(rig.device().rate(), Some(rate));
    traffic.assert_undisturbed(&rig);
    let history = rig.microcontroller().can().btr_history();
    history
        .iter()
        .filter(|(_, one)| *one == btr | SILENT)
        .count()
}

#[test]
fn sensor_without_traffic_listens_for_ever_and_sleeps_between_samples() {
    let mut rig = Rig::with("is2", BusRate::Wire, blank());
    rig.bus.close(rig.tester);
    rig.run(5_000);
    assert!(rig.log.is_empty());
    let can = rig.microcontroller().can();
    assert_eq!(can.btr_history().len(), 1, "a silent bus changes nothing");
    assert!(can.is_silent());
    // No more instructions than with a fixed bit rate.
    let mut fixed = Rig::with("is2", BusRate::Wire, fixed("is2", BitRate::K250));
    fixed.run(5_000);
    let [detecting, fixed] = [&mut rig, &mut fixed].map(|rig| {
        let before = rig.microcontroller().core().instructions();
        rig.run(1_000);
        rig.microcontroller().core().instructions() - before
    });
    assert!(detecting * 100 <= fixed * 105, "{detecting}, {fixed}");
}

/// The phases are fewer than on the PC, and differ in each case. The long periods are for the long run.
#[test]
fn each_rate_is_detected_within_11_frames_at_any_period_and_phase() {
    let mut phase = 0;
    check_detection(sensor, 11, |_, period| {
        let [short, long] = effort::choose([1, 0], [3, 1]);
        let number = if period < 200_000 { short } else { long };
        let mut next = || {
            phase = (phase + 12_347) % period.max(5_000);
            phase
        };
        (0..number).map(|_| next()).collect()
    });
}

#[test]
fn lone_master_is_acknowledged_within_36_attempts() {
    check_lone_master(sensor);
}
