//! A busy bus: every request of a burst is answered, and process data keeps its rate.

use crate::j1939::network::{Network, Objects, answers, frame};
use bench::Logged;

/// No process data.
const QUIET: Objects = &[(0x2104, 1, &[0, 0])];

/// The time between two frames of SSI2 may differ from 10 ms by the frames of other groups and nodes.
const DELAY_US: u64 = 4000;

fn ssi2(frames: &[Logged]) -> Vec<u64> {
    let own = frames.iter().filter(|one| {
        let text = format!("{:?}", one.frame);
        text.starts_with("0CF02980#")
    });
    own.map(|one| one.at.ticks()).collect()
}

#[test]
fn every_request_of_a_burst_is_answered() {
    let mut network = Network::new(&[7], QUIET);
    network.wait(500);
    for count in [2_u32, 20, 100] {
        // A group that is not supported, of a requester of its own.
        let mut expected = Vec::new();
        for number in 0..count {
            let requester = number + 1;
            let text = format!("18EA80{requester:02X}#{number:02X}FF00");
            network.bus.send(network.tester, frame(&text));
            expected.push(format!("18E8FF80#01FFFFFF{requester:02X}{number:02X}FF00"));
        }
        let sent = answers(&network.wait(20 + 3 * count));
        assert_eq!(sent, expected, "in their order");
    }
    for requester in 0..25 {
        for pgn in ["00EE00", "EEFE00"] {
            let text = format!("18EA80{requester:02X}#{pgn}");
            network.bus.send(network.tester, frame(&text));
        }
        let mut sent = answers(&network.wait(20));
        sent.sort();
        let refusal = format!("18E8FF80#01FFFFFF{requester:02X}EEFE00");
        assert_eq!(sent, [refusal.as_str(), "18EEFF80#0700E0FF00910080"]);
    }
}

#[test]
fn process_data_keeps_its_rate_on_a_busy_bus() {
    let mut network = Network::new(&[7], &[]);
    network.wait(500);
    let mut frames = Vec::new();
    for number in 0..100_u32 {
        for text in [
            "18EF8021#4000100000000000".to_string(),
            "18EA8021#EEFE00".to_string(),
            format!(
                "18EEFF{:02X}#{number:02X}0080FFFFFFFFFF",
                0x40 + number % 30
            ),
            format!("0CF004{:02X}#0102030405060708", number % 64),
            "18EAFF21#00EE00".to_string(),
        ] {
            network.bus.send(network.tester, frame(&text));
        }
        frames.extend(network.wait(12));
    }
    let times = ssi2(&frames);
    assert!((118..=121).contains(&times.len()), "{}", times.len());
    for pair in times.windows(2) {
        assert!((pair[1] - pair[0]).abs_diff(10_000) <= DELAY_US, "{pair:?}");
    }
    // The mean: a late frame does not delay those after it.
    let whole = times[times.len() - 1] - times[0];
    assert!(whole.abs_diff(10_000 * (times.len() as u64 - 1)) <= DELAY_US);
}
