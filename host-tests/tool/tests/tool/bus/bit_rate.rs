//! `rate`: writes, stores, restarts and checks, on a wire where a wrong rate is heard.

use super::rig::Rig;
use bench::BusRate;
use plumbline::can::{BitRate, CanId};

/// A sensor on a wire at its rate as delivered, or at 250 kbit/s if it detects the rate, after its start.
pub fn wired(product: &str, rate: BitRate) -> Rig {
    let mut rig = Rig::new(BusRate::Wire);
    rig.says_yes = true;
    rig.attach(product, 7);
    rig.listen(rate);
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, Some(rate), false);
    rig.run(3000);
    rig.bus.borrow_mut().remove(other);
    rig.bus.borrow_mut().assist(true);
    rig
}

/// The products with an address, their rate on the wire and another one.
const CASES: [(&str, &str, BitRate, &str, BitRate); 5] = [
    ("is2", "--id 300", BitRate::K250, "250", BitRate::K500),
    ("is1d", "--id 300", BitRate::K250, "250", BitRate::K62_5),
    ("jn2101", "--node 10", BitRate::K125, "125", BitRate::K800),
    ("ims360", "--node 50", BitRate::K125, "125", BitRate::M1),
    ("tiltix080", "--mac 63", BitRate::K125, "125", BitRate::K500),
];

pub fn kbits(rate: BitRate) -> String {
    (f64::from(rate.bits_per_second()) / 1000.0).to_string()
}

/// The sensor of the test answers.
#[track_caller]
fn assert_answers(rig: &mut Rig, address: &str) {
    let ended = rig.tool(&format!("{address} get"));
    assert_eq!(ended.code, 0, "{address} {ended:?}");
    assert!(ended.notes.contains("serial 7"), "{address} {ended:?}");
}

#[test]
fn rate_of_every_protocol_is_written_stored_and_checked() {
    for (product, address, before, old, new) in CASES {
        let mut rig = wired(product, before);
        let new_text = kbits(new);
        let out = rig.done(&format!("--rate {old} {address} rate {new_text}"));
        assert!(out.contains("now, and stored"), "{product} {out}");
        let question = &rig.questions[0];
        for part in [product, "serial 7", new.name()] {
            assert!(question.contains(part), "{part}: {question}");
        }
        assert_eq!(
            rig.fails(&format!("--rate {old} {address} get")),
            (3, "no-answer".to_owned()),
            "{product}"
        );
        rig.listen(new);
        let id = rig.first();
        rig.power_cycle(id);
        assert_answers(&mut rig, &format!("--rate {new_text} {address}"));
        let out = rig.done(&format!("--rate {new_text} {address} rate {new_text}"));
        assert!(out.contains("already"), "{product} {out}");
    }
}

#[test]
fn rate_auto_changes_nothing_if_the_sensor_detects_the_rate() {
    let mut rig = wired("is2", BitRate::K250);
    let out = rig.done("--rate 250 --id 300 rate auto");
    assert!(out.contains("already"), "{out}");
    assert!(rig.questions.is_empty());
}

#[test]
fn rate_without_a_yes_changes_nothing() {
    for (product, address, before, old, new) in CASES {
        let mut rig = wired(product, before);
        rig.says_yes = false;
        let command = format!("--rate {old} {address} rate {}", kbits(new));
        assert_eq!(
            rig.fails(&command),
            (2, "not-confirmed".to_owned()),
            "{product}"
        );
        let id = rig.first();
        rig.power_cycle(id);
        assert_answers(&mut rig, &format!("--rate {old} {address}"));
    }
}

#[test]
fn rate_that_product_or_adapter_does_not_have_is_refused_before_a_write() {
    for (product, rate) in [
        ("jn2101", "100"),
        ("ims360", "62.5"),
        ("tiltix080", "1000"),
        ("jn2101", "auto"),
        ("ims360", "20"),
    ] {
        let mut rig = Rig::with(product);
        assert_eq!(
            rig.fails(&format!("rate {rate}")),
            (2, "out-of-range".to_owned()),
            "{product} {rate}"
        );
        assert!(rig.questions.is_empty(), "{product} {rate}");
    }
    let mut rig = Rig::with("ims360");
    let ended = rig.tool("rate 20");
    let rates = "it has 125 kbit/s, 250 kbit/s, 500 kbit/s, 800 kbit/s, 1 Mbit/s";
    assert!(ended.notes.contains(rates), "{ended:?}");
    let mut rig = Rig::with("is2");
    rig.refused = Some(BitRate::K500);
    assert_eq!(
        rig.fails("--id 300 rate 500"),
        (4, "rate-refused".to_owned())
    );
    assert!(rig.questions.is_empty());
    rig.refused = None;
    assert_eq!(rig.json("get baud-rate")["baud-rate"]["raw"], 0);
}

#[test]
fn gemac_sensor_returns_to_automatic_detection() {
    let mut rig = wired("is2", BitRate::K250);
    rig.done("--rate 250 --id 300 rate 250");
    rig.done("--rate 250 --id 300 rate auto");
    let id = rig.first();
    rig.bus.borrow_mut().power_cycle(id);
    rig.run(100);
    let read = rig.json("--rate 500 --id 300 get baud-rate");
    assert_eq!(read["baud-rate"]["raw"], 0);
}

#[test]
fn lss_stores_the_rate_of_one_of_two_sensors_and_nothing_else() {
    // The wire follows the first sensor, so that the other one does not disturb it afterwards.
    let mut rig = Rig::with("ims360");
    rig.done("--node 50 node-id 51");
    rig.attach("ims360", 8);
    rig.run(500);
    rig.done("--node 51 set cut-off=2.5Hz");
    rig.witnessed();
    rig.done("--rate 125 --node 51 rate 500");
    let frames = rig.witnessed();
    let lss: Vec<String> = frames
        .iter()
        .filter(|frame| {
            [0x7E4, 0x7E5]
                .map(CanId::standard)
                .contains(&frame.can_id())
        })
        .map(|frame| format!("{frame:?}"))
        .collect();
    // Index 2 of the standard table is 500 kbit/s; all nodes return to waiting.
    for (place, start) in [
        (0, "7E5#0400"),
        (1, "7E5#40"),
        (2, "7E5#41"),
        (3, "7E5#42"),
        (4, "7E5#4301000000"),
        (5, "7E4#44"),
        (6, "7E5#130002"),
        (7, "7E4#1300"),
        (8, "7E5#17"),
        (9, "7E4#1700"),
        (10, "7E5#0400"),
    ] {
        assert!(lss[place].starts_with(start), "{place} {lss:#?}");
    }
    assert_eq!(lss.len(), 11, "{lss:#?}");
    let read = rig.json("--rate 500 --node 51 get cut-off baud-rate");
    assert_eq!(read["cut-off"]["raw"], 2000, "the filter was not stored");
    assert_eq!(read["baud-rate"]["raw"], 500_000);
    // The other sensor has its old rate, so that it is not on this wire.
    assert_eq!(rig.fails("--node 50 get"), (3, "no-answer".to_owned()));
}

#[test]
fn sensor_that_misses_its_restart_is_told_as_not_restarted() {
    for (product, address, new) in [
        ("jn2101", "--node 10", "800"),
        ("jn2101", "--node 10", "1000"),
        ("ims360", "--node 50", "1000"),
    ] {
        let mut rig = wired(product, BitRate::K125);
        // The request of NMT to reset the node.
        rig.lost = |frame| frame.can_id() == CanId::standard(0);
        assert_eq!(
            rig.fails(&format!("--rate 125 {address} rate {new}")),
            (1, "not-restarted".to_owned()),
            "{product} {new}"
        );
        assert_answers(&mut rig, &format!("--rate 125 {address}"));
    }
}
