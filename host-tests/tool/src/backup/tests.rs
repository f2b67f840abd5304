use super::*;

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
        assert!(error.contains(why), "{text}: {error}");
    }
}

#[test]
fn number_in_resolution_has_that_of_the_file() {
    let text = "[sensor]\nproduct = \"tiltix080\"\n[parameters]\nslope-long16-preset-value = \"12.3 deg\"\nresolution = \"0.1 deg\"\n";
    let backup = Backup::parse(text).unwrap();
    let (_, raw) = backup
        .values
        .iter()
        .find(|(entry, _)| entry.name.contains("preset-value"))
        .unwrap();
    assert_eq!(*raw, 123);
    assert!(Backup::parse(&text.replace("12.3", "12.34")).is_err());
}
