//! Bad input: the error, its exit code, and that nothing is written.

use super::rig::Rig;

/// Whether a frame of the tool writes something in an FSC sensor.
fn writes(rig: &mut Rig) -> Vec<String> {
    let frames = rig.witnessed();
    let frames = frames.iter().map(|frame| format!("{frame:?}"));
    frames
        .filter(|frame| {
            frame.starts_with("300#2") || frame.starts_with("300#4") || frame.starts_with("300#5")
        })
        .collect()
}

#[test]
fn value_out_of_range_is_refused_before_anything_is_written() {
    for (assignment, code) in [
        ("cyclic-time=0", "out-of-range"),
        ("cyclic-time=65.536s", "out-of-range"),
        ("cyclic-time=99999999", "out-of-range"),
        ("cyclic-time=raw:99999999", "out-of-range"),
        ("filter=99999999,butterworth", "out-of-range"),
        ("zero-x=90.01deg", "out-of-range"),
        ("zero-x=1.255deg", "bad-value"),
        ("zero-x=1.25Hz", "bad-value"),
        ("cut-off=99mHz", "out-of-range"),
        ("cut-off=25.001Hz", "out-of-range"),
        ("cut-off=8.001Hz", "out-of-range"),
        ("filter=9Hz,critically-damped", "out-of-range"),
        ("filter=2Hz,chebyshev", "bad-value"),
        ("filter-type=3", "bad-value"),
        ("filter-type=raw:3", "out-of-range"),
        ("baud-rate=300", "bad-value"),
        ("baud-rate=10", "bad-value"),
        ("set-id=301h", "out-of-range"),
        ("set-id=800h", "bad-value"),
        ("angle-x=0", "read-only"),
        ("cyclic-time", "bad-assignment"),
        ("nonsense=1", "unknown-name"),
        ("cyclic-time=", "bad-value"),
        ("cyclic-time=99999999999999999999999999999", "out-of-range"),
    ] {
        let mut rig = Rig::with("is2");
        rig.done("get cyclic-time");
        writes(&mut rig);
        // A good value before the bad one is not written either.
        let failed = rig.fails(&format!("set cyclic-mode=on {assignment}"));
        assert_eq!(failed, (2, code.to_owned()), "{assignment}");
        assert_eq!(writes(&mut rig), [""; 0], "{assignment}");
    }
}

#[test]
fn value_out_of_range_is_named_in_the_unit_of_the_user() {
    let mut rig = Rig::with("is2");
    for (assignment, part) in [
        (
            "zero-x=999deg",
            "999.00 deg is not permitted: zero-x takes -90.00..90.00 deg",
        ),
        (
            "cyclic-time=99999999",
            "99999999 ms is not permitted: cyclic-time takes 1..65535 ms",
        ),
        (
            "filter=99999999,butterworth",
            "99999999 mHz is not permitted",
        ),
        ("angle-x=0", "`plumbline get angle-x` shows it"),
        ("tpdo1-cob-id", "is no assignment"),
        ("=1", "no parameter \"\":"),
    ] {
        let ended = rig.tool(&format!("set {assignment}"));
        assert!(ended.notes.contains(part), "{assignment} {ended:?}");
    }
    for (command, part) in [
        (
            "--node 200 get",
            "--node 200: a node-ID is 1 to 127; `plumbline scan` shows",
        ),
        (
            "--mac 64 get",
            "--mac 64: a MAC ID is 0 to 63; `plumbline scan` shows",
        ),
    ] {
        let ended = rig.tool(command);
        assert!(ended.notes.contains(part), "{command} {ended:?}");
    }
    let mut jn2101 = Rig::with("jn2101");
    for (command, part) in [
        ("set tpdo1-cob-id=18B", "write 18Bh"),
        (
            "--rate 125 --node 10 raw 1017:0=F4",
            "The object has 2 bytes: write all bytes of the object, for example F400",
        ),
        (
            "--rate 125 --node 10 raw 1017:0=F4000000",
            "The object has 2 bytes: write all bytes of the object, for example F400",
        ),
        ("node-id 200", "200 is no node-ID: choose one from 1 to 127"),
    ] {
        let ended = jn2101.tool(command);
        assert!(ended.notes.contains(part), "{command} {ended:?}");
        assert_ne!(ended.code, 0, "{command}");
    }
    let ended = rig.tool_with(&["get", "\u{1b}]0;x\u{7}"]);
    assert!(ended.notes.contains("\"\\u{1b}]0;x\\u{7}\""), "{ended:?}");
}

#[test]
fn refusal_of_the_sensor_is_exit_code_1_and_names_the_next_step() {
    let list = "`plumbline parameters` lists";
    for (product, command, step) in [
        ("jn2101", "--rate 125 --node 10 raw 2000:0=00", list),
        ("ims360", "--rate 125 --node 50 raw 3100:1=03", list),
        ("ims360", "--rate 125 --node 50 raw 7777:0", list),
        ("tiltix080", "--rate 125 --mac 63 raw 10650171FF00", list),
    ] {
        let mut rig = Rig::with(product);
        let ended = rig.tool(command);
        assert_eq!(ended.code, 1, "{ended:?}");
        assert!(ended.notes.contains("the sensor refused"), "{ended:?}");
        assert!(ended.notes.contains(step), "{ended:?}");
        assert_eq!(rig.fails(command), (1, "refused".to_owned()));
    }
}

#[test]
fn raw_request_that_a_gemac_sensor_refuses_is_exit_code_1() {
    let mut rig = Rig::with("is2");
    // A sensor that detects the bit rate does not answer the first frame.
    rig.done("--rate 250 --id 300 get");
    for (request, code) in [
        ("25F401", 0),
        ("250000", 1),
        // A read has the bits of the earlier request in its status.
        ("10", 0),
        ("15", 0),
        ("02", 0),
        ("25F401", 0),
    ] {
        let ended = rig.tool(&format!("--rate 250 --id 300 raw {request}"));
        assert_eq!(ended.code, code, "{request}: {ended:?}");
        let is_told = ended.notes.contains("the sensor refused 250000");
        assert_eq!(is_told, code == 1, "{ended:?}");
    }
}

#[test]
fn refusal_of_a_gemac_sensor_names_the_next_step() {
    // The tables of IS2 permit a value that IS1 does not have: zero point Y.
    let mut rig = Rig::with("is1");
    let ended = rig.tool("--id 300 --product is2 set zero-y=1deg");
    assert_eq!(ended.code, 1, "{ended:?}");
    assert!(ended.notes.contains("CmdParamError"), "{ended:?}");
    assert!(
        ended.notes.contains("`plumbline parameters` lists"),
        "{ended:?}"
    );
}

#[test]
fn silent_bus_is_exit_code_3() {
    let mut rig = Rig::with("is2");
    assert_eq!(
        rig.fails("--rate 250 --id 555 get"),
        (3, "no-answer".to_owned())
    );
    assert_eq!(
        rig.fails("--rate 250 --node 10 get"),
        (3, "no-answer".to_owned())
    );
    assert_eq!(
        rig.fails("--rate 250 --mac 1 get"),
        (3, "no-answer".to_owned())
    );
}

#[test]
fn wrong_product_of_command_line_is_refused() {
    let mut rig = Rig::with("is2");
    assert_eq!(
        rig.fails("--id 300 --product jn2101 get"),
        (2, "wrong-product".to_owned())
    );
    assert_eq!(
        rig.fails("--product is3 get"),
        (2, "unknown-product".to_owned())
    );
    assert_eq!(
        rig.fails("--id 300 --node 3 get"),
        (2, "too-many-addresses".to_owned())
    );
    assert_eq!(rig.fails("node-id 3"), (2, "not-offered".to_owned()));
    assert_eq!(rig.fails("mac 3"), (2, "not-offered".to_owned()));
    assert_eq!(rig.fails("raw 03Q"), (2, "bad-request".to_owned()));
}

#[test]
fn sensor_that_another_master_owns_is_not_touched() {
    let mut rig = Rig::with("tiltix080");
    let master = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(master, None, false);
    let allocate = plumbline::can::Frame::data(
        plumbline::can::standard(0x5FE),
        &[0x0A, 0x4B, 3, 1, 3, 0x0A],
    );
    rig.bus.borrow_mut().send(master, allocate.unwrap());
    rig.run(20);
    assert_eq!(
        rig.fails("--rate 125 --mac 63 raw 0E010101"),
        (1, "owned".to_owned())
    );
    let (code, _) = rig.fails("--mac 63 --product tiltix080 get");
    assert_eq!(code, 1);
}
