//! Every product at every bit rate that it has, on a wire with that rate: found by listening, and by asking as delivered.

use super::bit_rate::{kbits, wired};
use super::cyclic::texts;
use super::rig::{PRODUCTS, Rig};
use super::scan::scan;
use plumbline::can::BitRate;
use plumbline::model::catalog::{Protocol, find};
use plumbline::time::millis;
use serde_json::{Value, json};

/// A product with the options for its address.
fn address(product: &str) -> (&'static str, &'static str) {
    match product {
        "jn2101" => ("--node", "10"),
        "ims360" => ("--node", "50"),
        "tiltix080" | "tiltix360" => ("--mac", "63"),
        _ => ("--id", "300"),
    }
}

/// The rate of a product as delivered, on a wire; GEMAC sensors detect it.
fn delivered(product: &str) -> BitRate {
    match product {
        "jn2101" | "ims360" | "tiltix080" | "tiltix360" => BitRate::K125,
        _ => BitRate::K250,
    }
}

/// The setting of a GEMAC sensor for a rate. `rate` would restart it, and wait for its answer.
fn setting(rate: BitRate) -> String {
    let product = find("is2").unwrap();
    let Protocol::Fsc(tables) = &product.protocol else {
        panic!("a GEMAC sensor");
    };
    let mut rates = tables.roles.bit_rates.iter();
    let code = rates.position(|own| *own == Some(rate)).unwrap();
    format!("set baud-rate=raw:{code} --save")
}

/// Runs `check` with the sensor at each of these rates that its product has. Returns how many these are.
fn at_each_rate(
    mut rig: Rig,
    address: &str,
    mut old: BitRate,
    rates: &[BitRate],
    mut check: impl FnMut(&mut Rig, BitRate),
) -> usize {
    let mut count = 0;
    for &rate in rates {
        rig.says_yes = true;
        rig.bus.borrow_mut().assist(false);
        let (from, to) = (kbits(old), kbits(rate));
        let command = match address.starts_with("--id") {
            true => setting(rate),
            false => format!("rate {to}"),
        };
        let ended = rig.tool(&format!("--json --rate {from} {address} {command}"));
        if ended.code != 0 {
            // Only because the tool, the object or LSS does not have this rate.
            let mut reasons = ["does not have", "to write baud-rate", "LSS error 1"].iter();
            let is_rate = reasons.any(|reason| ended.out.contains(reason));
            assert!(is_rate, "{rate:?} {ended:?}");
            continue;
        }
        (old, count) = (rate, count + 1);
        rig.says_yes = false;
        rig.questions.clear();
        rig.listen(rate);
        let id = rig.first();
        rig.bus.borrow_mut().power_cycle(id);
        check(&mut rig, rate);
    }
    count
}

fn number(rate: BitRate) -> Value {
    serde_json::from_str(&kbits(rate)).unwrap()
}

/// The products that differ in their bit rates and in what tells them, with the number of these rates.
const KINDS: [(&str, usize); 4] = [
    // Section 9.10.3.
    ("is2", 10),
    // Section 9.1.
    ("jn2101", 8),
    // Object 2001h.
    ("ims360", 5),
    // Attribute 2.
    ("tiltix080", 3),
];

/// A slow rate and a fast one that all of them have.
const ENDS: [BitRate; 2] = [BitRate::K125, BitRate::K500];

#[test]
fn sensor_is_found_at_its_rates_when_it_is_switched_on_and_by_asking() {
    for (product, rates) in KINDS {
        let (option, own) = address(product);
        let rig = wired(product, delivered(product));
        let count = at_each_rate(
            rig,
            &format!("{option} {own}"),
            delivered(product),
            &BitRate::ALL,
            |rig, rate| {
                // One product shows that the scan hears each rate.
                if product != "is2" && !ENDS.contains(&rate) {
                    rig.done(&format!("--rate {} {option} {own} get", kbits(rate)));
                    return;
                }
                // Nobody acknowledges: boot-up message or duplicate check.
                is_found(rig, product, rate);
                // Now it is silent. `scan` has a test that finds the rate of such a sensor.
                rig.run(3000);
                let ended = rig.tool(&format!("--rate {} scan --active", kbits(rate)));
                let row = ended.out.lines().next().unwrap_or_default();
                assert!(row.contains(product), "{product} {rate:?} {ended:?}");
            },
        );
        assert_eq!(count, rates, "{product}");
    }
}

/// A scan finds the sensor by what it sends after its start.
#[track_caller]
fn is_found(rig: &mut Rig, product: &str, rate: BitRate) {
    let (rows, time) = scan(rig, "");
    let found = (&rows[0]["product"], &rows[0]["address"], &rows[0]["rate"]);
    let (_, own) = address(product);
    let expected = (&json!(product), &json!(own), &number(rate));
    assert_eq!(found, expected, "{product} {rate:?}");
    assert!(time < 13_000, "{product} {rate:?} {time} ms");
    assert!(rig.questions.is_empty(), "{product} {rate:?}");
}

#[test]
fn every_product_is_found_when_it_is_switched_on() {
    for product in PRODUCTS {
        let (option, own) = address(product);
        let rate = delivered(product);
        let address = format!("{option} {own}");
        let count = at_each_rate(
            wired(product, rate),
            &address,
            rate,
            &[rate],
            |rig, rate| {
                is_found(rig, product, rate);
            },
        );
        assert_eq!(count, 1, "{product}");
    }
}

#[test]
fn heartbeat_of_a_second_is_found() {
    let product = "jn2101";
    let (option, own) = address(product);
    let mut rig = wired(product, BitRate::K125);
    rig.done(&format!(
        "--rate 125 {option} {own} set heartbeat-interval-time=1s --save"
    ));
    let count = at_each_rate(
        rig,
        &format!("{option} {own}"),
        BitRate::K125,
        &ENDS,
        |rig, rate| {
            let other = rig.bus.borrow_mut().adapter();
            rig.bus.borrow_mut().open(other, Some(rate), false);
            rig.run(1300);
            rig.witnessed();
            is_found(rig, product, rate);
            rig.bus.borrow_mut().remove(other);
        },
    );
    assert_eq!(count, ENDS.len());
}

/// An IMS360 in J1939 on a wire at 125 kbit/s.
fn j1939() -> Rig {
    let mut rig = wired("ims360", BitRate::K125);
    rig.done("--rate 125 --node 50 raw 3100:1=01");
    rig.done("--rate 125 --node 50 save");
    rig.done("--rate 125 --node 50 restart");
    rig.run(1000);
    rig
}

#[test]
fn address_claim_is_found() {
    let own = "--address 128";
    let count = at_each_rate(j1939(), own, BitRate::K125, &ENDS, |rig, rate| {
        rig.run(300);
        rig.witnessed();
        let (rows, time) = scan(rig, "");
        let found = (&rows[0]["product"], &rows[0]["protocol"], &rows[0]["rate"]);
        let expected = (&json!("ims360"), &json!("j1939"), &number(rate));
        assert_eq!(found, expected, "{rate:?}");
        assert!(time < 13_000, "{rate:?} {time} ms");
        // It was found by its claim, which nobody acknowledges.
        let seen = texts(&rig.witnessed());
        assert!(seen[..5].iter().all(|own| own.starts_with("18EEFF80#")));
    });
    assert_eq!(count, ENDS.len());
}

#[test]
fn mac_id_other_than_as_delivered_is_found_by_asking_all() {
    for mac in ["7", "0"] {
        let mut rig = Rig::with("tiltix080");
        rig.done(&format!("--mac 63 mac {mac}"));
        rig.run(3000);
        rig.witnessed();
        let (rows, _) = scan(&mut rig, "--active");
        assert_eq!(
            (&rows[0]["product"], &rows[0]["address"]),
            (&json!("tiltix080"), &json!(mac))
        );
    }
}

#[test]
fn silent_j1939_node_is_found_by_a_request_for_claims() {
    let mut rig = j1939();
    rig.done("--rate 125 --address 128 rate 250");
    rig.listen(BitRate::K250);
    let id = rig.first();
    rig.power_cycle(id);
    // What it sends by itself is not heard.
    let now = rig.bus.borrow().now();
    rig.deaf = Some((now, now + millis(12_100)));
    rig.bus.borrow_mut().assist(true);
    rig.says_yes = true;
    rig.questions.clear();
    let (rows, _) = scan(&mut rig, "--rate 250");
    assert_eq!(
        (
            &rows[0]["product"],
            &rows[0]["protocol"],
            &rows[0]["address"]
        ),
        (&json!("ims360"), &json!("j1939"), &json!("128"))
    );
    assert_eq!(rig.questions.len(), 1, "{:?}", rig.questions);
    let seen = texts(&rig.witnessed());
    assert!(seen.contains(&"18EAFFFE#00EE00".to_owned()));
}
