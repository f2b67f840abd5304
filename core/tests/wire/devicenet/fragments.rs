//! DeviceNet: fragmented explicit messages in both directions.

use crate::tester::canopen::frame;
use crate::tester::devicenet::{LevelTester, allocated};
use plumbline::node::ProductNode;

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
fn poll_during_the_transfer_is_answered() {
    let mut tester = sending();
    assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
    // Both frames are received at once: the fragment is sent after the I/O.
    tester.node_receives("41C#8AC000");
    tester.node_receives("41D#");
    assert_eq!(tester.sent_text(), ["3C3#D204C9FD", SECOND]);
}

/// A driver has something to do after a frame has left the queue only if a fragment waits for this.
#[test]
fn sent_frame_is_followed_by_work_only_if_a_fragment_waits() {
    let mut tester = sending();
    for acknowledged in [false, true] {
        if acknowledged {
            tester.node_receives("41C#8AC000");
        }
        tester.receive(frame("41D#"));
        let (communication, _) = tester.node.halves();
        assert!(communication.is_idle(tester.now));
        assert!(communication.transmit().is_some());
        assert_eq!(communication.is_idle(tester.now), !acknowledged);
    }
}

/// T31: a first fragment with the count 3Fh is a complete message. It is not acknowledged, and answered in the same form.
#[test]
fn first_and_only_fragment_is_served_and_answered_in_its_form() {
    let mut tester = allocated(2);
    tester.set_rate(2, 0);
    for header in ["8A", "CA"] {
        for (request, response) in [
            ("0E650171", "8E0A00"),
            ("10650171", "9413FF"),
            ("0E650163", "9414FF"),
            ("106501710A", "9413FF"),
            ("106501710A00", "90"),
            ("0E650178", "8E50D41200"),
            ("100502090000", "900000"),
        ] {
            let sent = tester.exchange(&format!("41C#{header}3F{request}"));
            assert_eq!(sent, [format!("41B#{header}3F{response}")], "{request}");
        }
    }
    // Six bytes of data do not fit.
    assert_eq!(
        tester.exchange("41C#8A3F0E05020E"),
        ["41B#0A8E200424673003"]
    );
    // A text is fragmented as ever.
    assert_eq!(tester.exchange("41C#8A3F0E010107"), [FIRST]);
    assert_eq!(tester.exchange("41C#8AC000"), [SECOND]);
    // It discards what was sent and received before, as an unfragmented request.
    assert_eq!(tester.exchange("41C#8A00106501"), ["41B#8AC000"]);
    assert_eq!(tester.exchange("41C#8A3F0E650171"), ["41B#8A3F8E0A00"]);
    tester.ignores("41C#8A81712C01");
    tester.ignores("41C#8AC100");
    for ignored in [
        "8A3F",
        "8A3F8E650171",
        "8B3F0E650171",
        "8A7F0E650171",
        "8ABF0E650171",
    ] {
        tester.ignores(&format!("41C#{ignored}"));
    }
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

/// All fragments of the name, each with its acknowledge.
const NAME_PARTS: [(&str, &str); 5] = [
    (FIRST, "41C#8AC000"),
    (SECOND, "41C#8AC100"),
    ("41B#8A42455220303830", "41C#8AC200"),
    ("41B#8A43206465677265", "41C#8AC300"),
    ("41B#8A8465", "41C#8AC400"),
];

/// Starts the name again, and acknowledges this number of fragments.
fn acknowledged(tester: &mut LevelTester, count: usize) {
    assert_eq!(tester.exchange(NAME), [FIRST]);
    for (number, (_, acknowledge)) in NAME_PARTS.iter().enumerate().take(count) {
        assert_eq!(tester.exchange(acknowledge), [NAME_PARTS[number + 1].0]);
    }
}

#[test]
fn each_fragment_is_repeated_once_and_then_given_up() {
    let mut tester = allocated(0);
    tester.set_rate(1, 0);
    for (count, (fragment, acknowledge)) in NAME_PARTS.into_iter().enumerate() {
        acknowledged(&mut tester, count);
        assert_eq!(tester.wait_text(1999), [(1000, fragment.into())]);
        assert_eq!(tester.wait_text(3000), []);
        tester.ignores(acknowledge);
    }
    // Each of them is acknowledged after its repetition.
    assert_eq!(tester.exchange(NAME), [FIRST]);
    for (number, (fragment, acknowledge)) in NAME_PARTS.into_iter().enumerate() {
        assert_eq!(tester.wait_text(1500), [(1000, fragment.into())]);
        let next = NAME_PARTS.get(number + 1).map(|(fragment, _)| *fragment);
        let expected: Vec<&str> = next.into_iter().collect();
        assert_eq!(tester.exchange(acknowledge), expected);
    }
    assert_eq!(tester.wait_text(3000), []);
}

#[test]
fn only_the_acknowledge_of_the_present_fragment_goes_on() {
    let mut tester = allocated(0);
    tester.set_rate(1, 0);
    for present in 0..4 {
        acknowledged(&mut tester, present);
        for count in (0..64).filter(|count| *count != present) {
            tester.ignores(&format!("41C#8A{:02X}00", 0xC0 | count));
        }
        for other in (0..64).filter(|other| *other != 0x0A) {
            tester.ignores(&format!("41C#{:02X}{:02X}00", 0x80 | other, 0xC0 | present));
        }
        for incomplete in ["8A".to_owned(), format!("8AC{present}")] {
            tester.ignores(&format!("41C#{incomplete}"));
        }
        let (_, acknowledge) = NAME_PARTS[present];
        assert_eq!(tester.exchange(acknowledge), [NAME_PARTS[present + 1].0]);
        tester.ignores(acknowledge);
    }
    for status in 1..=255 {
        acknowledged(&mut tester, 1);
        tester.ignores(&format!("41C#8AC1{status:02X}"));
        tester.ignores("41C#8AC100");
    }
    assert_eq!(tester.wait_text(3000), []);
}

#[test]
fn transfer_ends_with_a_request_of_the_owner_or_its_release() {
    for (text, response) in [
        ("41C#0A0E030101", "41B#0A8E03"),
        ("41C#0A0E030163", "41B#0A9414FF"),
        ("41C#0A4C030102", "41B#0ACC"),
        ("41C#0A4C030103", "41B#0ACC"),
        ("41E#0A4C030103", "41B#0ACC"),
    ] {
        let mut tester = allocated(2);
        acknowledged(&mut tester, 2);
        assert_eq!(tester.exchange(text), [response], "{text}");
        tester.ignores("41C#8AC200");
        assert_eq!(tester.wait_text(3000), [], "{text}");
        // It does not continue in a new connection.
        tester.exchange("41E#0A4B0301010A");
        tester.ignores("41C#8AC200");
        acknowledged(&mut tester, 1);
    }
    // The refusal of another master does not end it, and neither does a poll.
    let mut tester = allocated(2);
    tester.set_rate(2, 0);
    assert_eq!(tester.exchange(NAME), [FIRST]);
    for (number, (_, acknowledge)) in NAME_PARTS.into_iter().enumerate().take(4) {
        assert_eq!(tester.exchange("41E#0B4B0301010B"), ["41B#0B940C01"]);
        assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
        assert_eq!(tester.exchange(acknowledge), [NAME_PARTS[number + 1].0]);
    }
}

#[test]
fn request_arrives_in_fragments_of_any_size() {
    let mut tester = allocated(2);
    tester.set_rate(2, 0);
    for (header, done) in [("8A", "0A"), ("CA", "4A")] {
        for (value, parts) in [
            ("2C01", &["00106501", "81712C01"][..]),
            ("2D01", &["0010650171", "812D01"]),
            ("2E01", &["00106501712E", "8101"]),
            ("2F01", &["0010", "4165", "4201", "4371", "442F", "8501"]),
            ("3001", &["00106501713001", "81"]),
            ("3101", &["00", "41106501", "82713101"]),
        ] {
            let (last, first) = parts.split_last().unwrap();
            for (count, part) in first.iter().enumerate() {
                let sent = tester.exchange(&format!("41C#{header}{part}"));
                assert_eq!(sent, [format!("41B#{header}C{count}00")], "{part}");
                assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
            }
            let acknowledge = format!("41B#{header}C{}00", first.len());
            let sent = tester.exchange(&format!("41C#{header}{last}"));
            assert_eq!(sent, [acknowledge, format!("41B#{done}90")], "{parts:?}");
            assert_eq!(tester.explicit("0E650171"), format!("8E{value}"));
        }
    }
    // A fragmented request has a fragmented response.
    assert_eq!(tester.exchange("41C#8A000E01"), ["41B#8AC000"]);
    assert_eq!(tester.exchange("41C#8A810107"), ["41B#8AC100", FIRST]);
    assert_eq!(tester.exchange("41C#8AC000"), [SECOND]);
}
