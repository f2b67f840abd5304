//! `bridge` in simulated time, without a broker: the samples are in the buffer.

use super::j1939::network;
use super::rig::Rig;
use super::several::pair;
use bench::BusRate;
use plumbline::can::{BitRate, Frame, standard};
use plumbline_tool::ops::bridge::queue::{Cursor, Queue};
use serde_json::Value;
use std::path::Path;

/// Runs `bridge` and returns the samples with their topics.
fn bridge(rig: &mut Rig, words: &str) -> (Vec<(String, Value)>, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let buffer = folder.path().join("buffer");
    let notes = run(rig, words, &buffer);
    (samples(&buffer), notes)
}

/// Runs `bridge` with this buffer and returns its notes.
fn run(rig: &mut Rig, words: &str, buffer: &Path) -> String {
    let words = format!(
        "{words} --mqtt mqtt://127.0.0.1:1 --site s --bus b --buffer {}",
        buffer.display()
    );
    let ended = rig.tool(&words);
    assert_eq!(ended.code, 0, "{ended:?}");
    ended.notes
}

/// The samples in a buffer; their numbers have no gap.
fn samples(buffer: &Path) -> Vec<(String, Value)> {
    let mut queue = Queue::open(buffer, 1 << 20).expect("a buffer");
    let records = queue.read(&mut Cursor::default(), usize::MAX);
    let records = records.expect("records").into_iter();
    let samples = records.map(|(number, bytes)| {
        let text = String::from_utf8(bytes).expect("a text");
        let (topic, document) = text.split_once('\n').expect("a topic");
        let document: Value = serde_json::from_str(document).expect("a document");
        assert_eq!(document["seq"], number);
        (topic.to_owned(), document)
    });
    samples.collect()
}

/// The number of samples of a topic.
fn count(samples: &[(String, Value)], topic: &str) -> usize {
    samples.iter().filter(|(own, _)| own == topic).count()
}

#[test]
fn every_sensor_of_the_bus_is_sampled_with_the_same_pause() {
    let (mut rig, _) = pair(
        "jn2101",
        &["--node 10 set heartbeat-interval-time=1s --save"],
        "ims360",
    );
    rig.done("--rate 125 --node 50 set producer-heartbeat-time=700ms");
    let (samples, _) = bridge(&mut rig, "--rate 125 bridge --every 100 --seconds 5");
    let counts = ["s/b/7/angle", "s/b/8/angle"].map(|topic| count(&samples, topic));
    assert!(
        counts.iter().all(|count| (49..=51).contains(count)),
        "{counts:?}"
    );
    assert_eq!(counts.iter().sum::<usize>(), samples.len());
}

#[test]
fn sensors_of_two_makers_with_one_serial_number_have_different_topics() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
    rig.attach("jn2101", 7);
    rig.attach("ims360", 7);
    rig.run(2500);
    let (samples, _) = bridge(
        &mut rig,
        "--rate 125 bridge --active --every 100 --seconds 2",
    );
    let counts = ["s/b/7/angle", "s/b/canopen-50/angle"].map(|topic| count(&samples, topic));
    assert!(
        counts.iter().all(|count| (19..=21).contains(count)),
        "{counts:?}"
    );
}

#[test]
fn topic_stays_with_the_sensor_that_has_had_it_before_the_restart() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
    let folder = tempfile::tempdir().expect("a folder");
    let words = "--rate 125 bridge --active --every 100 --seconds 1";
    rig.attach("ims360", 7);
    rig.run(2500);
    run(&mut rig, words, folder.path());
    let first = samples(folder.path()).len();
    // Its node-ID is smaller, so it is found first.
    rig.attach("jn2101", 7);
    rig.run(2500);
    run(&mut rig, words, folder.path());
    let samples = samples(folder.path()).split_off(first);
    let counts = ["s/b/7/angle", "s/b/canopen-10/angle"].map(|topic| count(&samples, topic));
    assert!(
        counts.iter().all(|count| (9..=11).contains(count)),
        "{counts:?}"
    );
}

#[test]
fn angles_of_j1939_are_taken_as_they_come() {
    let mut rig = network("");
    let (samples, _) = bridge(&mut rig, "--rate 250 bridge --every 100 --seconds 5");
    let count = count(&samples, "s/b/1/angle");
    assert!((49..=51).contains(&count), "{count}");
    let (_, last) = samples.last().expect("a sample");
    let is_tilted = |value: &Value| value.as_f64().is_some_and(|angle| angle.abs() > 1.0);
    let angles = last.as_object().expect("a document").iter();
    let mut angles = angles.filter(|(name, _)| name.ends_with("_deg"));
    assert!(angles.any(|(_, value)| is_tilted(value)), "{last}");
    // 18EFxxF9: a message to the sensor.
    let seen = rig.witnessed().into_iter();
    let requests = seen.filter(|frame| frame.can_id().bits() & 0xFF00_00FF == 0x9800_00F9);
    assert!(requests.count() < 40);
}

#[test]
fn several_devicenet_sensors_are_polled_in_turn() {
    let (mut rig, _) = pair("tiltix080", &["--mac 63 mac 5"], "tiltix360");
    let words = "--rate 125 bridge --active --every 100 --seconds 5";
    let (samples, _) = bridge(&mut rig, words);
    let counts = ["s/b/7/angle", "s/b/8/angle"].map(|topic| count(&samples, topic));
    assert!(
        counts.iter().all(|count| (48..=51).contains(count)),
        "{counts:?}"
    );
}

#[test]
fn node_that_is_no_sensor_is_told_and_asked_with_growing_pauses() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
    rig.attach("jn2101", 7);
    let heartbeat = Frame::data(standard(0x733), &[5]).expect("a heartbeat");
    rig.cyclic = Some((500, heartbeat));
    rig.says_yes = true;
    rig.run(2500);
    rig.witnessed();
    let (_, notes) = bridge(&mut rig, "--rate 125 bridge --active --seconds 210");
    let told = "canopen  -  address 51  serial -  -  firmware -: skipped";
    assert!(notes.contains(told), "{notes}");
    let frames = rig.witnessed_at().into_iter();
    let questions = frames.filter(|(_, frame)| frame.can_id() == standard(0x633).into());
    let seconds = questions.map(|(at, _)| at.ticks() / 1_000_000);
    let mut times: Vec<u64> = seconds.collect();
    times.dedup_by_key(|second| *second / 10);
    let pauses: Vec<u64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let [.., first, second] = pauses[..] else {
        panic!("{times:?}");
    };
    assert!(
        first.abs_diff(32) <= 3 && second.abs_diff(65) <= 5,
        "{times:?}"
    );
}

#[test]
fn sensor_of_an_address_stays_the_only_one() {
    let (mut rig, _) = pair(
        "jn2101",
        &["--node 10 set heartbeat-interval-time=1s --save"],
        "ims360",
    );
    let (samples, notes) = bridge(&mut rig, "--rate 125 --node 50 bridge --seconds 70");
    let others = samples.len() - count(&samples, "s/b/8/angle");
    assert_eq!(others, 0, "{notes}");
}

#[test]
fn one_sensor_is_named_by_its_address_in_every_protocol() {
    for (product, option, topic, angle) in [
        ("is2", "--id 300", "s/b/1/angle", "angle_x_deg"),
        ("tiltix080", "--mac 63", "s/b/1/angle", "slope_long16_deg"),
        ("ims360", "--node 50", "s/b/1/angle", "slope_long32_deg"),
    ] {
        let mut rig = Rig::with(product);
        let words = format!("{option} bridge --every 50 --seconds 2");
        let (samples, _) = bridge(&mut rig, &words);
        let count = count(&samples, topic);
        assert!((39..=41).contains(&count), "{product}: {count}");
        let is_tilted = |value: &Value| value.as_f64().is_some_and(|angle| angle.abs() > 1.0);
        let (_, last) = samples.last().expect("a sample");
        assert!(is_tilted(&last[angle]), "{product}: {last}");
    }
}

#[test]
fn angles_that_a_sensor_sends_by_itself_are_thinned_out_and_not_polled() {
    let mut rig = Rig::with("is2");
    rig.done("set cyclic-time=10ms cyclic-mode=1");
    rig.witnessed();
    let (samples, _) = bridge(&mut rig, "--id 300 bridge --every 100 --seconds 3");
    assert!((29..=31).contains(&samples.len()), "{}", samples.len());
    let requests = rig.witnessed();
    let requests = requests.iter().filter(|frame| frame.bytes() == [0]).count();
    assert!(requests <= 2, "{requests} polls");
}

#[test]
fn lost_sensor_is_told_and_sampled_again_when_it_answers() {
    let mut rig = Rig::with("is2");
    let (from, to) = (rig.later(4000), rig.later(12_000));
    rig.deaf = Some((from, to));
    let (samples, notes) = bridge(&mut rig, "--id 300 bridge --every 100 --seconds 25");
    let place = |part: &str| {
        notes
            .find(part)
            .unwrap_or_else(|| panic!("{part}: {notes}"))
    };
    assert!(
        place("does not answer any more") < place("answers again"),
        "{notes}"
    );
    // About 8 s without samples, and 5 s until it is looked for at the longest.
    assert!((110..=180).contains(&samples.len()), "{}", samples.len());
}

#[test]
fn roll_of_several_sensors_is_refused() {
    let (mut rig, _) = pair(
        "jn2101",
        &["--node 10 set heartbeat-interval-time=1s --save"],
        "ims360",
    );
    rig.done("--rate 125 --node 50 set producer-heartbeat-time=700ms");
    let to = "--agopengps-to 127.0.0.1:9";
    let refused = rig.fails(&format!("--rate 125 bridge --agopengps steer {to}"));
    assert_eq!(refused, (2, "several-sensors".to_owned()));
    let words =
        format!("--rate 125 --node 50 bridge --agopengps steer {to} --seconds 1 --axis roll");
    assert_eq!(rig.fails(&words), (2, "no-axis".to_owned()));
}
