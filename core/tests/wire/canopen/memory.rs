//! Nonvolatile data of the JN2101: store, restore, factory reset (manual 7.6, 10).

use crate::tester::canopen::*;
use plumbline::can::BitRate;
use plumbline::measure::Calibration;
use plumbline::node::{Action, Boot, BusMode};

const HARDWARE: u32 = 0x0606_0000;
const LOAD: u32 = 0x6461_6F6C;

/// Index, sub-index, size, factory value and another value of all stored parameters (10.1) except the node-ID and the bit rate.
const COMMUNICATION: [(u16, u8, u8, u32, u32); 12] = [
    (0x1005, 0, 4, 0x80, 0xA0),
    (0x100C, 0, 2, 0, 1234),
    (0x100D, 0, 1, 0, 7),
    (0x1015, 0, 2, 0, 300),
    (0x1017, 0, 2, 0, 60_000),
    (0x1800, 2, 1, 1, 254),
    (0x1800, 3, 2, 0, 77),
    (0x1800, 5, 2, 10, 65_535),
    (0x1801, 2, 1, 1, 240),
    (0x1801, 3, 2, 0, 78),
    (0x1801, 5, 2, 10, 500),
    (0x1F80, 0, 4, 0, 8),
];
const OWN: [(u16, u8, u8, u32, u32); 6] = [
    (0x2040, 0, 1, 1, 2),
    (0x2041, 0, 1, 1, 0),
    (0x2043, 0, 1, 2, 4),
    (0x2044, 0, 1, 0, 3),
    (0x2045, 0, 1, 1, 0),
    (0x6000, 0, 2, 10, 1),
];

fn write_all(t: &mut Jn2101Tester) {
    for (index, sub, size, _, value) in COMMUNICATION.into_iter().chain(OWN) {
        assert_eq!(t.write(index, sub, size, value), Ok(()), "{index:04X}");
    }
}

fn expect(t: &mut Jn2101Tester, list: &[(u16, u8, u8, u32, u32)], factory: bool) {
    for &(index, sub, _, before, after) in list {
        let value = if factory { before } else { after };
        assert_eq!(t.read(index, sub), Ok(value), "{index:04X}:{sub}");
    }
}

fn load(t: &mut Jn2101Tester) -> Result<(), u32> {
    t.write(0x1011, 1, 4, LOAD)
}

#[test]
fn power_cycle_without_save_restores_factory_values() {
    let mut t = booted();
    write_all(&mut t);
    expect(&mut t, &COMMUNICATION, false);
    expect(&mut t, &OWN, false);
    t.power_cycle();
    t.sent_text();
    expect(&mut t, &COMMUNICATION, true);
    expect(&mut t, &OWN, true);
    assert_eq!(t.memory, None);
}

#[test]
fn save_keeps_all_parameters() {
    let mut t = booted();
    write_all(&mut t);
    assert_eq!(t.sdo("2310100173617665"), "6010100100000000");
    t.power_cycle();
    assert_eq!(t.sent_text(), ["70A#00"]);
    expect(&mut t, &COMMUNICATION, false);
    expect(&mut t, &OWN, false);
    assert!(t.actions.contains(&Action::Termination(false)));
    assert_eq!(t.read(0x1029, 1), Ok(0), "1029h is not saved");
}

#[test]
fn load_restores_communication_profile_after_reset() {
    for reset in ["000#8100", "000#8200", "power"] {
        let mut t = booted();
        write_all(&mut t);
        t.store();
        assert_eq!(t.sdo("231110016C6F6164"), "6011100100000000");
        expect(&mut t, &COMMUNICATION, false);
        if reset == "power" {
            t.power_cycle();
        } else {
            t.send(reset);
        }
        assert_eq!(t.sent_text(), ["70A#00"], "{reset}");
        expect(&mut t, &COMMUNICATION, true);
        expect(&mut t, &OWN, false);
    }
}

#[test]
fn failed_save_is_aborted_and_sends_emergency() {
    let mut t = booted();
    t.memory_works = Some(false);
    t.write(0x1017, 0, 2, 60_000).unwrap();
    let save = format!("60A#{}", write_request(0x1010, 1, 4, 0x6576_6173));
    // Hardware error, and its emergency message with status bit 3.
    assert_eq!(
        t.exchange(&save),
        ["58A#8010100100000606", "08A#0010010800000000"]
    );
    assert_eq!(t.write(0x1010, 1, 4, 0x6576_6173), Err(HARDWARE));
    assert_eq!(load(&mut t), Err(HARDWARE));
    assert_eq!(t.write(0x207F, 0, 1, 1), Err(HARDWARE));
    assert_eq!(t.read(0x207F, 0), Ok(0));
    // Zero point and teach-in could not be stored and are not in force.
    t.tilt(10.0, 5.0);
    assert_eq!(t.write(0x2046, 0, 1, 1), Err(HARDWARE));
    assert_eq!(t.read(0x2046, 0), Ok(2));
    assert_eq!(t.write(0x2042, 0, 1, 1), Err(HARDWARE));
    assert_eq!(t.read(0x2042, 0), Ok(2));
    assert_eq!(t.read_i16(0x6010), 1000);
    assert_eq!(t.read(0x1001, 0), Ok(1));
    t.memory_works = Some(true);
    assert_eq!(
        t.exchange(&save),
        ["58A#6010100100000000", "08A#0000000000000000"]
    );
    assert_eq!(t.read(0x1001, 0), Ok(0));
}

#[test]
fn damaged_memory_gives_factory_values_and_emergency() {
    let damaged = Boot {
        damaged: true,
        ..Boot::default()
    };
    let nonsense = Boot {
        parameters: Some(&[0xEE; 54]),
        ..Boot::default()
    };
    for loaded in [damaged, nonsense] {
        let mut t = with_memory(loaded);
        assert_eq!(t.sent_text(), ["70A#00", "08A#0010010800000000"]);
        expect(&mut t, &COMMUNICATION, true);
        let save = format!("60A#{}", write_request(0x1010, 1, 4, 0x6576_6173));
        assert_eq!(
            t.exchange(&save),
            ["58A#6010100100000000", "08A#0000000000000000"]
        );
        assert_eq!(t.read(0x1001, 0), Ok(0));
    }
}

#[test]
fn each_byte_of_image_is_checked() {
    let mut t = booted();
    t.tilt(10.0, 5.0);
    t.write(0x2042, 0, 1, 1).unwrap();
    t.store();
    let image = t.memory.clone().unwrap();
    for byte in 0..image.len() {
        for bit in 0..8 {
            let mut payload = image.clone();
            payload[byte] ^= 1 << bit;
            let loaded = Boot {
                parameters: Some(&payload),
                ..Boot::default()
            };
            let mut t = with_memory(loaded);
            let sent = t.sent_text();
            // Accepted as another permitted value, or the complete image is refused.
            let refused = sent
                .iter()
                .any(|frame| frame.ends_with("#0010010800000000"));
            if refused {
                expect(&mut t, &COMMUNICATION, true);
                expect(&mut t, &OWN, true);
                assert_eq!(t.read(0x2000, 0), Ok(10));
            }
        }
    }
}

/// The sizes of the stored parameters in the order of the table: the objects, then zero point and reference frame.
const STORED: [usize; 28] = [
    4, 2, 1, 2, 2, 1, 2, 2, 1, 2, 2, 4, 1, 2, 1, 1, 1, 1, 1, 1, 1, 2, 4, 4, 4, 4, 4, 4,
];

#[test]
fn stored_prefix_keeps_its_parameters_and_the_others_have_factory_values() {
    let mut t = booted();
    t.write(0x1017, 0, 2, 1234).unwrap();
    t.write(0x6000, 0, 2, 100).unwrap();
    t.store();
    let image = t.memory.clone().unwrap();
    assert_eq!(image.len(), STORED.iter().sum());
    let mut ends = vec![0];
    for size in STORED {
        ends.push(ends[ends.len() - 1] + size);
    }
    for length in 0..=image.len() + 3 {
        let mut stored = image.clone();
        // A newer firmware can have stored more parameters.
        stored.resize(length, 0x55);
        let loaded = Boot {
            parameters: Some(&stored),
            ..Boot::default()
        };
        let mut t = with_memory(loaded);
        let sent = t.sent_text();
        let damaged = sent
            .iter()
            .any(|frame| frame.ends_with("#0010010800000000"));
        let whole = length > image.len() || ends.contains(&length);
        assert_eq!(damaged, !whole, "{length} bytes");
        // 1017h ends with byte 10, 6000h with byte 36.
        let heartbeat = if whole && length >= 11 { 1234 } else { 0 };
        let resolution = if whole && length >= 37 { 100 } else { 10 };
        assert_eq!(t.read(0x6000, 0), Ok(resolution), "{length} bytes");
        assert_eq!(t.read(0x1017, 0), Ok(heartbeat), "{length} bytes");
    }
}

#[test]
fn factory_reset_restores_manufacturer_parameters_at_once() {
    let mut t = booted();
    write_all(&mut t);
    t.tilt(10.0, 5.0);
    t.write(0x2042, 0, 1, 1).unwrap();
    t.write(0x2046, 0, 1, 1).unwrap();
    t.write(0x2000, 0, 1, 0x20).unwrap();
    t.write(0x2001, 0, 2, 500).unwrap();
    t.store();
    t.power_cycle();
    assert_eq!(t.sent_text(), ["720#00"]);
    t.node_id = 0x20;
    assert_eq!(t.read(0x207F, 0), Ok(0));
    assert_eq!(t.write(0x207F, 0, 1, 1), Ok(()));
    assert_eq!(t.read(0x207F, 0), Ok(1));
    expect(&mut t, &OWN, true);
    expect(&mut t, &COMMUNICATION, false);
    assert_eq!(t.read(0x2042, 0), Ok(2));
    assert_eq!(t.read(0x2046, 0), Ok(2));
    assert_eq!(t.read_i16(0x6010), 1000);
    // Node-ID and bit rate are in force after the next reset.
    assert_eq!(t.read(0x2000, 0), Ok(10));
    assert_eq!(t.read(0x2001, 0), Ok(125));
    t.power_cycle();
    assert_eq!(t.sent_text(), ["70A#00"]);
    t.node_id = 10;
    expect(&mut t, &OWN, true);
    expect(&mut t, &COMMUNICATION, false);
    assert!(
        t.actions
            .contains(&Action::Bus(BusMode::Normal, BitRate::K125))
    );
}

#[test]
fn zero_point_and_teach_are_stored_at_once_without_other_parameters() {
    let mut t = booted();
    t.write(0x1017, 0, 2, 60_000).unwrap();
    t.write(0x6000, 0, 2, 100).unwrap();
    t.tilt(10.0, 5.0);
    t.write(0x2046, 0, 1, 1).unwrap();
    t.power_cycle();
    t.sent_text();
    assert_eq!(t.read(0x1017, 0), Ok(0));
    assert_eq!(t.read(0x6000, 0), Ok(10));
    assert_eq!(t.read(0x2046, 0), Ok(1));
    assert_eq!((t.read_i16(0x6010), t.read_i16(0x6020)), (0, 0));
    t.write(0x2046, 0, 1, 2).unwrap();
    t.write(0x2042, 0, 1, 1).unwrap();
    t.power_cycle();
    t.sent_text();
    assert_eq!(t.read(0x2046, 0), Ok(2));
    assert_eq!(t.read(0x2042, 0), Ok(1));
    assert_eq!((t.read_i16(0x6010), t.read_i16(0x6020)), (0, 0));
    t.write(0x2042, 0, 1, 2).unwrap();
    t.power_cycle();
    t.sent_text();
    assert_eq!((t.read_i16(0x6010), t.read_i16(0x6020)), (1000, 500));
}

#[test]
fn calibration_is_unchanged_after_each_reset() {
    let mut t = booted();
    t.store();
    // Offset of 0.1 g on the X axis.
    t.calibration = Calibration::new([26_843_546, 0, 0], [[0; 3]; 3], [0; 3]).unwrap();
    t.power_cycle();
    t.settle_at([0.1, 0.0, 1.0]);
    t.sent_text();
    assert_eq!(t.read_i16(0x6010), 0);
    t.write(0x207F, 0, 1, 1).unwrap();
    load(&mut t).unwrap();
    t.store();
    t.power_cycle();
    t.sent_text();
    assert_eq!(t.read_i16(0x6010), 0);
}
