//! DeviceNet: fragmented explicit messages in both directions.

use crate::tester::devicenet::{LevelTester, allocated};

const NAME: &str = "41C#0A0E010107";
const FIRST: &str = "41B#8A008E17494E434C";
const SECOND: &str = "41B#8A41494E4F4D4554";

/// A node that has sent the first fragment of its name.
fn sending() -> LevelTester {
    let mut tester = allocated(2);
    tester.set_rate(2, 0);
    assert_eq!(tester.exchange(NAME), [FIRST]);
    tester
}

#[test]
fn fragment_without_acknowledge_is_repeated_once() {
    let mut tester = sending();
    assert_eq!(tester.wait_text(5000), [(1000, FIRST.into())]);
    tester.ignores("41C#8AC000");
    assert_eq!(tester.exchange(NAME), [FIRST]);
}

#[test]
fn repeated_fragment_is_acknowledged_and_the_next_follows() {
    let mut tester = sending();
    assert_eq!(tester.wait_text(1500), [(1000, FIRST.into())]);
    assert_eq!(tester.exchange("41C#8AC000"), [SECOND]);
    assert_eq!(tester.wait_text(1000), [(1000, SECOND.into())]);
}

#[test]
fn acknowledge_of_another_fragment_or_master_is_ignored() {
    let mut tester = sending();
    for text in [
        "41C#8AC100",
        "41C#8BC000",
        "41C#8AC0",
        "41C#8A",
        "41C#8AFF00",
    ] {
        tester.ignores(text);
    }
    assert_eq!(tester.exchange("41C#8AC000"), [SECOND]);
    tester.ignores("41C#8AC000");
}

#[test]
fn acknowledge_with_a_status_ends_the_transfer() {
    let mut tester = sending();
    tester.ignores("41C#8AC001");
    assert_eq!(tester.wait_text(3000), []);
}

#[test]
fn request_ends_the_transfer_and_is_served() {
    let mut tester = sending();
    assert_eq!(tester.explicit("0E030101"), "8E03");
    tester.ignores("41C#8AC000");
    assert_eq!(tester.wait_text(3000), []);
}

#[test]
fn release_ends_the_transfer() {
    let mut tester = sending();
    assert_eq!(tester.exchange("41E#0A4C030101"), ["41B#0ACC"]);
    assert_eq!(tester.wait_text(3000), []);
    assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
}

#[test]
fn poll_during_the_transfer_is_answered() {
    let mut tester = sending();
    assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
    // Both frames are received at once: the fragment is sent after the I/O.
    tester.node_receives("41C#8AC000");
    tester.node_receives("41D#");
    assert_eq!(tester.sent_text(), ["3C3#D204C9FD", SECOND]);
}

#[test]
fn xid_is_that_of_the_request() {
    let mut tester = allocated(0);
    assert_eq!(tester.exchange("41C#4A0E010107"), ["41B#CA008E17494E434C"]);
    assert_eq!(tester.exchange("41C#CA000E01"), ["41B#CAC000"]);
    assert_eq!(
        tester.exchange("41C#CA810101"),
        ["41B#CAC100", "41B#4A8E6201"]
    );
}

#[test]
fn fragmented_set_has_the_errors_of_an_unfragmented_one() {
    let mut tester = allocated(0);
    for (fragments, last, response) in [
        (&["41C#8A00106501"][..], "41C#8A8171E903", "41B#0A9409FF"),
        (&["41C#8A00106501"], "41C#8A81710000FF", "41B#0A9415FF"),
        (&["41C#8A0055", "41C#8A4199"], "41C#8A8201", "41B#0A9416FF"),
        (&["41C#8A0010"], "41C#8A81", "41B#0A9413FF"),
    ] {
        for (count, fragment) in fragments.iter().enumerate() {
            let acknowledge = format!("41B#8AC{count}00");
            assert_eq!(tester.exchange(fragment), [acknowledge]);
        }
        let acknowledge = format!("41B#8AC{}00", fragments.len());
        assert_eq!(tester.exchange(last), [acknowledge.as_str(), response]);
    }
}

#[test]
fn fragmented_response_is_ignored() {
    let mut tester = allocated(0);
    assert_eq!(tester.exchange("41C#8A008E65"), ["41B#8AC000"]);
    assert_eq!(tester.exchange("41C#8A810171"), ["41B#8AC100"]);
}

#[test]
fn request_discards_received_fragments() {
    let mut tester = allocated(0);
    assert_eq!(tester.exchange("41C#8A00106501"), ["41B#8AC000"]);
    assert_eq!(tester.explicit("0E650171"), "8E0A00");
    tester.ignores("41C#8A81712C01");
    assert_eq!(tester.explicit("0E650171"), "8E0A00");
}

#[test]
fn fragments_of_other_masters_are_dropped() {
    let mut tester = allocated(0);
    tester.ignores("41C#8B00106501");
    assert_eq!(tester.exchange("41C#8A00106501"), ["41B#8AC000"]);
    tester.ignores("41C#8B81710000");
    assert_eq!(
        tester.exchange("41C#8A81712C01"),
        ["41B#8AC100", "41B#0A90"]
    );
}

#[test]
fn too_long_request_is_refused() {
    let mut tester = allocated(0);
    let part = "010203040506";
    assert_eq!(tester.exchange(&format!("41C#8A00{part}")), ["41B#8AC000"]);
    for count in 1..5 {
        let fragment = format!("41C#8A4{count}{part}");
        assert_eq!(tester.exchange(&fragment), [format!("41B#8AC{count}00")]);
    }
    assert_eq!(tester.exchange(&format!("41C#8A45{part}")), ["41B#8AC501"]);
    tester.ignores("41C#8A8601");
}
