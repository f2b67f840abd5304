//! The bit rate: found by listening, or tried at a silent bus only after a yes.

use super::rig::Rig;
use bench::{BusRate, Source};
use plumbline::can::BitRate;

/// A JN2101 at 125 kbit/s that sends a heartbeat each second, which another node acknowledges.
fn beating() -> Rig {
    let mut rig = Rig::new(BusRate::Wire);
    rig.attach("jn2101", 7);
    rig.listen(BitRate::K125);
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, Some(BitRate::K125), false);
    rig.run(100);
    rig.done("--rate 125 --node 10 set heartbeat-interval-time=1s");
    rig.run(700);
    rig.witnessed();
    rig
}

#[test]
fn rate_of_a_bus_with_one_message_each_second_is_found_without_an_error_frame() {
    let mut rig = beating();
    let disturbed = |rig: &Rig| rig.bus.borrow().disturbed(Source::Device(rig.first()));
    let before = disturbed(&rig);
    let read = rig.json("get serial-number");
    assert_eq!(read["serial-number"]["raw"], 7);
    assert!(rig.questions.is_empty(), "{:?}", rig.questions);
    assert_eq!(disturbed(&rig), before);
    // The node that was heard is the only one that was asked.
    let others: Vec<String> = rig
        .witnessed()
        .iter()
        .map(|frame| format!("{frame:?}"))
        .filter(|frame| {
            !["60A#", "58A#", "70A#"]
                .iter()
                .any(|own| frame.starts_with(own))
        })
        .collect();
    assert_eq!(others, [""; 0]);
}

#[test]
fn silent_bus_is_asked_at_all_rates_only_after_a_yes() {
    for command in [
        "get",
        "set filter=1Hz",
        "watch --seconds 1",
        "--id 300 zero",
    ] {
        let mut rig = Rig::with("is2");
        (rig.rate, rig.says_yes) = (None, false);
        assert_eq!(rig.fails(command), (2, "no-rate".to_owned()), "{command}");
        assert_eq!(rig.witnessed(), [], "{command}");
        assert_eq!(rig.questions.len(), 1, "{command}");
        rig.says_yes = true;
        let read = rig.json("get serial-number");
        assert_eq!(read["serial-number"]["raw"], 1, "{command}");
    }
}

#[test]
fn rate_that_the_adapter_does_not_have_is_left_out() {
    for command in ["get", "scan", "watch --seconds 1"] {
        let mut rig = Rig::with("is2");
        rig.rate = None;
        rig.refused = Some(BitRate::K250);
        rig.done(command);
        assert_eq!(
            rig.fails("--rate 250 get"),
            (4, "rate-refused".to_owned()),
            "{command}"
        );
    }
}

#[test]
fn traffic_without_a_sign_of_a_sensor_is_asked_only_after_a_yes() {
    let mut rig = Rig::with("is2");
    rig.done("set cyclic-mode=on");
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, None, false);
    rig.run(1000);
    for rate in [None, Some("250")] {
        (rig.rate, rig.says_yes) = (rate, false);
        rig.witnessed();
        assert_eq!(rig.fails("get"), (2, "no-address".to_owned()));
        let others = rig
            .witnessed()
            .iter()
            .filter(|frame| !format!("{frame:?}").starts_with("301#00"))
            .count();
        assert_eq!(others, 0);
        assert_eq!(
            rig.json("--id 300 get serial-number")["serial-number"]["raw"],
            1
        );
        rig.says_yes = true;
        assert_eq!(rig.json("get serial-number")["serial-number"]["raw"], 1);
    }
}

#[test]
fn sensor_of_a_session_is_named_and_one_of_two_is_never_chosen() {
    let mut rig = Rig::with("is2");
    let ended = rig.tool("get cyclic-time");
    assert!(
        ended
            .notes
            .contains("is2, serial 1, identifier 300h at 250 kbit/s"),
        "{ended:?}"
    );
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
    (rig.rate, rig.says_yes) = (Some("125"), true);
    rig.attach("is2", 1);
    rig.attach("jn2101", 9);
    rig.run(500);
    rig.done("--id 300 get");
    rig.witnessed();
    for command in ["zero --save", "load-factory", "get"] {
        let failed = rig.fails(command);
        assert_eq!(failed, (2, "several-sensors".to_owned()), "{command}");
    }
    let writes = rig.witnessed();
    let writes = writes.iter().map(|frame| format!("{frame:?}"));
    let is_write = |frame: &String| {
        ["300#2", "300#5", "60A#2"]
            .iter()
            .any(|own| frame.starts_with(own))
    };
    assert_eq!(writes.filter(is_write).count(), 0);
    rig.done("--node 10 get");
    rig.done("--product is2 get");
}

#[test]
fn silent_sensor_that_detects_the_rate_answers_at_the_rate_of_the_user() {
    for rate in ["125", "1000", "10"] {
        let mut rig = Rig::new(BusRate::Wire);
        rig.attach("is2", 9);
        rig.run(100);
        let read = rig.json(&format!("--rate {rate} get serial-number"));
        assert_eq!(read["serial-number"]["raw"], 9, "{rate}");
    }
}

#[test]
fn adapter_that_refuses_all_rates_is_named_as_the_cause() {
    for command in ["scan", "scan --active", "get"] {
        let mut rig = Rig::with("is2");
        rig.rate = None;
        rig.refuses_all = true;
        let ended = rig.tool(command);
        assert_eq!(ended.code, 4, "{command} {ended:?}");
        for part in [
            "refuses all bit rates",
            "Close the other program, or check --port",
        ] {
            assert!(ended.notes.contains(part), "{command} {ended:?}");
        }
        assert_eq!(rig.fails(command), (4, "adapter-refused".to_owned()));
    }
    let mut rig = Rig::with("is2");
    rig.refused = Some(BitRate::K250);
    let failed = rig.fails("--rate 250 scan");
    assert_eq!(failed, (4, "rate-refused".to_owned()));
}
