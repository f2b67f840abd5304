//! DeviceNet: the examples of the manual, and the start of a node, byte by byte.

use crate::tester::devicenet::{MAC_3, online, power_up};

#[test]
fn node_sends_two_requests_and_is_online_two_seconds_after_power_up() {
    let mut tester = power_up(Some(MAC_3));
    let request = "41F#00620101020304";
    assert_eq!(tester.exchange("41E#0A4C030101"), [request]);
    assert_eq!(tester.wait_text(1999), [(1000, request.into())]);
    tester.ignores("41E#0A4C030101");
    assert_eq!(tester.wait_text(1), []);
    assert_eq!(tester.exchange("41E#0A4C030101"), ["41B#0A940B02"]);
}

#[test]
fn polled_mode_exchanges_the_frames_of_the_manual() {
    let mut tester = online();
    for (request, response) in [
        ("41E#0A4B0301030A", "41B#0ACB00"),
        ("41C#0A100501090000", "41B#0A900000"),
        ("41C#0A100502090000", "41B#0A900000"),
        ("41C#4A0E650172", "41B#4A8ED204"),
        ("41C#0A0E650171", "41B#0A8E0A00"),
        ("41C#0A0E650178", "41B#0A8E50D41200"),
        ("41D#", "3C3#D204C9FD"),
        ("41E#0A4C030103", "41B#0ACC"),
        ("41E#0A4C030101", "41B#0A940B02"),
    ] {
        assert_eq!(tester.exchange(request), [response], "{request}");
    }
    tester.ignores("41D#");
}

#[test]
fn cos_mode_exchanges_the_frames_of_the_manual() {
    let mut tester = online();
    for (request, response) in [
        ("41E#0A4B0301510A", "41B#0ACB00"),
        ("41C#0A100501090000", "41B#0A900000"),
    ] {
        assert_eq!(tester.exchange(request), [response], "{request}");
    }
    assert_eq!(
        tester.exchange("41C#0A100504090000"),
        ["41B#0A900000", "343#D204C9FD"]
    );
    assert_eq!(tester.wait_text(5000), [], "no change");
    tester.force_milli(1235, -567);
    assert_eq!(tester.sent_text(), ["343#D304C9FD"]);
    assert_eq!(tester.exchange("41E#0A4C030151"), ["41B#0ACC"]);
    tester.force_milli(1236, -567);
    assert_eq!(tester.sent_text(), [""; 0]);
}

#[test]
fn product_name_has_five_fragments() {
    let mut tester = online();
    tester.allocate(1);
    for (received, sent) in [
        ("41C#0A0E010107", "41B#8A008E17494E434C"),
        ("41C#8AC000", "41B#8A41494E4F4D4554"),
        ("41C#8AC100", "41B#8A42455220303830"),
        ("41C#8AC200", "41B#8A43206465677265"),
        ("41C#8AC300", "41B#8A8465"),
    ] {
        assert_eq!(tester.exchange(received), [sent], "{received}");
    }
    tester.ignores("41C#8AC400");
    assert_eq!(tester.wait_text(3000), []);
}

#[test]
fn attribute_is_set_in_two_fragments() {
    let mut tester = online();
    tester.allocate(1);
    assert_eq!(tester.exchange("41C#8A00106501"), ["41B#8AC000"]);
    assert_eq!(
        tester.exchange("41C#8A81712C01"),
        ["41B#8AC100", "41B#0A90"]
    );
    assert_eq!(tester.explicit("0E650171"), "8E2C01");
}
