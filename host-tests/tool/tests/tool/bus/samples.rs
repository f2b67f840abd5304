//! The commands `watch`, `record` and `log`.

use super::rig::{PRODUCTS, Rig, file};
use plumbline::can::{BitRate, Frame, extended, standard};
use plumbline::time::millis;
use serde_json::{Value, json};
use std::rc::Rc;

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
    let last = ended.notes.lines().last();
    assert!(
        matches!(
            last,
            Some("0 of 200 samples lost" | "0 of 201 samples lost")
        ),
        "{ended:?}"
    );
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
fn shorter_recording_replaces_a_longer_one() {
    let path = file("record-longer.csv");
    std::fs::write(&path, "mine\n".repeat(10_000)).unwrap();
    let mut rig = Rig::with("is2");
    rig.done(&format!("record {} --seconds 0.5", path.display()));
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("time_s,"), "{text}");
    assert!(!text.contains("mine"), "{text}");
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
    let last = ended.notes.lines().last().unwrap();
    let lost: u64 = last.split(" of ").next().unwrap().parse().unwrap();
    assert!((5..=8).contains(&lost), "{}", ended.notes);
    let printed = ended.out.lines().count() as u64;
    assert_eq!(last, format!("{lost} of {} samples lost", printed + lost));
    assert!((40..=41).contains(&(printed + lost)), "{ended:?}");
}

#[test]
fn sensor_that_stops_answering_is_reported_while_the_command_runs() {
    const SILENT: &str = "the sensor has not answered for 1 s";
    let mut rig = Rig::with("is2");
    rig.deaf = Some((rig.later(2000), rig.later(4000)));
    let ended = rig.tool("--id 300 watch --every 100 --seconds 6");
    assert_eq!(ended.code, 0, "{ended:?}");
    let notes: Vec<&str> = ended.notes.lines().collect();
    let silent = notes.iter().position(|note| note.starts_with(SILENT));
    assert_eq!(notes[silent.unwrap() + 1], "the sensor answers again");
    // It does not answer at the end.
    let path = file("silent.csv");
    rig.deaf = Some((rig.later(2000), rig.later(60_000)));
    let record = format!("--id 300 record {} --every 100 --seconds 6", path.display());
    let ended = rig.tool(&record);
    assert_eq!(ended.code, 3, "{ended:?}");
    assert!(ended.out.contains("recorded "), "{ended:?}");
    assert!(ended.notes.contains(SILENT), "{ended:?}");
    let rows = std::fs::read_to_string(&path).unwrap().lines().count();
    assert!((15..=21).contains(&rows), "{rows}");
}

#[test]
fn samples_faster_than_the_bus_are_lost() {
    let mut rig = Rig::with("jn2101");
    let ended = rig.tool("--node 10 watch --every 1 --seconds 1");
    let last = ended.notes.lines().last().unwrap();
    let numbers: Vec<u64> = last
        .split(' ')
        .filter_map(|word| word.parse().ok())
        .collect();
    let printed = ended.out.lines().count() as u64;
    assert_eq!(numbers, [numbers[1] - printed, numbers[1]]);
    assert!(
        (990..=1001).contains(&numbers[1]) && numbers[0] > 0,
        "{last}"
    );
}

#[test]
fn connection_that_has_expired_between_samples_is_allocated_again() {
    let mut rig = Rig::with("tiltix080");
    let ended = rig.tool("--mac 63 watch --every 15000 --seconds 50");
    assert_eq!(ended.code, 0, "{ended:?}");
    assert_eq!(ended.out.lines().count(), 4, "{ended:?}");
    assert_eq!(
        ended.notes.lines().last(),
        Some("0 of 4 samples lost"),
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
    for place in 0..30_000_u16 {
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

/// Another device on the bus.
fn other_device(rig: &Rig) -> bench::AdapterId {
    let id = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(id, None, false);
    id
}

#[test]
fn log_writes_extended_and_remote_frames_as_candump_does() {
    let path = file("kinds.log");
    let mut rig = Rig::new(bench::BusRate::Follow);
    rig.rate = Some("250");
    let one = other_device(&rig);
    // Another device acknowledges.
    other_device(&rig);
    let kinds = [
        (Frame::data(standard(0x7FF), &[]), "7FF#"),
        (Frame::data(standard(0x001), &[0, 0xAB]), "001#00AB"),
        (
            Frame::data(extended(0x1FFF_FFFF), &[1, 2, 3, 4, 5, 6, 7, 8]),
            "1FFFFFFF#0102030405060708",
        ),
        (Frame::data(extended(0x123), &[0xFF]), "00000123#FF"),
        (Frame::remote(standard(0x123), 0), "123#R"),
        (Frame::remote(standard(0x70A), 1), "70A#R1"),
        (Frame::remote(extended(0x18EA_FF80), 8), "18EAFF80#R8"),
    ];
    let frames = kinds.map(|(frame, _)| frame.unwrap());
    let send = move |bus: &mut bench::Bus| frames.iter().for_each(|own| bus.send(one, *own));
    rig.events = vec![(rig.later(100), Rc::new(send))];
    rig.overruns = Some(3);
    let ended = rig.tool(&format!("--json log {} --seconds 1", path.display()));
    let document: Value = serde_json::from_str(&ended.out).unwrap();
    assert_eq!(
        (&document["frames"], &document["lost"]),
        (&json!(7), &json!(3))
    );
    assert!(ended.notes.contains("lost at least 3 frames"), "{ended:?}");
    let text = std::fs::read_to_string(&path).unwrap();
    let mut lines: Vec<&str> = text
        .lines()
        .map(|line| line.split_once(") can0 ").expect("candump -L").1)
        .collect();
    let mut expected = kinds.map(|(_, text)| text);
    lines.sort_unstable();
    expected.sort_unstable();
    assert_eq!(lines, expected);
}

#[test]
fn lines_of_the_adapter_that_cannot_be_read_are_told_in_place_of_the_wiring() {
    let mut rig = Rig::with("is2");
    for _ in 0..19 {
        rig.unread.take(b"y18EA".to_vec());
    }
    let told = "19 lines not in the format of slcan, the first is \"y18EA\"";
    for command in ["--rate 250 --id 300 watch --seconds 1", "--rate 250 scan"] {
        let ended = rig.tool(command);
        assert_eq!(ended.code, 0, "{ended:?}");
        assert!(ended.notes.contains(told), "{ended:?}");
    }
    rig.lost = |_| true;
    for command in [
        "--rate 250 --id 300 get",
        "--rate 250 --id 300 raw 03",
        "--rate 250 scan --active",
    ] {
        let ended = rig.tool(command);
        assert_eq!(ended.code, 3, "{ended:?}");
        assert!(ended.notes.contains(told), "{ended:?}");
        assert!(!ended.notes.contains("wiring"), "{ended:?}");
    }
}

#[test]
fn log_of_a_silent_bus_needs_the_rate() {
    let mut rig = Rig::with("is2");
    rig.rate = None;
    let path = file("silent.log");
    assert_eq!(
        rig.fails(&format!("log {}", path.display())),
        (3, "no-answer".to_owned())
    );
    assert_eq!(rig.fails("watch --seconds=-1"), (2, "bad-value".to_owned()));
}

#[test]
fn record_prints_an_object_for_each_row() {
    let path = file("record-json.csv");
    let mut rig = Rig::with("is2");
    let out = rig.done(&format!(
        "--json record {} --every 10 --seconds 1",
        path.display()
    ));
    let text = std::fs::read_to_string(&path).unwrap();
    let mut objects = out.lines();
    let rows = text.lines().skip(1);
    assert!((100..=101).contains(&rows.clone().count()), "{text}");
    for row in rows {
        let object: Value = serde_json::from_str(objects.next().expect("an object")).unwrap();
        let cells = row.split(',').map(str::parse);
        let cells: Vec<f64> = cells.map_while(Result::ok).take(3).collect();
        let values = ["time", "angle-x", "angle-y"].map(|name| object[name].as_f64().unwrap());
        assert_eq!(values, *cells);
        // DefaultParam and AutobaudDetection.
        assert_eq!(object["status"].as_array().unwrap().len(), 2, "{object}");
        assert!(row.ends_with(",03"), "{row}");
    }
    assert_eq!(objects.next(), None);
}
