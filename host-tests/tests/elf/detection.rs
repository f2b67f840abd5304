//! Automatic bit rate detection (manual, section 9.10.3): it disturbs nobody, finds each of the ten rates, and only then says a word.

use crate::rig::*;
use bench::{AdapterId, BusRate, Flash, Source};
use plumbline::can::BitRate;
use plumbline::node::BusMode;

/// CAN_BTR.SILM.
const SILENT: u32 = 1 << 31;

/// What CAN_BTR must hold (RM0008, section 24.9.2) for a sample point of 87.5 % with 32 MHz: 16 time quanta, 13 of them in segment 1
/// and 2 in segment 2, a jump width of 2. At 800 kbit/s there are 8: 6 and 1, a jump width of 1.
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

/// Two machines that talk to each other, 20 and 33 ms between their frames.
struct Traffic {
    ends: [AdapterId; 2],
    number: u8,
}

impl Traffic {
    fn at(rig: &mut Rig, rate: BitRate) -> Self {
        let ends = [rig.tester, rig.bus.adapter()];
        for end in ends {
            rig.bus.open(end, Some(rate), false);
        }
        Self { ends, number: 0 }
    }

    fn millisecond(&mut self, rig: &mut Rig) {
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
fn each_of_the_ten_rates_is_found_without_disturbing_anybody() {
    for name in MODELS {
        for (rate, btr) in BIT_TIMING {
            let mut rig = Rig::with(name, BusRate::Wire, Flash::default());
            let mut traffic = Traffic::at(&mut rig, rate);
            for _ in 0..20_000 {
                traffic.millisecond(&mut rig);
                if rig.device().mode() == Some(BusMode::Normal) {
                    break;
                }
                assert!(rig.frames().is_empty(), "{name} at {rate:?}: not silent");
            }
            // Two frames of 160 bits at the slowest rate, and those of the others between.
            for _ in 0..150 {
                traffic.millisecond(&mut rig);
            }
            let boot_up = rig.frames();
            assert_eq!(boot_up.len(), 2, "{name} at {rate:?}: {boot_up:?}");
            // Table 16: the alive code, the status (default parameters, automatic detection), the Set-Parameter-ID, the version.
            let alive = data(REPLY, &[fsc::ALIVE, 3, 0x00, 0x03, 0, 0, 0x44, 0x03]);
            assert_eq!(boot_up, [alive, alive], "{name} at {rate:?}");
            assert_eq!(rig.device().rate(), Some(rate));
            traffic.assert_undisturbed(&rig);

            let history = rig.microcontroller().can().btr_history();
            let mut listened: Vec<_> = history.iter().copied().collect();
            let locked = listened.pop().map(|(_, btr)| btr);
            assert_eq!(locked, Some(btr), "{name} at {rate:?}");
            assert!(!listened.is_empty());
            assert!(listened.iter().all(|(_, btr)| btr & SILENT != 0));
            let (_, last) = listened[listened.len() - 1];
            assert_eq!(last, btr | SILENT, "locked where a frame was understood");
        }
    }
}

/// At a wrong rate one error follows the other, until the controller has left the bus. None of them may count at the next rate: it
/// could be the right one, and would be left again.
#[test]
fn on_a_full_bus_each_rate_is_found_at_the_first_visit() {
    for name in MODELS {
        for (rate, btr) in BIT_TIMING {
            let mut rig = Rig::with(name, BusRate::Wire, Flash::default());
            let traffic = Traffic::at(&mut rig, rate);
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
            assert_eq!(rig.device().rate(), Some(rate), "{name}");
            let history = rig.microcontroller().can().btr_history();
            let visits = history.iter().filter(|(_, one)| *one == btr | SILENT);
            assert_eq!(visits.count(), 1, "{name} at {rate:?}: {history:X?}");
            traffic.assert_undisturbed(&rig);
        }
    }
}

#[test]
fn without_traffic_a_sensor_listens_for_ever() {
    let mut rig = Rig::with("is2", BusRate::Wire, Flash::default());
    rig.bus.close(rig.tester);
    rig.run(5_000);
    assert!(rig.log.is_empty());
    let can = rig.microcontroller().can();
    assert!(can.btr_history().len() > 20, "it goes round");
    assert!(can.is_silent());
}
