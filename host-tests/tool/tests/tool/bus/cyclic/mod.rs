//! `--cyclic`: sensors that send their angles by themselves, and what they are set to afterwards.

mod canopen;
pub mod devicenet;
mod invalid;
mod power;

use super::files::file;
use super::rig::Rig;
use super::rig::run::Ended;
use plumbline::can::{Frame, standard};
use plumbline::time::millis;

/// Sends a frame as another node, which acknowledges from then on.
pub fn send(rig: &mut Rig, frames: &[(u16, &[u8])]) {
    let master = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(master, None, false);
    for (id, bytes) in frames {
        let frame = Frame::data(standard(*id), bytes).unwrap();
        rig.bus.borrow_mut().send(master, frame);
        rig.run(20);
    }
}

pub fn texts(frames: &[Frame]) -> Vec<String> {
    frames.iter().map(|frame| format!("{frame:?}")).collect()
}

/// The last note: lost samples, all samples.
#[track_caller]
fn lost(ended: &Ended) -> [u64; 2] {
    assert_eq!(ended.code, 0, "{ended:?}");
    let all = ended.notes.lines();
    let mut summary = all.filter(|line| line.ends_with(" samples lost"));
    let words = summary.next_back().expect("a summary").split(' ');
    let numbers: Vec<u64> = words.filter_map(|word| word.parse().ok()).collect();
    numbers.try_into().unwrap()
}

/// Records for this time at 1 kHz, and returns heading and rows.
#[track_caller]
fn recorded(rig: &mut Rig, name: &str, options: &str) -> Vec<String> {
    let path = file(name);
    let ended = rig.tool(&format!(
        "{options} record {} --every 1 --cyclic --seconds 3",
        path.display()
    ));
    let text = std::fs::read_to_string(&path).unwrap();
    let rows: Vec<String> = text.lines().map(str::to_owned).collect();
    assert!(
        (2990..=3001).contains(&rows.len()),
        "{} {ended:?}",
        rows.len()
    );
    assert_eq!(lost(&ended), [0, rows.len() as u64 - 1], "{ended:?}");
    rows
}

/// The settings of cyclic mode.
fn cyclic_settings(rig: &mut Rig) -> [u64; 2] {
    let read = rig.json("--id 300 get cyclic-time cyclic-mode");
    ["cyclic-time", "cyclic-mode"].map(|name| read[name]["raw"].as_u64().unwrap())
}

#[test]
fn cyclic_samples_at_1_khz_are_complete_and_the_settings_are_put_back() {
    let path = file("cyclic.csv");
    let mut rig = Rig::with("is2");
    rig.done("--id 300 set cyclic-time=300ms");
    let ended = rig.tool(&format!(
        "--id 300 record {} --every 1 --cyclic --seconds 3",
        path.display()
    ));
    assert_eq!(ended.code, 0, "{ended:?}");
    let text = std::fs::read_to_string(&path).unwrap();
    let rows: Vec<&str> = text.lines().skip(1).collect();
    assert!((2990..=3000).contains(&rows.len()), "{}", rows.len());
    let last = ended.notes.lines().last().unwrap();
    assert_eq!(last, format!("0 of {} samples lost", rows.len()));
    assert!(
        rows[1000].starts_with("1.000,10.00,5.00,"),
        "{}",
        rows[1000]
    );
    assert_eq!(cyclic_settings(&mut rig), [300, 0]);
}

#[test]
fn settings_of_cyclic_mode_are_put_back_after_ctrl_c() {
    for looks in 1.. {
        let mut rig = Rig::with("is2");
        rig.stop = Some(looks);
        let ended = rig.tool("--id 300 watch --every 10 --cyclic --seconds 0.2");
        rig.stop = None;
        assert_eq!(cyclic_settings(&mut rig), [250, 0], "{looks} {ended:?}");
        if ended.out.lines().count() >= 18 {
            assert!(looks > 20, "{looks}");
            break;
        }
    }
}

#[test]
fn cyclic_samples_that_are_missing_are_counted() {
    let mut rig = Rig::with("is2");
    // The adapter loses the frames of 0.6 s.
    let now = rig.bus.borrow().now();
    rig.deaf = Some((now + millis(1500), now + millis(2100)));
    let ended = rig.tool("--id 300 watch --every 20 --cyclic --seconds 3");
    assert_eq!(ended.code, 0, "{ended:?}");
    let last = ended.notes.lines().last().unwrap();
    let lost: u64 = last.split(" of ").next().unwrap().parse().unwrap();
    assert!((29..=31).contains(&lost), "{}", ended.notes);
    let printed = ended.out.lines().count() as u64;
    assert!((148..=151).contains(&(printed + lost)), "{last}");
}

#[test]
fn period_that_other_devices_can_need_is_changed_only_after_a_yes() {
    let mut rig = Rig::with("is2");
    rig.done("set cyclic-time=50ms cyclic-mode=on");
    let record = |every: u32| {
        let path = file("cyclic-in-use.csv");
        let path = path.display();
        format!("--id 300 --rate 250 record {path} --every {every} --cyclic --seconds 1")
    };
    rig.says_yes = false;
    rig.witnessed();
    let failed = rig.fails(&record(20));
    assert_eq!(failed, (2, "not-confirmed".to_owned()));
    let seen = texts(&rig.witnessed());
    let is_write = |frame: &&String| frame.starts_with("300#25") || frame.starts_with("300#26");
    assert_eq!(seen.iter().find(is_write), None);
    rig.done(&record(50));
    rig.says_yes = true;
    rig.done(&record(20));
    assert!(
        rig.questions
            .iter()
            .any(|question| question.contains("50 ms"))
    );
    assert_eq!(cyclic_settings(&mut rig), [50, 1]);
}
