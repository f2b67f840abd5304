//! `watch`, `record` and `log`.

use super::rig::{PRODUCTS, Rig};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::time::millis;
use serde_json::Value;
use std::path::PathBuf;

fn file(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

#[test]
fn watch_prints_one_document_for_each_sample_of_every_product() {
    for product in PRODUCTS {
        let mut rig = Rig::with(product);
        let out = rig.done("--json watch --every 100 --seconds 1");
        let samples: Vec<Value> = out
            .lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect();
        assert!(
            (10..=11).contains(&samples.len()),
            "{product} {}",
            samples.len()
        );
        for (place, sample) in samples.iter().enumerate() {
            let time = sample["time"].as_f64().unwrap();
            assert!(
                (time - 0.1 * place as f64).abs() < 0.012,
                "{product} {time}"
            );
        }
        let angles = samples[0].as_object().unwrap();
        let expected = if product.starts_with("is1") || product == "tiltix360" {
            1
        } else {
            2
        };
        assert_eq!(
            angles.values().filter(|value| value.is_number()).count(),
            1 + expected,
            "{product}"
        );
    }
}

#[test]
fn watch_polls_only_and_changes_nothing() {
    let mut rig = Rig::with("is2");
    let before = rig.done("get");
    rig.witnessed();
    let out = rig.done("watch --every 50 --seconds 0.5");
    assert!(
        out.lines()
            .all(|line| line.contains("angle-x   10.00 deg  angle-y    5.00 deg")),
        "{out}"
    );
    assert!(out.contains("DefaultParam AutobaudDetection"), "{out}");
    let polls: Vec<String> = rig
        .witnessed()
        .iter()
        .map(|frame| format!("{frame:?}"))
        .filter(|frame| frame.starts_with("300#"))
        .collect();
    assert!(
        polls
            .iter()
            .all(|frame| ["300#00", "300#03", "300#04"].contains(&frame.as_str())),
        "{polls:?}"
    );
    assert_eq!(rig.done("get"), before);
}

#[test]
fn record_writes_one_row_for_each_sample() {
    let path = file("record.csv");
    let mut rig = Rig::with("is2");
    let ended = rig.tool(&format!("record {} --every 10 --seconds 2", path.display()));
    assert_eq!(ended.code, 0, "{ended:?}");
    assert!(ended.notes.contains("0 of 20"), "{ended:?}");
    let text = std::fs::read_to_string(&path).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("time_s,angle-x_deg,angle-y_deg,status"));
    let rows: Vec<&str> = lines.collect();
    assert!((200..=201).contains(&rows.len()), "{}", rows.len());
    assert!(
        rows.iter().all(|row| row.ends_with(",10.00,5.00,03")),
        "{}",
        rows[0]
    );
    assert!(rows[100].starts_with("1.00"), "{}", rows[100]);
}

#[test]
fn lost_samples_are_counted() {
    let mut rig = Rig::with("is2");
    rig.done("get angle-x");
    let now = rig.bus.borrow().now();
    // For 0.6 s no frame passes.
    for place in 0..3000 {
        let at = now + millis(1000) + plumbline::time::Duration::from_ticks(200 * place);
        rig.bus.borrow_mut().noise(at);
    }
    let ended = rig.tool("--rate 250 --id 300 watch --every 100 --seconds 4");
    assert_eq!(ended.code, 0, "{ended:?}");
    let lost: u64 = ended.notes.split(" of ").next().unwrap().parse().unwrap();
    assert!((1..=4).contains(&lost), "{}", ended.notes);
    let printed = ended.out.lines().count() as u64;
    assert!(
        ended
            .notes
            .contains(&format!("{lost} of {} samples lost", printed + lost)),
        "{ended:?}"
    );
}

#[test]
fn log_writes_every_frame_and_sends_nothing() {
    let path = file("bus.log");
    let mut rig = Rig::new(bench::BusRate::Wire);
    rig.listen(BitRate::K500);
    let (one, other) = {
        let mut bus = rig.bus.borrow_mut();
        (bus.adapter(), bus.adapter())
    };
    for id in [one, other] {
        rig.bus.borrow_mut().open(id, Some(BitRate::K500), false);
    }
    rig.run(10);
    for place in 0..10_000_u16 {
        rig.bus.borrow_mut().send(
            one,
            Frame::data(standard(0x123), &place.to_be_bytes()).unwrap(),
        );
    }
    let logged = rig.json(&format!("log {} --seconds 0.2", path.display()));
    let text = std::fs::read_to_string(&path).unwrap();
    let frames: Vec<&str> = text.lines().collect();
    assert_eq!(logged["frames"].as_u64().unwrap(), frames.len() as u64);
    assert!(frames.len() > 900, "{}", frames.len());
    let numbers: Vec<u16> = frames
        .iter()
        .map(|line| {
            let (time, rest) = line.split_once(") can0 123#").expect("candump -L");
            assert!(time.starts_with('('));
            u16::from_str_radix(rest, 16).unwrap()
        })
        .collect();
    assert!(
        numbers.windows(2).all(|pair| pair[1] == pair[0] + 1),
        "no frame is lost"
    );
    assert_eq!(rig.bus.borrow().disturbed(bench::Source::Adapter(one)), 0);
}

#[test]
fn log_of_a_silent_bus_needs_the_rate() {
    let mut rig = Rig::with("is2");
    let path = file("silent.log");
    assert_eq!(
        rig.fails(&format!("log {}", path.display())),
        (3, "no-answer".to_owned())
    );
    assert_eq!(rig.fails("watch --seconds=-1"), (2, "bad-value".to_owned()));
}
