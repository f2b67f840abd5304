//! Warm-up of GEMAC's reference line: AccuracyWarning over minutes, in scenes with a temperature (manual 9.3 and 9.5.2).

mod heated;

use bench::scene::{Axes, Scene};
use bench::{Bus, BusRate, Device, Flash, NodeType};
use heated::{Bench, RUNNING_TIME, recording};
use plumbline::can::BitRate;
use plumbline::time::{Instant, after, millis};

#[test]
fn warning_without_a_temperature_in_the_scene_is_cleared_within_minutes() {
    for (model, axes) in [
        ("is1tk", Axes::One),
        ("is2tk", Axes::Two),
        ("is1dm", Axes::One),
        ("is2dm", Axes::Two),
    ] {
        let scene = Scene::tilt(10.0, 5.0, axes).expect("a valid attitude");
        let mut bench = Bench::new(model, Box::new(scene));
        let seconds = bench.warning_becomes(false);
        println!("{model} from 25 degC: {seconds} s");
        assert!((60..RUNNING_TIME).contains(&seconds), "{seconds}");
        bench.stays_accurate(seconds + 300);
    }
}

/// G32: neither the warning nor the temperature see the restart.
#[test]
fn warning_stays_cleared_over_a_reset() {
    for temperature in [-40.0, 25.0, 80.0] {
        let name = format!("reset-{temperature}.csv");
        let mut bench = Bench::new("is2tk", recording(&name, &[(0, temperature)]));
        let seconds = bench.warning_becomes(false);
        bench.stays_accurate(seconds + 300);
        for round in 1..=3 {
            assert!(!bench.reset(), "{temperature} degC");
            bench.stays_accurate(seconds + 300 + 120 * round);
        }
    }
}

#[test]
fn warning_after_a_cold_start_follows_the_temperature() {
    let rows = [
        (0, -20.0),
        (900, -20.0),
        // Hotter than the set point: the heater cannot cool.
        (960, 90.0),
        (1500, 90.0),
        (1560, 20.0),
    ];
    let mut bench = Bench::new("is2tk", recording("cold-start.csv", &rows));
    let seconds = bench.warning_becomes(false);
    println!("from -20 degC: {seconds} s");
    assert!((120..RUNNING_TIME).contains(&seconds), "{seconds}");
    bench.stays_accurate(900);
    let hot = bench.warning_becomes(true);
    assert!((901..1500).contains(&hot), "{hot}");
    bench.bus.run_until(Instant::from_ticks(1_500_000_000));
    let again = bench.warning_becomes(false);
    assert!((1501..1500 + RUNNING_TIME).contains(&again), "{again}");
    bench.stays_accurate(again + 300);
}

/// "Independent of the operation temperature" (9.3): -40 to +80 degC (table 1).
#[test]
fn warning_is_cleared_at_every_operating_temperature() {
    for temperature in [-40.0, -10.0, 50.0, 80.0] {
        let name = format!("operating-{temperature}.csv");
        let mut bench = Bench::new("is2tk", recording(&name, &[(0, temperature)]));
        let seconds = bench.warning_becomes(false);
        println!("from {temperature} degC: {seconds} s");
        bench.stays_accurate(seconds + 300);
    }
}

#[test]
fn warning_after_a_power_cut_is_set_until_the_temperature_is_stable() {
    let mut bench = Bench::new("is2tk", recording("power-cut.csv", &[(0, 25.0)]));
    bench.warning_becomes(false);
    let cut = bench.bus.now();
    let device = bench.bus.device_mut(bench.device);
    device.power_off(cut);
    bench.bus.run_until(after(cut, millis(5000)));
    let on = bench.bus.now();
    bench.bus.device_mut(bench.device).power_on(on);
    let started = bench.seconds();
    bench.boot();
    let again = bench.warning_becomes(false) - started;
    println!("after 5 s without power: {again} s");
    assert!((30..RUNNING_TIME).contains(&again), "{again}");
}

#[test]
fn product_without_a_heater_never_sets_the_warning() {
    let rows = [(0, -20.0), (60, 82.0)];
    let node_type = NodeType::find("is2").expect("a product");
    assert_eq!(node_type.cell, None);
    let mut bus = Bus::new(BusRate::Fixed(BitRate::K250));
    let scene = recording("unheated.csv", &rows);
    bus.attach(Device::new(&node_type, 1, Flash::default(), scene));
    let tester = bus.adapter();
    bus.open(tester, None, false);
    bus.lead_detection();
    bus.run_until(after(bus.now(), millis(160)));
    for second in 0..120 {
        bus.send(tester, bench::script::frame(0x300, &[0x02]));
        bus.run_until(after(bus.now(), millis(1000)));
        let frames = bus.take_received(tester);
        assert!(!frames.is_empty());
        for (_, frame) in frames {
            assert_eq!(frame.bytes()[1], 0x03, "at {second} s");
        }
    }
}
