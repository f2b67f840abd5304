//! The bit rate: found by listening, or tried at a silent bus.

use super::rig::Rig;
use bench::BusRate;
use plumbline::can::BitRate;

#[test]
fn rate_of_a_talking_sensor_is_found_without_an_error_frame() {
    let mut rig = Rig::new(BusRate::Wire);
    let id = rig.attach("jn2101", 7);
    rig.listen(BitRate::K125);
    rig.run(100);
    let read = rig.json("get serial-number");
    assert_eq!(read["serial-number"]["raw"], 7);
    let disturbed = rig.bus.borrow().disturbed(bench::Source::Device(id));
    // Its own boot-up message was not acknowledged before the tool took part; nothing else was disturbed.
    let (transmit, receive) = rig.bus.borrow().device(id).error_counters().unwrap();
    assert!(receive == 0, "{transmit} {receive} {disturbed}");
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
