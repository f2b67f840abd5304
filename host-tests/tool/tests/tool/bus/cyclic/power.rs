//! Sensors that are switched off and on during `watch` and `record`.

use super::super::rig::Rig;
use super::{cyclic_settings, lost};
use plumbline::can::{Frame, extended};

#[test]
fn polling_of_a_gemac_sensor_goes_on_after_a_power_cycle() {
    let mut rig = Rig::with("is2");
    let id = rig.first();
    rig.power_cycle_at(rig.later(2000), id);
    let ended = rig.tool("--id 300 watch --every 50 --seconds 6");
    let [missing, all] = lost(&ended);
    assert!((1..=40).contains(&missing), "{}", ended.notes);
    assert!((118..=121).contains(&all), "{}", ended.notes);
    assert_eq!(ended.out.lines().count() as u64, all - missing);
    let last = ended.out.lines().last().unwrap();
    assert!(last.contains("5.9") && last.contains("10.00 deg"), "{last}");
}

#[test]
fn cyclic_mode_that_a_power_cycle_ends_is_an_error_with_the_next_step() {
    let mut rig = Rig::with("is2");
    let id = rig.first();
    rig.power_cycle_at(rig.later(2000), id);
    let ended = rig.tool("--id 300 watch --every 50 --cyclic --seconds 20");
    assert_eq!(ended.code, 3, "{ended:?}");
    let lines = ended.out.lines().count();
    assert!((20..=40).contains(&lines), "{lines} {ended:?}");
    assert!(ended.notes.contains("does not send its angles any more"));
    assert!(ended.notes.contains("start the command again"), "{ended:?}");
    assert_eq!(cyclic_settings(&mut rig), [250, 0]);
}

#[test]
fn stored_cyclic_mode_goes_on_after_a_power_cycle_with_the_lost_samples() {
    let mut rig = Rig::with("is2");
    // A sensor that detects the bit rate sends nothing until another node sends.
    rig.done("--id 300 set baud-rate=250kbit/s cyclic-time=5ms cyclic-mode=on --save");
    let id = rig.first();
    rig.power_cycle_at(rig.later(2500), id);
    let ended = rig.tool("--id 300 watch --every 5 --cyclic --seconds 6");
    let [missing, all] = lost(&ended);
    assert!((1..=240).contains(&missing), "{}", ended.notes);
    assert!((1190..=1205).contains(&all), "{}", ended.notes);
    assert_eq!(ended.out.lines().count() as u64, all - missing);
    assert!(ended.notes.contains("started again"), "{}", ended.notes);
}

fn ims360() -> Rig {
    let mut rig = Rig::with("ims360");
    rig.done("--node 50 raw 3100:1=01");
    rig.done("--node 50 save");
    let id = rig.first();
    rig.power_cycle(id);
    rig
}

/// The same, which is switched off and on in 3 s.
fn j1939() -> Rig {
    let mut rig = ims360();
    let id = rig.first();
    rig.power_cycle_at(rig.later(3000), id);
    rig
}

#[test]
fn claims_that_another_device_requests_cost_no_sample() {
    let mut rig = ims360();
    let request = Frame::data(extended(0x18EA_FFFE), &[0x00, 0xEE, 0x00]).unwrap();
    rig.cyclic = Some((200, request));
    let ended = rig.tool("--address 128 watch --every 10 --cyclic --seconds 3");
    let [missing, all] = lost(&ended);
    assert_eq!(missing, 0, "{}", ended.notes);
    assert!((295..=301).contains(&all), "{}", ended.notes);
}

#[test]
fn angles_of_a_j1939_sensor_go_on_after_a_power_cycle() {
    // The period as delivered is 10 ms.
    for (options, samples) in [("--every 50", 160), ("--every 10 --cyclic", 800)] {
        let ended = j1939().tool(&format!("--address 128 watch {options} --seconds 8"));
        let [missing, all] = lost(&ended);
        assert!((1..=samples / 10).contains(&missing), "{}", ended.notes);
        assert!(all.abs_diff(samples) <= 3, "{}", ended.notes);
        assert_eq!(ended.out.lines().count() as u64, all - missing);
    }
}

#[test]
fn j1939_sensor_that_has_its_stored_period_after_a_power_cycle_is_an_error_with_the_next_step() {
    for every in [20, 100] {
        let mut rig = j1939();
        let ended = rig.tool(&format!(
            "--address 128 watch --every {every} --cyclic --seconds 8"
        ));
        assert_eq!(ended.code, 3, "{}", ended.notes);
        assert!(
            ended.notes.contains("start the command again"),
            "{}",
            ended.notes
        );
        let lines = ended.out.lines().count();
        assert!((500 / every..3000 / every).contains(&lines), "{lines}");
        let read = rig.json("--address 128 get transmission-rate-ssi2");
        assert_eq!(read["transmission-rate-ssi2"]["raw"], 10);
    }
}

#[test]
fn inhibit_time_that_is_longer_than_the_event_timer_is_the_period() {
    let mut rig = Rig::with("jn2101");
    rig.done(
        "--node 10 set tpdo1-transmission-type=254 tpdo1-event-timer=1ms tpdo1-inhibit-time=10ms",
    );
    super::send(&mut rig, &[(0, &[1, 10])]);
    let ended = rig.tool("--node 10 watch --cyclic --seconds 2");
    let [missing, all] = lost(&ended);
    assert!(
        missing == 0 && (195..=202).contains(&all),
        "{}",
        ended.notes
    );
    assert!(ended.notes.contains("every 10 ms"), "{}", ended.notes);
}
