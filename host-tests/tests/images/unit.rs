//! The identity of a unit in the flash of the image, beside its parameters.

use crate::rig::{blank, board, part, tilt};
use bench::{Bus, BusRate, Flash};
use host_tests::store_file;
use plumbline::can::{BitRate, Frame, standard};
use plumbline::model::catalog::find;
use plumbline::store::{Name, Unit};
use plumbline::time::{after, millis};

/// The memory that `plumbline identity --store` writes.
fn memory(product: &str, unit: &Unit) -> Flash {
    let name = format!("image-{}-{product}-{:?}.bin", std::process::id(), board());
    let path = std::env::temp_dir().join(name);
    let geometry = blank().geometry();
    std::fs::write(&path, vec![0xFF; geometry.size()]).unwrap();
    store_file::identify(find(product).unwrap(), unit, &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    Flash::with_content(geometry, bytes)
}

/// The frames of a sensor with this identity: those that it sends by itself within `wait`, then the answers to requests.
fn frames(product: &'static str, unit: &Unit, wait: u32, requests: &[(u16, &[u8])]) -> Vec<String> {
    let mut bus = Bus::new(BusRate::Fixed(BitRate::K125));
    let motion = tilt(product, 0.0, 0.0);
    let flash = memory(product, unit);
    bus.attach(part(product, 1, flash, motion));
    let master = bus.adapter();
    bus.open(master, None, false);
    bus.run_until(after(bus.now(), millis(wait)));
    for (id, bytes) in requests {
        let frame = Frame::data(standard(*id), bytes).unwrap();
        bus.send(master, frame);
        bus.run_until(after(bus.now(), millis(10)));
    }
    let frames = bus.take_received(master).into_iter();
    frames.map(|(_, frame)| format!("{frame:?}")).collect()
}

#[test]
pub fn image_has_the_identity_in_its_flash() {
    let unit = Unit {
        vendor: Some(0x195),
        serial: Some(0x00A1_B2C3),
        name: Name::new("Old"),
        ..Unit::NONE
    };
    let read = |sub: u8| [0x40, 0x18, 0x10, sub, 0, 0, 0, 0];
    let requests = [
        (0x60A, &read(1)[..]),
        (0x60A, &read(2)),
        (0x60A, &read(4)),
        (0x60A, &[0x40, 0x08, 0x10, 0, 0, 0, 0, 0]),
    ];
    let expected = [
        "70A#00",
        "58A#4318100195010000",
        "58A#4318100201000000",
        "58A#43181004C3B2A100",
        "58A#470810004F6C6400",
    ];
    assert_eq!(frames("jn2101", &unit, 200, &requests), expected);
    let check = "5FF#009501C3B2A100";
    assert_eq!(frames("tiltix080", &unit, 2500, &[]), [check, check]);
}
