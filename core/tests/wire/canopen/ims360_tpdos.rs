//! The four TPDOs of the IMS360 and block transfer of its objects (manual, 6.1; S10, S48, S50 to S52, S74 of the product's README).

use super::ims360_dictionary::OBJECTS;
use crate::tester::canopen::frame;
use crate::tester::dictionary::Access;
use crate::tester::ims360::{Ims360Tester, booted};
use crc::{CRC_16_XMODEM, Crc};

/// The objects that can be mapped, and their lengths in bits: table 7, and the four that only their pages mark.
#[rustfmt::skip]
const MAPPABLE: &[(u16, u8, u32)] = &[
    (0x3000, 1, 8), (0x3010, 1, 16), (0x3010, 2, 16), (0x3010, 3, 16), (0x3011, 0, 32), (0x3012, 0, 32), (0x3013, 0, 32),
    (0x3020, 1, 16), (0x3020, 2, 16), (0x3020, 3, 16), (0x3021, 0, 32), (0x3022, 0, 32), (0x3023, 0, 32),
    (0x3100, 1, 8), (0x3110, 2, 8), (0x3112, 1, 8), (0x3112, 4, 8), (0x6110, 0, 32), (0x6120, 0, 32), (0x6511, 0, 8),
];

const LONGITUDINAL: u32 = 0x6110_0020;

fn entry(index: u16, sub: u8, bits: u32) -> u32 {
    u32::from(index) << 16 | u32::from(sub) << 8 | bits
}

/// A sensor with another value in each measured object.
fn moving() -> Ims360Tester {
    let mut t = booted();
    t.rate = [655_360, -1_310_720, 1_966_080];
    t.temperature = 31_00;
    t.settle_at([0.5, -0.3, 0.81]);
    t
}

#[test]
fn each_mappable_object_is_sent_as_sdo_reads_it() {
    let mut t = moving();
    t.write(0x1801, 2, 1, 253).unwrap();
    t.send("000#0132");
    for &(index, sub, bits) in MAPPABLE {
        t.map(1, &[entry(index, sub, bits)]);
        let value = t.read(index, sub).unwrap().to_le_bytes();
        let expected: String = value[..bits as usize / 8]
            .iter()
            .map(|byte| format!("{byte:02X}"))
            .collect();
        let sent = t.exchange("2B2#R8");
        assert_eq!(sent, [format!("2B2#{expected}")], "{index:04X}h:{sub:02X}");
    }
}

/// 6.1.3 prints the four data bytes of each frame. The number of objects is UNSIGNED8 (7.2.18), the event timer UNSIGNED16 (7.2.14).
#[test]
fn printed_steps_without_an_indicated_size_map_the_angular_rates() {
    let mut t = moving();
    for step in [
        "011801B2010080",
        "011A0000000000",
        "011A0110012030",
        "011A0210022030",
        "011A0310032030",
        "011A0003000000",
        "011801B2010000",
        "01180564000000",
    ] {
        let written = t.sdo(&format!("22{step}"));
        assert_eq!(written, format!("60{}00000000", &step[..6]));
    }
    t.send("000#0132");
    let rates: String = [1, 2, 3]
        .map(|sub| (t.read(0x3020, sub).unwrap() as u16).to_le_bytes())
        .concat()
        .iter()
        .map(|byte| format!("{byte:02X}"))
        .collect();
    assert_eq!(t.wait_text(100), [(100, format!("1B2#{rates}"))]);
    // With four indicated bytes, the length is wrong (CiA 301).
    for step in ["011A0003000000", "01180564000000"] {
        let refused = t.sdo(&format!("23{step}"));
        assert_eq!(refused, format!("80{}12000706", &step[..6]));
    }
    assert_eq!((t.read(0x1A01, 0), t.read(0x1801, 5)), (Ok(3), Ok(100)));
}

#[test]
fn no_other_object_of_the_dictionary_can_be_mapped() {
    let mut t = booted();
    for &(index, sub, size, ..) in OBJECTS {
        let bits = u32::from(size.max(1)) * 8;
        if !MAPPABLE.contains(&(index, sub, bits)) {
            let written = t.write(0x1A01, 1, 4, entry(index, sub, bits));
            assert_eq!(written, Err(0x0604_0041), "{index:04X}h:{sub:02X}");
        }
    }
}

#[test]
fn each_tpdo_has_all_triggers() {
    let mut t = booted();
    t.tilt(12.34, -5.67);
    let lateral = t.read(0x6120, 0).unwrap().to_le_bytes();
    let lateral: String = lateral.map(|byte| format!("{byte:02X}")).concat();
    let longitudinal = t.read(0x6110, 0).unwrap().to_le_bytes();
    let longitudinal: String = longitudinal.map(|byte| format!("{byte:02X}")).concat();
    t.send("000#0132");
    assert_eq!(t.wait_text(300), [], "type 254 with an event timer of 0");
    for number in 1..4 {
        t.map(number, &[LONGITUDINAL]);
    }
    for number in 0..4 {
        let id = 0x1B2 + 0x100 * number;
        let data = format!("{longitudinal}{}", if number == 0 { &lateral } else { "" });
        let (tpdo, request) = (format!("{id:03X}#{data}"), format!("{id:03X}#R8"));
        let index = 0x1800 + number;
        for n in [1, 3, 240] {
            t.write(index, 2, 1, n).unwrap();
            for count in 1..=2 * n {
                let expected: &[&str] = if count % n == 0 { &[&tpdo] } else { &[] };
                assert_eq!(t.exchange("080#"), expected, "{count} of {n}");
            }
        }
        for kind in [252, 253] {
            t.write(index, 2, 1, kind).unwrap();
            assert_eq!(t.exchange("080#"), [""; 0], "{kind}");
            assert_eq!(t.exchange(&request), [tpdo.as_str()], "{kind}");
        }
        t.write(index, 1, 4, 0x4000_0000 | u32::from(id)).unwrap();
        assert_eq!(t.exchange(&request), [""; 0], "bit 30");
        t.write(index, 2, 1, 254).unwrap();
        t.write(index, 5, 2, 50).unwrap();
        let expected = [50, 100, 150].map(|at| (at, tpdo.clone()));
        assert_eq!(t.wait_text(150), expected);
        // 100 ms, in units of 100 us.
        t.write(index, 3, 2, 1000).unwrap();
        let times: Vec<_> = t.wait_text(400).into_iter().map(|(at, _)| at).collect();
        let steps: Vec<_> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(
            steps.len() >= 2 && steps.iter().all(|step| *step == 100),
            "{times:?}"
        );
        t.write(index, 5, 2, 0).unwrap();
        t.wait_text(200);
        assert_eq!(t.wait_text(300), [], "timer off");
        t.write(index, 3, 2, 0).unwrap();
        t.write(index, 2, 1, 253).unwrap();
    }
}

#[test]
fn wrong_step_of_the_mapping_is_refused_in_each_state() {
    for state in ["000#8032", "000#0132"] {
        let mut t = booted();
        t.send(state);
        for (sub, size, value) in [
            (0, 1, 0),
            (0, 1, 1),
            (1, 4, 0x6120_0020),
            (3, 4, LONGITUDINAL),
        ] {
            assert_eq!(t.write(0x1A00, sub, size, value), Err(0x0601_0000), "valid");
        }
        for (sub, size, value) in [(0, 1, 2), (1, 4, LONGITUDINAL), (8, 4, 0)] {
            assert_eq!(t.write(0x1A00, sub, size, value), Ok(()), "as it is");
        }
        t.write(0x1800, 1, 4, 0x8000_01B2).unwrap();
        assert_eq!(t.write(0x1A00, 1, 4, 0x6120_0020), Err(0x0601_0000));
        t.write(0x1A00, 0, 1, 0).unwrap();
        // 5h is a dummy object.
        for (value, code) in [
            (0x6010_0010, 0x0602_0000),
            (0x0005_0008, 0x0602_0000),
            (0x3000_0808, 0x0609_0011),
            (0x6110_0120, 0x0609_0011),
            (0x6110_0010, 0x0604_0041),
            (0x3010_0120, 0x0604_0041),
            (0x1001_0008, 0x0604_0041),
            (0x3100_0208, 0x0604_0041),
        ] {
            assert_eq!(t.write(0x1A00, 1, 4, value), Err(code), "{value:08X}h");
            assert_eq!(t.read(0x1A00, 1), Ok(LONGITUDINAL));
        }
        t.write(0x1A00, 2, 4, 0).unwrap();
        assert_eq!(t.write(0x1A00, 0, 1, 2), Err(0x0604_0041), "empty entry");
        assert_eq!(t.write(0x1A00, 0, 1, 9), Err(0x0604_0042), "too many");
        for sub in [2, 3] {
            t.write(0x1A00, sub, 4, LONGITUDINAL).unwrap();
        }
        assert_eq!(t.write(0x1A00, 0, 1, 3), Err(0x0604_0042), "96 bits");
        assert_eq!(t.read(0x1A00, 0), Ok(0));
        assert_eq!(t.write(0x1A00, 0, 1, 2), Ok(()), "64 bits");
        assert_eq!(t.write(0x1800, 1, 4, 0x1B2), Ok(()));
    }
}

/// Reads an object by block upload: size, segments, CRC.
fn upload(t: &mut Ims360Tester, index: u16, sub: u8) -> Vec<u8> {
    let [low, high] = index.to_le_bytes();
    let reply = t.sdo(&format!("A4{low:02X}{high:02X}{sub:02X}7F000000"));
    assert_eq!(
        reply[..8],
        format!("C6{low:02X}{high:02X}{sub:02X}"),
        "{reply}"
    );
    let length = usize::from_str_radix(&reply[8..10], 16).unwrap();
    let sent = t.exchange("632#A300000000000000");
    let segments = length.div_ceil(7);
    assert_eq!(sent.len(), segments, "{sent:?}");
    let mut value = Vec::new();
    for (place, text) in sent.iter().enumerate() {
        let segment = frame(text);
        let (&number, data) = segment.bytes().split_first().unwrap();
        let last = if place + 1 == segments { 0x80 } else { 0 };
        assert_eq!(usize::from(number), (place + 1) | last);
        value.extend_from_slice(data);
    }
    value.truncate(length);
    let unused = (7 * segments - length) as u8;
    let [a, b] = Crc::<u16>::new(&CRC_16_XMODEM)
        .checksum(&value)
        .to_le_bytes();
    let end = t.sdo(&format!("A2{segments:02X}7F0000000000"));
    let expected = format!("{:02X}{a:02X}{b:02X}0000000000", 0xC1 | unused << 2);
    assert_eq!(end, expected);
    assert_eq!(t.exchange("632#A100000000000000"), [""; 0]);
    value
}

#[test]
fn each_object_is_read_in_a_block_as_otherwise() {
    let mut t = moving();
    for &(index, sub, size, access, _) in OBJECTS {
        let name = format!("{index:04X}h:{sub:02X}");
        let [low, high] = index.to_le_bytes();
        if access == Access::Wo {
            let refused = t.sdo(&format!("A4{low:02X}{high:02X}{sub:02X}7F000000"));
            let code = "01000106";
            assert_eq!(refused, format!("80{low:02X}{high:02X}{sub:02X}{code}"));
        } else if size == 0 {
            let text = match index {
                0x1009 => "01".to_string(),
                _ => t.read_text_at(index, sub),
            };
            assert_eq!(upload(&mut t, index, sub), text.as_bytes(), "{name}");
        } else {
            let value = t.read(index, sub).unwrap().to_le_bytes();
            let expected = &value[..usize::from(size)];
            assert_eq!(upload(&mut t, index, sub), expected, "{name}");
        }
    }
}

#[test]
fn setting_is_written_in_a_block_and_refused_values_are_aborted() {
    let mut t = booted();
    let writes: [(u16, u8, u8, u32, Option<&str>); 6] = [
        (0x1017, 0, 2, 500, None),
        (0x3210, 0, 4, -8_000_i32 as u32, None),
        (0x3112, 2, 1, 0xF6, None),
        (0x1A01, 1, 4, LONGITUDINAL, None),
        (0x1017, 0, 2, 5, Some("30000906")),
        (0x3112, 2, 1, 11, Some("31000906")),
    ];
    for (index, sub, size, value, code) in writes {
        let [low, high] = index.to_le_bytes();
        let before = t.read(index, sub);
        let object = format!("{low:02X}{high:02X}{sub:02X}");
        let begin = format!("C6{object}{size:02X}000000");
        assert_eq!(t.sdo(&begin), format!("A4{object}1F000000"));
        let data = value.to_le_bytes();
        let [a, b, c, d] = data;
        let segment = format!("81{a:02X}{b:02X}{c:02X}{d:02X}000000");
        assert_eq!(t.sdo(&segment), "A2011F0000000000");
        let sum = Crc::<u16>::new(&CRC_16_XMODEM).checksum(&data[..usize::from(size)]);
        let [x, y] = sum.to_le_bytes();
        let end = format!("{:02X}{x:02X}{y:02X}0000000000", 0xC1 | (7 - size) << 2);
        let reply = t.sdo(&end);
        match code {
            None => {
                assert_eq!(reply, "A100000000000000");
                assert_eq!(t.read(index, sub), Ok(value), "{index:04X}h");
            }
            Some(code) => {
                assert_eq!(reply, format!("80{object}{code}"));
                assert_eq!(t.read(index, sub), before, "{index:04X}h");
            }
        }
    }
}
