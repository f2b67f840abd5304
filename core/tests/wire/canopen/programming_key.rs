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
    // It is stored, and node-ID and bit rate act with a reset.
    assert_eq!(second.exchange("000#8100"), ["720#00"]);
    second.power_cycle();
    assert_eq!(second.sent_text(), ["720#00"]);
    second.node_id = 0x20;
    assert_eq!(second.read_text(0x3000), key);
}

#[test]
fn programming_key_is_in_force_when_it_is_stored_and_stores_nothing_else() {
    let mut first = booted();
    first.write(0x2044, 0, 1, 3).unwrap();
    first.write(0x2043, 0, 1, 4).unwrap();
    let key = first.read_text(0x3000);
    let mut t = booted();
    t.write(0x1017, 0, 2, 1000).unwrap();
    t.memory_works = None;
    t.actions.clear();
    t.send("60A#2100300010000000");
    t.send(&format!("60A#00{}", hex(&key[..7])));
    t.send(&format!("60A#10{}", hex(&key[7..14])));
    t.sent_text();
    assert_eq!(
        t.exchange(&format!("60A#0B{}0000000000", hex(&key[14..]))),
        [""; 0]
    );
    assert_eq!(t.read(0x2044, 0), Ok(0), "not stored yet");
    assert_eq!(t.write(0x2044, 0, 1, 1), Err(0x0800_0022));
    assert_eq!(t.write(0x2044, 0, 1, 0), Ok(()), "in force");
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), ["58A#2000000000000000"]);
    assert_eq!((t.read(0x2044, 0), t.read(0x2043, 0)), (Ok(3), Ok(4)));
    let saves = t
        .actions
        .iter()
        .filter(|action| matches!(action, Action::Save));
    assert_eq!(saves.count(), 1);
    t.memory_works = Some(true);
    // The same key: nothing is left to store.
    t.actions.clear();
    assert_eq!(t.write_text(0x3000, &key), "2000000000000000");
    assert!(!t.actions.contains(&Action::Save));
}

#[test]
fn programming_key_that_cannot_be_stored_changes_nothing() {
    let mut first = booted();
    first.write(0x2044, 0, 1, 3).unwrap();
    first.write(0x2000, 0, 1, 7).unwrap();
    let key = first.read_text(0x3000);
    let mut t = booted();
    t.memory_works = Some(false);
    t.sdo("2100300010000000");
    t.sdo(&format!("00{}", hex(&key[..7])));
    t.sdo(&format!("10{}", hex(&key[7..14])));
    let sent = t.exchange(&format!("60A#0B{}0000000000", hex(&key[14..])));
    assert_eq!(sent[0], "58A#8000300000000606");
    assert_eq!((t.read(0x2044, 0), t.read(0x2000, 0)), (Ok(0), Ok(10)));
    assert_eq!(t.memory, None);
}

#[test]
fn one_nul_behind_the_programming_key_is_ignored() {
    let mut t = booted();
    t.write(0x2044, 0, 1, 3).unwrap();
    let key = t.read_text(0x3000);
    for ended in [key.clone() + "\0", "D0UfZEgRKHAI5Ag=\0".to_string()] {
        let reply = t.write_text(0x3000, &ended);
        assert!(reply.starts_with('2') || reply.starts_with('3'), "{reply}");
        assert_eq!(t.read_text(0x3000), ended[..16]);
    }
    for wrong in [
        key.clone() + "\0\0",
        key[..15].to_string() + "\0",
        key + " ",
    ] {
        assert_eq!(
            t.write_text(0x3000, &wrong),
            "8000300030000906",
            "{wrong:?}"
        );
    }
}

fn hex(text: &str) -> String {
    text.bytes().map(|byte| format!("{byte:02X}")).collect()
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
