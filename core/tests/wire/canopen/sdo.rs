//! The SDO server of the JN2101 (CiA 301, 7.2.4; manual 7.6 and 7.7).

use crate::tester::canopen::*;
use plumbline::node::{Action, Node};

const TOGGLE: u32 = 0x0503_0000;
const COMMAND: u32 = 0x0504_0001;
const LENGTH: u32 = 0x0607_0010;
const TOO_LONG: u32 = 0x0607_0012;
const TOO_SHORT: u32 = 0x0607_0013;
const VALUE: u32 = 0x0609_0030;

#[test]
fn read_reply_of_each_size_indicates_number_of_bytes() {
    let mut t = booted();
    // 1000h: u32 4019Ah; 1017h: u16; 1001h: u8.
    assert_eq!(t.sdo("4000100000000000"), "430010009A010400");
    assert_eq!(t.sdo("4017100000000000"), "4B17100000000000");
    assert_eq!(t.sdo("4001100000000000"), "4F01100000000000");
    // The lower five bits of the command and the last four bytes are reserved.
    assert_eq!(t.sdo("5F00100000000000"), "430010009A010400");
    assert_eq!(t.sdo("40001000FFFFFFFF"), "430010009A010400");
}

#[test]
fn write_with_wrong_length_is_refused() {
    let mut t = booted();
    assert_eq!(t.write(0x1017, 0, 4, 1000), Err(TOO_LONG));
    assert_eq!(t.write(0x1017, 0, 1, 100), Err(TOO_SHORT));
    assert_eq!(t.write(0x2043, 0, 2, 1), Err(TOO_LONG));
    assert_eq!(t.write(0x1F80, 0, 1, 8), Err(TOO_SHORT));
    assert_eq!(t.read(0x1017, 0), Ok(0));
    // An expedited write without indicated size has the size of the object.
    assert_eq!(t.sdo("22171000E8030000"), "6017100000000000");
    assert_eq!(t.read(0x1017, 0), Ok(1000));
    // Announced sizes of segmented transfers.
    assert_eq!(t.sdo("2117100004000000"), abort("171000", TOO_LONG));
    assert_eq!(t.sdo("2117100001000000"), abort("171000", TOO_SHORT));
    assert_eq!(t.sdo("21003000FF000000"), abort("003000", TOO_LONG));
    assert_eq!(t.sdo("2117100000000080"), abort("171000", TOO_LONG));
}

#[test]
fn text_is_read_in_segments() {
    let mut t = booted();
    assert_eq!(t.sdo("4008100000000000"), "4108100006000000");
    // "JN2101", one byte unused, the last segment.
    assert_eq!(t.sdo("6000000000000000"), "034A4E3231303100");
    // There are no more segments.
    assert_eq!(t.sdo("7000000000000000"), abort("000000", COMMAND));
    // Sixteen characters: 7 + 7 + 2, the toggle bit alternating.
    assert_eq!(t.sdo("4000300000000000"), "4100300010000000");
    assert_eq!(
        t.sdo("6000000000000000"),
        "0044305566 5A4567".replace(' ', "")
    );
    assert_eq!(
        t.sdo("7000000000000000"),
        "1052 4B4841493541".replace(' ', "")
    );
    assert_eq!(t.sdo("6000000000000000"), "0B673D0000000000");
}

#[test]
fn wrong_toggle_bit_aborts_transfer() {
    let mut t = booted();
    t.sdo("4000300000000000");
    assert_eq!(t.sdo("7000000000000000"), abort("003000", TOGGLE));
    assert_eq!(t.sdo("6000000000000000"), abort("000000", COMMAND));
    t.sdo("4000300000000000");
    t.sdo("6000000000000000");
    assert_eq!(t.sdo("6000000000000000"), abort("003000", TOGGLE));
    // Writing the second segment of the programming key.
    t.sdo("2100300010000000");
    assert_eq!(
        t.sdo("0044305566 5A4567".replace(' ', "").as_str()),
        "2000000000000000"
    );
    assert_eq!(t.sdo("00524B4841493541"), abort("003000", TOGGLE));
    assert_eq!(t.sdo("10524B4841493541"), abort("000000", COMMAND));
    // Writing 1017h.
    assert_eq!(t.sdo("2117100002000000"), "6017100000000000");
    assert_eq!(t.sdo("1BE8030000000000"), abort("171000", TOGGLE));
    assert_eq!(t.sdo("0BE8030000000000"), abort("000000", COMMAND));
    assert_eq!(t.read(0x1017, 0), Ok(0));
}

#[test]
fn number_is_written_in_segments() {
    let mut t = booted();
    // With and without an announced size; in one segment and in two.
    assert_eq!(t.sdo("2117100002000000"), "6017100000000000");
    assert_eq!(t.sdo("0BE8030000000000"), "2000000000000000");
    assert_eq!(t.read(0x1017, 0), Ok(1000));
    assert_eq!(t.sdo("2017100000000000"), "6017100000000000");
    assert_eq!(t.sdo("0CD0000000000000"), "2000000000000000");
    assert_eq!(t.sdo("1D07000000000000"), "3000000000000000");
    assert_eq!(t.read(0x1017, 0), Ok(2000));
    // The length is not the announced one. Nothing is written.
    assert_eq!(t.sdo("2117100002000000"), "6017100000000000");
    assert_eq!(t.sdo("0D01000000000000"), abort("171000", LENGTH));
    assert_eq!(t.sdo("2017100000000000"), "6017100000000000");
    assert_eq!(t.sdo("0901020300000000"), abort("171000", TOO_LONG));
    assert_eq!(t.sdo("2017100000000000"), "6017100000000000");
    assert_eq!(t.sdo("0D01000000000000"), abort("171000", TOO_SHORT));
    // A value that is refused at the end.
    assert_eq!(t.sdo("2101200002000000"), "6001200000000000");
    assert_eq!(t.sdo("0B07000000000000"), abort("012000", VALUE));
    assert_eq!(t.read(0x1017, 0), Ok(2000));
    assert_eq!(t.read(0x2001, 0), Ok(125));
}

#[test]
fn text_longer_than_buffer_is_refused() {
    let mut t = booted();
    t.sdo("2000300000000000");
    for (segment, reply) in [
        ("0041414141414141", "2000000000000000"),
        ("1041414141414141", "3000000000000000"),
        ("0041414141414141", "2000000000000000"),
    ] {
        assert_eq!(t.sdo(segment), reply);
    }
    assert_eq!(t.sdo("1041414141414141"), abort("003000", TOO_LONG));
}

#[test]
fn transfer_times_out_after_one_second() {
    let mut t = booted();
    t.sdo("4000300000000000");
    assert_eq!(t.wait_text(999), []);
    t.sdo("6000000000000000");
    assert_eq!(t.wait_text(999), []);
    assert_eq!(t.wait_text(1), [(1, "58A#8000300000000405".to_string())]);
    assert_eq!(t.wait_text(5000), []);
    t.sdo("2117100002000000");
    let code = "58A#8017100000000405".to_string();
    assert_eq!(t.wait_text(2000), [(1000, code)]);
    assert_eq!(t.sdo("0BE8030000000000"), abort("000000", COMMAND));
}

#[test]
fn new_initiate_request_replaces_transfer() {
    let mut t = booted();
    t.sdo("4000300000000000");
    t.sdo("6000000000000000");
    assert_eq!(t.sdo("4000100000000000"), "430010009A010400");
    assert_eq!(t.sdo("7000000000000000"), abort("000000", COMMAND));
    t.sdo("2117100002000000");
    assert_eq!(t.sdo("4008100000000000"), "4108100006000000");
    assert_eq!(t.sdo("6000000000000000"), "034A4E3231303100");
    // An expedited write during an upload, an upload and another download during a download.
    t.sdo("4000300000000000");
    assert_eq!(t.sdo("2F43200003000000"), "6043200000000000");
    assert_eq!(t.sdo("6000000000000000"), abort("000000", COMMAND));
    t.sdo("2117100002000000");
    assert_eq!(t.sdo("4000100000000000"), "430010009A010400");
    assert_eq!(t.sdo("0BE8030000000000"), abort("000000", COMMAND));
    t.sdo("2117100002000000");
    t.sdo("210D100001000000");
    assert_eq!(t.sdo("0D09000000000000"), "2000000000000000");
    assert_eq!((t.read(0x100D, 0), t.read(0x1017, 0)), (Ok(9), Ok(0)));
    // A segment of the other direction aborts the transfer.
    t.sdo("4000300000000000");
    assert_eq!(t.sdo("0BE8030000000000"), abort("003000", COMMAND));
    assert_eq!(t.sdo("6000000000000000"), abort("000000", COMMAND));
    assert_eq!(t.wait_text(3000), []);
}

#[test]
fn client_abort_ends_transfer() {
    let mut t = booted();
    assert_eq!(t.exchange("60A#8017100000000508"), [""; 0], "no transfer");
    t.sdo("2117100002000000");
    assert_eq!(t.exchange("60A#8017100000000508"), [""; 0]);
    assert_eq!(t.sdo("0BE8030000000000"), abort("000000", COMMAND));
    t.sdo("4000300000000000");
    assert_eq!(t.exchange("60A#8000300000000508"), [""; 0]);
    assert_eq!(t.sdo("6000000000000000"), abort("000000", COMMAND));
    assert_eq!(t.wait_text(3000), []);
    assert_eq!(t.read(0x1017, 0), Ok(0));
}

/// The commands of block transfers, which the manual has not, and command 7.
#[test]
fn unknown_command_is_refused_and_ends_a_transfer() {
    for command in 0xA0..=0xFF_u8 {
        let request = format!("{command:02X}081000087F0000");
        let mut t = booted();
        assert_eq!(t.sdo(&request), abort("081000", COMMAND), "{command:02X}h");
        assert_eq!(t.sdo("4000300000000000"), "4100300010000000");
        let refused = t.sdo(&request);
        assert_eq!(refused[8..], abort("", COMMAND)[2..], "{command:02X}h");
        assert_eq!(t.sdo("4000100000000000"), "430010009A010400");
        assert_eq!(t.sdo("6000000000000000"), abort("000000", COMMAND));
    }
}

#[test]
fn segment_without_transfer_is_refused() {
    let mut t = booted();
    for command in (0x00..=0x1F).chain(0x60..=0x7F) {
        let request = format!("{command:02X}00000000000000");
        assert_eq!(t.sdo(&request), abort("000000", COMMAND), "{command:02X}h");
    }
}

/// Also in the middle of a transfer, which continues.
#[test]
fn frame_that_is_no_sdo_request_is_ignored() {
    let mut t = operational();
    assert_eq!(t.sdo("4000300000000000"), "4100300010000000");
    for request in ["4000100000000000", "2F43200001000000", "6000000000000000"] {
        let others = (0..=127_u16).filter(|node_id| *node_id != 10);
        let mut frames: Vec<String> = others
            .map(|node_id| format!("{:03X}#{request}", 0x600 + node_id))
            .collect();
        frames.extend((0..8).map(|length| format!("60A#{}", &request[..2 * length])));
        frames.extend([
            format!("0000060A#{request}"),
            format!("58A#{request}"),
            "0000060A#R8".to_string(),
        ]);
        frames.extend((0..=8).map(|length| format!("60A#R{length}")));
        for frame in frames {
            assert_eq!(t.exchange(&frame), [""; 0], "{frame}");
        }
    }
    assert_eq!(t.sdo("6000000000000000"), "00443055665A4567");
    assert_eq!(t.read(0x2043, 0), Ok(2));
}

#[test]
fn reset_ends_transfer() {
    for reset in ["000#810A", "000#820A"] {
        for begin in ["4000300000000000", "2117100002000000"] {
            let mut t = booted();
            t.sdo(begin);
            assert_eq!(t.exchange(reset), ["70A#00"]);
            for segment in ["6000000000000000", "0BE8030000000000"] {
                assert_eq!(t.sdo(segment), abort("000000", COMMAND), "{reset}");
            }
            assert_eq!(t.wait_text(3000), []);
            assert_eq!(t.read(0x1017, 0), Ok(0));
        }
    }
}

#[test]
fn sdo_request_in_stopped_is_ignored() {
    let mut t = booted();
    t.sdo("4000300000000000");
    t.send("000#020A");
    assert_eq!(t.exchange("60A#4000100000000000"), [""; 0]);
    assert_eq!(
        t.wait_text(3000),
        [],
        "the transfer has ended without a message"
    );
    t.send("000#800A");
    assert_eq!(t.sdo("6000000000000000"), abort("000000", COMMAND));
    assert_eq!(t.sdo("4000100000000000"), "430010009A010400");
    t.send("000#010A");
    assert_eq!(t.sdo("4000100000000000"), "430010009A010400");
}

/// A board calls `transmit` before `poll`. A change of the filters would discard a reply in a mailbox.
#[test]
fn reply_waits_until_controller_has_new_filters() {
    let mut tester = booted();
    let request = frame("60A#23051000A0000000");
    tester.node.receive(tester.now, &request);
    assert_eq!(tester.node.transmit(tester.now), None);
    let action = tester.node.poll(tester.now);
    assert!(matches!(action, Some(Action::Bus(..))), "{action:?}");
    assert_eq!(tester.sent_text(), ["58A#6005100000000000"]);
}
