//! 1010h and 1011h: the groups of CiA 301, and two manufacturer-specific groups.

use super::Stranger;
use super::booted;
use crate::tester::Tester;

const SAVE: u32 = 0x6576_6173;
const LOAD: u32 = 0x6461_6F6C;

/// The place of the hidden parameter in the stored image, from its end: before 1016h, three numbers of 64 bits, 2202h and 1029h.
const HIDDEN_FROM_END: usize = 1 + 12 + 24 + 4 + 1;

/// Index, sub-index, size, value as delivered, another value, the group besides 1.
type Setting = (u16, u8, u8, u32, u32, u8);

/// All settings but node-ID and bit rate, with the group of their index.
#[rustfmt::skip]
const SETTINGS: [Setting; 15] = [
    (0x1005, 0, 4, 0x80, 0x85, 2),
    (0x100C, 0, 2, 0, 500, 2),
    (0x100D, 0, 1, 0, 3, 2),
    (0x1015, 0, 2, 0, 100, 2),
    (0x1017, 0, 2, 0, 60_000, 2),
    (0x1800, 2, 1, 1, 7, 2),
    (0x1800, 3, 2, 0, 70, 2),
    (0x1800, 5, 2, 10, 77, 2),
    (0x1016, 1, 4, 0, 0x0005_0064, 2),
    (0x1029, 1, 1, 0, 2, 2),
    (0x2100, 0, 1, 4, 5, 4),
    (0x2202, 0, 4, 0x4000_0000, 0x3F80_0000, 4),
    (0x3000, 0, 2, 0, 900, 5),
    (0x6000, 0, 2, 10, 100, 3),
    (0x6013, 0, 2, 0, 12, 3),
];

fn change(t: &mut Tester<Stranger>) {
    for (index, sub, size, _, value, _) in SETTINGS {
        assert_eq!(
            t.write(index, sub, size, value),
            Ok(()),
            "{index:04X}h:{sub:02X}"
        );
    }
}

/// Expects the other value in the settings of these groups, and the factory value in all others.
fn expect(t: &mut Tester<Stranger>, changed: &[u8], what: &str) {
    for (index, sub, _, delivered, other, group) in SETTINGS {
        let value = if changed.contains(&group) {
            other
        } else {
            delivered
        };
        assert_eq!(
            t.read(index, sub),
            Ok(value),
            "{what}: {index:04X}h:{sub:02X}"
        );
    }
}

fn restarted(t: &mut Tester<Stranger>) {
    t.power_cycle();
    assert_eq!(t.sent_text(), ["71E#00"]);
}

#[test]
fn save_stores_group_of_its_sub_index() {
    for (sub, groups) in [
        (1, &[2, 3, 4, 5][..]),
        (2, &[2]),
        (3, &[3]),
        (4, &[4]),
        (5, &[5]),
    ] {
        let mut t = booted();
        change(&mut t);
        assert_eq!(t.write(0x1010, sub, 4, SAVE), Ok(()));
        expect(&mut t, &[2, 3, 4, 5], "before the restart");
        restarted(&mut t);
        expect(&mut t, groups, &format!("1010h:{sub:02}"));
    }
}

#[test]
fn saves_of_all_groups_store_everything() {
    let mut t = booted();
    change(&mut t);
    for sub in 2..=5 {
        t.write(0x1010, sub, 4, SAVE).unwrap();
    }
    restarted(&mut t);
    expect(&mut t, &[2, 3, 4, 5], "after the restart");
}

#[test]
fn load_restores_group_of_its_sub_index_at_the_next_reset() {
    for (sub, groups) in [
        (1, &[][..]),
        (2, &[3, 4, 5]),
        (3, &[2, 4, 5]),
        (4, &[2, 3, 5]),
        (5, &[2, 3, 4]),
    ] {
        let mut t = booted();
        change(&mut t);
        t.write(0x1010, 1, 4, SAVE).unwrap();
        assert_eq!(t.write(0x1011, sub, 4, LOAD), Ok(()));
        expect(&mut t, &[2, 3, 4, 5], "before the reset");
        t.send("000#811E");
        assert_eq!(t.sent_text(), ["71E#00"]);
        expect(&mut t, groups, &format!("1011h:{sub:02}, reset node"));
        restarted(&mut t);
        expect(&mut t, groups, &format!("1011h:{sub:02}, power-up"));
    }
}

#[test]
fn reset_communication_takes_restored_communication_parameters() {
    let mut t = booted();
    change(&mut t);
    t.write(0x1010, 1, 4, SAVE).unwrap();
    t.write(0x1011, 1, 4, LOAD).unwrap();
    t.send("000#821E");
    assert_eq!(t.sent_text(), ["71E#00"]);
    expect(&mut t, &[3, 4, 5], "after the reset of the communication");
}

#[test]
fn load_of_all_restores_node_id_and_bit_rate_at_power_up() {
    for (sub, node_id, rate) in [
        (1, 30, 125),
        (2, 31, 250),
        (3, 31, 250),
        (4, 30, 125),
        (5, 31, 250),
    ] {
        let mut t = booted();
        t.write(0x2000, 0, 1, 31).unwrap();
        t.write(0x2001, 0, 2, 250).unwrap();
        t.write(0x1010, 1, 4, SAVE).unwrap();
        t.write(0x1011, sub, 4, LOAD).unwrap();
        t.power_cycle();
        t.sent();
        t.node_id = node_id;
        assert_eq!(t.read(0x2001, 0), Ok(rate), "1011h:{sub:02}");
    }
}

#[test]
fn parameter_without_object_belongs_to_sub_index_4() {
    // The filter has been changed once: the hidden counter is 1. Two more changes are not stored.
    for (sub, counter) in [(1, 1), (2, 0), (3, 0), (4, 1), (5, 0)] {
        let mut t = booted();
        t.write(0x2100, 0, 1, 5).unwrap();
        // Changes a parameter of each group, so that each save stores something.
        change(&mut t);
        t.write(0x1010, sub, 4, SAVE).unwrap();
        let memory = t.memory.clone().unwrap();
        let place = memory.len() - HIDDEN_FROM_END;
        assert_eq!(memory[place], counter, "1010h:{sub:02}");
    }
}

#[test]
fn group_objects_return_1_for_storage_on_command() {
    let mut t = booted();
    for index in [0x1010, 0x1011] {
        assert_eq!(t.read(index, 0), Ok(5));
        for sub in 1..=5 {
            assert_eq!(t.read(index, sub), Ok(1));
        }
        assert_eq!(t.read(index, 6), Err(0x0609_0011));
    }
}

#[test]
fn group_without_signature_is_not_stored() {
    let mut t = booted();
    change(&mut t);
    for sub in 1..=5 {
        assert_eq!(t.write(0x1010, sub, 4, LOAD), Err(0x0800_0020));
        assert_eq!(t.write(0x1011, sub, 4, SAVE), Err(0x0800_0020));
    }
    assert_eq!(t.memory, None);
}

#[test]
fn save_of_a_group_is_refused_during_another_save() {
    let mut t = booted();
    t.memory_works = None;
    t.send("61E#2310100273617665");
    assert_eq!(t.sent_text(), [""; 0]);
    assert_eq!(t.write(0x1010, 3, 4, SAVE), Err(0x0800_0022));
    assert_eq!(t.write(0x1011, 3, 4, LOAD), Err(0x0800_0022));
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), ["59E#6010100200000000"]);
}

#[test]
fn failed_save_of_a_group_returns_hardware_error() {
    let mut t = booted();
    t.memory_works = Some(false);
    assert_eq!(
        t.exchange("61E#2310100373617665"),
        ["59E#8010100300000606", "09E#0063010400000000"]
    );
}
