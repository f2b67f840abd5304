//! Boot-up, saving, loading and restarting of the FSC sensors (manual 9.6, 9.8, 9.10.7, 9.10.8).
//!
//! Section and table numbers refer to the English manual of 2021.

use crate::tester::fsc::*;
use crate::tester::leds;
use plumbline::can::{BitRate, Frame, extended, standard};
use plumbline::model::gemac::is2::{self, TwoAxes};
use plumbline::node::{Action, BitTime, Boot, BusEvent, BusMode, Leds, Node};

#[test]
fn boot_up_is_sent_twice_after_bit_rate_detection() {
    let mut tester: FscTester<TwoAxes> = power_up(&is2::BP_CL);
    assert_eq!(
        tester.actions,
        [
            Action::Bus(BusMode::Listen, BitRate::K250),
            Action::Leds(leds(true, false))
        ]
    );
    assert_eq!(tester.wait(10_000), [], "no frame during the search");
    let rate = BitRate::K62_5;
    tester.bus(BusEvent::Error);
    tester.bus(BusEvent::BitTime(BitTime::of(rate)));
    let listens = Action::Bus(BusMode::Listen, rate);
    assert_eq!(tester.actions.last(), Some(&listens));
    // The request by which the bit rate is detected is not answered.
    tester.receive(Frame::data(standard(0x300), &[0]).unwrap());
    assert!(tester.actions.contains(&Action::Bus(BusMode::Normal, rate)));
    let boot_up = Frame::data(
        standard(0x301),
        &[0xFF, DELIVERED, 0x00, 0x03, 0, 0, 0x44, 0x03],
    )
    .unwrap();
    assert_eq!(tester.sent(), [boot_up, boot_up]);
    assert_eq!(tester.leds, leds(true, false));
}

#[test]
fn written_identifiers_act_after_restart_and_must_differ() {
    let mut tester = is2();
    tester.ask(&[0x20, 0x00, 0x04, 0, 0]); // 400h after the next restart
    tester.ask(&[0x22, 0x00, 0x03, 0, 0]); // 300h is free now
    assert_eq!(tester.ask(&[0x12])[2..], [0x00, 0x03, 0, 0]);
    // 300h is still in force, and the alive reply contains it.
    assert_eq!(
        tester.ask(&[0xFF]),
        [0xFF, AUTOBAUD, 0x00, 0x03, 0, 0, 0x44, 0x03]
    );
    // Without a save, the previous identifiers are in force after the restart.
    tester.silent(b"\xFFRESET");
    assert!(tester.actions.contains(&Action::Restart));
    tester.power_cycle();
    assert_eq!(tester.memory, None);
}

#[test]
fn saved_parameters_are_in_force_after_power_cycle() {
    let mut tester = is2();
    tester.ask(&[0x20, 0x61, 0x03, 0, 0x80]);
    tester.ask(&[0x21, 0x62, 0x03, 0, 0x80]);
    tester.ask(&[0x23, 7]);
    assert_eq!(tester.ask(b"\x50SAVE and more"[..8].into()), [0x50, 0]);
    tester.actions.clear();
    tester.power_cycle();
    assert!(
        tester
            .actions
            .contains(&Action::Bus(BusMode::Normal, BitRate::K500))
    );
    let boot_up =
        Frame::data(extended(0x362), &[0xFF, 0, 0x61, 0x03, 0, 0x80, 0x44, 0x03]).unwrap();
    assert_eq!(tester.sent(), [boot_up, boot_up]);
    tester.receive(Frame::data(extended(0x361), &[0x00]).unwrap());
    assert_eq!(
        tester.sent(),
        [Frame::data(extended(0x362), &[0, 0, 0, 0, 0, 0]).unwrap()]
    );
    assert!(tester.accepts(extended(0x361)));
    assert!(tester.accepts(standard(0x100)));
    assert!(!tester.accepts(standard(0x300)));
}

#[test]
fn load_acts_at_once_except_identifiers_and_baud_rate() {
    let mut tester = is2();
    for write in [
        &[0x20, 0, 4, 0, 0][..],
        &[0x23, 6],
        &[0x28, 100, 0],
        &[0x25, 10, 0],
        &[0x26, 1],
    ] {
        tester.ask(write);
    }
    tester.ask(b"\x50SAVE");
    tester.power_cycle();
    tester.sent();
    tester.receive(Frame::data(standard(0x400), b"\x40LOAD").unwrap());
    assert_eq!(
        tester.sent(),
        [Frame::data(standard(0x301), &[0x40, DELIVERED]).unwrap()]
    );
    assert_eq!(tester.wait(1000), [], "cyclic mode is off");
    // 400h is in force until the restart. A read returns the factory value.
    tester.receive(Frame::data(standard(0x400), &[0x10]).unwrap());
    assert_eq!(tester.sent()[0].bytes(), [0x10, DELIVERED, 0, 3, 0, 0]);
    tester.power_cycle();
    assert!(
        tester
            .actions
            .contains(&Action::Bus(BusMode::Listen, BitRate::K250))
    );
}

#[test]
fn failed_save_or_load_sets_error_and_changes_nothing() {
    let mut tester = is2();
    tester.ask(&[0x28, 100, 0]);
    tester.memory_works = Some(false);
    let status = AUTOBAUD | CMD_PARAM_ERROR | EEPROM_ERROR;
    assert_eq!(tester.ask(b"\x50SAVE"), [0x50, status]);
    assert_eq!(tester.ask(&[0x02]), [0x02, status]);
    assert_eq!(tester.ask(&[0x02]), [0x02, AUTOBAUD]);
    assert_eq!(tester.ask(b"\x40LOAD"), [0x40, status]);
    assert_eq!(tester.ask(&[0x18])[2..], [100, 0]);
}

#[test]
fn damaged_memory_gives_factory_values_and_error() {
    let damaged = Boot {
        damaged: true,
        ..Boot::default()
    };
    // Values that are not permitted in a record with a correct CRC.
    let nonsense = Boot {
        parameters: Some(&[0xEE; 24]),
        ..Boot::default()
    };
    for loaded in [damaged, nonsense] {
        let mut tester: FscTester<TwoAxes> = with_memory(&is2::BP_CL, loaded);
        tester.receive(Frame::data(standard(0x300), &[0]).unwrap());
        assert_eq!(
            tester.sent()[0].bytes()[..2],
            [0xFF, DELIVERED | EEPROM_ERROR]
        );
        assert_eq!(tester.ask(&[0x02]), [0x02, DELIVERED | EEPROM_ERROR]);
        assert_eq!(tester.ask(&[0x02]), [0x02, DELIVERED]);
    }
}

#[test]
fn queued_replies_are_sent_before_a_restart() {
    let mut tester = is2();
    tester.receive(Frame::data(standard(0x300), &[0x02]).unwrap());
    tester.receive(Frame::data(standard(0x300), b"\xFFRESET!!").unwrap());
    assert!(!tester.actions.contains(&Action::Restart));
    assert_eq!(tester.sent().len(), 1);
    assert_eq!(tester.actions.last(), Some(&Action::Restart));
    assert_eq!(tester.leds, Leds::default());
}

#[test]
fn write_during_load_is_not_lost() {
    let mut tester = is2();
    tester.ask(&[0x28, 100, 0]);
    tester.memory_works = None;
    tester.silent(b"\x40LOAD");
    // During the load, reads are answered and a write waits.
    assert_eq!(tester.ask(&[0x18])[2..], [100, 0]);
    tester.silent(&[0x24, 1]);
    assert_eq!(tester.ask(&[0x18])[2..], [100, 0]);
    // A third request waits in the driver.
    tester.silent(&[0x25, 10, 0]);
    assert!(!tester.node.ready());
    tester.finish_save(Ok(()));
    let replies: Vec<_> = tester
        .sent()
        .iter()
        .map(|frame| frame.bytes().to_vec())
        .collect();
    assert_eq!(
        replies,
        [
            vec![0x40, DELIVERED],
            vec![0x24, AUTOBAUD],
            vec![0x25, AUTOBAUD]
        ]
    );
    assert_eq!(tester.ask(&[0x14])[2..], [1]);
    assert_eq!(tester.ask(&[0x18])[2..], [0, 0]);
}

/// Only a SAVE, a LOAD and a restart wait for the end of a save.
#[test]
fn requests_during_a_save_are_answered_at_once() {
    let mut tester = is2();
    tester.ask(&[0x28, 100, 0]);
    tester.memory_works = None;
    tester.silent(b"\x50SAVE");
    assert_eq!(tester.ask(&[0x24, 1]), [0x24, AUTOBAUD]);
    assert_eq!(tester.ask(&[0x14])[2..], [1]);
    assert_eq!(tester.ask(&[0xFF])[..2], [0xFF, AUTOBAUD]);
    let refused = AUTOBAUD | CMD_PARAM_ERROR;
    assert_eq!(tester.ask(&[0x99]), [0x99, refused]);
    assert_eq!(tester.ask(&[0x02]), [0x02, refused]);
    tester.silent(b"\x50SAVE");
    tester.finish_save(Ok(()));
    assert_eq!(tester.sent().len(), 1, "the second save runs");
    tester.finish_save(Ok(()));
    assert_eq!(tester.sent().len(), 1);
}

#[test]
fn image_of_firmware_without_the_last_parameter_keeps_the_others() {
    let mut tester = is2();
    tester.ask(&[0x25, 0x21, 0x43]);
    tester.ask(&[0x28, 100, 0]);
    tester.ask(&[0x29, 200, 0]);
    tester.ask(b"\x50SAVE");
    let memory = tester.memory.clone().unwrap();
    // The last parameter is the zero offset Y, two bytes.
    let older = Boot {
        parameters: memory.get(..memory.len() - 2),
        ..Boot::default()
    };
    let mut tester = with_memory::<TwoAxes>(&is2::BP_CL, older);
    tester.receive(Frame::data(standard(0x7FF), &[]).unwrap());
    tester.sent();
    assert_eq!(tester.ask(&[0x02])[1] & EEPROM_ERROR, 0);
    assert_eq!(tester.ask(&[0x15])[2..], [0x21, 0x43]);
    assert_eq!(tester.ask(&[0x18])[2..], [100, 0]);
    assert_eq!(tester.ask(&[0x19])[2..], [0, 0], "the factory value");
}

#[test]
fn write_after_waiting_load_is_not_lost() {
    let mut tester = is2();
    tester.memory_works = None;
    tester.silent(b"\x50SAVE");
    tester.silent(b"\x40LOAD");
    tester.silent(&[0x24, 1]);
    tester.finish_save(Ok(()));
    tester.finish_save(Ok(()));
    assert_eq!(tester.sent().len(), 3);
    assert_eq!(tester.ask(&[0x14])[2..], [1]);
}

#[test]
fn request_after_waiting_reset_is_not_executed() {
    let mut tester = is2();
    tester.memory_works = None;
    tester.silent(b"\x50SAVE");
    tester.silent(b"\xFFRESET");
    tester.silent(b"\x40LOAD");
    tester.finish_save(Ok(()));
    tester.wait(0);
    assert!(tester.actions.contains(&Action::Restart));
    let saves = tester
        .actions
        .iter()
        .filter(|action| **action == Action::Save);
    assert_eq!(saves.count(), 1);
}
