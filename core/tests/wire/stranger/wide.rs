//! Numbers of 64 bits: dynamic mapping (1A00h and following), and permitted ranges.

use super::dynamic::Mast;
use super::types::{WRITTEN, hex, read, write};
use crate::tester::Tester;
use plumbline::canopen::CanopenNode;
use plumbline::node::Boot;

/// Mapping entries: a parameter of the type INTEGER64, one of the type REAL64, a value of the type INTEGER64.
const TOTAL: u32 = 0x2200_0040;
const SCALE: u32 = 0x2201_0040;
const SAMPLES: u32 = 0x6210_0040;

const NOT_MAPPABLE: u32 = 0x0604_0041;
const TOO_MANY: u32 = 0x0604_0042;

type Node = CanopenNode<Mast>;

/// A node in operational that has sent its boot-up message. A SYNC sends its second TPDO only.
fn operational() -> Tester<Node> {
    let mut t = Tester::power_up(Boot::default(), Node::new);
    t.node_id = 50;
    assert_eq!(t.sent_text(), ["732#00"]);
    t.write(0x1801, 2, 1, 1).unwrap();
    t.send("000#0132");
    t
}

#[test]
fn factory_mapping_of_64_bits_is_sent_with_sync() {
    let mut t = operational();
    assert_eq!(t.exchange("080#"), ["2B2#FBFFFFFFFFFFFFFF"]);
    assert_eq!(write(&mut t, 0x2200, 0x12_3456_789A), WRITTEN);
    assert_eq!(t.exchange("080#"), ["2B2#9A78563412000000"]);
}

#[test]
fn numbers_of_64_bits_are_mapped_by_a_master() {
    let mut t = operational();
    t.map(1, &[SCALE]);
    let scale = hex(&2.0_f64.to_le_bytes());
    assert_eq!(t.exchange("080#"), [format!("2B2#{scale}")]);
    t.map(1, &[SAMPLES]);
    let before = read(&mut t, 0x6210) as i64;
    t.hold([0, 0, plumbline::measure::ONE_G], 1);
    let samples = hex(&(before - 1).to_le_bytes());
    assert_eq!(t.exchange("080#"), [format!("2B2#{samples}")]);
    t.map(1, &[TOTAL]);
    assert_eq!(t.exchange("080#"), ["2B2#FBFFFFFFFFFFFFFF"]);
}

#[test]
fn mapping_of_64_bits_is_stored() {
    let mut t = operational();
    t.map(1, &[SCALE]);
    t.store();
    t.power_cycle();
    assert_eq!(t.sent_text(), ["732#00"]);
    t.send("000#0132");
    let scale = hex(&2.0_f64.to_le_bytes());
    assert_eq!(t.exchange("080#"), [format!("2B2#{scale}")]);
}

#[test]
fn object_of_64_bits_fills_the_frame() {
    let mut t = operational();
    t.write(0x1801, 1, 4, 0x8000_02B2).unwrap();
    t.write(0x1A01, 0, 1, 0).unwrap();
    for entry in [0x2200_0020, 0x2200_0008, 0x2200_0000, 0x2300_0010] {
        assert_eq!(
            t.write(0x1A01, 1, 4, entry),
            Err(NOT_MAPPABLE),
            "{entry:08X}"
        );
    }
    t.write(0x1A01, 1, 4, TOTAL).unwrap();
    t.write(0x1A01, 2, 4, 0x6010_0010).unwrap();
    assert_eq!(t.write(0x1A01, 0, 1, 2), Err(TOO_MANY));
    t.write(0x1A01, 1, 4, 0x6010_0010).unwrap();
    t.write(0x1A01, 2, 4, TOTAL).unwrap();
    assert_eq!(t.write(0x1A01, 0, 1, 2), Err(TOO_MANY));
    assert_eq!(t.read(0x1A01, 0), Ok(0));
}

#[test]
fn number_of_64_bits_out_of_range_is_refused() {
    let abort = |index: u16, code: &str| {
        let [low, high] = index.to_le_bytes();
        format!("80{low:02X}{high:02X}00{code}")
    };
    let [invalid, too_high, too_low] = ["30000906", "31000906", "32000906"];
    let mut t = operational();
    let mut last = -5_i64 as u64;
    for (number, code) in [
        (-5, ""),
        (-6, too_low),
        (i64::MIN, too_low),
        (-1, ""),
        (1 << 40, ""),
        ((1 << 40) + 1, too_high),
        (i64::MAX, too_high),
    ] {
        let reply = write(&mut t, 0x2200, number as u64);
        if code.is_empty() {
            assert_eq!(reply, WRITTEN, "{number}");
            last = number as u64;
        } else {
            assert_eq!(reply, abort(0x2200, code), "{number}");
        }
        assert_eq!(read(&mut t, 0x2200), last);
    }
    for (number, code) in [
        (90.0_f64, ""),
        (-90.0, ""),
        (-0.0, ""),
        (90.000_000_000_1, too_high),
        (f64::INFINITY, too_high),
        (-90.000_000_000_1, too_low),
        (f64::NEG_INFINITY, too_low),
        (f64::NAN, invalid),
        (-f64::NAN, invalid),
    ] {
        let reply = write(&mut t, 0x2201, number.to_bits());
        let expected = match code {
            "" => WRITTEN.into(),
            code => abort(0x2201, code),
        };
        assert_eq!(reply, expected, "{number}");
    }
    assert_eq!(read(&mut t, 0x2201), (-0.0_f64).to_bits());
}

#[test]
fn stored_number_of_64_bits_out_of_range_is_refused() {
    for scale in [90.5_f64, f64::NAN] {
        let mut t = operational();
        t.store();
        let mut memory = t.memory.clone().unwrap();
        let place = memory.len() - 8;
        assert_eq!(memory[place..], 2.0_f64.to_le_bytes());
        memory[place..].copy_from_slice(&scale.to_le_bytes());
        t.memory = Some(memory);
        t.power_cycle();
        // The memory fault.
        assert_eq!(t.sent_text(), ["732#00", "0B2#0063010400000000"]);
        assert_eq!(read(&mut t, 0x2201), 2.0_f64.to_bits());
    }
}
