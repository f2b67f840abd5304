//! `decode` with the data sheet (EDS) of a CANopen device that is not in the catalogue.

use super::decode::log;
use super::rig::{Rig, file};
use std::path::PathBuf;

/// The data sheet of an encoder whose TPDO 1 has its position and speed.
fn encoder(name: &str) -> PathBuf {
    let object = |place: &str, what: &str| format!("\n[{place}]\nParameterName={what}\n");
    let number = |place: &str, kind: u8, default: &str| {
        let name = object(place, place);
        format!(
            "{name}ObjectType=0x7\nDataType={kind}\nAccessType=rw\nDefaultValue={default}\nPDOMapping=0\n"
        )
    };
    let text = [
        include_str!("../process/encoder.eds").to_owned(),
        object("1800", "TPDO 1"),
        "ObjectType=0x9\nSubNumber=1\n".to_owned(),
        number("1800sub1", 7, "$NODEID+0x180"),
        object("1A00", "Mapping of TPDO 1"),
        "ObjectType=0x9\nSubNumber=2\n".to_owned(),
        number("1A00sub0", 5, "1"),
        number("1A00sub1", 7, "0x60040020"),
    ];
    let path = file(&format!("{name}.eds"));
    std::fs::write(&path, text.concat()).unwrap();
    path
}

#[test]
fn data_sheet_names_the_objects_of_nodes_that_tell_no_other_identity() {
    let eds = encoder("decode");
    let frames = [
        // The position is 1000, and not the angles of a JN2101.
        "18C#E8030000",
        "60C#4004600000000000",
        "58C#43046000E8030000",
        // Another device than that of the data sheet.
        "60D#4018100100000000",
        "58D#4318100199000000",
        "60D#4004600000000000",
        "18D#E8030000",
        // Products of the catalogue, in CANopen and in the other protocols.
        "60A#4018100100000000",
        "58A#431810010069666D",
        "70A#05",
        "18A#E803F401",
        "301#FF03000300004403",
        "301#FF03000300004403",
        "301#0002E803F4010100",
        "18EAFFFE#00EE00",
    ];
    let path = log("decode-eds", frames.map(can_wire::text::frame));
    let mut rig = Rig::with("is2");
    let text = rig.done(&format!(
        "--eds {} decode {}",
        eds.display(),
        path.display()
    ));
    let lines = text
        .lines()
        .map(|line| line.split_once("  ").map_or("-", |(_, text)| text));
    let expected = [
        "canopen 12 encoder: TPDO 1, position-value = 1000",
        "canopen 12 encoder: SDO read 6004h:0 position-value",
        "canopen 12 encoder: SDO answer 6004h:0 position-value, position-value = 1000",
        "canopen 13: SDO read 1018h:1 vendor-id",
        "canopen 13: SDO answer 1018h:1 vendor-id, value = 00000099h",
        "canopen 13: SDO read 6004h:0",
        "-",
        "canopen 10 jn2101: SDO read 1018h:1 vendor-id",
        "canopen 10 jn2101: SDO answer 1018h:1 vendor-id, value = 6D666900h",
        "canopen 10 jn2101: heartbeat, operational",
        "canopen 10 jn2101: TPDO 1, slope-long16 = 10.00 deg, slope-lateral16 = 5.00 deg",
        "fsc 300h: boot-up",
        "fsc 300h: boot-up",
        "fsc 300h: reply Inclination (00h)",
        "j1939 254: request",
    ];
    for (line, start) in lines.zip(expected) {
        assert!(line.starts_with(start), "{start}: {text}");
    }
    assert_eq!(text.lines().count(), expected.len());
}

/// The vendor of the data sheet is that of a product of the catalogue.
#[test]
fn product_code_decides_between_data_sheet_and_catalogue() {
    let eds = encoder("decode-vendor");
    let text = std::fs::read_to_string(&eds).unwrap();
    std::fs::write(
        &eds,
        text.replace("VendorNumber=0x000003FF", "VendorNumber=0x6D666900"),
    )
    .unwrap();
    let jn2101 = "58B#43181002";
    let mut rig = Rig::with("jn2101");
    rig.rate = Some("125");
    let answer = rig.done("--node 10 raw 1018:2");
    let code = answer.trim().replace(' ', "");
    let frames = [
        "58C#431810010069666D".to_owned(),
        "58C#4318100206040000".to_owned(),
        "18C#E8030000".to_owned(),
        "58B#431810010069666D".to_owned(),
        format!("{jn2101}{code}"),
        "70B#05".to_owned(),
        "18B#E803F401".to_owned(),
    ];
    let path = log(
        "decode-vendor",
        frames.iter().map(|text| can_wire::text::frame(text)),
    );
    let text = rig.done(&format!(
        "--eds {} decode {}",
        eds.display(),
        path.display()
    ));
    let lines: Vec<&str> = text.lines().collect();
    assert!(
        lines[2].ends_with("canopen 12 encoder: TPDO 1, position-value = 1000"),
        "{text}"
    );
    assert!(
        lines[6].contains("canopen 11 jn2101: TPDO 1, slope-long16"),
        "{text}"
    );
}
