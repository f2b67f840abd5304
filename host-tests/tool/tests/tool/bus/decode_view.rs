//! Which frames `log` and `decode` show, and how: filters, the list by identifier, databases of other devices.

use super::decode::log;
use super::rig::{Rig, file};

#[test]
fn database_decodes_what_no_protocol_knows() {
    let database = file("crane.dbc");
    let text = "BO_ 290 Boom: 2 Crane\n SG_ Length : 0|16@1+ (0.01,0) [0|1] \"m\" Vector__XXX\n\nBO_ 1802 Own: 1 Crane\n";
    std::fs::write(
        &database,
        format!("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: Crane\n\n{text}"),
    )
    .unwrap();
    let path = log(
        "database",
        ["122#D204", "70A#05", "123#00"].map(can_wire::text::frame),
    );
    let mut rig = Rig::with("is2");
    let decode = format!("decode {} --dbc", path.display());
    let lines = rig.done(&format!("{decode} {}", database.display()));
    let lines: Vec<&str> = lines.lines().collect();
    assert!(
        lines[0].ends_with("122#D204  dbc: Boom, Length = 12.34 m"),
        "{lines:?}"
    );
    assert!(
        lines[1].ends_with("canopen 10: heartbeat, operational"),
        "{lines:?}"
    );
    assert!(lines[2].ends_with("123#00"), "{lines:?}");
    std::fs::write(&database, "no database").unwrap();
    let wrong = rig.fails(&format!("{decode} {}", database.display()));
    assert_eq!(wrong, (2, "bad-file".to_owned()));
    std::fs::remove_file(&database).unwrap();
    let missing = rig.fails(&format!("{decode} {}", database.display()));
    assert_eq!(missing, (4, "no-file".to_owned()));
}

#[test]
fn list_by_identifier_has_count_mean_period_newest_data_and_meaning() {
    let frames = [
        "70A#7F",
        "18EEFF80#0100E0FF00810080",
        "70A#05",
        "123#R0",
        "70A#05",
    ];
    let path = log("by-id", frames.map(can_wire::text::frame));
    let mut rig = Rig::with("is2");
    let text = rig.done(&format!(
        "decode {} --by-id --filter 70A,123",
        path.display()
    ));
    let lines: Vec<&str> = text.lines().collect();
    let expected = [
        "identifier    count  period/ms  data                     meaning",
        "       123        1          -  RTR",
        "       70A        3     2000.0  05                       canopen 10: heartbeat, operational",
    ];
    assert_eq!(lines, expected);
    let document = rig.json(&format!("decode {} --by-id", path.display()));
    assert_eq!(document[1]["frame"], "70A#05");
    assert_eq!(document[1]["count"], 3);
    assert_eq!(document[1]["period"], 2000.0);
    assert_eq!(document[1]["message"], "heartbeat, operational");
    assert_eq!(document[2]["protocol"], "j1939");
}

#[test]
fn log_by_identifier_ends_with_the_list() {
    let mut rig = Rig::with("jn2101");
    rig.done("--node 10 set heartbeat-interval-time=500ms");
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, None, false);
    let text = rig.done("log - --by-id --decode --seconds 3");
    let row = text
        .lines()
        .find(|line| line.contains(" 70A "))
        .expect("a row");
    assert!(
        row.contains(" 6      500.0  7F ") && row.ends_with("pre-operational"),
        "{text}"
    );
    assert!(!text.contains("can0"), "{text}");
}

#[test]
fn filters_show_the_frames_of_an_identifier_a_meaning_or_a_sensor() {
    const FRAMES: [&str; 8] = [
        "70A#05",
        "732#05",
        "18A#E803F401",
        "301#0002E803F401",
        "5FF#00620101000000",
        "18EEFF80#0100E0FF00810080",
        "18EA80FE#00EE00",
        "18EAFFFE#00EE00",
    ];
    let path = log("filtered", FRAMES.map(can_wire::text::frame));
    let mut rig = Rig::with("is2");
    for (options, shown) in [
        ("", &[0, 1, 2, 3, 4, 5, 6, 7][..]),
        ("--filter 70A", &[0]),
        ("--filter 70A,301", &[0, 3]),
        ("--filter 700:780 --filter 18EEFF80", &[0, 1, 5]),
        ("--filter 000~400", &[0, 1, 4, 5, 6, 7]),
        ("--filter heartbeat", &[0, 1]),
        ("--filter devicenet,is2,fsc", &[3, 4]),
        ("--node 10", &[0, 2]),
        ("--node 10 --filter heartbeat", &[0]),
        ("--mac 63", &[4]),
        ("--id 300", &[3]),
        ("--address 128", &[5, 6]),
    ] {
        let text = rig.done(&format!("decode {} {options}", path.display()));
        let lines: Vec<&str> = text.lines().collect();
        let starts: Vec<String> = shown
            .iter()
            .map(|place| format!("({place}.000000) can0 {}", FRAMES[*place]))
            .collect();
        let are_same = lines
            .iter()
            .zip(&starts)
            .all(|(line, start)| line.starts_with(start));
        assert!(are_same && lines.len() == starts.len(), "{options}: {text}");
    }
    let wrong = rig.tool(&format!("--node 200 decode {}", path.display()));
    assert_eq!(wrong.code, 2, "{wrong:?}");
}

#[test]
fn filtered_log_has_only_the_frames_of_the_filter() {
    let mut rig = Rig::with("jn2101");
    rig.done("--node 10 set heartbeat-interval-time=500ms");
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, None, false);
    let path = file("filtered-live.log");
    let out = rig.done(&format!(
        "log {} --filter heartbeat --seconds 3",
        path.display()
    ));
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(
        text.lines().all(|line| line.ends_with(" can0 70A#7F")),
        "{text}"
    );
    assert_eq!(text.lines().count(), 6, "{text}");
    assert!(out.starts_with("recorded 6 frames"), "{out}");
}
