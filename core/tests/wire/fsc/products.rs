//! What each GEMAC product answers: identity, boot-up, function select codes and ignored frames (manual 9.5 to 9.7).

use crate::tester::canopen::frame;
use crate::tester::fsc::CMD_PARAM_ERROR;
use crate::tester::gemac::*;
use plumbline::can::{CanId, Frame, extended, standard};
use plumbline::fsc::Product;
use plumbline::node::Action;

#[test]
fn numbers_and_version_match_manual() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        let number = sheet.product_number.to_le_bytes();
        let revision = [1, 0];
        let reply = [&[0x03, unit.status()], &number[..], &revision].concat();
        unit.ask(&[0x03], &reply);
        let serial = [1, 2, 3, 4];
        let reply = [&[0x04, unit.status()], &serial[..], &sheet.version].concat();
        unit.ask(&[0x04], &reply);
        unit.ask(&[0xFF], &unit.alive());
        assert_eq!(unit.tester.wait(1000), [], "one alive message");
    }
    each_product!(check);
}

/// The frame that shows the bit rate is not answered (G21).
#[test]
fn first_frame_of_any_kind_causes_two_boot_up_messages_and_no_reply() {
    const FRAMES: [&str; 8] = [
        "300#00",
        "300#FF",
        "300#FF5245534554",
        "300#01",
        "7FE#0102",
        "100#",
        "7FE#R",
        "00001234#",
    ];
    fn check<P: Product>(sheet: &'static Sheet) {
        for first in FRAMES {
            let mut unit = sheet.power_up::<P>();
            assert_eq!(unit.tester.wait(150), []);
            unit.tester.receive(frame(first));
            unit.boots();
            assert_eq!(unit.tester.wait(1000), [], "after {first}");
            assert!(!unit.tester.actions.contains(&Action::Restart), "{first}");
            unit.ask(&[0x00], &unit.inclination(None));
            unit.keeps_values();
        }
    }
    each_product!(check);
}

#[test]
fn code_that_the_product_does_not_have_is_refused() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        for code in (0..=0xFF).filter(|code| !sheet.has(*code)) {
            unit.refuses(&[code]);
            for data in [&b"SAVELOA"[..], b"LOAD", b"RESET"] {
                unit.refuses(&[&[code], data].concat());
            }
        }
    }
    each_product!(check);
}

#[test]
fn reads_are_answered_with_any_number_of_further_bytes() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        for size in 0..8 {
            let further = &[0xA1, 0x53, 0x41, 0x56, 0x45, 0x00, 0xFF][..size];
            let status = [0x02, unit.status()];
            let mut replies = vec![status.to_vec(), unit.inclination(None)];
            replies.extend((0..sheet.parameters.len()).map(|place| unit.reading(place)));
            for reply in replies {
                unit.ask(&[&reply[..1], further].concat(), &reply);
            }
        }
    }
    each_product!(check);
}

#[test]
fn request_without_data_is_not_answered_and_sets_error() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        unit.tester.receive(unit.frame(0, &[]));
        assert_eq!(unit.tester.sent(), []);
        unit.errors |= CMD_PARAM_ERROR;
        unit.clears_errors();
    }
    each_product!(check);
}

/// Remote frames, other identifiers, the other format, and sync frames with data (G11, G26).
fn ignores_foreign_frames<P: Product>(unit: &mut Unit<P>, identifiers: [u32; 3]) {
    let id = |bits| CanId::from_bits(bits).into();
    let data = |bits, data: &[u8]| Frame::data(id(bits), data).unwrap();
    let [set, reply, sync] = identifiers;
    for bits in identifiers {
        for length in [0, 1, 4, 8] {
            unit.ignores(Frame::remote(id(bits), length).unwrap());
        }
        // The same number, or the same first eleven bits, in the other format.
        let number = bits & !EXTENDED;
        let mut others = vec![bits ^ EXTENDED];
        if bits < EXTENDED {
            others.push(EXTENDED | number << 18);
        }
        for other in others {
            for request in [&[][..], &[0x00], &[0x01], b"\xFFRESET"] {
                unit.ignores(data(other, request));
            }
        }
    }
    for request in [&[0x00][..], &[0x01], &[0x02], &[], b"\x50SAVE"] {
        unit.ignores(data(reply, request));
        unit.ignores(data(set ^ 2, request));
    }
    for size in 1..=8 {
        unit.ignores(data(sync, &[0; 8][..size]));
    }
}

#[test]
fn frames_that_are_no_requests_are_ignored() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        ignores_foreign_frames(&mut unit, [0x300, 0x301, 0x100]);
        // The same with identifiers of 29 bits.
        for (place, value) in IDENTIFIERS.into_iter().zip([0x300, 0x301, 0x100]) {
            unit.accepts(place, EXTENDED | value);
        }
        unit.saves();
        let values = unit.values.clone();
        unit.power_cycle(&values);
        unit.wake();
        ignores_foreign_frames(&mut unit, [0x300, 0x301, 0x100].map(|id| EXTENDED | id));
        unit.tester.receive(unit.frame(2, &[]));
        let reply = unit.frame(1, &unit.inclination(None));
        assert_eq!(unit.tester.sent(), [reply]);
        assert!(unit.tester.accepts(extended(0x300)) && !unit.tester.accepts(standard(0x300)));
    }
    each_product!(check);
}

/// CmdParamError is in every reply until 02h, which still has it (G17).
#[test]
fn error_is_set_in_every_reply_until_status_is_read() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        unit.errors = CMD_PARAM_ERROR;
        unit.acknowledges(&[0x2F]);
        unit.ask(&[0x00], &unit.inclination(None));
        unit.keeps_values();
        unit.accepts(CYCLIC_TIME, 251);
        unit.accepts(CYCLIC_TIME, 250);
        unit.ask(&[0xFF], &unit.alive());
        unit.tester.receive(unit.frame(2, &[]));
        let reply = unit.frame(1, &unit.inclination(None));
        assert_eq!(unit.tester.sent(), [reply]);
        unit.saves();
        unit.acknowledges(&[0x2F]);
        unit.clears_errors();
        unit.ask(&[0x00], &unit.inclination(None));
    }
    each_product!(check);
}

/// FFh: one alive message; other data than RESET are discarded, so a master can fill its frames up. A spoiled RESET also sets
/// CmdParamError (G14). RESET: no reply, and further bytes are ignored (G26).
#[test]
fn only_signature_restarts() {
    const SPOILED: [&[u8]; 8] = [
        b"R",
        b"RE",
        b"RES",
        b"RESE",
        b"RESES",
        b"RESEt",
        b"RESE\0",
        b"R\0\0\0\0\0\0",
    ];
    const PADDING: [&[u8]; 7] = [
        &[0; 7],
        &[0xFF; 7],
        &[0x55],
        b"reset",
        b"XESET",
        b" RESET",
        b"SAVE",
    ];
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        unit.tester.actions.clear();
        for data in PADDING {
            unit.ask(&[b"\xFF", data].concat(), &unit.alive());
        }
        for data in SPOILED {
            unit.errors = CMD_PARAM_ERROR;
            unit.ask(&[b"\xFF", data].concat(), &unit.alive());
            unit.clears_errors();
        }
        assert!(!unit.tester.actions.contains(&Action::Restart));
        for further in [&b""[..], b"!", b"\x00\xFF"] {
            unit.errors = CMD_PARAM_ERROR;
            unit.acknowledges(&[0x2F]);
            let request = [b"\xFFRESET", further].concat();
            unit.tester.receive(unit.frame(0, &request));
            assert_eq!(unit.tester.sent(), []);
            assert!(unit.tester.actions.contains(&Action::Restart));
            // The restart detects the bit rate again and clears the errors (G27).
            let values = unit.values.clone();
            unit.power_cycle(&values);
            assert_eq!(unit.tester.wait(300), []);
            unit.wake();
            unit.acknowledges(&[0x02]);
        }
    }
    each_product!(check);
}
