//! Hostile files: the program reads them with few steps and little memory.

use super::*;
use crate::backup::Backup;
use crate::master::canopen::eds::sections::Section;
use std::marker::PhantomData;

#[test]
fn entries_with_the_same_place_and_title_get_short_names_in_few_steps() {
    let line = |place: usize| {
        format!(
            "Param{place} = 0,6,\"20 65 24 01 30 71\",0,0xC7,2,\"A\",\"\",\"\",0,9,0,1,1,1,0,0,0,0,0,0;\n"
        )
    };
    let text: String = (1..=MOST).map(line).collect();
    let sheet = parsed(format!("[Params]\n{text}").as_bytes()).unwrap();
    let names: Vec<&str> = sheet.entries.iter().map(|entry| &entry.name[..]).collect();
    assert_eq!(names.len(), MOST);
    assert_eq!(names[..2], ["a", "object-101-1-113"]);
    assert_eq!(names[2], "object-101-1-113-2");
    assert_eq!(names[MOST - 1], format!("object-101-1-113-{}", MOST - 1));
    // Titles that are names of this kind.
    let mut entries = sheet.entries.clone();
    for (place, entry) in entries.iter_mut().enumerate() {
        entry.name = match place {
            0..10_000 => format!("object-101-1-113-{place}"),
            _ => String::new(),
        };
    }
    let tried = make_unique(&mut entries);
    assert!(tried <= 2 * MOST, "{tried}");
    let different: HashSet<&str> = entries.iter().map(|entry| &entry.name[..]).collect();
    assert_eq!(different.len(), MOST);
    let text = text + &line(MOST + 1);
    let why = parsed(format!("[Params]\n{text}").as_bytes()).unwrap_err();
    assert!(why.contains("20000"), "{why}");
}

/// Says whether a type can be cloned: the inherent constant takes precedence over the constant of the trait.
struct Probe<T>(PhantomData<T>);

trait Fallback {
    const IS_CLONE: bool = false;
}

impl<T> Fallback for Probe<T> {}

impl<T: Clone> Probe<T> {
    const IS_CLONE: bool = true;
}

#[test]
fn section_as_long_as_a_file_is_not_copied_for_its_sub_indices() {
    const { assert!(Probe::<String>::IS_CLONE && !Probe::<Section>::IS_CLONE) };
    let mut text =
        "[2000]\nParameterName=Curve\nObjectType=8\nDataType=5\nAccessType=rw\nCompactSubObj=254\n"
            .to_owned();
    for place in 0..8000 {
        text.push_str(&format!("k{place}={}\n", "x".repeat(1000)));
    }
    let sheet = parsed(text.as_bytes()).unwrap();
    assert_eq!(sheet.entries.len(), 254);
    assert_eq!(sheet.entries[253].name, "curve-254");
}

#[test]
fn long_line_and_too_many_sections_are_refused() {
    let entry = "[2000]\nDataType=5\nAccessType=rw\nParameterName=";
    let line = |length: usize| parsed(format!("{entry}{}", "x".repeat(length)).as_bytes());
    assert!(line(1024 - "ParameterName=".len()).is_ok());
    let why = line(1025 - "ParameterName=".len()).unwrap_err();
    assert!(why.contains("line 4 is too long"), "{why}");
    let sections: String = (0..=3 * MOST).map(|place| format!("[{place}]\n")).collect();
    assert!(parsed(sections.as_bytes()).unwrap_err().contains("20000"));
    // Entries that are left out count too.
    let mut text = String::new();
    for index in 0x2000..0x2100 {
        text.push_str(&format!(
            "[{index:04X}]\nObjectType=8\nDataType=8\nAccessType=rw\nCompactSubObj=254\n"
        ));
    }
    assert!(parsed(text.as_bytes()).unwrap_err().contains("20000"));
}

/// A file with this text that is filled up to this length.
fn filled(text: &str, length: u64) -> tempfile::NamedTempFile {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(&file, text).unwrap();
    file.as_file().set_len(length).unwrap();
    file
}

#[test]
fn data_sheet_that_is_too_long_is_refused() {
    let file = filled(FOREIGN, FOREIGN.len() as u64);
    assert!(read(file.path()).is_ok());
    let file = filled(FOREIGN, LONGEST + 1);
    let failure = read(file.path()).unwrap_err();
    assert_eq!(failure.code(), "bad-file");
    assert!(failure.to_string().contains("it is too long"), "{failure}");
}

#[test]
fn data_sheet_with_too_many_entries_is_refused() {
    let object = |index: usize| {
        let index = 0x2000 + index;
        format!(
            "[{index:X}]\nParameterName=Curve {index}\nObjectType=8\nDataType=6\nAccessType=rw\nCompactSubObj=250\n"
        )
    };
    let text = |objects: usize| (0..objects).map(object).collect::<String>();
    assert!(parsed(text(MOST / 250).as_bytes()).is_ok());
    let why = parsed(text(MOST / 250 + 1).as_bytes()).unwrap_err();
    assert!(why.contains("more than 20000"), "{why}");
}

#[test]
fn backup_that_is_too_long_is_refused() {
    let file = filled("[sensor]\nproduct = \"is2\"\n[parameters]\n", (1 << 20) + 1);
    let failure = Backup::read(file.path()).unwrap_err();
    assert_eq!(failure.code(), "bad-file");
    assert!(failure.to_string().contains("it is too long"), "{failure}");
}
