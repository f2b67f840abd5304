//! Numbers of 64 bits and real numbers: SDO, process data, range checks and the memory.

use super::booted;
use crate::tester::Tester;
use plumbline::node::Node;

/// Reads eight bytes with a segmented transfer.
pub fn read<N: Node>(t: &mut Tester<N>, index: u16) -> u64 {
    let [low, high] = index.to_le_bytes();
    let object = format!("{low:02X}{high:02X}00");
    let reply = t.sdo(&format!("40{object}00000000"));
    assert_eq!(reply, format!("41{object}08000000"));
    let (first, last) = (t.sdo("6000000000000000"), t.sdo("7000000000000000"));
    assert_eq!((&first[..2], &last[..2]), ("00", "1D"));
    let bytes = format!("{}{}", &first[2..], &last[2..4]);
    u64::from_str_radix(&bytes, 16).unwrap().swap_bytes()
}

/// Writes eight bytes with a segmented transfer. Returns the last reply.
pub fn write<N: Node>(t: &mut Tester<N>, index: u16, value: u64) -> String {
    let [low, high] = index.to_le_bytes();
    let reply = t.sdo(&format!("21{low:02X}{high:02X}0008000000"));
    assert_eq!(reply, format!("60{low:02X}{high:02X}0000000000"));
    let bytes = format!("{:016X}", value.swap_bytes());
    assert_eq!(t.sdo(&format!("00{}", &bytes[..14])), "2000000000000000");
    t.sdo(&format!("1D{}000000000000", &bytes[14..]))
}

pub const WRITTEN: &str = "3000000000000000";

#[test]
fn number_of_64_bits_has_its_factory_value() {
    let mut t = booted();
    assert_eq!(read(&mut t, 0x2200), 1 << 40);
    assert_eq!(read(&mut t, 0x2201), -5_i64 as u64);
    assert_eq!(read(&mut t, 0x2203), 0.25_f64.to_bits());
    assert_eq!(t.read(0x2202, 0), Ok(2.0_f32.to_bits()));
}

#[test]
fn number_of_64_bits_is_written_and_stored_whole() {
    let numbers = [0, 1, u64::MAX, 0x0000_0001_0000_0000, 0x0123_4567_89AB_CDEF];
    for number in numbers {
        let mut t = booted();
        for index in [0x2200, 0x2201] {
            assert_eq!(write(&mut t, index, number), WRITTEN);
            assert_eq!(read(&mut t, index), number);
        }
        t.store();
        t.power_cycle();
        t.sent();
        assert_eq!(
            (read(&mut t, 0x2200), read(&mut t, 0x2201)),
            (number, number)
        );
    }
}

#[test]
fn number_of_64_bits_with_another_length_is_refused() {
    let mut t = booted();
    assert_eq!(t.write(0x2200, 0, 4, 7), Err(0x0607_0013));
    for (length, code) in [("07", "13000706"), ("09", "12000706"), ("00", "13000706")] {
        assert_eq!(
            t.sdo(&format!("21002200{length}000000")),
            format!("80002200{code}")
        );
    }
    // Without an announced length.
    assert_eq!(t.sdo("2000220000000000"), "6000220000000000");
    assert_eq!(t.sdo("0101020304050607"), "8000220013000706");
    assert_eq!(read(&mut t, 0x2200), 1 << 40);
}

#[test]
fn nan_is_refused() {
    let mut t = booted();
    for nan in [0x7FC0_0000, 0x7F80_0001, 0xFFFF_FFFF] {
        assert_eq!(t.write(0x2202, 0, 4, nan), Err(0x0609_0030), "{nan:08X}");
    }
    assert_eq!(
        write(&mut t, 0x2203, f64::NAN.to_bits()),
        "8003220030000906"
    );
    assert_eq!(t.read(0x2202, 0), Ok(2.0_f32.to_bits()));
    assert_eq!(read(&mut t, 0x2203), 0.25_f64.to_bits());
    assert_eq!(write(&mut t, 0x2203, f64::INFINITY.to_bits()), WRITTEN);
}

#[test]
fn real_number_out_of_range_is_refused() {
    let mut t = booted();
    for (number, expected) in [
        (90.0_f32, Ok(())),
        (-90.0, Ok(())),
        (-0.0, Ok(())),
        (0.125, Ok(())),
        (90.00001, Err(0x0609_0031)),
        (f32::INFINITY, Err(0x0609_0031)),
        (-90.00001, Err(0x0609_0032)),
    ] {
        let written = t.write(0x2202, 0, 4, number.to_bits());
        assert_eq!(written, expected, "{number}");
    }
}

#[test]
fn stored_image_with_nan_is_refused() {
    let mut t = booted();
    t.store();
    let mut memory = t.memory.clone().unwrap();
    let place = memory.len() - 1 - 8 - 4;
    assert_eq!(memory[place..place + 4], 2.0_f32.to_le_bytes());
    memory[place..place + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    t.memory = Some(memory);
    t.power_cycle();
    assert_eq!(t.sent_text(), ["71E#00", "09E#0063010400000000"]);
    assert_eq!(t.read(0x2202, 0), Ok(2.0_f32.to_bits()));
}

#[test]
fn values_of_64_bits_and_real_values_are_read() {
    let mut t = booted();
    t.tilt(-12.34, 0.0);
    let slope = t.read_i16(0x6010);
    assert_ne!(slope, 0);
    let degrees = f64::from(slope) / 100.0;
    assert_eq!(t.read(0x5000, 0), Ok((degrees as f32).to_bits()));
    assert_eq!(read(&mut t, 0x5002), (degrees / 2.0).to_bits());
    assert_eq!(read(&mut t, 0x5001), -401_i64 as u64);
}

#[test]
fn process_data_have_real_numbers_and_64_bits() {
    let mut t = booted();
    t.write(0x6013, 0, 2, 1250).unwrap();
    t.hold([0, 0, plumbline::measure::ONE_G], 1);
    t.send("000#011E");
    let real = hex(&12.5_f32.to_le_bytes());
    let samples = hex(&(-2_i64).to_le_bytes());
    assert_eq!(
        t.exchange("080#"),
        [format!("19E#E204{real}"), format!("29E#{samples}")]
    );
}

pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect()
}
