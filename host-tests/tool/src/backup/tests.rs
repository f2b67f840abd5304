use super::*;
use ::texts::Cause;
use plumbline::model::catalog::find;
#[cfg(unix)]
use std::path::PathBuf;

const FILE: &str = "[sensor]\nproduct = \"is2\"\nserial = 7\n[parameters]\ncyclic-time = \"0.1 s\"\nzero-x = -1.25\ncyclic-mode = 1\n";

#[test]
fn file_is_read_in_every_spelling_and_written_in_one() {
    let backup = Backup::parse(FILE).unwrap();
    assert_eq!(backup.serial, Some(7));
    let text = backup.text();
    for line in [
        "product = \"is2\"",
        "cyclic-time = \"100 ms\"",
        "zero-x = \"-1.25 deg\"",
        "cyclic-mode = \"on\"",
    ] {
        assert!(text.lines().any(|own| own == line), "{line}: {text}");
    }
    assert_eq!(Backup::parse(&text).unwrap().text(), text);
}

#[test]
fn default_identifiers_of_a_device_with_a_data_sheet_follow_its_node_id() {
    let data_sheet = "[DeviceInfo]\nProductName=Drive\n[1800]\nParameterName=TPDO\nObjectType=9\n\
                      [1800sub1]\nParameterName=COB-ID\nDataType=7\nAccessType=rw\nDefaultValue=$NODEID+0x40000180\n";
    let sheet = crate::eds::parse(data_sheet.as_bytes()).unwrap();
    let parse = |node: &str, cob_id: &str| {
        let text = format!(
            "[sensor]\nproduct = \"drive\"\nnode-id = {node}\n[parameters]\ncob-id = \"{cob_id}\"\n"
        );
        Backup::parse_with(&text, Some(&sheet))
    };
    for (cob_id, restored) in [("C000018Ah", 0xC000_01CD), ("4000019Ah", 0x4000_019A)] {
        let mut backup = parse("10", cob_id).unwrap();
        assert!(backup.text().contains("\nnode-id = 10\n"));
        backup.number_for(77);
        assert_eq!(backup.values[0].1, restored, "{cob_id}");
    }
    for node in ["0", "128", "-1", "\"10\"", "1e3"] {
        let why = parse(node, "180h").unwrap_err().to_string();
        assert!(why.contains("node-id"), "{node}: {why}");
    }
}

#[test]
fn hostile_file_is_refused() {
    for (text, why) in [
        ("", "[sensor]"),
        ("[sensor]\nproduct = 1\n[parameters]", "product"),
        ("[sensor]\nproduct = \"is9\"\n[parameters]", "is9"),
        ("[sensor]\nproduct = \"is2\"", "[parameters]"),
        (
            "[sensor]\nproduct = \"is2\"\n[parameters]\nnonsense = 1",
            "nonsense",
        ),
        (
            "[sensor]\nproduct = \"is2\"\n[parameters]\nserial-number = 1",
            "serial-number",
        ),
        (
            "[sensor]\nproduct = \"is2\"\n[parameters]\ncyclic-time = [1]",
            "cyclic-time",
        ),
        (
            "[sensor]\nproduct = \"is2\"\n[parameters]\ncyclic-time = \"0 ms\"",
            "1..65535 ms",
        ),
        (
            "[sensor]\nproduct = \"is2\"\n[parameters]\nzero-x = \"1e400\"",
            "zero-x",
        ),
        (
            "[sensor]\nproduct = \"is2\"\n[parameters]\nzero-x = nan",
            "zero-x",
        ),
        (
            "[sensor]\nproduct = \"is2\"\n[parameters]\ncyclic-time = 1\ncyclic-time = 2",
            "duplicate",
        ),
        ("\u{0}", ""),
    ] {
        let error = Backup::parse(text)
            .err()
            .unwrap_or_else(|| panic!("{text}"));
        let error = error.to_string();
        assert!(error.contains(why), "{text}: {error}");
    }
}

#[test]
fn number_uses_the_resolution_of_the_file() {
    let text = "[sensor]\nproduct = \"tiltix080\"\n[parameters]\nslope-long16-preset-value = \"12.3 deg\"\nresolution = \"0.1 deg\"\n";
    let mut backup = Backup::parse(text).unwrap();
    let (_, raw) = backup
        .values
        .iter()
        .find(|(entry, _)| entry.name.contains("preset-value"))
        .unwrap();
    assert_eq!(*raw, 123);
    assert!(Backup::parse(&text.replace("12.3", "12.34")).is_err());
    // 12.3 deg cannot be a number of 1 deg.
    let before = backup.text();
    let wrong = backup.set("resolution", "1 deg").unwrap_err();
    assert!(matches!(wrong, NumberError::First(_)), "{wrong}");
    assert_eq!(backup.text(), before);
}

/// An empty folder for a test.
#[cfg(unix)]
fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("plumbline-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

#[cfg(unix)]
#[test]
fn file_behind_a_symbolic_link_is_written_and_keeps_its_permissions() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = folder("link");
    let (file, link) = (folder.join("crane.toml"), folder.join("link.toml"));
    std::fs::write(&file, "old").unwrap();
    std::fs::set_permissions(&file, PermissionsExt::from_mode(0o640)).unwrap();
    symlink(&file, &link).unwrap();
    write_file(&link, "new").unwrap();
    assert!(link.is_symlink());
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "new");
    let mode = std::fs::metadata(&file).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o640);
    // A new file can be read by everybody whom the settings of the user permit, as other new files.
    let (new, usual) = (folder.join("new.toml"), folder.join("usual"));
    write_file(&new, "new").unwrap();
    std::fs::write(&usual, "usual").unwrap();
    let mode = |path| std::fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&new), mode(&usual));
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 4);
    std::fs::remove_dir_all(folder).unwrap();
}

#[cfg(unix)]
#[test]
fn file_that_is_not_regular_is_refused_before_it_fills_the_memory() {
    let folder = folder("special");
    let (pipe, labels) = (folder.join("pipe"), folder.join("labels.toml"));
    // Nobody writes to the pipe, so the opening would wait without end.
    for pipe in [&pipe, &labels] {
        let made = std::process::Command::new("mkfifo").arg(pipe).status();
        assert!(made.unwrap().success());
    }
    for path in [
        Path::new("/dev/zero"),
        Path::new("/dev/null"),
        &pipe,
        &folder,
    ] {
        for failure in [
            Backup::read(path).unwrap_err(),
            crate::eds::read(path).unwrap_err(),
        ] {
            assert_eq!(
                (failure.code(), failure.kind().exit_code()),
                ("bad-file", 2)
            );
        }
    }
    let failure = crate::labels::Labels::open(Some(&folder)).unwrap_err();
    assert!(
        failure.to_string().contains("not a regular file"),
        "{failure}"
    );
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn file_that_cannot_be_written_names_the_next_step() {
    let failure = write_file(Path::new("/nonexistent/x.toml"), "").unwrap_err();
    assert!(
        failure
            .to_string()
            .contains("choose another file or folder"),
        "{failure}"
    );
}

#[test]
fn control_characters_of_a_file_are_not_in_a_message() {
    for text in [
        "[sensor]\nproduct = \"is2\"\n[parameters]\n\"\\u001b]0;x\\u0007\" = 1",
        "[sensor]\nproduct = \"is2\"\n[parameters]\n\"\\u001b]0;x\\u0007\" = [1]",
        "[sensor]\nproduct = \"\\u001b]0;x\\u0007\"\n[parameters]",
        "[sensor]\nproduct = \"is2\"\n[parameters]\nzero-x = \"1\\u001bdeg\"",
        "[sensor]\n\"\\u001b\" = 1\n\"\\u001b\" = 1",
    ] {
        let why = Backup::parse(text).unwrap_err().to_string();
        assert!(!why.chars().any(char::is_control), "{text} {why:?}");
    }
}

#[test]
fn value_of_a_file_that_is_not_permitted_is_told_from_one_that_is_none() {
    let mut backup = Backup::parse(FILE).unwrap();
    for (name, text, code, part) in [
        (
            "cyclic-time",
            "99999999",
            "out-of-range",
            "99999999 ms is not permitted: cyclic-time takes 1..65535 ms",
        ),
        (
            "cyclic-time",
            "99999999999999999999999 ms",
            "out-of-range",
            "cyclic-time takes 1..65535 ms",
        ),
        (
            "zero-x",
            "999",
            "out-of-range",
            "999.00 deg is not permitted: zero-x takes -90.00..90.00 deg",
        ),
        ("zero-x", "91", "out-of-range", "91.00 deg is not permitted"),
        (
            "zero-x",
            "1 Hz",
            "bad-value",
            "its unit is deg; it takes -90.00..90.00 deg",
        ),
        (
            "serial-number",
            "1",
            "read-only",
            "`plumbline get serial-number`",
        ),
        ("nonsense", "1", "unknown-name", "\"nonsense\""),
    ] {
        let wrong = backup.set(name, text).unwrap_err();
        assert_eq!(wrong.code(), code, "{name} {text} {wrong}");
        assert!(wrong.to_string().contains(part), "{name} {text} {wrong}");
    }
    // The resolution of the sensor is the unit, the range stays that of the table.
    let text = "[sensor]\nproduct = \"tiltix080\"\n[parameters]\nresolution = \"1 deg\"\n";
    let mut backup = Backup::parse(text).unwrap();
    let wrong = backup
        .set("slope-long16-preset-value", "99999 deg")
        .unwrap_err();
    assert!(
        wrong.to_string().starts_with("99999 deg is not permitted"),
        "{wrong}"
    );
}

/// The name of the setting at an address.
fn name_at(sheet: &Sheet, index: u16, sub: u8) -> String {
    let wanted = crate::sheet::Address::Object { index, sub };
    let found = sheet.settings().find(|own| own.address == wanted);
    found
        .unwrap_or_else(|| panic!("no {index:04X}h:{sub}"))
        .name
        .clone()
}

/// What the object dictionary refuses with 0609 0030h, 0604 0041h and 0604 0042h (CiA 301, 7.5.2).
#[test]
fn cob_id_and_mapping_that_the_sensor_refuses_are_refused_in_a_file() {
    for (product, changes, refused) in [
        // The TPDOs of node 10; their identifiers are fixed.
        ("jn2101", &[(0x1005, 0, "18Ah")][..], true),
        ("jn2101", &[(0x1005, 0, "28Ah")], true),
        ("jn2101", &[(0x1005, 0, "80h")], false),
        ("ims360", &[(0x1800, 1, "200h")], false),
        ("ims360", &[(0x1800, 1, "600h")], false),
        ("ims360", &[(0x1800, 1, "601h")], true),
        ("ims360", &[(0x1800, 1, "80000601h")], false),
        ("ims360", &[(0x1014, 0, "700h")], false),
        ("ims360", &[(0x1014, 0, "701h")], true),
        ("ims360", &[(0x1A00, 0, "9")], true),
        ("ims360", &[(0x1A00, 0, "1")], false),
        ("ims360", &[(0x1A00, 1, "30000108h")], false),
        ("ims360", &[(0x1A00, 1, "30000110h")], true),
        ("ims360", &[(0x1A00, 1, "12345678h")], true),
        // 3 entries of which the last is empty; 96 bits.
        ("ims360", &[(0x1A00, 0, "3")], true),
        (
            "ims360",
            &[(0x1A00, 3, "61100020h"), (0x1A00, 0, "3")],
            true,
        ),
        ("ims360", &[(0x1A00, 3, "61100020h")], false),
        // Entries of a TPDO without objects.
        (
            "ims360",
            &[(0x1A01, 1, "61100020h"), (0x1A01, 0, "1")],
            false,
        ),
    ] {
        let sheet = Sheet::of(find(product).unwrap());
        let factory = |entry: &Entry| Some((entry.clone(), entry.factory?));
        let mut backup = Backup {
            values: sheet.settings().filter_map(factory).collect(),
            ..Backup::of(&sheet)
        };
        let node = sheet.parameter(tables(sheet.product).unwrap().node_id);
        let node = &node.unwrap().name;
        backup.assign(&[format!("{node}=10")]).unwrap();
        let changes = changes
            .iter()
            .map(|(index, sub, value)| format!("{}={value}", name_at(&sheet, *index, *sub)));
        let changes: Vec<String> = changes.collect();
        let assigned = backup.assign(&changes);
        assert_eq!(
            assigned.is_err(),
            refused,
            "{product} {changes:?} {assigned:?}"
        );
    }
}
