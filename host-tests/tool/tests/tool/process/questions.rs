//! Questions at a terminal and without one.

use super::sensor::plumbline;
use serde_json::Value;

const ZERO: &str = "--rate 250 --id 300 zero";

#[test]
fn question_without_a_terminal_is_shown_and_answered_with_no() {
    let output = plumbline("demo:is2", ZERO);
    let notes = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{notes}");
    let question = notes.lines().find(|line| line.contains("position zero? "));
    let question = question.unwrap_or_else(|| panic!("{notes}"));
    for part in ["is2", "identifier 300h", "angle-x", "--yes=zero"] {
        assert!(question.contains(part), "{part}: {notes}");
    }
}

#[test]
fn yes_with_names_answers_only_their_questions() {
    for (yes, code) in [
        ("--yes", 0),
        ("--yes=zero", 0),
        ("--yes=overwrite,zero", 0),
        ("--yes=overwrite", 2),
        ("--yes=nonsense", 2),
    ] {
        let output = plumbline("demo:is2", &format!("{yes} {ZERO}"));
        assert_eq!(output.status.code(), Some(code), "{yes}: {output:?}");
    }
}

#[test]
fn names_of_questions_follow_yes_without_an_equals_sign_after_the_command() {
    for (line, code) in [
        (format!("{ZERO} --yes zero"), 0),
        (format!("{ZERO} x --yes overwrite,zero"), 0),
        (format!("{ZERO} --yes overwrite"), 2),
        (format!("{ZERO} --yes nonsense"), 2),
        // The word is the command.
        ("--rate 250 --id 300 --yes zero".to_owned(), 0),
    ] {
        let output = plumbline("demo:is2", &line);
        assert_eq!(output.status.code(), Some(code), "{line}: {output:?}");
    }
}

#[test]
fn file_that_the_same_command_reads_is_not_overwritten_in_spite_of_a_yes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let plan = "[[sensor]]\nname = \"boom\"\nproduct = \"is2\"\n";
    for (name, text) in [
        ("old.toml", ""),
        ("plan.toml", plan),
        ("unit.toml", "product = \"is2\"\n"),
        ("is2.elf", ""),
    ] {
        std::fs::write(path(name), text).expect("a file");
    }
    let key = path("own.key");
    assert!(plumbline("", &format!("key new {key}")).status.success());
    let (old, unit, elf) = (path("old.toml"), path("unit.toml"), path("is2.elf"));
    let (state, dotted) = (path("plan.state.toml"), path("./old.toml"));
    std::fs::write(&state, "").expect("a file");
    for line in [
        format!("replace write {old} --report {old}"),
        format!("replace write {old} --report {dotted}"),
        format!("replace write {old} --store {old}"),
        format!("replace write {old} --report new --store new"),
        format!("commission {0} --report {0}", path("plan.toml")),
        format!("commission {} --report {state}", path("plan.toml")),
        format!("--product is2 identity --from {unit} --store {unit}"),
        format!("--product is2 identity --from {unit} --output {unit}"),
        format!("image {elf} -o {elf}"),
        format!("key show {key} -o {key}"),
        format!("key sign {elf} --key {key} -o {key}"),
    ] {
        let output = plumbline("demo:is2", &format!("--json --yes {line}"));
        let document: Value = serde_json::from_slice(&output.stdout).expect("one document");
        assert_eq!(document["error"]["code"], "same-file", "{line}: {document}");
        assert_eq!(output.status.code(), Some(2), "{line}");
    }
}

#[test]
fn word_after_yes_that_is_no_question_is_refused_with_the_names() {
    for line in ["backup a.toml --yes foo", "zero x --yes zero,foo"] {
        let output = plumbline("demo:is2", line);
        let notes = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{line}: {notes}");
        for part in ["'foo'", "data-sheet", "overwrite"] {
            assert!(notes.contains(part), "{line}: {notes}");
        }
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_at_a_question_ends_the_program_and_an_answer_goes_on() {
    use super::sensor::{command, terminal};
    use rustix::fs::{Mode, OFlags, open};
    use rustix::process::{Pid, Signal, kill_process};
    use std::fs::File;
    use std::io::{Read, Write};
    use std::process::Stdio;
    for (answer, code) in [
        (None, 130),
        (Some("y\n"), 0),
        (Some("Yes\n"), 0),
        (Some("j\n"), 0),
        (Some(" Ja \n"), 0),
        (Some("n\n"), 2),
        (Some("nein\n"), 2),
        (Some("yep\n"), 2),
        (Some("\n"), 2),
    ] {
        let (master, path) = terminal();
        let flags = OFlags::RDWR | OFlags::NOCTTY;
        let terminal = open(path.as_c_str(), flags, Mode::empty()).expect("it opens");
        let mut child = command("demo:is2", "bus", ZERO)
            .stdin(terminal)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let mut notes = child.stderr.take().expect("a pipe");
        let (mut text, mut byte) = (Vec::new(), [0]);
        while !text.ends_with(b"[y/N] ") {
            assert_eq!(notes.read(&mut byte).expect("it runs"), 1, "{text:?}");
            text.push(byte[0]);
        }
        let mut master = File::from(master);
        match answer {
            Some(answer) => master.write_all(answer.as_bytes()).expect("it is open"),
            None => kill_process(Pid::from_child(&child), Signal::INT).expect("it runs"),
        }
        notes.read_to_end(&mut text).expect("it ends");
        let output = child.wait_with_output().expect("it ends");
        let notes = String::from_utf8_lossy(&text);
        assert_eq!(output.status.code(), Some(code), "{answer:?}: {notes}");
    }
}
