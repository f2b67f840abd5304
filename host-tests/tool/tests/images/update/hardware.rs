//! Files for another board or another measuring element.

use super::{Files, line, rig};
use plumbline::can::Frame;
use plumbline::update::layout::{BLUEPILL, NUCLEO_F103RB};
use plumbline::update::{Element, Layout};

/// A product of each protocol, its address, and its request to stop the program.
const PRODUCTS: [(&str, &str, &[u8]); 3] = [
    ("jn2101", "--node 10", &[0x2F, 0x51, 0x1F, 1, 0]),
    ("is2", "--id 300", b"FLASH"),
    ("tiltix080", "--mac 63", b"BOOT"),
];

/// Files for the wrong board and the wrong element, and how their hardware is told.
const WRONG: [(Layout, Element, &str); 2] = [
    (
        NUCLEO_F103RB,
        Element::Ism330dhcx,
        "(nucleo-f103rb, ISM330DHCX)",
    ),
    (BLUEPILL, Element::Adxl355, "(bluepill, ADXL355)"),
];

/// Only identification goes over the bus.
#[test]
fn file_for_another_board_or_element_is_refused_before_the_program_stops() {
    for (product, address, stop) in PRODUCTS {
        let files = Files::new(product, &format!("hardware-{product}"));
        let mut rig = rig(product);
        rig.witnessed();
        for (board, element, told) in WRONG {
            let file = files.image_for(1, &board, element);
            let ended = rig.tool(&format!("{address} update {}", file.display()));
            assert_eq!(ended.code, 2, "{ended:?}");
            let own = "that of the sensor (bluepill, ISM330DHCX): nothing has changed";
            assert!(
                ended.notes.contains(&format!("{told} than {own}")),
                "{ended:?}"
            );
            assert!(!files.backup().exists());
        }
        let stops = |frame: &Frame| frame.bytes().windows(stop.len()).any(|part| part == stop);
        assert!(!rig.witnessed().iter().any(stops), "{product}");
    }
}

/// The reply of a program that does not tell its hardware.
fn silent_about_hardware(frame: Frame) -> Frame {
    let bytes = match frame.bytes() {
        [0x43, 0x56, 0x1F, 2, ..] => &[0x80, 0x56, 0x1F, 2, 0x11, 0, 0x09, 0x06],
        [told @ .., 1, 0] if matches!(told, [0x60, ..] | [_, 0xB2, ..]) => told,
        bytes => bytes,
    };
    Frame::data(frame.id(), bytes).unwrap_or(frame)
}

/// The bootloader refuses it before the flash changes.
#[test]
fn file_for_a_program_that_does_not_tell_its_hardware_is_left_to_the_bootloader() {
    for (product, address, _) in PRODUCTS {
        let files = Files::new(product, &format!("silent-{product}"));
        let mut rig = rig(product);
        rig.altered = Some((rig.later(0), rig.later(60_000), silent_about_hardware));
        let file = files.image_for(1, &BLUEPILL, Element::Adxl355);
        let (code, error) = rig.fails(&line(address, &file, ""));
        assert_eq!((code, &*error), (1, "wrong-image"), "{product}");
        rig.run(2500);
        let same = rig.json(&line(address, &files.same(), ""));
        assert_eq!(same["loaded"], false, "{product}");
    }
}
