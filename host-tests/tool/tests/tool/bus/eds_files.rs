//! Backups of devices that are known only from their data sheet (`--eds`).

use super::files::file;
use super::rig::Rig;
use plumbline::model::catalog::find;
use serde_json::json;

/// The data sheet of a JN2101 as a file, with its text 3000h as "Label", and with the resolution 6000h as process data.
fn options(name: &str) -> String {
    let text = descriptors::describe(find("jn2101").unwrap()).text;
    let is_in = |part: &str, index: &str| part.starts_with(index);
    let parts = text.split('[').map(|part| match part {
        part if is_in(part, "3000]") => part.replace("ParameterName=", "ParameterName=Label;"),
        part if is_in(part, "6000]") => part.replace("PDOMapping=0", "PDOMapping=1"),
        part => part.to_owned(),
    });
    let changed = parts.collect::<Vec<_>>().join("[");
    assert_eq!(changed.len(), text.len() + "Label;".len());
    let eds = file(name);
    std::fs::write(&eds, changed).unwrap();
    format!("--node 10 --eds {}", eds.display())
}

#[test]
fn text_object_with_the_name_of_a_key_of_the_file_is_in_its_own_section() {
    let options = options("eds-texts.eds");
    let mut rig = Rig::with("jn2101");
    let path = file("eds-texts.toml");
    let shown = path.display();
    let key = rig.json(&format!("{options} get label"))["label"]["value"].clone();
    let key = key.as_str().unwrap();
    rig.done(&format!("{options} backup {shown}"));
    let read = || std::fs::read_to_string(&path).unwrap();
    let text = read();
    let (sensor, rest) = text.split_once("\n[texts]\n").unwrap();
    assert!(!sensor.contains("label"), "{text}");
    assert!(
        rest.starts_with(&format!("label = \"{key}\"\n\n[parameters]\n")),
        "{text}"
    );
    // The file is read by all commands, and a change keeps the text.
    assert_eq!(rig.json(&format!("{options} diff {shown}")), json!({}));
    rig.done(&format!(
        "{options} set tpdo1-event-timer=20 --file {shown}"
    ));
    assert!(read().contains(rest.lines().next().unwrap()), "{}", read());
    rig.done(&format!("{options} restore {shown}"));
    assert_eq!(rig.json(&format!("{options} diff {shown}")), json!({}));
}

#[test]
fn process_data_is_left_out_of_a_backup_and_never_restored() {
    let options = options("eds-process-data.eds");
    let mut rig = Rig::with("jn2101");
    let path = file("eds-process-data.toml");
    let ended = rig.tool(&format!("{options} backup {}", path.display()));
    assert_eq!(ended.code, 0, "{ended:?}");
    assert!(ended.notes.contains("entries are skipped"), "{ended:?}");
    let text = std::fs::read_to_string(&path).unwrap();
    let last = text.lines().last().unwrap();
    assert!(
        last.starts_with("# Skipped, ") && last.contains("resolution"),
        "{text}"
    );
    assert!(!text.contains("resolution = "), "{text}");
    rig.done(&format!("{options} set resolution=100"));
    rig.done(&format!("{options} restore {}", path.display()));
    let read = rig.json(&format!("{options} get resolution"));
    assert_eq!(read["resolution"]["raw"], 100);
}
