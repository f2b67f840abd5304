//! Writes that are refused or interrupted: the sensor is left as it was, or a repetition completes them.

use super::files::{file, writes};
use super::rig::Rig;
use plumbline::can::{CanId, Frame, standard};
use serde_json::{Value, json};

#[test]
fn interrupted_restore_is_complete_after_a_repetition() {
    let path = file("cut.toml");
    let mut rig = Rig::with("is2");
    rig.done("set cyclic-time=100ms filter=1Hz,butterworth zero-x=1.25deg");
    rig.done(&format!("backup {}", path.display()));
    let expected = std::fs::read_to_string(&path).unwrap();
    let repeated = file("cut-repeated.toml");
    let restore = format!("--id 300 restore {}", path.display());
    for cut in 1.. {
        let mut rig = Rig::with("is2");
        rig.cut = Some(cut);
        let ended = rig.tool(&restore);
        if ended.code == 0 {
            assert!(cut > 10, "{cut}");
            break;
        }
        assert_eq!(ended.code, 4, "{cut} {ended:?}");
        rig.cut = None;
        rig.done(&restore);
        let id = rig.first();
        rig.power_cycle(id);
        rig.done(&format!("--id 300 backup {}", repeated.display()));
        assert_eq!(
            std::fs::read_to_string(&repeated).unwrap(),
            expected,
            "{cut}"
        );
    }
}

#[test]
fn tpdo_is_never_left_off_by_ctrl_c() {
    let path = file("stopped.toml");
    let mut rig = Rig::with("ims360");
    rig.done("set tpdo2-cob-id=2B2h tpdo2-mapping-entry-1=raw:1628438560 tpdo2-number-of=raw:1");
    rig.done(&format!("backup {}", path.display()));
    let restore = format!(
        "--node 50 restore {} --only tpdo2-mapping-entry-1",
        path.display()
    );
    for looks in 1.. {
        let mut rig = Rig::with("ims360");
        rig.done("--node 50 set tpdo2-cob-id=2B2h");
        rig.stop = Some(looks);
        let ended = rig.tool(&restore);
        rig.stop = None;
        let cob_id = rig.json("--node 50 get tpdo2-cob-id");
        assert_eq!(cob_id["tpdo2-cob-id"]["raw"], 0x2B2, "{looks} {ended:?}");
        if ended.code == 0 {
            assert!(looks > 5, "{looks}");
            break;
        }
        assert_eq!(ended.code, 130, "{looks} {ended:?}");
        assert!(ended.notes.contains("Ctrl-C"), "{looks} {ended:?}");
        rig.done(&restore);
    }
}

#[test]
fn emcy_identifier_is_written_also_to_an_operational_node() {
    let mut rig = Rig::with("ims360");
    // A heartbeat each 100 ms shows the state.
    rig.done("--node 50 raw 1017:0=6400");
    let master = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(master, None, false);
    let start = Frame::data(standard(0), &[1, 50]).unwrap();
    rig.bus.borrow_mut().send(master, start);
    rig.run(50);
    for id in ["0A3h", "0A4h"] {
        rig.done(&format!("--node 50 set cob-id-emcy={id}"));
        rig.witnessed();
        rig.run(500);
        let seen = rig.witnessed();
        assert_eq!(format!("{:?}", seen[0]), "732#05", "operational");
    }
    let read = rig.json("--node 50 get cob-id-emcy");
    assert_eq!(read["cob-id-emcy"]["raw"], 0xA4);
}

#[test]
fn identifiers_that_are_equal_are_refused_before_a_write() {
    let path = file("equal.toml");
    let mut rig = Rig::with("is2");
    rig.done(&format!("backup {}", path.display()));
    let good = std::fs::read_to_string(&path).unwrap();
    assert_eq!(
        rig.fails(&format!("set set-id=301h --file {}", path.display())),
        (2, "out-of-range".to_owned())
    );
    assert_eq!(std::fs::read_to_string(&path).unwrap(), good);
    let equal = good.replace("set-id = \"300h\"", "set-id = \"301h\"");
    assert_ne!(equal, good);
    std::fs::write(&path, equal).unwrap();
    for command in ["restore", "diff"] {
        let failed = rig.fails(&format!("{command} {}", path.display()));
        assert_eq!(failed, (2, "bad-file".to_owned()));
    }
    // Each file is valid, but its request identifier is the reply identifier of this sensor.
    let other = good
        .replace("set-id = \"300h\"", "set-id = \"301h\"")
        .replace("reply-id = \"301h\"", "reply-id = \"302h\"");
    std::fs::write(&path, other).unwrap();
    assert_eq!(
        rig.fails(&format!("restore {} --only set-id", path.display())),
        (2, "out-of-range".to_owned())
    );
    assert_eq!(writes(&mut rig), [""; 0]);
    rig.done(&format!("restore {}", path.display()));
}

#[test]
fn address_in_use_is_refused_before_a_write() {
    let path = file("in-use.toml");
    let mut rig = Rig::with("tiltix080");
    rig.done("set resolution=0.1deg mac-id=7");
    rig.done(&format!("--mac 7 backup {}", path.display()));
    rig.attach("tiltix080", 2);
    rig.run(4000);
    for command in [
        format!("--mac 63 restore {}", path.display()),
        "--mac 63 set resolution=0.1deg mac-id=7".to_owned(),
    ] {
        assert_eq!(rig.fails(&command), (1, "address-in-use".to_owned()));
        let read = rig.json("--mac 63 get resolution serial-number");
        assert_eq!(
            (&read["resolution"]["raw"], &read["serial-number"]["raw"]),
            (&json!(10), &json!(2))
        );
    }
    let mut rig = Rig::with("jn2101");
    rig.attach("ims360", 2);
    rig.run(500);
    assert_eq!(
        rig.fails("--node 10 set filter=10Hz node-id=50"),
        (1, "address-in-use".to_owned())
    );
}

#[test]
fn connection_of_devicenet_is_released_after_ctrl_c() {
    for looks in 1.. {
        let mut rig = Rig::with("tiltix080");
        rig.stop = Some(looks);
        let ended = rig.tool("--mac 63 get resolution serial-number");
        let requests = rig.witnessed();
        // Byte 1 of a request to the unconnected port: 4Bh allocates, 4Ch releases.
        let count = |service: u8| {
            let own = requests.iter().filter(|frame| {
                frame.can_id() == CanId::standard(0x5FE) && frame.bytes().get(1) == Some(&service)
            });
            own.count()
        };
        assert_eq!(count(0x4B), count(0x4C), "{looks} {ended:?}");
        if ended.code == 0 {
            assert!(looks > 5, "{looks}");
            break;
        }
    }
}

/// The NMT commands among frames.
fn commands(frames: &[Frame]) -> Vec<String> {
    let frames = frames.iter().map(|frame| format!("{frame:?}"));
    frames.filter(|frame| frame.starts_with("000#")).collect()
}

#[test]
fn state_of_operational_node_without_heartbeat_is_the_same_after_a_write() {
    let mut rig = Rig::with("ims360");
    let master = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(master, None, false);
    let start = Frame::data(standard(0), &[1, 50]).unwrap();
    rig.bus.borrow_mut().send(master, start);
    rig.run(50);
    rig.witnessed();
    rig.done("--node 50 set cob-id-emcy=0A3h");
    assert_eq!(commands(&rig.witnessed()), ["000#8032", "000#0132"]);
    assert_eq!(rig.done("--node 50 raw 1017:0").trim(), "00 00");
    // A node that is Pre-operational is never started.
    let stop = Frame::data(standard(0), &[128, 50]).unwrap();
    rig.bus.borrow_mut().send(master, stop);
    rig.run(50);
    rig.witnessed();
    rig.done("--node 50 set cob-id-emcy=0A4h");
    assert_eq!(commands(&rig.witnessed()), [""; 0]);
}

/// COB-ID, number and first two objects of TPDO2.
fn tpdo2(rig: &mut Rig) -> [u64; 4] {
    let names = [
        "tpdo2-cob-id",
        "tpdo2-number-of",
        "tpdo2-mapping-entry-1",
        "tpdo2-mapping-entry-2",
    ];
    let read = rig.json(&format!("--node 50 get {}", names.join(" ")));
    names.map(|name| {
        let entry = read
            .as_object()
            .unwrap()
            .iter()
            .find(|(own, _)| own.starts_with(name));
        entry.unwrap().1["raw"].as_u64().unwrap()
    })
}

#[test]
fn tpdo_has_the_old_or_the_new_mapping_or_is_off_with_a_note() {
    const OFF: u64 = 1 << 31;
    // The objects of the two entries are exchanged.
    let mapped = "--node 50 set tpdo2-cob-id=2B2h tpdo2-mapping-entry-1=raw:1628438560 tpdo2-mapping-entry-2=raw:1629487136 tpdo2-number-of=raw:2";
    let mut rig = Rig::with("ims360");
    rig.done(mapped);
    let old = tpdo2(&mut rig);
    let new = [old[0], old[1], old[3], old[2]];
    assert!(old[1] >= 2 && old[2] != old[3], "{old:X?}");
    let set = format!(
        "--node 50 set tpdo2-mapping-entry-1=raw:{} tpdo2-mapping-entry-2=raw:{}",
        new[2], new[3]
    );
    let mut places = 0;
    for is_cut in [true, false] {
        for place in 1.. {
            let mut rig = Rig::with("ims360");
            rig.done(mapped);
            match is_cut {
                true => rig.cut = Some(place),
                false => rig.stop = Some(place as u32),
            }
            let ended = rig.tool(&set);
            (rig.cut, rig.stop) = (None, None);
            let now = tpdo2(&mut rig);
            if ended.code == 0 {
                assert_eq!(now, new);
                break;
            }
            places += 1;
            let is_off = now[0] & OFF != 0;
            assert!(
                now == old || now == new || (is_cut && is_off),
                "{place} {now:X?} {ended:?}"
            );
            // A repetition says that it is off.
            let again = rig.tool(&set);
            assert_eq!(again.code, 0, "{place} {again:?}");
            assert_eq!(
                again.notes.contains("switched off"),
                is_off,
                "{place} {again:?}"
            );
        }
    }
    assert!(places > 20, "{places}");
}

#[test]
fn node_is_operational_again_after_ctrl_c() {
    for looks in 1.. {
        let mut rig = Rig::with("ims360");
        let master = rig.bus.borrow_mut().adapter();
        rig.bus.borrow_mut().open(master, None, false);
        let start = Frame::data(standard(0), &[1, 50]).unwrap();
        rig.bus.borrow_mut().send(master, start);
        rig.run(50);
        rig.witnessed();
        rig.stop = Some(looks);
        let ended = rig.tool("--node 50 set cob-id-emcy=0A3h");
        let seen = commands(&rig.witnessed());
        assert!(
            seen.is_empty() || seen == ["000#8032", "000#0132"],
            "{looks} {seen:?} {ended:?}"
        );
        if ended.code == 0 {
            assert!(looks > 5, "{looks}");
            break;
        }
        assert_eq!(ended.code, 130, "{looks} {ended:?}");
    }
}

#[test]
fn rows_before_ctrl_c_are_the_document_of_a_scan() {
    let mut counts = [0; 2];
    for looks in (1..).step_by(40) {
        let mut rig = Rig::with("is2");
        rig.stop = Some(looks);
        let ended = rig.tool("--json --rate 250 scan --active");
        let document: Value = serde_json::from_str(&ended.out).expect("one document");
        if ended.code == 0 {
            break;
        }
        assert_eq!(ended.code, 130, "{looks} {ended:?}");
        match document.as_array() {
            Some(rows) => {
                assert_eq!((rows.len(), &rows[0]["product"]), (1, &json!("is2")));
                assert!(ended.notes.contains("Ctrl-C"), "{looks} {ended:?}");
                counts[1] += 1;
            }
            None => {
                assert_eq!(document["error"]["code"], "stopped", "{looks}");
                counts[0] += 1;
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 0), "{counts:?}");
}
