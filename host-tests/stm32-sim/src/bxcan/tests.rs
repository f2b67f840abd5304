//! Tests of the complete controller, through its registers and the wire.

mod frames;
mod silicon;
mod wire;

use super::*;
use crate::io::AccessError;
use can_wire::protocol::ErrorCode;
use plumbline::can::{BitRate, extended, standard};

const MCR: u32 = 0x000;
const MSR: u32 = 0x004;
const TSR: u32 = 0x008;
const RF0R: u32 = 0x00C;
const RF1R: u32 = 0x010;
const IER: u32 = 0x014;
const ESR: u32 = 0x018;
const BTR: u32 = 0x01C;
const TI0R: u32 = 0x180;
const TDT0R: u32 = 0x184;
const RI0R: u32 = 0x1B0;
const RDT0R: u32 = 0x1B4;
const RDL0R: u32 = 0x1B8;
const RDH0R: u32 = 0x1BC;
const FMR: u32 = 0x200;
const FM1R: u32 = 0x204;
const FS1R: u32 = 0x20C;
const FA1R: u32 = 0x21C;
const F0R1: u32 = 0x240;

const INRQ: u32 = 1;
const SLEEP: u32 = 1 << 1;
const TTCM: u32 = 1 << 7;
const RESET: u32 = 1 << 15;
const INAK: u32 = 1;
const SLAK: u32 = 1 << 1;
const SILM: u32 = 1 << 31;
const LBKM: u32 = 1 << 30;

/// 500 kbit/s at 32 MHz.
const BTR_500K: u32 = 0x011C_0003;

const NOW: Picoseconds = 1_000;

impl BxCan {
    fn get(&mut self, offset: u32) -> u32 {
        self.read(NOW, offset).expect("a register")
    }

    fn set(&mut self, offset: u32, value: u32) {
        self.write(NOW, offset, value).expect("a register");
    }

    fn acknowledged(&mut self) -> u32 {
        self.get(MSR) & (INAK | SLAK)
    }

    /// The registers and reasons of the violations.
    fn violation_list(&self) -> Vec<(&str, &str)> {
        self.violations()
            .iter()
            .map(|violation| (violation.register, violation.reason.as_str()))
            .collect()
    }
}

/// A controller whose changes take no time, with a genuine CAN_FMR.
fn at_once() -> BxCan {
    let mut can = BxCan::new();
    can.set_silicon(Silicon {
        reset: ResetTime::Cycles(0),
        mode: 0,
        release: 0,
        lock_after: None,
        ..Silicon::default()
    });
    can
}

/// In initialization mode, with bit timing, and with a bank that accepts every frame.
fn initializing(btr: u32) -> BxCan {
    let mut can = at_once();
    can.set_clock(32_000_000);
    can.set(MCR, INRQ);
    can.set(BTR, btr);
    can.set(FS1R, 1);
    can.set(FA1R, 1);
    can.set(FMR, 0x2A1C_0E00);
    can
}

fn on_the_bus(btr: u32) -> BxCan {
    let mut can = initializing(btr);
    can.set(MCR, 0);
    can.event(NOW, Event::Joined);
    assert_eq!(can.acknowledged(), 0);
    assert_eq!(can.violation_list(), []);
    can
}

fn frame(id: u16) -> Frame {
    Frame::data(standard(id), &[1, 2, 3]).unwrap()
}

/// Requests the transmission of an empty frame in mailbox 0.
fn request(can: &mut BxCan, id: u32) {
    can.set(TDT0R, 0);
    can.set(TI0R, id << 21 | 1);
}

#[test]
fn reset_values() {
    let mut can = at_once();
    for (offset, value) in [
        (MCR, 0x0001_0002),
        (MSR, 0x0000_0C02),
        (TSR, 0x1C00_0000),
        (RF0R, 0),
        (RF1R, 0),
        (IER, 0),
        (ESR, 0),
        (BTR, 0x0123_0000),
        (FMR, 0x2A1C_0E01),
        (FM1R, 0),
        (FS1R, 0),
        (FA1R, 0),
    ] {
        assert_eq!(can.get(offset), value, "{offset:03X}h");
    }
    assert_eq!(can.lines(), [false; 4]);
    assert_eq!(can.bit_rate(), None);
}

#[test]
fn mode_changes_from_sleep_through_initialization_to_normal() {
    let mut can = at_once();
    can.set_clock(32_000_000);
    assert_eq!(can.acknowledged(), SLAK);
    can.set(MCR, INRQ);
    assert_eq!(can.acknowledged(), INAK);
    can.set(BTR, BTR_500K);
    assert_eq!(can.bit_rate(), None);
    can.set(MCR, 0);
    assert_eq!(can.acknowledged(), INAK);
    assert_eq!(can.bit_rate(), Some(500_000));
    can.event(NOW, Event::Joined);
    assert_eq!(can.acknowledged(), 0);
    can.set(MCR, SLEEP);
    assert_eq!(can.acknowledged(), SLAK);
    assert_eq!(can.violation_list(), []);
}

#[test]
fn ten_bit_rates_match_btr() {
    // Prescaler, segments 1 and 2 of the table of the board: 32 MHz.
    let table = [
        (200, 13, 2),
        (100, 13, 2),
        (40, 13, 2),
        (32, 13, 2),
        (20, 13, 2),
        (16, 13, 2),
        (8, 13, 2),
        (4, 13, 2),
        (5, 6, 1),
        (2, 13, 2),
    ];
    for (rate, (prescaler, before, after)) in BitRate::ALL.into_iter().zip(table) {
        let can = on_the_bus((after - 1) << 20 | (before - 1) << 16 | (prescaler - 1));
        assert_eq!(can.bit_rate(), Some(rate.bits_per_second()));
        assert!(!can.is_silent());
    }
}

#[test]
fn btr_write_outside_initialization_mode_is_violation() {
    let mut can = on_the_bus(BTR_500K);
    can.set(BTR, 0x011C_0001);
    assert_eq!(can.get(BTR), BTR_500K);
    assert_eq!(
        can.violation_list(),
        [("CAN_BTR", "written outside initialization mode")]
    );
    assert_eq!(*can.btr_history(), [(NOW, BTR_500K)]);
    let mut joining = initializing(BTR_500K);
    joining.set(MCR, 0);
    joining.set(BTR, 0x011C_0001);
    assert_eq!(joining.violation_list().len(), 1);
}

#[test]
fn invalid_timing_is_violation_when_joining_the_bus() {
    let mut can = initializing(0x011C_0000);
    assert_eq!(can.violation_list(), []);
    can.set(MCR, 0);
    assert_eq!(
        can.violation_list(),
        [("CAN_BTR", "2000000 bit/s are more than CAN permits")]
    );
    assert_eq!(can.violations()[0].at, NOW);
}

#[test]
fn clock_change_on_the_bus_is_violation() {
    let mut can = on_the_bus(BTR_500K);
    can.set_clock(32_000_000);
    assert_eq!(can.violation_list(), []);
    can.set_clock(36_000_000);
    let reason = "changed from 32000000 to 36000000 Hz while on the bus";
    assert_eq!(can.violation_list(), [("PCLK1", reason)]);
}

#[test]
fn loop_back_is_a_violation() {
    let mut can = initializing(BTR_500K);
    assert_eq!(can.write(NOW, BTR, BTR_500K | LBKM), Ok(()));
    let reason = "LBKM: a sensor has no use for loop back";
    assert_eq!(can.violation_list(), [("CAN_BTR", reason)]);
}

#[test]
fn modes_not_modelled_are_refused() {
    let mut can = initializing(BTR_500K);
    assert!(matches!(
        can.write(NOW, MCR, INRQ | TTCM),
        Err(AccessError::Refused(_))
    ));
    assert_eq!(can.read(NOW, 0x20), Err(AccessError::Unmapped));
    assert_eq!(can.write(NOW, 0x20, 0), Err(AccessError::Unmapped));
}

#[test]
fn change_of_reserved_bits_is_violation() {
    for (offset, value, register) in [
        (MCR, 0x0002_0001, "CAN_MCR"),
        (MSR, 0x0000_1000, "CAN_MSR"),
        (TSR, 0x0000_0010, "CAN_TSR"),
        (RF1R, 0x0000_0004, "CAN_RF1R"),
        (IER, 0x0000_0080, "CAN_IER"),
        (ESR, 0x0000_0008, "CAN_ESR"),
        (BTR, 0x0080_0000, "CAN_BTR"),
        (FMR, 0x0000_0001, "CAN_FMR"),
        (FA1R, 0x0000_4000, "CAN_FA1R"),
    ] {
        let mut can = at_once();
        can.set(MCR, INRQ);
        can.set(offset, value);
        assert_eq!(can.violations()[0].register, register);
        assert!(can.violations()[0].reason.contains("reserved"));
        assert_eq!(can.violations().len(), 1);
    }
    let mut can = at_once();
    can.set(FMR, 0x2A1C_0E01);
    assert_eq!(can.violation_list(), []);
}

#[test]
fn start_of_frame_in_sleep_mode_is_interrupt() {
    let mut can = at_once();
    can.set_clock(32_000_000);
    can.set(IER, 1 << 16);
    can.wire(NOW, true);
    assert_eq!(can.lines(), [false, false, false, true]);
    assert_eq!(can.get(MSR), 1 << 10 | 1 << 3 | SLAK);
    can.wire(NOW, false);
    can.set(MSR, 1 << 3);
    assert_eq!(can.get(MSR), 0x0C00 | SLAK);
    // AWUM: 11 recessive bits later it takes part.
    can.set(MCR, 1 << 5 | SLEEP);
    can.wire(NOW, true);
    assert_eq!(can.get(MCR), 1 << 5);
    assert_eq!(can.acknowledged(), SLAK);
    can.event(NOW, Event::Joined);
    assert_eq!(can.acknowledged(), 0);
}

#[test]
fn entry_into_sleep_mode_is_interrupt() {
    let mut can = on_the_bus(BTR_500K);
    can.set(IER, 1 << 17);
    can.set(MCR, SLEEP);
    assert_eq!(can.lines(), [false, false, false, true]);
    can.set(MSR, 1 << 4);
    assert_eq!(can.lines(), [false; 4]);
}

#[test]
fn reset_bit_of_mcr_resets_only_mcr_and_pending_messages() {
    let mut can = on_the_bus(BTR_500K);
    can.set(IER, 1 << 1);
    request(&mut can, 0x123);
    can.event(NOW, Event::Received(frame(1)));
    can.set(ESR, 7 << 4);
    can.set(MCR, RESET);
    assert_eq!(can.get(MCR), 0x0001_0002);
    assert_eq!(can.get(RF0R), 0);
    assert_eq!(can.acknowledged(), SLAK);
    assert_eq!(can.get(TSR) >> 26 & 0b111, 0b110, "the request stays");
    assert_eq!(can.get(IER), 1 << 1);
    assert_eq!(can.get(ESR), 7 << 4);
    assert_eq!(can.get(BTR), BTR_500K);
    assert_eq!(can.get(FA1R), 1);
    assert_eq!(can.violation_list(), []);
    assert_eq!(can.btr_history().len(), 1);
}

#[test]
fn lec_write_other_than_seven_is_violation() {
    let mut can = at_once();
    can.set(ESR, 7 << 4);
    assert_eq!(can.get(ESR), 7 << 4);
    can.set(ESR, 2 << 4);
    assert_eq!(
        can.violation_list(),
        [("CAN_ESR", "LEC: software may write 7 only")]
    );
}

#[test]
fn filter_violation_names_register() {
    let mut can = on_the_bus(BTR_500K);
    can.set(FM1R, 1);
    can.set(F0R1, 1);
    can.set(F0R1 + 14 * 8, 1);
    assert_eq!(
        can.violation_list(),
        [
            ("CAN_FM1R", "written without CAN_FMR.FINIT"),
            ("CAN_FiR1", "filter bank 0 is active"),
            ("CAN_FiR1", "there is no filter bank 14"),
        ]
    );
}
