//! `scan`: what it finds, how fast, and what a witness sees of it.

use super::rig::Rig;
use bench::BusRate;
use plumbline::can::{BitRate, Frame, standard};
use plumbline::time::{Duration, millis};
use plumbline_tool::output::{Bar, Progress};
use serde_json::{Value, json};
use std::cell::RefCell;
use std::rc::Rc;

/// Runs a scan and returns its rows and its time in ms.
pub fn scan(rig: &mut Rig, arguments: &str) -> (Vec<Value>, u64) {
    let start = rig.bus.borrow().now();
    let rows = rig.json(&format!("scan {arguments}"));
    let time = rig.bus.borrow().now().ticks() - start.ticks();
    (rows.as_array().unwrap().clone(), time / 1000)
}

/// A wire with a rate; sensors that detect it have heard a frame, and are silent now.
pub fn silent(product: &str, rate: BitRate) -> Rig {
    let mut rig = Rig::new(BusRate::Wire);
    rig.attach(product, 5);
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, Some(rate), false);
    rig.bus
        .borrow_mut()
        .send(other, Frame::data(standard(0x7FF), &[]).unwrap());
    rig.run(3000);
    rig.bus.borrow_mut().remove(other);
    rig.listen(rate);
    rig.run(10);
    rig.witnessed();
    rig
}

#[test]
fn sensors_that_nobody_acknowledges_are_found_and_asked() {
    for (product, row) in [
        (
            "jn2101",
            json!({"rate": 125, "protocol": "canopen", "product": "jn2101", "address": "10", "serial": 5, "article": "JN2101", "firmware": "2.2.0"}),
        ),
        (
            "ims360",
            json!({"rate": 125, "protocol": "canopen", "product": "ims360", "address": "50", "serial": 5, "article": "IMS360", "firmware": "010000"}),
        ),
        (
            "tiltix080",
            json!({"rate": 125, "protocol": "devicenet", "product": "tiltix080", "address": "63", "serial": 5, "article": "TILTIX-080-2-D100-HE2-PM", "firmware": "1.1"}),
        ),
    ] {
        let mut rig = Rig::new(BusRate::Wire);
        rig.attach(product, 5);
        rig.run(200);
        let (rows, time) = scan(&mut rig, "");
        assert_eq!(rows, [row], "{product}");
        assert!(time < 13_000, "{product} {time} ms");
        assert!(rig.questions.is_empty(), "{product}");
    }
}

#[test]
fn silent_sensor_is_only_asked_after_a_yes() {
    let mut rig = silent("is2", BitRate::K250);
    let ended = rig.tool("--json scan");
    assert_eq!(ended.code, 3);
    assert_eq!(rig.questions.len(), 1);
    assert!(ended.notes.contains("nothing was sent"));
    assert_eq!(rig.witnessed(), []);
    rig.says_yes = true;
    let (rows, time) = scan(&mut rig, "");
    let row = json!({"rate": 250, "protocol": "fsc", "product": "is2", "address": "300", "serial": 5, "article": "PR-23054-30", "firmware": "3.44"});
    assert_eq!(rows, [row]);
    // 12 s of listening, the answer, and the other addresses at that rate.
    assert!(time < 22_000, "{time} ms");
}

#[test]
fn silent_sensor_is_found_at_every_rate_within_five_seconds_of_the_yes() {
    for (product, rates) in [
        ("is2", &BitRate::ALL[..]),
        ("is1d", &[BitRate::M1]),
        ("tiltix360", &[BitRate::K125]),
    ] {
        for rate in rates {
            let mut rig = silent(product, *rate);
            rig.says_yes = true;
            let ended = rig.tool("scan");
            let first = ended.out.lines().next().expect("a row");
            assert!(first.contains(product), "{rate:?} {ended:?}");
            let time = ended.times[0].ticks() - rig.asked_at[0].ticks();
            assert!(time < 5_000_000, "{product} {rate:?} {time} us");
        }
    }
}

#[test]
fn silent_sensor_is_found_though_the_first_answers_are_late() {
    let mut rig = silent("is2", BitRate::K250);
    let now = rig.bus.borrow().now();
    // While the addresses as delivered are asked first, no frame passes.
    for place in 0..2500 {
        let at = now + millis(1010) + Duration::from_ticks(200 * place);
        rig.bus.borrow_mut().noise(at);
    }
    let ended = rig.tool("scan --active --rate 250");
    let asked = ended
        .notes
        .matches("sending requests to the factory addresses");
    assert_eq!(asked.count(), 2, "{ended:?}");
    let again = ended
        .notes
        .matches("factory addresses again, with more time");
    assert_eq!(again.count(), 1, "{ended:?}");
    assert!(ended.out.contains("  fsc  is2  address 300"), "{ended:?}");
}

#[test]
fn fresh_sensor_that_detects_the_rate_is_found_by_asking() {
    let mut rig = Rig::new(BusRate::Wire);
    rig.attach("is2tk", 3);
    rig.run(100);
    let (rows, _) = scan(&mut rig, "--active");
    assert_eq!(
        (&rows[0]["product"], &rows[0]["rate"]),
        (&json!("is2tk"), &json!(250))
    );
}

#[test]
fn older_generation_with_same_article_is_told_by_its_version() {
    for (product, firmware) in [("is2", "3.44"), ("is2d", "1.03"), ("is1dm", "1.03")] {
        let mut rig = Rig::with(product);
        let (rows, _) = scan(&mut rig, "--active");
        assert_eq!(
            (&rows[0]["product"], &rows[0]["firmware"]),
            (&json!(product), &json!(firmware))
        );
    }
}

#[test]
fn two_sensors_on_one_bus_are_both_found() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
    rig.attach("jn2101", 11);
    rig.attach("ims360", 12);
    rig.run(500);
    let (rows, _) = scan(&mut rig, "--active");
    let mut serials: Vec<u64> = rows
        .iter()
        .map(|row| row["serial"].as_u64().unwrap())
        .collect();
    serials.sort_unstable();
    assert_eq!(serials, [11, 12]);
}

#[test]
fn node_with_another_node_id_is_found_by_asking_all() {
    let mut rig = Rig::with("jn2101");
    rig.done("node-id 99");
    rig.run(500);
    rig.witnessed();
    let (rows, _) = scan(&mut rig, "--active");
    assert_eq!(
        (&rows[0]["product"], &rows[0]["address"]),
        (&json!("jn2101"), &json!("99"))
    );
}

#[test]
fn node_without_node_id_is_found_by_fastscan() {
    let mut rig = Rig::with("ims360");
    // LSS: select, node-ID 255, store.
    let master = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(master, None, false);
    for bytes in [
        [4, 1, 0, 0, 0, 0, 0, 0],
        [0x11, 255, 0, 0, 0, 0, 0, 0],
        [0x17, 0, 0, 0, 0, 0, 0, 0],
    ] {
        rig.bus
            .borrow_mut()
            .send(master, Frame::data(standard(0x7E5), &bytes).unwrap());
        rig.run(500);
    }
    rig.bus
        .borrow_mut()
        .send(master, Frame::data(standard(0x000), &[0x82, 50]).unwrap());
    rig.run(500);
    rig.bus.borrow_mut().remove(master);
    let (rows, _) = scan(&mut rig, "--active --rate 125");
    assert_eq!(rows[0]["address"], "unconfigured");
    assert_eq!(
        (&rows[0]["serial"], &rows[0]["heard"]),
        (&json!(1), &json!("vendor 195h, product code 1869Fh"))
    );
}

#[test]
fn search_finds_a_sensor_at_a_slow_rate() {
    let mut rig = silent("is2", BitRate::K10);
    rig.done("--rate 10 --id 300 set set-id=020h reply-id=6A6h baud-rate=raw:1 --save");
    rig.done("--rate 10 --id 300 restart");
    rig.run(500);
    rig.done("--rate 10 --id 020 get serial-number");
    let (rows, _) = scan(&mut rig, "--rate 10 --active --search");
    assert_eq!(
        (&rows[0]["product"], &rows[0]["address"]),
        (&json!("is2"), &json!("020"))
    );
}

#[test]
fn unknown_identifiers_are_found_after_power_cycle_and_by_search() {
    let mut rig = silent("is2", BitRate::K250);
    rig.done("--rate 250 set set-id=6A5h reply-id=6A6h baud-rate=raw:6 --save");
    let id = rig.first();
    rig.bus.borrow_mut().power_cycle(id);
    rig.run(200);
    // Nobody acknowledges its boot-up message, so it is repeated: listening finds it.
    let (rows, time) = scan(&mut rig, "");
    assert_eq!(
        (&rows[0]["product"], &rows[0]["address"]),
        (&json!("is2"), &json!("6A5"))
    );
    assert!(time < 3000, "{time} ms");
    // Now it is silent: only a search finds it.
    rig.run(100);
    let (rows, _) = scan(&mut rig, "--rate 250 --active --search");
    assert_eq!(
        (&rows[0]["product"], &rows[0]["address"]),
        (&json!("is2"), &json!("6A5"))
    );
}

#[test]
fn sensor_with_unknown_identifiers_that_detects_the_rate_is_found_by_its_boot_up_message() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K500));
    rig.attach("is1", 8);
    rig.done("--rate 500 set set-id=555h reply-id=556h --save");
    let id = rig.first();
    rig.bus.borrow_mut().power_cycle(id);
    rig.run(100);
    let (rows, _) = scan(&mut rig, "--rate 500 --active");
    assert_eq!(
        (&rows[0]["product"], &rows[0]["address"]),
        (&json!("is1"), &json!("555"))
    );
}

/// The steps that a progress bar has shown, and a mark where the bar was removed.
#[derive(Clone, Default)]
struct Shown(Rc<RefCell<Vec<(usize, usize, String)>>>);

impl Bar for Shown {
    fn show(&mut self, Progress { done, total, step }: Progress) {
        self.0.borrow_mut().push((done, total, step.to_string()));
    }

    fn hide(&mut self) {
        self.0.borrow_mut().push((0, 0, String::new()));
    }
}

#[test]
fn progress_bar_shows_each_step_instead_of_lines_and_is_away_during_questions() {
    let mut rig = silent("is2", BitRate::K500);
    let shown = Shown::default();
    rig.bar = Some(Box::new(shown.clone()));
    let ended = rig.tool("scan");
    assert!(
        !ended.notes.contains("listened at") && ended.notes.contains("nothing was sent"),
        "{ended:?}"
    );
    let steps = shown.0.take();
    let listened: Vec<usize> = steps
        .iter()
        .filter(|(_, _, text)| text.starts_with("listened at"))
        .map(|(done, total, _)| {
            assert_eq!(*total, 80);
            *done
        })
        .collect();
    assert_eq!(listened, (1..=80).collect::<Vec<usize>>());
    // A note comes before the first step, and the question after the last one.
    for place in [0, 81] {
        assert_eq!(steps[place], (0, 0, String::new()), "{place}");
    }
    assert!(steps[1].2.contains("off and on now"), "{steps:?}");
    rig.says_yes = true;
    rig.bar = Some(Box::new(shown.clone()));
    rig.tool("--rate 500 scan --active --search");
    let steps = shown.0.take();
    for (text, total) in [
        ("sending requests to the factory addresses", 2),
        ("sending requests to all node-IDs and MAC IDs", 191),
    ] {
        let own = steps
            .iter()
            .filter(|own| own.2.starts_with(text) && own.1 == total);
        let own: Vec<usize> = own.map(|(done, _, _)| *done).collect();
        assert!(!own.is_empty() && own.is_sorted(), "{text} {steps:?}");
        assert!(own.iter().all(|done| *done < total), "{text} {own:?}");
    }
    assert_eq!(steps.last().map(|(_, total, _)| *total), Some(0));
}

/// A number in the first note with this text before it.
fn number_after(notes: &str, text: &str) -> Option<usize> {
    let (_, rest) = notes.split_once(text)?;
    rest.split(' ').next()?.parse().ok()
}

#[test]
fn scan_says_how_many_frames_it_has_sent() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K250));
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, Some(BitRate::K250), false);
    let ended = rig.tool("--rate 250 scan --active");
    let count = rig.witnessed().len();
    assert!(count > 100, "{count}");
    let told = format!("sent {count} frames at 250 kbit/s");
    assert!(ended.notes.lines().any(|line| line == told), "{ended:?}");
}

#[test]
fn scan_tells_what_it_has_heard_at_each_rate() {
    let mut rig = silent("is2", BitRate::K250);
    let ended = rig.tool("scan");
    for rate in BitRate::ALL {
        let told = format!("listened at {} for ", rate.name());
        assert!(ended.notes.contains(&told), "{told}: {}", ended.notes);
    }
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K250));
    let frame = |id| Frame::data(standard(id), &[1]).unwrap();
    rig.cyclic = Some((40, frame(0x7A0)));
    let ended = rig.tool("--rate 250 scan");
    let heard = number_after(&ended.notes, " ms: ");
    assert!(
        heard.is_some_and(|count| (26..=28).contains(&count)),
        "{ended:?}"
    );
}

#[test]
fn search_says_how_long_it_takes_in_total() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K250));
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, Some(BitRate::K250), false);
    let start = rig.bus.borrow().now();
    let ended = rig.tool("--rate 250 scan --active --search");
    let seconds = (rig.bus.borrow().now().ticks() - start.ticks()) / 1_000_000;
    let told = number_after(&ended.notes, "11-bit identifiers take at least ");
    let told = told.unwrap_or(0) as u64;
    // The tool listens, and asks at the addresses as delivered, before.
    assert!(
        (seconds - 5..=seconds).contains(&told),
        "{told} s, {seconds} s: {ended:?}"
    );
}
