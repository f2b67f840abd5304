//! Behaviour of the silicon: the time of changes, CAN2SB, the lock of the transmit output.

use super::*;

#[test]
fn reset_bit_of_mcr_stays_set_for_its_time() {
    let mut can = on_the_bus(BTR_500K);
    can.set_silicon(Silicon {
        reset: ResetTime::Cycles(32),
        mode: 16,
        ..can.silicon()
    });
    let us = 1_000_000;
    let mut at = |time, offset| can.read(time, offset).unwrap();
    assert_eq!(at(NOW, MSR) & (INAK | SLAK), 0);
    can.set(MCR, RESET);
    // Other writes have no effect during the reset.
    can.set(MCR, INRQ);
    let mut at = |time, offset| can.read(time, offset).unwrap();
    assert_eq!(at(NOW + us - 1, MCR), 0x0001_8002);
    assert_eq!(at(NOW + us - 1, MSR) & (INAK | SLAK), 0);
    assert_eq!(at(NOW + us, MCR), 0x0001_0002);
    assert_eq!(at(NOW + us, MSR) & (INAK | SLAK), 0);
    assert_eq!(at(NOW + us + us / 2, MSR) & (INAK | SLAK), SLAK);
    can.set_silicon(Silicon {
        reset: ResetTime::Endless,
        ..can.silicon()
    });
    can.set(MCR, RESET);
    assert_eq!(can.read(1 << 60, MCR), Ok(0x0001_8002));
    // Only a reset by RCC ends it.
    can.reset();
    assert_eq!(can.get(MCR), 0x0001_0002);
    assert_eq!(can.acknowledged(), SLAK);
}

#[test]
fn initialization_mode_is_acknowledged_after_its_time() {
    let mut can = at_once();
    can.set_clock(32_000_000);
    can.set_silicon(Silicon {
        mode: 32,
        ..can.silicon()
    });
    can.set(MCR, INRQ | SLEEP);
    assert_eq!(can.next_event(), Some(NOW + 1_000_000));
    assert_eq!(can.acknowledged(), SLAK);
    assert_eq!(can.read(NOW + 1_000_000, MSR).unwrap() & 3, INAK | SLAK);
    can.write(NOW + 1_000_000, MCR, INRQ).unwrap();
    assert_eq!(can.read(NOW + 1_000_000, MSR).unwrap() & 3, INAK);
}

#[test]
fn released_mailbox_is_pending_for_its_time() {
    let mut can = on_the_bus(BTR_500K);
    can.set_silicon(Silicon {
        release: 32,
        ..can.silicon()
    });
    can.set(IER, 1 << 1);
    can.event(NOW, Event::Received(frame(1)));
    can.set(RF0R, 1 << 5);
    assert_eq!(can.get(RF0R), 1 << 5 | 1);
    assert_eq!(can.next_event(), Some(NOW + 1_000_000));
    can.step(NOW + 1_000_000, false);
    assert!(can.take_changed());
    assert_eq!(can.lines(), [false; 4]);
    assert_eq!(can.get(RF0R), 0);
    assert_eq!(can.violation_list(), []);
}

#[test]
fn code_of_tsr_is_number_of_free_mailbox_or_a_constant() {
    for (mailbox_code, code) in [(None, 1), (Some(0), 0), (Some(3), 3)] {
        let mut can = on_the_bus(BTR_500K);
        can.set_silicon(Silicon {
            mailbox_code,
            ..can.silicon()
        });
        can.set(TI0R, 1);
        // Mailboxes 1 and 2 are empty.
        assert_eq!(can.get(TSR) >> 24 & 0b1_1111, 0b11000 | code);
    }
}

#[test]
fn content_of_can2sb_is_that_of_the_chip() {
    let mut can = at_once();
    can.set_silicon(Silicon {
        filter_master: 0,
        ..can.silicon()
    });
    assert_eq!(can.get(FMR), 1);
    can.set(FMR, 0);
    assert_eq!(can.violation_list(), []);
    can.set(FMR, 0x2A1C_0E00);
    assert_eq!(can.violations()[0].register, "CAN_FMR");
    assert_eq!(can.get(FMR), 0);
}

#[test]
fn frame_in_silent_mode_after_reset_locks_output_until_next_reset() {
    let mut can = initializing(SILM | BTR_500K);
    can.set_silicon(Silicon {
        lock_after: Some(1),
        ..can.silicon()
    });
    for uses in 0..2 {
        can.set(MCR, INRQ);
        can.set(BTR, SILM | BTR_500K);
        can.set(MCR, 0);
        can.event(NOW, Event::Joined);
        can.event(NOW, Event::Received(frame(1)));
        assert_eq!(can.is_dominant(), uses == 1);
        // RESET does not end it.
        can.set(MCR, RESET);
        assert_eq!(can.is_dominant(), uses == 1);
        can.reset();
        assert!(!can.is_dominant());
    }
    can.power_on();
    can.set(MCR, INRQ);
    can.set(BTR, SILM | BTR_500K);
    can.set(MCR, 0);
    can.event(NOW, Event::Received(frame(1)));
    assert!(!can.is_locked(), "first use since power-up");
}

#[test]
fn reserved_bits_read_as_in_the_silicon_and_are_written_as_read_or_as_in_the_manual() {
    let mut can = at_once();
    can.set_silicon(Silicon {
        reserved: !0,
        ..can.silicon()
    });
    can.set(MCR, INRQ);
    assert_eq!(can.get(MCR), 0xFFFE_7F00 | INRQ);
    for reserved in [0, 0x3C80_FC00] {
        can.set(BTR, BTR_500K | reserved);
        assert_eq!(can.get(BTR), BTR_500K | 0x3C80_FC00);
    }
    assert!(can.violations().is_empty());
    can.set_silicon(Silicon::default());
    assert_eq!(can.get(BTR), BTR_500K);
}
