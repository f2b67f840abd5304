//! Several controllers on one wire.

use super::*;

/// A bit at 500 kbit/s.
const BIT: Picoseconds = 2_000_000;

/// Upper limit of the time of a frame without data, including its intermission.
const FRAME: Picoseconds = 70 * BIT;

const ABOM: u32 = 1 << 6;
const BOFF: u32 = 1 << 2;

/// Controllers on a wire, which the test can force to a level.
struct Wire {
    cans: Vec<BxCan>,
    dominant: bool,
    held: Option<bool>,
    now: Picoseconds,
}

impl Wire {
    /// Controllers with these values of CAN_BTR, on the bus.
    fn joined(btr: &[u32]) -> Self {
        let mut wire = Self::new(btr);
        for can in 0..btr.len() {
            wire.set(can, MCR, 0);
        }
        wire.run(30 * BIT);
        for can in 0..btr.len() {
            assert_eq!(wire.get(can, MSR) & (INAK | SLAK), 0);
        }
        wire
    }

    fn new(btr: &[u32]) -> Self {
        Self {
            cans: btr.iter().map(|btr| initializing(*btr)).collect(),
            dominant: false,
            held: None,
            now: 10 * NOW,
        }
    }

    fn get(&mut self, can: usize, offset: u32) -> u32 {
        self.cans[can].read(self.now, offset).unwrap()
    }

    fn set(&mut self, can: usize, offset: u32, value: u32) {
        self.cans[can].write(self.now, offset, value).unwrap();
    }

    fn send(&mut self, can: usize, id: u32) {
        self.set(can, TDT0R, 0);
        self.set(can, TI0R, id << 21 | 1);
    }

    fn state(&mut self, can: usize) -> u32 {
        self.get(can, MSR) & (INAK | SLAK)
    }

    fn run(&mut self, time: Picoseconds) {
        let end = self.now + time;
        self.join_levels();
        while let Some(at) = self.next().filter(|at| *at < end) {
            self.now = at;
            for can in &mut self.cans {
                if can.next_event().is_some_and(|due| due <= at) {
                    can.step(at, self.dominant);
                }
            }
            self.join_levels();
        }
        self.now = end;
    }

    /// Runs until the condition is true; returns the elapsed time.
    fn run_until(&mut self, mut is_so: impl FnMut(&mut Self) -> bool) -> Picoseconds {
        let start = self.now;
        while !is_so(self) {
            assert!(self.now - start < 10_000 * BIT, "never");
            self.run(BIT / 8);
        }
        self.now - start
    }

    fn next(&self) -> Option<Picoseconds> {
        let due = self.cans.iter().filter_map(BxCan::next_event).min();
        due.map(|at| at.max(self.now))
    }

    fn join_levels(&mut self) {
        let driven = self.cans.iter().any(|can| can.is_dominant());
        let dominant = self.held.unwrap_or(driven);
        if dominant != self.dominant {
            self.dominant = dominant;
            for can in &mut self.cans {
                can.wire(self.now, dominant);
            }
        }
    }
}

/// A controller in bus-off after 32 failed transmissions, with a frame pending; MCR has the value `control`.
fn in_bus_off(control: u32) -> Wire {
    let mut wire = Wire::joined(&[BTR_500K, BTR_500K]);
    wire.set(0, MCR, control);
    wire.set(0, IER, 1 << 15 | 1 << 10);
    wire.send(0, 0x123);
    wire.held = Some(false);
    wire.run_until(|wire| wire.get(0, ESR) & BOFF != 0);
    wire.held = None;
    wire.run(FRAME);
    assert_eq!(wire.cans[0].lines(), [false, false, false, true]);
    wire
}

#[test]
fn controller_joins_after_eleven_recessive_bits() {
    let mut wire = Wire::new(&[BTR_500K]);
    wire.set(0, MCR, 0);
    wire.run(10 * BIT);
    assert_eq!(wire.state(0), INAK);
    wire.run(2 * BIT);
    assert_eq!(wire.state(0), 0);
    // It does not join while the wire is dominant.
    let mut stuck = Wire::new(&[BTR_500K]);
    stuck.held = Some(true);
    stuck.set(0, MCR, 0);
    stuck.run(100 * BIT);
    assert_eq!(stuck.state(0), INAK);
}

#[test]
fn frame_is_received_by_other_controller() {
    let mut wire = Wire::joined(&[BTR_500K, BTR_500K]);
    wire.send(0, 0x123);
    wire.run(FRAME);
    assert_eq!(wire.get(0, TSR) & 0xFF, 0b11);
    assert_eq!(wire.get(1, RF0R), 1);
    assert_eq!(wire.get(1, RI0R), 0x123 << 21);
    assert_eq!(
        wire.get(0, RF0R),
        0,
        "the transmitter does not receive its own frame"
    );
}

#[test]
fn frames_are_sent_in_order_of_identifiers() {
    let mut wire = Wire::joined(&[BTR_500K, BTR_500K]);
    for (mailbox, id) in [(0, 0x300), (1, 0x100), (2, 0x200)] {
        wire.set(0, TI0R + 16 * mailbox, id << 21 | 1);
    }
    wire.run(3 * FRAME);
    for id in [0x100, 0x200, 0x300] {
        assert_eq!(wire.get(1, RI0R) >> 21, id);
        wire.set(1, RF0R, 1 << 5);
    }
}

#[test]
fn lost_arbitration_sets_alst_and_retransmits() {
    let mut wire = Wire::joined(&[BTR_500K, BTR_500K]);
    wire.send(0, 0x200);
    wire.send(1, 0x100);
    wire.run(30 * BIT);
    assert_eq!(wire.get(0, TSR) & 0xFF, 1 << 2);
    wire.run(2 * FRAME);
    assert_eq!(wire.get(0, TSR) & 0xFF, 0b11);
    assert_eq!(wire.get(0, RI0R) >> 21, 0x100);
    assert_eq!(wire.get(1, RI0R) >> 21, 0x200);
}

#[test]
fn initialization_mode_waits_for_end_of_frame() {
    for asked in [0, 1] {
        let mut wire = Wire::joined(&[BTR_500K, BTR_500K]);
        wire.send(0, 0x123);
        wire.run(20 * BIT);
        wire.set(asked, MCR, INRQ);
        assert_eq!(wire.state(asked), 0);
        wire.run_until(|wire| wire.state(asked) == INAK);
        assert_eq!(wire.get(0, TSR) & 0xFF, 0b11);
        assert_eq!(wire.get(1, RF0R), 1);
    }
}

#[test]
fn lone_controller_becomes_error_passive_but_not_bus_off() {
    let mut wire = Wire::joined(&[BTR_500K]);
    wire.send(0, 0x123);
    wire.run(100 * FRAME);
    // TEC 128, last error: acknowledgment, passive and warning.
    assert_eq!(wire.get(0, ESR), 128 << 16 | 3 << 4 | 0b011);
    assert_eq!(wire.get(0, TSR) & 1, 0);
}

#[test]
fn silent_controller_receives_without_acknowledge() {
    let mut wire = Wire::joined(&[BTR_500K, SILM | BTR_500K]);
    wire.send(0, 0x123);
    wire.run(FRAME);
    assert_eq!(wire.get(0, ESR) >> 4 & 7, 3);
    // With another controller that acknowledges, it receives the frame.
    let mut wire = Wire::joined(&[BTR_500K, SILM | BTR_500K, BTR_500K]);
    wire.send(0, 0x123);
    wire.run(FRAME);
    assert_eq!(wire.get(0, TSR) & 0xFF, 0b11);
    assert_eq!(wire.get(1, RF0R), 1);
}

#[test]
fn silent_controller_at_other_rate_sees_errors_without_disturbing() {
    // 250 kbit/s.
    let mut wire = Wire::joined(&[BTR_500K, BTR_500K, SILM | 0x011C_0007]);
    wire.send(0, 0x123);
    wire.run_until(|wire| wire.get(2, ESR) >> 4 & 7 != 0);
    wire.run(FRAME);
    assert_eq!(wire.get(0, TSR) & 0xFF, 0b11);
    assert_eq!(wire.get(2, RF0R), 0);
}

#[test]
fn bus_off_lasts_until_software_requests_recovery() {
    let mut wire = in_bus_off(0);
    wire.run(3_000 * BIT);
    assert_eq!(wire.get(0, ESR) & BOFF, BOFF);
    assert_eq!(wire.state(0), 0);
    // Software enters and leaves initialization mode.
    wire.set(0, MCR, INRQ);
    assert_eq!(wire.state(0), INAK);
    wire.run(3_000 * BIT);
    assert_eq!(wire.get(0, ESR) & BOFF, BOFF);
    wire.set(0, MCR, 0);
    let joined = wire.run_until(|wire| wire.state(0) == 0);
    assert_eq!(joined / BIT, 11);
    assert_eq!(wire.get(0, ESR) & BOFF, BOFF);
    let recovered = joined + wire.run_until(|wire| wire.get(0, ESR) & BOFF == 0);
    assert_eq!(recovered / BIT, 128 * 11);
    assert_eq!(wire.get(0, ESR) & 0xFFFF_0007, 0);
    // The pending frame is sent.
    wire.run(FRAME);
    assert_eq!(wire.get(0, TSR) & 0xFF, 0b11);
    assert_eq!(wire.get(1, RI0R), 0x123 << 21);
}

#[test]
fn automatic_recovery_leaves_bus_off() {
    let mut wire = in_bus_off(ABOM);
    let recovered = wire.run_until(|wire| wire.get(0, ESR) & BOFF == 0);
    let passed = FRAME / BIT;
    assert!((128 * 11 - passed - 2..=128 * 11).contains(&(recovered / BIT)));
    wire.run(FRAME);
    assert_eq!(wire.get(0, TSR) & 0xFF, 0b11);
}

#[test]
fn bus_off_continues_on_dominant_wire() {
    let mut wire = in_bus_off(0);
    wire.held = Some(true);
    wire.set(0, MCR, INRQ);
    wire.set(0, MCR, 0);
    wire.run(3_000 * BIT);
    assert_eq!(wire.state(0), INAK);
    assert_eq!(wire.get(0, ESR) & BOFF, BOFF);
}

#[test]
fn only_reset_by_rcc_leaves_bus_off() {
    let mut wire = in_bus_off(0);
    let status = wire.get(0, ESR);
    wire.set(0, MCR, RESET);
    assert_eq!(wire.get(0, ESR), status);
    assert_eq!(wire.state(0), SLAK);
    wire.cans[0].reset();
    assert_eq!(wire.get(0, ESR), 0);
    assert_eq!(wire.state(0), SLAK);
}

#[test]
fn reset_during_own_frame_ends_the_frame() {
    let mut wire = Wire::joined(&[BTR_500K, BTR_500K]);
    wire.send(0, 0x123);
    wire.run(20 * BIT);
    // With an abort, the mailbox is empty then.
    wire.set(0, TSR, 1 << 7);
    wire.set(0, MCR, RESET);
    assert!(!wire.cans[0].is_dominant());
    assert_eq!(wire.get(0, TSR) >> 26 & 0b111, 0b111);
    wire.run(FRAME);
    assert_eq!(wire.get(1, RF0R), 0);
}

#[test]
fn bus_traffic_wakes_sleeping_controller() {
    let mut wire = Wire::joined(&[BTR_500K, BTR_500K, BTR_500K]);
    wire.set(2, MCR, 1 << 5 | SLEEP);
    assert_eq!(wire.state(2), SLAK);
    wire.send(0, 0x123);
    wire.run(FRAME);
    // It does not receive the frame that wakes it up.
    assert_eq!(wire.get(2, RF0R), 0);
    assert_eq!(wire.get(2, MSR) & 1 << 3, 1 << 3);
    wire.run_until(|wire| wire.state(2) == 0);
    wire.send(0, 0x124);
    wire.run(FRAME);
    assert_eq!(wire.get(2, RI0R), 0x124 << 21);
}

/// RM0008, 24.4.4.
#[test]
fn disturbed_loop_back_receives_only_own_frames_and_needs_no_acknowledgment() {
    const RECEIVED: u32 = 0b11;
    let mut wire = Wire::joined(&[BTR_500K]);
    assert!(wire.cans[0].disturb(wire.now, BTR, LBKM));
    wire.send(0, 0x123);
    wire.run(FRAME);
    assert_eq!(wire.get(0, TSR) & 0b1111, 0b11, "RQCP and TXOK");
    assert_eq!(wire.get(0, RF0R) & RECEIVED, 1);
    let mut wire = Wire::joined(&[BTR_500K, BTR_500K, BTR_500K]);
    assert!(wire.cans[0].disturb(wire.now, BTR, LBKM));
    wire.send(1, 0x123);
    wire.run(FRAME);
    let received = [0, 2].map(|can| wire.get(can, RF0R) & RECEIVED);
    assert_eq!(received, [0, 1]);
}

#[test]
fn disturbed_prescaler_changes_the_bit_time_at_once() {
    let mut wire = Wire::joined(&[BTR_500K]);
    // A prescaler of 8 instead of 4.
    assert!(wire.cans[0].disturb(wire.now, BTR, 1 << 2));
    assert_eq!(wire.cans[0].protocol().timing().bit, 2 * BIT);
}
