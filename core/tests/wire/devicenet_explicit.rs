//! DeviceNet: explicit messages, their errors, and the objects.

use crate::tester::devicenet::{allocated, online};
use plumbline::node::Node;

/// Sends requests and compares the bodies of the responses.
fn exchange(choice: u8, messages: &[(&str, &str)]) {
    let mut tester = allocated(choice);
    for (request, response) in messages {
        assert_eq!(tester.explicit(request), *response, "{request}");
    }
}

#[test]
fn errors_follow_the_order_of_checks() {
    exchange(
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
    exchange(
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
fn identity_has_its_attributes() {
    exchange(
        0,
        &[
            ("0E010101", "8E6201"),
            ("0E010102", "8E0000"),
            ("0E010103", "8E0700"),
            ("0E010104", "8E0102"),
            // Owned, and configured: the MAC ID is 3.
            ("0E010105", "8E0500"),
            ("0E010106", "8E01020304"),
        ],
    );
}

#[test]
fn devicenet_object_has_its_attributes() {
    exchange(
        0x52,
        &[
            ("0E030101", "8E03"),
            ("0E030102", "8E00"),
            ("0E030103", "8E00"),
            ("1003010301", "90"),
            ("0E030103", "8E01"),
            ("0E030104", "8E00"),
            ("0E030105", "8E530A"),
        ],
    );
}

#[test]
fn assemblies_contain_their_words() {
    exchange(
        0,
        &[
            ("0E046503", "8ED204"),
            ("0E046603", "8EC9FD"),
            ("0E046703", "8ED204C9FD"),
            ("0E046803", "9416FF"),
        ],
    );
}

#[test]
fn vendor_object_reads_parameters_values_and_constants() {
    exchange(
        0,
        &[
            ("0E650101", "8E0B00"),
            ("0E650171", "8E0A00"),
            ("0E650172", "8ED204"),
            ("0E650173", "8EFDFF"),
            ("0E650175", "8E00"),
            ("0E650176", "8E0000"),
            ("0E650178", "8E50D41200"),
            ("0E65017A", "8EC9FD"),
            ("0E650181", "8E67"),
            ("106501739CFF", "90"),
            ("0E650173", "8E9CFF"),
            ("106501736400", "90"),
            ("0E650173", "8E6400"),
        ],
    );
}

#[test]
fn connections_have_their_attributes() {
    // Explicit, poll, COS with acknowledge.
    let mut tester = allocated(0x12);
    for (attribute, explicit, poll, cos) in [
        ("01", "03", "01", "01"),
        ("02", "00", "01", "01"),
        ("03", "83", "82", "13"),
        ("04", "1B04", "C303", "4303"),
        ("05", "1C04", "1D04", "1A04"),
        ("06", "21", "01", "01"),
        ("07", "2200", "0400", "0400"),
        ("08", "2000", "0000", "0000"),
        ("09", "C409", "0000", "0000"),
        ("0C", "01", "00", "00"),
        ("0D", "0000", "0600", "0600"),
        ("0E", "", "200424673003", "200424673003"),
        ("0F", "0000", "0000", "0400"),
        ("10", "", "", "202B2401"),
    ] {
        for (instance, expected) in [("01", explicit), ("02", poll), ("04", cos)] {
            let response = tester.explicit(&format!("0E05{instance}{attribute}"));
            assert_eq!(response, format!("8E{expected}"), "{instance} {attribute}");
        }
    }
    assert_eq!(tester.explicit("0E050111"), "9414FF");
    assert_eq!(tester.explicit("0E050211"), "9414FF");
    assert_eq!(tester.explicit("0E050411"), "8E0000");
    assert_eq!(tester.explicit("0E050301"), "9416FF");
    tester.set_rate(2, 0);
    assert_eq!(tester.explicit("0E050201"), "8E03");
}

#[test]
fn attributes_of_connection_4_follow_its_choice() {
    for (choice, trigger, consumed, communication, path) in [
        (0x10, "13", "1A04", "01", "0400"),
        (0x20, "03", "1A04", "01", "0400"),
        (0x50, "10", "FFFF", "0F", "0000"),
        (0x60, "00", "FFFF", "0F", "0000"),
    ] {
        exchange(
            choice,
            &[
                ("0E050403", &format!("8E{trigger}")),
                ("0E050405", &format!("8E{consumed}")),
                ("0E050406", &format!("8E{communication}")),
                ("0E05040F", &format!("8E{path}")),
            ],
        );
    }
}

#[test]
fn connection_that_is_not_allocated_does_not_exist() {
    exchange(
        0,
        &[
            ("0E050101", "8E03"),
            ("0E050201", "9416FF"),
            ("100502090000", "9416FF"),
            ("0E050401", "9416FF"),
        ],
    );
}

#[test]
fn produced_size_and_path_follow_the_selected_assembly() {
    let mut tester = allocated(0);
    assert_eq!(tester.explicit("1065018165"), "90");
    assert_eq!(tester.explicit("1065018266"), "90");
    tester.allocate(0x52);
    for (request, response) in [
        ("0E050207", "8E0200"),
        ("0E05020E", "8E200424653003"),
        ("0E050407", "8E0200"),
        ("0E05040E", "8E200424663003"),
        ("1005020E200424673003", "940EFF"),
    ] {
        let response = format!("41B#0A{response}");
        let request = format!("41C#0A{request}");
        if request.len() <= 20 {
            assert_eq!(tester.exchange(&request), [response]);
        }
    }
    tester.set_rate(2, 0);
    assert_eq!(tester.exchange("41D#"), ["3C3#D204"]);
    tester.receive(crate::tester::canopen::frame("41C#0A100504090000"));
    assert_eq!(tester.sent_text(), ["41B#0A900000", "343#C9FD"]);
}

#[test]
fn assembly_of_an_existing_connection_is_not_settable() {
    let mut tester = allocated(2);
    for configured in [false, true] {
        if configured {
            tester.set_rate(2, 0);
        }
        assert_eq!(tester.explicit("1065018165"), "940CFF");
        assert_eq!(tester.explicit("1065018164"), "9409FF");
        assert_eq!(tester.explicit("0E650181"), "8E67");
        assert_eq!(tester.explicit("1065018265"), "90");
    }
    assert_eq!(tester.exchange("41E#0A4C030102"), ["41B#0ACC"]);
    assert_eq!(tester.explicit("1065018165"), "90");
    tester.allocate(0x50);
    assert_eq!(tester.explicit("1065018267"), "940CFF");
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
fn sets_are_stored_together_within_a_second() {
    let mut tester = allocated(0);
    tester.actions.clear();
    tester.explicit("106501712C01");
    tester.wait(200);
    tester.explicit("106501731000");
    tester.wait(99);
    assert_eq!(tester.actions, []);
    tester.wait(900);
    assert_eq!(tester.actions.len(), 1, "one save");
    assert_eq!(tester.memory.as_ref().unwrap()[6..10], [0x2C, 1, 0x10, 0]);
    // The same value again, and a parameter that is not stored.
    tester.explicit("106501712C01");
    tester.explicit("1065017505");
    tester.wait(1000);
    assert_eq!(tester.actions.len(), 1);
    assert_eq!(tester.explicit("0E650175"), "8E05");
}

#[test]
fn change_during_a_save_is_stored_after_it() {
    let mut tester = allocated(0);
    tester.memory_works = None;
    tester.explicit("106501712C01");
    tester.wait(400);
    tester.explicit("106501731000");
    assert_eq!(tester.explicit("0E650173"), "8E1000");
    tester.wait(500);
    tester.memory_works = Some(true);
    tester.finish_save(Ok(()));
    assert_eq!(tester.memory.as_ref().unwrap()[6..10], [0x2C, 1, 0x10, 0]);
}

#[test]
fn failed_save_is_repeated_and_reported() {
    let mut tester = allocated(0);
    tester.memory_works = Some(false);
    tester.explicit("106501712C01");
    tester.wait(350);
    assert_eq!(tester.explicit("0E010105"), "8E0501");
    tester.memory_works = Some(true);
    tester.wait(350);
    assert_eq!(tester.explicit("0E010105"), "8E0500");
    assert_eq!(tester.memory.as_ref().unwrap()[6..8], [0x2C, 1]);
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
