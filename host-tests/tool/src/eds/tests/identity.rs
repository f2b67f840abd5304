//! The identity in the data sheet and the identity of the device.

use super::super::*;
use super::{FOREIGN, foreign};
use crate::link::tests::{Scripted, frame, link};
use crate::master::{Node, Target};
use plumbline::can::Frame;
use std::rc::Rc;

/// The answer to a read of object 1018h.
fn says(sub: u8, number: u32) -> Frame {
    let [a, b, c, d] = number.to_le_bytes();
    frame(0x58A, &[0x43, 0x18, 0x10, sub, a, b, c, d])
}

/// The device has no such object.
fn refuses(sub: u8) -> Frame {
    frame(0x58A, &[0x80, 0x18, 0x10, sub, 0, 0, 0x02, 0x06])
}

/// Compares the identity of a device with these answers with a data sheet. Returns the result, the questions and the notes.
fn checked(
    sheet: Sheet,
    answers: [Frame; 2],
    says_yes: bool,
) -> (Result<(), Error>, Vec<String>, String) {
    let adapter = Scripted::default();
    adapter.0.borrow_mut().answers = vec![(0x40, answers.to_vec())];
    let mut session = Session::with_sheet(link(&adapter), Target::Canopen(Node(10)), sheet);
    let (mut out, mut notes, mut questions) = (Vec::new(), Vec::new(), Vec::new());
    let mut confirm = |question: &Question| {
        questions.push(question.to_string());
        says_yes
    };
    let mut terminal = Terminal {
        json: false,
        out: &mut out,
        notes: &mut notes,
        confirm: &mut confirm,
        bar: None,
        yes: &[],
        stopped: Rc::new(|| false),
    };
    let result = check(&mut session, &mut terminal);
    (result, questions, String::from_utf8(notes).unwrap())
}

#[test]
fn device_with_the_identity_of_the_data_sheet_is_used_without_a_question() {
    let (result, questions, _) = checked(foreign(), [says(1, 0x12345), says(2, 4711)], false);
    assert_eq!((result, questions), (Ok(()), Vec::new()));
}

#[test]
fn identity_that_cannot_be_read_is_asked_about() {
    let answers = [refuses(1), refuses(2)];
    let (result, questions, _) = checked(foreign(), answers, true);
    assert_eq!(result, Ok(()));
    let expected = [
        "The data sheet is for vendor 12345h, but the device does not let it be read; ",
        "it is for product code 1267h, but the device does not let it be read. Use it anyway?",
    ];
    assert_eq!(questions, [expected.concat()]);
    let (result, questions, _) = checked(foreign(), answers, false);
    let failure = result.unwrap_err();
    assert_eq!((failure.code(), questions.len()), ("wrong-product", 1));
    assert!(failure.to_string().contains("--yes"), "{failure}");
}

#[test]
fn other_product_code_is_asked_about_once() {
    let (result, questions, _) = checked(foreign(), [says(1, 0x12345), says(2, 4712)], false);
    assert_eq!(result.unwrap_err().code(), "wrong-product");
    let expected =
        "The data sheet is for product code 1267h, but the device reports 1268h. Use it anyway?";
    assert_eq!(questions, [expected]);
}

#[test]
fn data_sheet_without_a_vendor_is_reported() {
    let text = FOREIGN.replace("VendorNumber=0x12345", "VendorNumber=0");
    let sheet = parse(text.as_bytes()).unwrap();
    let (result, questions, notes) = checked(sheet, [says(1, 1), says(2, 4711)], false);
    assert_eq!((result, questions), (Ok(()), Vec::new()));
    assert_eq!(
        notes.lines().last(),
        Some("the data sheet names no vendor, so it is not compared")
    );
}
