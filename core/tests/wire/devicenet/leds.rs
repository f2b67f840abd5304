//! DeviceNet: the module status LED and the network status LED.

use crate::tester::devicenet::{LevelTester, MAC_3, allocated, online, power_up};
use plumbline::node::{BusEvent, BusState, Leds};

/// The colours of the module status LED and of the network status LED: green, red or off.
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

/// The colours of the network status LED every 250 ms of two seconds.
fn network(tester: &mut LevelTester) -> String {
    let mut shown = String::new();
    for _ in 0..8 {
        tester.wait(125);
        let [module, network] = colours(tester.leds);
        assert_eq!(module, 'g');
        shown.push(network);
        tester.wait(125);
    }
    shown
}

fn flashes(shown: &str, colour: char) -> bool {
    let full: String = [colour, colour, '-', '-'].iter().cycle().take(12).collect();
    full.contains(shown)
}

#[test]
fn self_test_shows_each_colour_for_a_quarter_of_a_second() {
    let mut tester = power_up(Some(MAC_3));
    let mut shown = vec![];
    for _ in 0..6 {
        tester.wait(125);
        shown.push(colours(tester.leds));
        tester.wait(125);
    }
    let expected = ["g-", "r-", "-g", "-r", "g-", "g-"];
    let expected = expected.map(|text| {
        let mut colours = text.chars();
        [colours.next().unwrap(), colours.next().unwrap()]
    });
    assert_eq!(shown, expected);
}

#[test]
fn network_status_shows_the_connections() {
    let mut tester = online();
    assert!(flashes(&network(&mut tester), 'g'));
    tester.allocate(3);
    assert_eq!(network(&mut tester), "gggggggg");
    tester.explicit("100501090000");
    tester.set_rate(2, 1);
    tester.wait(10_000);
    assert!(flashes(&network(&mut tester), 'r'), "timed out");
    tester.allocate(2);
    assert_eq!(network(&mut tester), "gggggggg");
    tester.exchange("41E#0A4C030101");
    assert!(flashes(&network(&mut tester), 'g'));
    tester.ignores("41F#80620102020304");
    assert_eq!(network(&mut tester), "rrrrrrrr");
}

#[test]
fn module_status_flashes_red_without_measurements() {
    let mut tester = allocated(0);
    tester.wait_without_samples(225);
    assert_eq!(colours(tester.leds)[0], 'r');
    assert_eq!(tester.explicit("0E010105"), "8E0104");
    tester.sample();
    assert_eq!(colours(tester.leds)[0], 'g');
    assert_eq!(tester.explicit("0E010105"), "8E0100");
}

#[test]
fn network_status_is_red_in_bus_off() {
    let mut tester = allocated(2);
    tester.bus(BusEvent::State(BusState::BusOff));
    assert_eq!(network(&mut tester), "rrrrrrrr");
}

#[test]
fn network_status_is_off_during_the_check_of_a_new_mac_id() {
    let mut tester = allocated(0);
    let sent = tester.exchange("41C#0A1003010105");
    assert_eq!(sent, ["41B#0A90", "42F#00620101020304"]);
    let shown = network(&mut tester);
    assert_eq!(shown, "--------", "two seconds");
    assert!(flashes(&network(&mut tester), 'g'));
}

#[test]
fn module_status_flashes_red_after_a_failed_save() {
    let mut tester = allocated(0);
    tester.memory_works = Some(false);
    assert_eq!(tester.explicit("106501712C01"), "90");
    tester.wait(350);
    let mut shown = String::new();
    for _ in 0..4 {
        tester.wait(500);
        shown.push(colours(tester.leds)[0]);
    }
    assert!(shown == "r-r-" || shown == "-r-r", "{shown}");
    tester.memory_works = Some(true);
    assert_eq!(tester.explicit("106501712D01"), "90");
    tester.wait(350);
    assert_eq!(colours(tester.leds)[0], 'g');
}
