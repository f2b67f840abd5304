//! `doctor --active`: diagnostic data of a sensor with the firmware of this project, and a single request to an original.

use super::rig::Rig;
use bench::BusRate;
use plumbline::can::{BitRate, Frame, standard};
use serde_json::{Value, json};

/// The products with the rate at which they are examined: one of each protocol.
const PRODUCTS: [(&str, BitRate, u32); 3] = [
    ("is2", BitRate::K250, 250),
    ("jn2101", BitRate::K125, 125),
    ("tiltix080", BitRate::K125, 125),
];

/// The second start of a sensor, 61 s long.
fn used(product: &str, rate: BitRate) -> Rig {
    let mut rig = Rig::new(BusRate::Fixed(rate));
    rig.attach(product, 1);
    rig.run(11_000);
    rig.power_cycle(rig.first());
    rig.run(61_000);
    rig
}

fn document(rig: &mut Rig, rate: u32) -> Value {
    rig.json(&format!("--rate {rate} doctor --seconds 1 --active"))
}

#[test]
fn usage_of_a_sensor_is_in_the_document_and_in_lines() {
    for (product, rate, number) in PRODUCTS {
        let mut rig = used(product, rate);
        let document = document(&mut rig, number);
        let usage = &document["usage"][0];
        assert_eq!(usage["sensor"], document["sensors"][0], "{document}");
        let expected = json!({
            "reset": ["power-on"], "starts": 2, "minutes": 1, "saves": 0, "erases": 0, "calibrated": false,
            "overruns": 0, "passive": 0, "bus_off": 0,
        });
        for (key, value) in expected.as_object().expect("an object") {
            assert_eq!(&usage[key], value, "{product}, {key}: {usage}");
        }
        let number_of = |key: &str| usage[key].as_f64().expect("a number");
        assert!(number_of("coldest") <= number_of("warmest"), "{usage}");
        assert!((0.9..1.1).contains(&number_of("shock")), "{usage}");
        let ended = rig.tool(&format!("--rate {number} doctor --seconds 1 --active"));
        for part in [
            "    last reset: power-on",
            "    2 starts, 0.0 h in operation",
            " degC\n",
            "    until this start 0 saves and 0 erases of the memory",
            "    not calibrated",
            "received frames lost 0 times, error passive 0 times, bus-off 0 times",
        ] {
            assert!(ended.out.contains(part), "{product}, {part}: {ended:?}");
        }
    }
}

/// The IMS360 answers as its original.
#[test]
fn sensor_without_usage_gets_one_request_and_has_no_line() {
    let mut rig = used("ims360", BitRate::K125);
    rig.witnessed();
    let document = document(&mut rig, 125);
    assert_eq!(document["usage"], json!([]), "{document}");
    assert!(document["sensors"][0].is_string(), "{document}");
    assert_eq!(document["findings"], json!([]), "{document}");
    let asked = |frame: &Frame| frame.bytes().starts_with(&[0x40, 0x00, 0x5F]);
    let asked = rig.witnessed().into_iter().filter(asked).count();
    assert_eq!(asked, 1);
}

/// An IS2 of GEMAC answers an unknown code with CmdParamError, which stays in its status until that is read.
#[test]
fn original_of_gemac_is_asked_once_and_its_status_is_read() {
    let mut rig = used("is2", BitRate::K250);
    let original = |frame: Frame| match frame.bytes() {
        [0x61, ..] => Frame::data(standard(0x301), &[0x61, 0x08]).expect("a frame"),
        _ => frame,
    };
    rig.altered = Some((rig.later(0), rig.later(600_000), original));
    rig.witnessed();
    let document = document(&mut rig, 250);
    assert_eq!(document["usage"], json!([]), "{document}");
    assert_eq!(document["findings"], json!([]), "{document}");
    let requests = rig.witnessed().into_iter();
    let requests: Vec<_> = requests
        .filter(|frame| frame.id() == standard(0x300))
        .map(|frame| frame.bytes().to_vec())
        .collect();
    assert_eq!(requests.iter().filter(|bytes| bytes[0] == 0x61).count(), 1);
    let place = requests.iter().position(|bytes| bytes[0] == 0x61);
    assert_eq!(requests[place.expect("the request") + 1], [0x02]);
}

/// A TILTIX of POSITAL answers an unknown class with error 16h, object does not exist.
#[test]
fn original_of_posital_is_asked_once() {
    let mut rig = used("tiltix080", BitRate::K125);
    let original = |frame: Frame| match *frame.bytes() {
        [master, 0x8E, _, _, _, _] => {
            Frame::data(frame.id(), &[master, 0x94, 0x16, 0xFF]).expect("a frame")
        }
        _ => frame,
    };
    rig.altered = Some((rig.later(0), rig.later(600_000), original));
    rig.witnessed();
    let document = document(&mut rig, 125);
    assert_eq!(document["usage"], json!([]), "{document}");
    let asked = |frame: &Frame| matches!(frame.bytes(), [_, 0x0E, 0xC7, 1, _]);
    let asked = rig.witnessed().into_iter().filter(asked).count();
    assert_eq!(asked, 1);
}
