//! What configuration tools write to the JN2101: COB-IDs and mapping of its fixed TPDOs, and values that they have read.

use crate::tester::canopen::*;
use plumbline::model::catalog::{Protocol, find};
use plumbline::node::Action;

const NOT_MAPPABLE: u32 = 0x0604_0041;
const NO_SUB: u32 = 0x0609_0011;
const VALUE: u32 = 0x0609_0030;

/// Bit 31 of a COB-ID: the TPDO is not valid.
const OFF: u32 = 1 << 31;
/// Bit 30: the TPDO does not answer remote frames.
const NO_RTR: u32 = 1 << 30;

/// The COB-IDs of the TPDOs, and their mapping entries.
const COB_IDS: [(u16, u32); 2] = [(0x1800, 0x18A), (0x1801, 0x28A)];
const ENTRIES: [(u16, [u32; 2]); 2] = [
    (0x1A00, [0x6010_0010, 0x6020_0010]),
    (0x1A01, [0x6110_0020, 0x6120_0020]),
];

/// The TPDOs of a sensor with 10.00 and -5.00 deg.
const TPDO0: &str = "18A#E8030CFE";
const TPDO1: &str = "28A#E80300000CFEFFFF";

/// In operational, with 10.00 and -5.00 deg.
fn tilted() -> Jn2101Tester {
    let mut t = operational();
    t.tilt(10.0, -5.0);
    t
}

#[test]
fn own_cob_id_is_accepted_with_and_without_bits_31_and_30_in_each_state() {
    for state in ["000#800A", "000#010A"] {
        let mut t = booted();
        t.send(state);
        t.actions.clear();
        for (index, own) in COB_IDS {
            for flags in [OFF, NO_RTR, OFF | NO_RTR, 0] {
                assert_eq!(t.write(index, 1, 4, own | flags), Ok(()), "{index:04X}");
                assert_eq!(t.read(index, 1), Ok(own | flags), "{index:04X}");
            }
        }
        // The controller keeps its filters, so that no frame is lost.
        assert_eq!(t.actions, []);
    }
}

#[test]
fn other_cob_id_of_tpdo_is_refused_and_changes_nothing() {
    let mut t = tilted();
    for (index, own) in COB_IDS {
        for value in [
            0,
            OFF,
            own ^ 1,
            own - 10,
            OFF | (own ^ 1),
            NO_RTR | (own + 0x100),
            1 << 29 | own,
            OFF | 1 << 29 | own,
            own | 0x800,
            0x0001_0000 | own,
            0x7FF,
            u32::MAX,
        ] {
            let refused = Err(VALUE);
            assert_eq!(
                t.write(index, 1, 4, value),
                refused,
                "{index:04X} {value:X}"
            );
            assert_eq!(t.read(index, 1), Ok(own));
        }
    }
    assert_eq!(t.exchange("080#"), [TPDO0, TPDO1]);
}

#[test]
fn cob_id_with_bit_31_switches_tpdo_off_until_written_without_it() {
    let mut t = tilted();
    t.write(0x1800, 1, 4, OFF | 0x18A).unwrap();
    assert_eq!(t.exchange("080#"), [TPDO1]);
    assert_eq!(t.exchange("18A#R4"), [""; 0]);
    t.write(0x1800, 2, 1, 254).unwrap();
    assert_eq!(t.wait_text(100), []);
    t.write(0x1800, 2, 1, 1).unwrap();
    // NMT commands do not switch it on.
    t.send("000#800A");
    t.send("000#010A");
    assert_eq!(t.exchange("080#"), [TPDO1]);
    t.write(0x1800, 1, 4, 0x18A).unwrap();
    assert_eq!(t.exchange("080#"), [TPDO0, TPDO1]);
    assert_eq!(t.exchange("18A#R4"), [TPDO0]);
    // Both are off when pre-operational ends.
    t.send("000#800A");
    for (index, own) in COB_IDS {
        t.write(index, 1, 4, OFF | own).unwrap();
    }
    t.send("000#010A");
    assert_eq!(t.exchange("080#"), [""; 0]);
}

#[test]
fn bit_31_is_not_stored_and_ends_with_reset_communication() {
    for reset in ["000#820A", "000#810A", "60A#2F02200001000000", "power"] {
        let mut t = tilted();
        t.write(0x1800, 1, 4, OFF | NO_RTR | 0x18A).unwrap();
        t.store();
        if reset == "power" {
            t.power_cycle();
        } else {
            t.send(reset);
        }
        t.wait_text(200);
        assert_eq!(t.read(0x1800, 1), Ok(0x18A), "{reset}");
        t.tilt(10.0, -5.0);
        t.send("000#010A");
        assert_eq!(t.exchange("080#"), [TPDO0, TPDO1], "{reset}");
        assert_eq!(t.exchange("18A#R4"), [TPDO0], "{reset}");
    }
}

#[test]
fn tpdo_that_is_switched_off_is_removed_from_the_queue() {
    for (index, sub, size, value) in [(0x1800, 1, 4, OFF | 0x18A), (0x1A00, 0, 1, 0)] {
        let mut t = tilted();
        t.send("080#");
        t.send(&format!("60A#{}", write_request(index, sub, size, value)));
        let reply = format!(
            "58A#60{}00000000",
            &write_request(index, sub, size, value)[2..8]
        );
        assert_eq!(t.sent_text(), [TPDO1.to_string(), reply]);
    }
}

#[test]
fn event_timer_begins_a_new_period_when_tpdo_is_switched_on() {
    for (index, sub, size, off, on) in [(0x1800, 1, 4, OFF | 0x18A, 0x18A), (0x1A00, 0, 1, 0, 2)] {
        let mut t = booted();
        t.tilt(10.0, -5.0);
        t.write(0x1800, 2, 1, 254).unwrap();
        t.write(0x1800, 5, 2, 20).unwrap();
        // Events while it is off do not start the inhibit time.
        t.write(0x1800, 3, 2, 150).unwrap();
        t.send("000#010A");
        t.wait_text(30);
        t.write(index, sub, size, off).unwrap();
        assert_eq!(t.wait_text(45), []);
        t.write(index, sub, size, on).unwrap();
        let expected = [20, 40].map(|at| (at, TPDO0.to_string()));
        assert_eq!(t.wait_text(50), expected, "{index:04X}");
        // A write of the present value does not shift the period.
        t.write(index, sub, size, on).unwrap();
        assert_eq!(t.wait_text(10), [(10, TPDO0.to_string())], "{index:04X}");
    }
}

#[test]
fn bit_30_switches_the_answer_to_remote_frames_off() {
    let mut t = tilted();
    t.write(0x1801, 1, 4, NO_RTR | 0x28A).unwrap();
    assert_eq!(t.exchange("28A#R8"), [""; 0]);
    assert_eq!(t.exchange("18A#R4"), [TPDO0]);
    assert_eq!(t.exchange("080#"), [TPDO0, TPDO1]);
    t.write(0x1801, 1, 4, 0x28A).unwrap();
    assert_eq!(t.exchange("28A#R8"), [TPDO1]);
}

#[test]
fn mapping_entry_accepts_only_its_current_value() {
    let mut t = tilted();
    for (index, entries) in ENTRIES {
        assert_eq!(t.write(index, 0, 1, 2), Ok(()));
        for (sub, entry) in (1..).zip(entries) {
            assert_eq!(t.write(index, sub, 4, entry), Ok(()));
            for other in [0, entry ^ 1, entry & !0xFF, 0x6010_0008, entry ^ 1 << 31] {
                assert_eq!(
                    t.write(index, sub, 4, other),
                    Err(NOT_MAPPABLE),
                    "{other:X}"
                );
            }
            assert_eq!(t.write(index, sub, 2, entry), Err(NOT_MAPPABLE));
            assert_eq!(t.read(index, sub), Ok(entry));
        }
        for number in [1, 3, 8, 0xFE, 0xFF] {
            assert_eq!(t.write(index, 0, 1, number), Err(NOT_MAPPABLE), "{number}");
        }
        for size in [2, 4] {
            assert_eq!(t.write(index, 0, size, 2), Err(NOT_MAPPABLE));
            assert_eq!(t.write(index, 0, size, 0), Err(NOT_MAPPABLE));
        }
        assert_eq!(t.read(index, 0), Ok(2));
        assert_eq!(t.write(index, 3, 4, 0), Err(NO_SUB));
    }
    // Segmented transfers.
    assert_eq!(t.sdo("21001A0104000000"), "60001A0100000000");
    assert_eq!(t.sdo("0710001060000000"), "2000000000000000");
    assert_eq!(t.sdo("21001A0104000000"), "60001A0100000000");
    assert_eq!(t.sdo("0710001160000000"), abort("001A01", NOT_MAPPABLE));
    assert_eq!(t.sdo("21001A0105000000"), abort("001A01", NOT_MAPPABLE));
    assert_eq!(t.exchange("080#"), [TPDO0, TPDO1]);
}

#[test]
fn number_0_of_mapped_objects_keeps_tpdo_silent_until_the_number_is_written() {
    let mut t = tilted();
    assert_eq!(t.write(0x1A01, 0, 1, 0), Ok(()));
    assert_eq!(t.read(0x1A01, 0), Ok(0));
    assert_eq!(t.exchange("080#"), [TPDO0]);
    assert_eq!(t.exchange("28A#R8"), [""; 0]);
    // The entries have not changed.
    assert_eq!(t.read(0x1A01, 1), Ok(0x6110_0020));
    assert_eq!(t.write(0x1A01, 1, 4, 0x6110_0020), Ok(()));
    assert_eq!(t.exchange("080#"), [TPDO0]);
    assert_eq!(t.write(0x1A01, 0, 1, 2), Ok(()));
    assert_eq!(t.read(0x1A01, 0), Ok(2));
    assert_eq!(t.exchange("080#"), [TPDO0, TPDO1]);
    // Each of the two conditions disables the TPDO.
    t.write(0x1801, 1, 4, OFF | 0x28A).unwrap();
    t.write(0x1A01, 0, 1, 0).unwrap();
    t.write(0x1801, 1, 4, 0x28A).unwrap();
    assert_eq!(t.exchange("080#"), [TPDO0]);
    // A reset restores the number of mapped objects.
    for reset in ["000#820A", "000#810A"] {
        t.write(0x1A01, 0, 1, 0).unwrap();
        assert_eq!(t.exchange(reset), ["70A#00"]);
        assert_eq!(t.read(0x1A01, 0), Ok(2), "{reset}");
        t.send("000#010A");
        assert_eq!(t.exchange("080#"), [TPDO0, TPDO1], "{reset}");
    }
}

#[test]
fn refused_mapping_puts_the_fixed_mapping_in_force_again() {
    let entries = ["23011A0120001060", "23011A0220001061", "2B011A0120000000"];
    let numbers = ["2F011A0001000000", "2F011A0003000000", "2B011A0000000000"];
    for refused in entries.into_iter().chain(numbers) {
        let mut t = tilted();
        t.write(0x1A01, 0, 1, 0).unwrap();
        assert_eq!(t.exchange("080#"), [TPDO0]);
        assert_eq!(
            t.sdo(refused),
            abort(&refused[2..8], NOT_MAPPABLE),
            "{refused}"
        );
        assert_eq!(t.read(0x1A01, 0), Ok(2), "{refused}");
        assert_eq!(t.exchange("080#"), [TPDO0, TPDO1], "{refused}");
    }
}

/// A tool that switches the TPDO off before it maps, like python-canopen: bit 31 is not a part of the mapping.
#[test]
fn disabled_tpdo_keeps_its_mapping_after_a_refused_mapping() {
    for zero in [false, true] {
        let mut t = tilted();
        t.write(0x1801, 1, 4, OFF | 0x28A).unwrap();
        if zero {
            t.write(0x1A01, 0, 1, 0).unwrap();
        }
        assert_eq!(t.write(0x1A01, 1, 4, 0x6010_0010), Err(NOT_MAPPABLE));
        assert_eq!(t.exchange("080#"), [TPDO0]);
        assert_eq!(t.read(0x1801, 1), Ok(OFF | 0x28A));
        assert_eq!(t.read(0x1A01, 0), Ok(2));
        assert_eq!(t.read(0x1A01, 1), Ok(0x6110_0020));
        t.write(0x1801, 1, 4, 0x28A).unwrap();
        assert_eq!(t.exchange("080#"), [TPDO0, TPDO1]);
    }
}

#[test]
fn sampled_data_is_not_sent_while_no_object_is_mapped() {
    let mut t = tilted();
    t.write(0x1800, 2, 1, 252).unwrap();
    assert_eq!(t.exchange("080#"), [TPDO1]);
    t.write(0x1A00, 0, 1, 0).unwrap();
    assert_eq!(t.exchange("18A#R4"), [""; 0]);
    t.write(0x1A00, 0, 1, 2).unwrap();
    assert_eq!(t.exchange("18A#R4"), [TPDO0]);
}

/// What `tpdo.save()` of python-canopen, dcfgen and the configurators of PLCs write.
#[test]
fn complete_configuration_of_a_tpdo_is_accepted_in_each_state() {
    for state in ["000#800A", "000#010A"] {
        let mut t = booted();
        t.tilt(10.0, -5.0);
        t.send(state);
        for ((communication, own), (mapping, entries)) in COB_IDS.into_iter().zip(ENTRIES) {
            for (index, sub, size, value) in [
                (communication, 1, 4, OFF | own),
                (communication, 2, 1, 1),
                (communication, 3, 2, 0),
                (communication, 5, 2, 10),
                (mapping, 0, 1, 0),
                (mapping, 1, 4, entries[0]),
                (mapping, 2, 4, entries[1]),
                (mapping, 0, 1, 2),
                (communication, 1, 4, own),
            ] {
                let written = t.write(index, sub, size, value);
                assert_eq!(written, Ok(()), "{index:04X}:{sub} in {state}");
            }
        }
        t.send("000#010A");
        assert_eq!(t.exchange("080#"), [TPDO0, TPDO1]);
    }
}

/// The commands: a write does more than change the value. The EDS marks them with ObjFlags.
const COMMANDS: [(u16, u8); 9] = [
    (0x1003, 0),
    (0x1010, 1),
    (0x1011, 1),
    (0x2002, 0),
    (0x2042, 0),
    (0x2046, 0),
    (0x207F, 0),
    (0x3000, 0),
    (0x4004, 1),
];

#[test]
fn objects_other_than_commands_accept_the_value_that_was_read() {
    let product = find("jn2101").expect("a product");
    let Protocol::Canopen(tables) = &product.protocol else {
        panic!("CANopen")
    };
    let mut t = tilted();
    let mut written = 0;
    for object in tables.objects {
        let address = (object.index, object.sub);
        if !object.access.is_writable() || COMMANDS.contains(&address) {
            continue;
        }
        let size = object
            .data_type(product.parameters, product.quantities)
            .size();
        let value = t.read(object.index, object.sub).unwrap();
        let back = t.write(object.index, object.sub, size, value);
        assert_eq!(back, Ok(()), "{:04X}:{}", object.index, object.sub);
        written += 1;
    }
    // Manual 7.6: six, four of each TPDO, and 1F80h; 7.7: eight.
    assert_eq!(written, 23);
    assert!(
        !t.actions
            .iter()
            .any(|action| matches!(action, Action::Save))
    );
    assert_eq!(t.exchange("080#"), [TPDO0, TPDO1]);
}
