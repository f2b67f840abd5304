//! The programming key of the JN2101 (manual 9.11; J9 of the product's README).

use super::jn2101::angles;
use crate::tester::canopen::*;
use plumbline::node::Action;

#[test]
fn programming_key_copies_parameters_to_another_sensor() {
    let mut first = booted();
    let list = [
        (0x2000, 1, 0x20),
        (0x2001, 2, 1000),
        (0x2040, 1, 2),
        (0x2041, 1, 0),
        (0x2043, 1, 4),
        (0x2044, 1, 3),
        (0x2045, 1, 0),
        (0x6000, 2, 1000),
    ];
    for (index, size, value) in list {
        first.write(index, 0, size, value).unwrap();
    }
    let key = first.read_text(0x3000);
    assert_eq!(key.len(), 16);
    assert_ne!(key, "D0UfZEgRKHAI5Ag=");
    let mut second = booted();
    assert_eq!(second.write_text(0x3000, &key), "2000000000000000");
    for (index, _, value) in list {
        assert_eq!(second.read(index, 0), Ok(value), "{index:04X}");
    }
    assert!(second.actions.contains(&Action::Termination(false)));
    assert_eq!(second.read_text(0x3000), key);
    assert_eq!(second.memory, None, "not before it is saved");
}

#[test]
fn wrong_programming_key_is_refused_and_changes_nothing() {
    let mut t = booted();
    t.write(0x2044, 0, 1, 3).unwrap();
    let key = t.read_text(0x3000);
    let mut wrong = vec![
        "A".to_string(),
        "D0UfZEgRKHAI5Ag".into(),
        key.clone() + "A",
        "????????????????".into(),
        "D0UfZEgRKHA=".into(),
        "                ".into(),
        "\0".repeat(16),
    ];
    for place in 0..key.len() {
        let mut bytes = key.clone().into_bytes();
        bytes[place] = if bytes[place] == b'B' { b'C' } else { b'B' };
        wrong.push(String::from_utf8(bytes).unwrap());
    }
    for text in &wrong {
        let reply = t.write_text(0x3000, text);
        assert_eq!(reply, "8000300030000906", "{text}");
        assert_eq!(t.read_text(0x3000), key);
    }
}

#[test]
fn printed_programming_key_restores_factory_values() {
    let mut t = booted();
    t.tilt(10.0, 5.0);
    t.write(0x2042, 0, 1, 1).unwrap();
    t.write(0x2044, 0, 1, 3).unwrap();
    t.write(0x2000, 0, 1, 0x20).unwrap();
    assert_eq!(t.write_text(0x3000, "D0UfZEgRKHAI5Ag="), "2000000000000000");
    assert_eq!(t.read(0x2044, 0), Ok(0));
    assert_eq!(t.read(0x2000, 0), Ok(10));
    assert_eq!(t.read(0x2042, 0), Ok(2));
    assert_eq!(angles(&mut t), (1000, 500));
    assert_eq!(t.read_text(0x3000), "D0UfZEgRKHAI5Ag=");
    // The end of the teach-in is stored at once.
    t.power_cycle();
    t.sent_text();
    assert_eq!(t.read(0x2042, 0), Ok(2));
}

#[test]
fn programming_key_does_not_contain_reference_frame() {
    let mut first = booted();
    first.tilt(10.0, 5.0);
    first.write(0x2042, 0, 1, 1).unwrap();
    let key = first.read_text(0x3000);
    let mut second = booted();
    second.write_text(0x3000, &key);
    assert_eq!(second.read(0x2042, 0), Ok(2));
    // Written to the first sensor, it does not end the teach-in.
    first.write_text(0x3000, &key);
    assert_eq!(first.read(0x2042, 0), Ok(1));
    assert_eq!(angles(&mut first), (0, 0));
}
