use super::*;
use crate::gs_usb::tests::fake::{CANDLE_LIGHT, endpoint, interface};
use texts::Cause as _;

/// A configuration with these descriptors.
fn configuration(descriptors: &[&[u8]]) -> Vec<u8> {
    let descriptors = descriptors.concat();
    let length = (9 + descriptors.len()) as u16;
    let [low, high] = length.to_le_bytes();
    let mut bytes = vec![9, 2, low, high, 1, 1, 0, 0x80, 50];
    bytes.extend(descriptors);
    bytes
}

#[test]
fn endpoints_are_those_of_the_descriptor() {
    let expected = Layout {
        interface: 0,
        input: 0x81,
        output: 0x02,
        packet: 32,
    };
    assert_eq!(Layout::of(&CANDLE_LIGHT), Some(expected));
    let other = configuration(&[
        &interface(0, 1, 0x0A),
        &endpoint(0x83, 2, 64),
        &interface(1, 3, 0xFF),
        &endpoint(0x85, 3, 8),
        &endpoint(0x01, 2, 64),
        &endpoint(0x81, 2, 64),
    ]);
    let expected = Layout {
        interface: 1,
        input: 0x81,
        output: 0x01,
        packet: 64,
    };
    assert_eq!(Layout::of(&other), Some(expected));
}

#[test]
fn descriptor_without_bulk_endpoints_in_both_directions_is_refused() {
    let input_only = configuration(&[&interface(0, 1, 0xFF), &endpoint(0x81, 2, 64)]);
    let no_packets = configuration(&[
        &interface(0, 2, 0xFF),
        &endpoint(0x81, 2, 0),
        &endpoint(0x02, 2, 0),
    ]);
    for bytes in [&input_only, &no_packets, &Vec::new()] {
        assert_eq!(Layout::of(bytes), None, "{bytes:02X?}");
    }
    for length in 0..CANDLE_LIGHT.len() {
        assert_eq!(Layout::of(&CANDLE_LIGHT[..length]), None, "{length}");
    }
}

fn candidate(serial: &str) -> Candidate {
    Candidate {
        serial: Some(serial.to_owned()),
        interface: None,
    }
}

#[track_caller]
fn refusal(candidates: &[Candidate], serial: Option<&str>) -> String {
    let failure = choose(candidates, serial).unwrap_err();
    assert_eq!(
        (failure.code(), failure.kind().exit_code()),
        ("no-adapter", 4)
    );
    failure.to_string()
}

#[test]
fn adapter_is_selected_by_serial_number_or_if_it_is_the_only_one() {
    let two = [candidate("0031001A"), candidate("0042003B")];
    assert_eq!(choose(&two[1..], None), Ok(0));
    assert_eq!(choose(&two, Some("0042003b")), Ok(1));
    let message = refusal(&two, None);
    assert!(message.contains("usb:0031001A, usb:0042003B"), "{message}");
    let message = refusal(&two, Some("1"));
    assert!(message.contains("usb:0031001A, usb:0042003B"), "{message}");
    assert_eq!(choose(&[Candidate::default()], None), Ok(0));
    refusal(&[Candidate::default()], Some("1"));
    assert!(refusal(&[], None).contains("plug it in"));
}

#[test]
fn adapter_of_the_kernel_is_refused_with_its_interface() {
    let kernel = Candidate {
        interface: Some("can0".to_owned()),
        ..candidate("1")
    };
    assert!(refusal(&[kernel], None).contains("port can0"));
}

#[test]
fn ports_of_the_adapters_have_their_serial_numbers() {
    let kernel = Candidate {
        interface: Some("can0".to_owned()),
        ..candidate("0031001A")
    };
    let port = |port: &str, serial: Option<&str>| Port {
        port: port.to_owned(),
        serial: serial.map(str::to_owned),
    };
    assert_eq!(
        ports_of(&[kernel, candidate("0042003B"), Candidate::default()]),
        [
            port("can0", Some("0031001A")),
            port("usb:0042003B", Some("0042003B")),
            port("usb", None),
        ]
    );
    assert_eq!(ports_of(&[]), []);
}
