//! DeviceNet: explicit messages and their errors.

use crate::tester::devicenet::{allocated, compare, online};
use plumbline::node::Node;

#[test]
fn errors_follow_the_order_of_checks() {
    compare(
        0,
        &[
            // Class and instance.
            ("559901", "9416FF"),
            ("0E066501", "9416FF"),
            ("0E000001", "9416FF"),
            ("0E010201", "9416FF"),
            ("0E030201", "9416FF"),
            ("0E040101", "9416FF"),
            ("0E2B0201", "9416FF"),
            ("0E650201", "9416FF"),
            ("556502", "9416FF"),
            ("0E020201", "9416FF"),
            // Service.
            ("556501", "9408FF"),
            ("0F650172", "9408FF"),
            ("4B650172", "9408FF"),
            ("05650100", "9408FF"),
            ("016501", "9408FF"),
            ("0E020101", "9408FF"),
            ("10020101", "9408FF"),
            ("050301", "9408FF"),
            ("050501", "9408FF"),
            ("0D0501", "9408FF"),
            // Attribute.
            ("0E650163", "9414FF"),
            ("0E650100", "9414FF"),
            ("0E6501FF", "9414FF"),
            ("10650163", "9414FF"),
            ("106501632C01", "9414FF"),
            ("0E030106", "9414FF"),
            ("0E030109", "9414FF"),
            ("0E01010A", "9414FF"),
            ("0E010108", "9414FF"),
            ("0E050100", "9414FF"),
            ("0E05010A", "9414FF"),
            ("0E05010B", "9414FF"),
            ("0E050114", "9414FF"),
            ("0E046601", "9414FF"),
            ("0E046604", "9414FF"),
            ("0E2B0104", "9414FF"),
            // The attribute is missing.
            ("0E6501", "9413FF"),
            ("106501", "9413FF"),
            ("0E0101", "9413FF"),
            ("0E0466", "9413FF"),
            // Settable.
            ("10650172", "940EFF"),
            ("10650172000000", "940EFF"),
            ("1065017600", "940EFF"),
            ("10650101", "940EFF"),
            ("10046603", "940EFF"),
            ("100301050000", "940EFF"),
            ("10010101", "940EFF"),
            ("1005010103", "940EFF"),
            ("100501", "9413FF"),
            ("10050104", "940EFF"),
            ("1005010D", "940EFF"),
            ("102B0103", "940EFF"),
            // Length.
            ("10650171", "9413FF"),
            ("1065017100", "9413FF"),
            ("10650171000000", "9415FF"),
            ("10650188FFFF", "9415FF"),
            ("10030101", "9413FF"),
            ("100301010102", "9415FF"),
            ("10030104", "9413FF"),
            ("0E65017200", "9415FF"),
            ("0E01010100", "9415FF"),
            ("0E03010500", "9415FF"),
            ("0E05010100", "9415FF"),
            ("0E2B010100", "9415FF"),
            ("0E04660300", "9415FF"),
            // Range.
            ("10650171E903", "9409FF"),
            ("106501739BFF", "9409FF"),
            ("106501736500", "9409FF"),
            ("10650181FF", "9409FF"),
            ("1065018164", "9409FF"),
            ("10650188C9", "9409FF"),
            ("1003010140", "9409FF"),
            ("1003010203", "9409FF"),
            ("1003010302", "9409FF"),
            // State.
            ("106501734D00", "940CFF"),
        ],
    );
}

#[test]
fn refused_set_changes_nothing() {
    let mut tester = allocated(0);
    for request in [
        "10650171E903",
        "106501710000FF",
        "106501734D00",
        "1065017300",
    ] {
        assert!(tester.explicit(request).starts_with("94"));
    }
    assert_eq!(tester.explicit("0E650171"), "8E0A00");
    assert_eq!(tester.explicit("0E650173"), "8EFDFF");
    tester.actions.clear();
    tester.wait(1000);
    assert_eq!(tester.actions, []);
}

#[test]
fn classes_have_their_revision_and_refuse_set() {
    compare(
        0,
        &[
            ("0E010001", "8E0100"),
            ("0E030001", "8E0200"),
            ("0E040001", "8E0200"),
            ("0E050001", "8E0100"),
            ("0E2B0001", "8E0100"),
            ("0E650001", "8E0300"),
            ("0E650002", "9414FF"),
            ("0E6500", "9413FF"),
            ("1001000101", "9408FF"),
            ("1003000101", "9408FF"),
            ("1004000101", "9408FF"),
            ("1005000101", "9408FF"),
            ("102B000101", "9408FF"),
            ("1065000101", "9408FF"),
            ("10020001", "9408FF"),
            ("4B03000101", "9408FF"),
            ("050100", "9408FF"),
        ],
    );
}

#[test]
fn header_is_echoed_and_foreign_masters_are_ignored() {
    let mut tester = allocated(0);
    assert_eq!(tester.exchange("41C#4A0E030101"), ["41B#4A8E03"]);
    assert_eq!(tester.exchange("41C#4A0E030109"), ["41B#4A9414FF"]);
    for text in [
        "41C#0B0E030101",
        "41C#4B0E030101",
        "41C#000E030101",
        "41C#8B000E0301",
        "41C#0A8E030101",
        "41C#0A94030101",
        "41C#0A",
        "41C#",
        "41C#R4",
        "0000041C#0A0E030101",
        "41B#0A0E030101",
        "418#0A0E030101",
        "414#0A0E030101",
        "603#0A0E030101",
        "7C3#0A0E030101",
    ] {
        tester.ignores(text);
    }
    assert_eq!(tester.explicit("0E"), "9413FF");
    assert_eq!(tester.explicit("0E03"), "9413FF");
}

#[test]
fn nothing_is_answered_without_an_allocation() {
    let mut tester = online();
    for text in ["41C#0A0E030101", "41D#", "41A#", "41C#FF0E030101"] {
        tester.ignores(text);
    }
}

#[test]
fn unconnected_port_allocates_and_releases_only() {
    let mut tester = online();
    for (request, response) in [
        ("41E#0A0E030101", "41B#0A940203"),
        ("41E#0A0E010107", "41B#0A940203"),
        ("41E#0A10030101", "41B#0A940203"),
        ("41E#0A4B0302010A", "41B#0A940203"),
        ("41E#0A4B0401010A", "41B#0A940203"),
        ("41E#0A4B", "41B#0A9413FF"),
        ("41E#0A4B0301", "41B#0A9413FF"),
        ("41E#0A4B030101", "41B#0A9413FF"),
        ("41E#0A4B0301010A00", "41B#0A9415FF"),
        ("41E#0A4C0301", "41B#0A9413FF"),
        ("41E#0A4C03010100", "41B#0A9415FF"),
        ("41E#4A4B0301030A", "41B#4ACB00"),
        ("41E#0B4B0301010B", "41B#0B940C01"),
        ("41E#0B4C030101", "41B#0B940C01"),
        ("41C#0A4B0301500A", "41B#0ACB00"),
        ("41C#0A0E030105", "41B#0A8E530A"),
        ("41C#0A4C030150", "41B#0ACC"),
        ("41C#0A4C030104", "41B#0A940202"),
        ("41C#0A4C030101", "41B#0ACC"),
    ] {
        assert_eq!(tester.exchange(request), [response], "{request}");
    }
    for text in ["41E#", "41E#0A", "41E#8A4B0301010A", "41E#0ACB0301010A"] {
        tester.ignores(text);
    }
    assert!(!tester.owner());
}

#[test]
fn set_blocks_the_next_frame_until_it_is_applied() {
    let mut tester = allocated(2);
    tester.set_rate(2, 0);
    let set = crate::tester::canopen::frame("41C#0A106501712C01");
    tester.node.receive(tester.now, &set);
    assert!(
        tester.node.ready(),
        "the node applies before the next frame"
    );
    assert_eq!(tester.sent_text(), ["41B#0A90"]);
}
