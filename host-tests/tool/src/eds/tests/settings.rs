//! The entries of a CANopen data sheet that are settings, so that a backup has them and `restore` writes them.

use super::*;

#[test]
fn process_data_and_commands_are_no_settings() {
    let variable = |index: &str, more: &str| {
        format!("[{index}]\nParameterName=o{index}\nDataType=6\nAccessType=rw\n{more}")
    };
    let mut text = String::new();
    // Parameters, among them the resolution and a preset of CiA 410.
    for index in ["1029", "2000", "6000", "6011"] {
        text += &variable(index, "PDOMapping=0\n");
    }
    // Store, time stamps, NMT start-up, the state of a node.
    for index in [
        "1010", "1011", "1012", "1013", "1F51", "1F80", "1F81", "1F82", "1F83",
    ] {
        text += &variable(index, "");
    }
    // A control word, a set value, outputs, and what the maker calls process data.
    text += &variable("6040", "PDOMapping=1\n");
    text += &variable("60FF", "PDOMapping=0x1\n");
    text += &variable("6200", "ObjectType=8\nCompactSubObj=2\nPDOMapping=1\n");
    text += &variable("6411", "PDOMapping=0\n").replace("=rw", "=RWW");
    // A measured value.
    text += &variable("6010", "PDOMapping=1\n").replace("=rw", "=ro");
    let sheet = parsed(text.as_bytes()).unwrap();
    let names = |entries: Vec<&Entry>| -> Vec<String> {
        entries.iter().map(|entry| entry.name.clone()).collect()
    };
    let settings = names(sheet.settings().collect());
    assert_eq!(settings, ["o1029", "o2000", "o6000", "o6011"]);
    let expected = [
        "o1010", "o1011", "o1012", "o1013", "o1f51", "o1f80", "o1f81", "o1f82", "o1f83", "o6040",
        "o60ff", "o6200-1", "o6200-2", "o6411",
    ];
    assert_eq!(names(sheet.commands().collect()), expected);
    // They can be written by name.
    assert!(
        sheet
            .commands()
            .all(|entry| entry.readable && entry.writable)
    );
}
