//! Nodes without an address of their own, which fastscan finds.

use super::{commission, plan, rig, sensors};
use bench::BusRate;
use plumbline::can::{BitRate, standard};
use std::fs;

#[test]
fn fastscan_that_is_stopped_leaves_no_node_in_configuration_mode() {
    const RELEASE: [u8; 8] = [4, 0, 0, 0, 0, 0, 0, 0];
    let (mut rig, ids) = rig(BusRate::Fixed(BitRate::K125), &[("ims360", 7)]);
    let text = "[[sensor]]\nname = \"one\"\nproduct = \"ims360\"\nfind = \"fastscan\"\nparameters.node-id = 61\n";
    let plan = plan(&mut rig, "stopped", text);
    let mut bus = rig.bus.borrow_mut();
    let now = bus.now();
    bus.device_mut(ids[0]).power_on(now);
    drop(bus);
    rig.run(2000);
    rig.stop = Some(60);
    rig.witnessed();
    let ended = commission(&mut rig, &plan, "");
    assert_ne!(ended.code, 0, "{ended:?}");
    let seen = rig.witnessed().into_iter();
    let mut masters = seen.filter(|frame| frame.can_id() == standard(0x7E5).into());
    let last = masters.next_back().expect("a request of fastscan");
    assert!(masters.count() > 3, "{ended:?}");
    assert_eq!(last.bytes(), RELEASE);
}

#[test]
fn fastscan_finds_equal_sensors_that_are_on_together() {
    let devices = [("ims360", 7), ("ims360", 8), ("ims360", 9)];
    let (mut rig, ids) = rig(BusRate::Fixed(BitRate::K125), &devices);
    let text = |name: &str, node: u8| {
        format!(
            "[[sensor]]\nname = \"{name}\"\nproduct = \"ims360\"\nfind = \"fastscan\"\nparameters.node-id = {node}\n"
        )
    };
    let first = text("one", 61);
    let plan = plan(&mut rig, "fastscan", &first);
    for id in &ids {
        let mut bus = rig.bus.borrow_mut();
        let now = bus.now();
        bus.device_mut(*id).power_on(now);
    }
    // The adapter fails after fastscan, and at other places before and after it.
    for cut in [20, 150, 160, 170] {
        rig.cut = Some(cut);
        let ended = commission(&mut rig, &plan, "");
        assert!([0, 4].contains(&ended.code), "{cut}: {ended:?}");
    }
    rig.cut = None;
    assert_eq!(sensors(&commission(&mut rig, &plan, "--json")).len(), 1);
    // The two others come later, beside the first one.
    let all = format!("{first}{}{}", text("two", 62), text("three", 63));
    fs::write(&plan, all).expect("a file");
    let ended = commission(&mut rig, &plan, "--json");
    let rows = sensors(&ended);
    assert_eq!(rows.len(), 3, "{rows:?}");
    for (row, node) in rows.iter().zip(61..) {
        assert!(
            row.ends_with(&format!(" node-ID {node} 125 kbit/s")),
            "{rows:?}"
        );
    }
    for id in &ids {
        rig.bus.borrow_mut().power_cycle(*id);
    }
    rig.run(1000);
    let mut serials = Vec::new();
    for node in 61..64 {
        let own = rig.json(&format!(
            "--rate 125 --node {node} get identity-object-serial-number"
        ));
        serials.push(own["identity-object-serial-number"]["value"].as_u64());
    }
    serials.sort();
    assert_eq!(serials, [Some(7), Some(8), Some(9)]);
}
