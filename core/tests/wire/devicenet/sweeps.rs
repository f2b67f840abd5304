//! DeviceNet: every class, instance, service and attribute, and every value of a settable byte.

use crate::tester::devicenet::{LevelTester, allocated};

/// An object with its attributes, and the sizes of those that can be set. A class (instance 0) has its revision.
struct Object {
    class: u8,
    instance: u8,
    readable: &'static [u8],
    settable: &'static [(u8, usize)],
}

const fn read_only(class: u8, instance: u8, readable: &'static [u8]) -> Object {
    object(class, instance, readable, &[])
}

const fn object(
    class: u8,
    instance: u8,
    readable: &'static [u8],
    settable: &'static [(u8, usize)],
) -> Object {
    Object {
        class,
        instance,
        readable,
        settable,
    }
}

const CONNECTION: &[u8] = &[1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 13, 14, 15, 16];
const PRODUCING: &[u8] = &[1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 13, 14, 15, 16, 17];
const ANGLE: &[u8] = &[
    0x01, 0x71, 0x72, 0x73, 0x75, 0x76, 0x78, 0x7A, 0x81, 0x82, 0x88,
];

/// The objects of a node with explicit, poll and COS connections. The message router (class 2) has no service.
const OBJECTS: [Object; 18] = [
    read_only(1, 0, &[1]),
    read_only(1, 1, &[1, 2, 3, 4, 5, 6, 7]),
    read_only(3, 0, &[1]),
    object(3, 1, &[1, 2, 3, 4, 5], &[(1, 1), (2, 1), (3, 1), (4, 1)]),
    read_only(4, 0, &[1]),
    read_only(4, 0x65, &[3]),
    read_only(4, 0x66, &[3]),
    read_only(4, 0x67, &[3]),
    read_only(5, 0, &[1]),
    object(5, 1, CONNECTION, &[(9, 2), (12, 1)]),
    object(5, 2, CONNECTION, &[(9, 2)]),
    object(5, 4, PRODUCING, &[(9, 2), (17, 2)]),
    read_only(0x2B, 0, &[1]),
    object(0x2B, 1, &[1, 2, 3], &[(1, 2), (2, 1)]),
    read_only(0x65, 0, &[1]),
    object(
        0x65,
        1,
        ANGLE,
        &[
            (0x71, 2),
            (0x73, 2),
            (0x75, 1),
            (0x81, 1),
            (0x82, 1),
            (0x88, 1),
        ],
    ),
    read_only(0x66, 0, &[1]),
    object(0x66, 1, &[1, 2], &[(1, 1)]),
];

const ROUTER: [(u8, u8); 2] = [(2, 0), (2, 1)];

/// Explicit, poll and COS connections. The explicit one does not time out.
fn node() -> LevelTester {
    let mut tester = allocated(0x12);
    tester.set_rate(1, 0);
    tester
}

/// All attributes that fit into a frame.
fn snapshot(tester: &mut LevelTester) -> Vec<String> {
    let mut values = Vec::new();
    for object in &OBJECTS {
        let Object {
            class, instance, ..
        } = object;
        for &attribute in object.readable {
            if (*class, attribute) != (1, 7) {
                let request = format!("0E{class:02X}{instance:02X}{attribute:02X}");
                values.push(tester.explicit(&request));
            }
        }
    }
    values
}

/// The class of the diagnostic data.
const DIAGNOSIS: u8 = 0xC7;

#[test]
fn object_that_does_not_exist_is_refused_before_everything_else() {
    let mut tester = node();
    let exists = |class, instance| {
        let mut objects = OBJECTS.iter();
        objects.any(|it| (it.class, it.instance) == (class, instance))
            || ROUTER.contains(&(class, instance))
            || matches!((class, instance), (DIAGNOSIS, 0 | 1))
    };
    for class in 0..=255 {
        let has_objects = exists(class, 0);
        for instance in 0..=255_u8 {
            let sampled = instance < 6 || (0x60..0x70).contains(&instance) || instance > 0xFD;
            if exists(class, instance) || !has_objects && !sampled {
                continue;
            }
            for (service, data) in [
                (0x0E, "01"),
                (0x0E, ""),
                (0x10, "0100"),
                (0x05, "00"),
                (0x4B, "010A"),
                (0x55, ""),
            ] {
                let request = format!("{service:02X}{class:02X}{instance:02X}{data}");
                assert_eq!(tester.explicit(&request), "9416FF", "{request}");
            }
        }
    }
}

#[test]
fn objects_have_exactly_their_services() {
    let mut tester = node();
    let before = snapshot(&mut tester);
    let objects = OBJECTS.iter().map(|it| (it.class, it.instance));
    for (class, instance) in objects.chain(ROUTER) {
        for service in 0..128 {
            let expected = match (class, instance, service) {
                // The reset.
                (1, 1, 0x05) => continue,
                (2, ..) => "9408FF",
                (_, _, 0x0E) | (3, 1, 0x4B | 0x4C) => "9413FF",
                (_, 1.., 0x10) => "9413FF",
                _ => "9408FF",
            };
            let request = format!("{service:02X}{class:02X}{instance:02X}");
            assert_eq!(tester.explicit(&request), expected, "{request}");
        }
    }
    assert_eq!(snapshot(&mut tester), before);
}

#[test]
fn objects_have_exactly_their_attributes() {
    let mut tester = node();
    for object in &OBJECTS {
        for attribute in 0..=255 {
            let is_readable = object.readable.contains(&attribute);
            let address = format!("{:02X}{:02X}{attribute:02X}", object.class, object.instance);
            let excess = tester.explicit(&format!("0E{address}00"));
            assert_eq!(
                excess,
                if is_readable { "9415FF" } else { "9414FF" },
                "{address}"
            );
            // The product name needs fragments.
            if (object.class, attribute) != (1, 7) {
                let read = tester.explicit(&format!("0E{address}"));
                let good = if is_readable {
                    read.starts_with("8E")
                } else {
                    read == "9414FF"
                };
                assert!(good, "{address}: {read}");
            }
        }
    }
}

#[test]
fn set_without_the_size_of_the_attribute_is_refused() {
    let mut tester = node();
    let before = snapshot(&mut tester);
    for object in &OBJECTS {
        for attribute in 0..=255 {
            let settable = object.settable.iter().find(|(it, _)| *it == attribute);
            for length in 0..=3 {
                let expected = match settable {
                    _ if object.instance == 0 => "9408FF",
                    Some((_, size)) if length == *size => continue,
                    Some((_, size)) if length < *size => "9413FF",
                    Some(_) => "9415FF",
                    None if object.readable.contains(&attribute) => "940EFF",
                    None => "9414FF",
                };
                let Object {
                    class, instance, ..
                } = object;
                let data = "00".repeat(length);
                let request = format!("10{class:02X}{instance:02X}{attribute:02X}{data}");
                assert_eq!(tester.explicit(&request), expected, "{request}");
            }
        }
    }
    assert_eq!(snapshot(&mut tester), before);
}

/// Whether an attribute of one byte accepts a value.
fn accepts(address: &str, value: u8) -> bool {
    match address {
        "030102" => value <= 2,
        "030103" => value <= 1,
        "05010C" => value == 1 || value == 3,
        "2B0102" => true,
        "650181" | "650182" => (101..=103).contains(&value),
        "650188" => value <= 200,
        "660101" => value <= 100,
        _ => panic!("{address}"),
    }
}

#[test]
fn byte_takes_exactly_its_values() {
    let mut tester = allocated(0);
    for address in [
        "030102", "030103", "05010C", "2B0102", "650181", "650182", "650188", "660101",
    ] {
        let mut present = tester.explicit(&format!("0E{address}"));
        for value in 0..=255 {
            let response = tester.explicit(&format!("10{address}{value:02X}"));
            let expected = if accepts(address, value) {
                present = format!("8E{value:02X}");
                "90"
            } else {
                "9409FF"
            };
            assert_eq!(response, expected, "{address}: {value}");
            assert_eq!(tester.explicit(&format!("0E{address}")), present);
        }
    }
    // Any value clears the bus-off counter; a MAC ID has 6 bits.
    for value in 0..=255 {
        assert_eq!(tester.explicit(&format!("10030104{value:02X}")), "90");
        if value > 63 {
            assert_eq!(tester.explicit(&format!("10030101{value:02X}")), "9409FF");
        }
    }
    assert_eq!(tester.explicit("0E030101"), "8E03");
}

#[test]
fn rates_and_times_are_taken_exactly() {
    let powers = (0..16).map(|bit| 1_u16 << bit);
    let values: Vec<u16> = powers
        .chain([3, 7, 10, 999, 5001, 65_534, 65_535])
        .collect();
    for choice in [0x12, 0x62] {
        // The rates of explicit, poll and COS or cyclic, the inhibit time and the acknowledge timer.
        for address in ["050109", "050209", "050409", "050411", "2B0101"] {
            let mut tester = allocated(choice);
            for &value in &values {
                // T18.
                let actual = if address == "050409" {
                    value.max(2)
                } else {
                    value
                };
                let [sent, actual] = [value, actual].map(|it| format!("{:04X}", it.swap_bytes()));
                let response = tester.exchange(&format!("41C#0A10{address}{sent}"));
                assert_eq!(response[0], format!("41B#0A90{actual}"), "{address}");
                let read = tester.explicit(&format!("0E{address}"));
                assert_eq!(read, format!("8E{actual}"), "{address}");
            }
        }
    }
}
