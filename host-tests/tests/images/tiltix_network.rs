//! The images of the TILTIX on the network: bus-off with and without bus-off interrupt (BOI), and the colours of both LEDs.

use crate::tiltix::Bench;
use bench::Source;
use plumbline::node::{BusState, Leds};

const REQUEST: &str = "5FF#00620101000000";

/// Destroys every frame of the sensor until it is bus-off.
fn drive_bus_off(bench: &mut Bench) {
    bench.bus.corrupt(32, Some(Source::Device(bench.sensor)));
    assert_eq!(bench.ask(&[0x0E, 3, 1, 4]), "");
    let is_off =
        |bench: &Bench| bench.bus.device(bench.sensor).bus_state() == Some(BusState::BusOff);
    let limit = (0..100).find(|_| {
        bench.wait(1);
        is_off(bench)
    });
    assert!(limit.is_some(), "bus-off within 100 ms");
}

/// The number of frames of the master that nobody has acknowledged yet.
fn pending(bench: &Bench) -> usize {
    bench.bus.queued(bench.master)
}

/// The colours of the module status LED and of the network status LED.
fn colours(leds: Leds) -> [char; 2] {
    let colour = |green, red| match (green, red) {
        (true, false) => 'g',
        (false, true) => 'r',
        (false, false) => '-',
        (true, true) => '!',
    };
    [
        colour(leds.module_green, leds.module_red),
        colour(leds.run, leds.error),
    ]
}

fn shown(bench: &Bench) -> [char; 2] {
    colours(bench.bus.device(bench.sensor).leds())
}

/// The colours of the network status LED in the middle of each half second.
fn network(bench: &mut Bench, count: usize) -> String {
    let mut colours = String::new();
    for _ in 0..count {
        bench.wait(500);
        let [module, network] = shown(bench);
        assert_eq!(module, 'g');
        colours.push(network);
    }
    colours
}

#[test]
fn bus_off_without_interrupt_lasts_until_a_restart() {
    let mut bench = Bench::new("tiltix080", 0.0, 0.0);
    bench.allocate();
    bench.bus.assist(false);
    drive_bus_off(&mut bench);
    for _ in 0..10 {
        assert_eq!(bench.wait(100), [""; 0]);
        let state = bench.bus.device(bench.sensor).bus_state();
        assert_eq!(state, Some(BusState::BusOff));
        assert_eq!(shown(&bench), ['g', 'r']);
    }
    assert_eq!(bench.exchange(0x5FD, &[]), [""; 0]);
    assert_eq!(pending(&bench), 1, "nobody acknowledges the poll command");
    bench.bus.power_cycle(bench.sensor);
    bench.wait(500);
    assert_eq!(pending(&bench), 0);
}

#[test]
fn bus_off_with_interrupt_checks_the_mac_id_again() {
    let mut bench = Bench::new("tiltix080", 0.0, 0.0);
    bench.allocate();
    assert_eq!(bench.ask(&[0x10, 3, 1, 3, 1]), "5FB#0A90");
    drive_bus_off(&mut bench);
    bench.check_duplicate(REQUEST);
    bench.allocate();
    assert_eq!(bench.ask(&[0x0E, 3, 1, 4]), "5FB#0A8E01");
}

#[test]
pub fn leds_show_the_self_test_and_the_connections() {
    let mut bench = Bench::new("tiltix080", 0.0, 0.0);
    let mut tested = Vec::new();
    for (at, leds) in bench.bus.device(bench.sensor).led_history() {
        tested.push((at.ticks() / 1000, colours(*leds)));
    }
    let from = tested.iter().find(|(_, colours)| *colours != ['-', '-']);
    let start = from.expect("a colour").0;
    assert!(start < 300, "{tested:?}");
    for (number, colours) in [['g', '-'], ['r', '-'], ['-', 'g'], ['-', 'r'], ['g', '-']]
        .into_iter()
        .enumerate()
    {
        let middle = start + 250 * number as u64 + 125;
        let last = tested.iter().rfind(|(at, _)| *at <= middle);
        assert_eq!(last.map(|(_, colours)| *colours), Some(colours), "{middle}");
    }
    let flashes =
        |shown: &str, on: &str| shown == format!("{on}-{on}-") || shown == format!("-{on}-{on}");
    let idle = network(&mut bench, 4);
    assert!(flashes(&idle, "g"), "{idle}");
    bench.allocate();
    assert_eq!(network(&mut bench, 4), "gggg");
    // The poll connection times out 400 ms after the poll command.
    bench.exchange(0x5FC, &[0x0A, 0x10, 5, 2, 9, 100, 0]);
    bench.exchange(0x5FD, &[]);
    bench.wait(1000);
    let timed_out = network(&mut bench, 4);
    assert!(flashes(&timed_out, "r"), "{timed_out}");
    // Another node has the MAC ID.
    bench.exchange(0x5FF, &[0x80, 0x62, 1, 2, 0, 0, 0]);
    assert_eq!(network(&mut bench, 4), "rrrr");
}
