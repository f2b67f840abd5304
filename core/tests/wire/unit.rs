//! The identity of a unit, in place of that of its product: each protocol answers with what is given, and with its own of the rest.

use crate::tester::devicenet::{LevelTester, MAC_3, power_up};
use crate::tester::fsc::{DELIVERED, FscTester};
use crate::tester::j1939::{NAME, claimed};
use crate::tester::{Tester, canopen, fsc, ims360};
use plumbline::can::{Frame, standard};
use plumbline::model::gemac::is2::{self, TwoAxes};
use plumbline::node::Node;
use plumbline::store::{Name, Unit};

/// The identity of the sensor that was replaced.
const OLD: Unit = Unit {
    vendor: Some(0x0000_0195),
    device_type: Some(0x22),
    product_code: Some(0x1234),
    revision: Some(0x0305),
    serial: Some(0x00A1_B2C3),
    article: Some(2_302_220),
    name: Some(Name::constant("Old sensor of the crane, 2 axes!")),
    hardware: Some(Name::constant("7.1.2")),
    software: Some(Name::constant("12.3456")),
};

/// The node after power-up with this identity.
fn powered_with<N: Node>(unit: Unit, mut tester: Tester<N>) -> Tester<N> {
    tester.sent();
    tester.unit = unit;
    tester.power_cycle();
    tester
}

#[test]
fn jn2101_answers_with_the_identity_of_the_unit() {
    let mut t = powered_with(OLD, canopen::power_up());
    assert_eq!(t.sent_text(), ["70A#00"]);
    for (sub, number) in (1..).zip([0x195, 0x1234, 0x305, 0x00A1_B2C3]) {
        assert_eq!(t.read(0x1018, sub), Ok(number), "1018h:{sub:02}");
    }
    assert_eq!(t.read_text(0x1008), "Old sensor of the crane, 2 axes!");
    assert_eq!(t.read_text(0x1009), "7.1.2");
    assert_eq!(t.read_text(0x100A), "12.3456");
    // Everything else is that of the product.
    assert_eq!(t.read(0x1018, 0), Ok(4));
    assert_eq!(t.read(0x1000, 0), Ok(0x0004_019A));
    assert_eq!(t.read_text(0x3000), "D0UfZEgRKHAI5Ag=");
}

#[test]
fn what_the_unit_does_not_give_is_that_of_the_product() {
    let partial = Unit {
        product_code: Some(9),
        hardware: Some(Name::constant("2.0.0")),
        ..Unit::NONE
    };
    let mut t = powered_with(partial, canopen::power_up());
    assert_eq!(t.sent_text(), ["70A#00"]);
    for (sub, number) in (1..).zip([0x6D66_6900, 9, 0xAA, 0x0403_0201]) {
        assert_eq!(t.read(0x1018, sub), Ok(number), "1018h:{sub:02}");
    }
    assert_eq!(t.read_text(0x1008), "JN2101");
    assert_eq!(t.read_text(0x1009), "2.0.0");
    assert_eq!(t.read_text(0x100A), "2.2.0");
}

#[test]
fn ims360_has_the_serial_number_of_the_unit_in_all_its_objects() {
    let mut t = powered_with(OLD, ims360::booted());
    assert_eq!(t.sent_text(), ["732#00"]);
    assert_eq!(t.read(0x1018, 4), Ok(0x00A1_B2C3));
    assert_eq!(t.read_text_at(0x2000, 1), 0x00A1_B2C3.to_string());
    // 21 bits.
    assert_eq!(t.read(0x2106, 9), Ok(0x0001_B2C3));
}

#[test]
fn lss_finds_the_unit_by_its_identity_and_not_by_that_of_the_product() {
    let mut t = powered_with(OLD, ims360::booted());
    assert_eq!(t.sent_text(), ["732#00"]);
    t.send("7E5#0401000000000000");
    for (request, answer) in [
        ("5A", "7E4#5A95010000000000"),
        ("5B", "7E4#5B34120000000000"),
        ("5C", "7E4#5C05030000000000"),
        ("5D", "7E4#5DC3B2A100000000"),
    ] {
        assert_eq!(
            t.exchange(&format!("7E5#{request}00000000000000")),
            [answer]
        );
    }
    t.send("7E5#0400000000000000");
    let mut select = |numbers: [u32; 4]| {
        let mut sent = Vec::new();
        for (command, number) in (0x40..).zip(numbers) {
            let [a, b, c, d] = number.to_le_bytes();
            sent = t.exchange(&format!(
                "7E5#{command:02X}{a:02X}{b:02X}{c:02X}{d:02X}000000"
            ));
        }
        sent
    };
    assert_eq!(select([0x195, 0x1234, 0x305, 0x0403_0201]), [""; 0]);
    let selected = select([0x195, 0x1234, 0x305, 0x00A1_B2C3]);
    assert_eq!(selected, ["7E4#4400000000000000"]);
}

#[test]
fn j1939_identifies_itself_with_name_version_and_serial_number_of_the_unit() {
    let mut t = powered_with(OLD, claimed());
    // Of the NAME only the identity number is another one.
    let claim = format!("18EEFF80#C3B2E1{}", &NAME[6..]);
    assert_eq!(t.sent_text(), [claim]);
    t.wait(250);
    let mut message = |pgn: &str| {
        let start = t.request_group("FF", pgn);
        let mut packets: Vec<String> = start;
        packets.extend(t.wait_text(900).into_iter().map(|(_, text)| text));
        let data = |text: &String| {
            let data = text.strip_prefix("1CEBFF80#")?;
            Some(
                (1..8)
                    .map(|at| u8::from_str_radix(&data[2 * at..2 * at + 2], 16).unwrap())
                    .collect::<Vec<u8>>(),
            )
        };
        let bytes: Vec<u8> = packets.iter().filter_map(data).flatten().collect();
        String::from_utf8(bytes.into_iter().take_while(|byte| *byte != 0xFF).collect()).unwrap()
    };
    let serial = 0x00A1_B2C3;
    let name = "Old sensor of the crane, 2 axes!";
    assert_eq!(message("EBFE00"), format!("Plumbline*{name}*{serial}**"));
    assert_eq!(
        message("C5FD00"),
        format!("{name}*{serial}**Inclinometer*Plumbline*")
    );
    assert_eq!(message("DAFE00"), "\u{1}12.3456*");
}

#[test]
fn j1939_fills_the_frame_of_a_short_version_and_takes_no_text_with_a_separator() {
    let short = Unit {
        name: Some(Name::constant("A*B")),
        software: Some(Name::constant("1.2")),
        ..Unit::NONE
    };
    let mut t = powered_with(short, claimed());
    t.wait(250);
    t.sent();
    let version = t.request_group("FF", "DAFE00");
    assert_eq!(version, ["18FEDA80#01312E322AFFFFFF"]);
    // 26 bytes, with the name of the product.
    let announced = t.request_group("FF", "EBFE00");
    assert_eq!(announced, ["1CECFF80#201B0004FFEBFE00"]);
}

/// A DeviceNet node with this identity, on-line at the MAC ID 3, with an explicit connection.
fn allocated(unit: Unit) -> LevelTester {
    let mut t = powered_with(unit, power_up(Some(MAC_3)));
    t.wait(2001);
    t.sent();
    t.allocate(1);
    t
}

#[test]
fn devicenet_identity_object_and_duplicate_mac_check_have_the_identity_of_the_unit() {
    let mut t = powered_with(OLD, power_up(Some(MAC_3)));
    let request = "41F#009501C3B2A100";
    assert_eq!(
        t.wait_text(2001)
            .iter()
            .filter(|(_, text)| text == request)
            .count(),
        2
    );
    // Another node asks for the MAC ID of the unit.
    assert_eq!(t.exchange("41F#00620101020304"), ["41F#809501C3B2A100"]);
    t.allocate(1);
    for (attribute, response) in [
        (1, "8E9501"),
        (2, "8E2200"),
        (3, "8E3412"),
        (4, "8E0305"),
        (6, "8EC3B2A100"),
    ] {
        assert_eq!(t.explicit(&format!("0E0101{attribute:02X}")), response);
    }
    // The first fragment of 32 characters.
    assert_eq!(t.exchange("41C#0A0E010107"), ["41B#8A008E204F6C6420"]);
}

#[test]
fn devicenet_number_that_does_not_fit_its_attribute_is_that_of_the_product() {
    for (vendor, product_code, revision) in [
        (0, 0, 0),
        (0x1_0162, 0x1_0001, 0x1_0102),
        (0, 0, 0x8001),
        (0, 0, 0x0100),
    ] {
        let mut t = allocated(Unit {
            vendor: Some(vendor),
            product_code: Some(product_code),
            revision: Some(revision),
            ..Unit::NONE
        });
        for (attribute, response) in [(1, "8E6201"), (3, "8E0700"), (4, "8E0102")] {
            assert_eq!(t.explicit(&format!("0E0101{attribute:02X}")), response);
        }
    }
}

#[test]
fn devicenet_name_that_fits_into_a_frame_is_not_fragmented() {
    let mut t = allocated(Unit {
        name: Some(Name::constant("IS2D")),
        ..Unit::NONE
    });
    assert_eq!(t.explicit("0E010107"), "8E0449533244");
}

#[test]
fn gemac_sensor_answers_03h_and_04h_with_the_identity_of_the_unit() {
    for (unit, number, revision, serial) in [
        (OLD, 2_302_220_u32, 0x305_u16, 0x00A1_B2C3_u32),
        (Unit::NONE, 2_305_430, 1, 0x0403_0201),
    ] {
        let mut t: FscTester<TwoAxes> = powered_with(unit, fsc::power_up(&is2::BP_CL));
        t.wait(60);
        t.receive(Frame::data(standard(0x7FF), &[]).unwrap());
        t.sent();
        let reply = [
            &[0x03, DELIVERED],
            &number.to_le_bytes()[..],
            &revision.to_le_bytes(),
        ]
        .concat();
        assert_eq!(t.ask(&[0x03]), reply);
        let reply = [&[0x04, DELIVERED], &serial.to_le_bytes()[..], &[0x44, 0x03]].concat();
        assert_eq!(t.ask(&[0x04]), reply);
    }
}
