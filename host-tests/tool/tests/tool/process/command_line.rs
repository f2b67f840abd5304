//! The command line: its help, its errors, and the examples of the document.

use super::sensor::{no_config, plumbline};
use clap::CommandFactory;
use plumbline_tool::cli::Cli;
use serde_json::Value;
use std::path::PathBuf;
use std::process::{Command, Stdio};

#[test]
fn completions_of_every_shell_are_printed() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = plumbline("", &format!("completions {shell}"));
        assert!(
            output.status.success() && output.stdout.len() > 1000,
            "{shell}"
        );
    }
}

#[test]
fn manual_page_of_every_command_has_its_options() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("manual");
    let _ = std::fs::remove_dir_all(&folder);
    let output = plumbline("", &format!("man --out {}", folder.display()));
    assert!(output.status.success(), "{output:?}");
    let main = std::fs::read_to_string(folder.join("plumbline.1")).expect("the page");
    assert!(main.contains(".TH plumbline 1"), "{main}");
    assert_eq!(
        plumbline("", "man").stdout,
        main.as_bytes(),
        "the page that is printed"
    );
    let program = Cli::command();
    for command in program.get_subcommands() {
        let name = command.get_name();
        let printed = plumbline("", &format!("man {name}"));
        assert!(printed.status.success(), "{printed:?}");
        let page = String::from_utf8_lossy(&printed.stdout).into_owned();
        let file = std::fs::read_to_string(folder.join(format!("plumbline-{name}.1")));
        assert_eq!(page, file.expect("the page of a command"), "{name}");
        for option in command.get_arguments().filter_map(clap::Arg::get_long) {
            let option = format!("\\-\\-{}", option.replace('-', "\\-"));
            assert!(page.contains(&option), "{name} {option}: {page}");
        }
    }
    let output = plumbline("", "man nonsense");
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("plumbline --help"), "{message}");
}

#[test]
fn error_with_json_is_a_document() {
    for (port, arguments, exit, code) in [
        ("demo:is2", "--json nonsense", 2, "bad-usage"),
        ("demo:is2", "--json --rate 5 get", 2, "bad-usage"),
        ("demo:is2", "--json set cyclic-time=0", 2, "out-of-range"),
        ("demo:is2", "--json --id 310 get", 3, "no-answer"),
        ("nonexistent0", "--json get", 4, "no-adapter"),
        ("slcan:", "--json get", 2, "unknown-port"),
        ("slcan://", "--json get", 2, "unknown-port"),
        ("slcan://localhost", "--json get", 2, "unknown-port"),
        ("slcan://localhost:", "--json get", 2, "unknown-port"),
        ("slcan://:11898", "--json get", 2, "unknown-port"),
        ("socket://localhost:0", "--json get", 2, "unknown-port"),
        ("slcan://localhost:99999", "--json get", 2, "unknown-port"),
    ] {
        let output = plumbline(port, arguments);
        assert_eq!(output.status.code(), Some(exit), "{arguments}: {output:?}");
        let document: Value = serde_json::from_slice(&output.stdout).expect("one document");
        let error = &document["error"];
        assert_eq!(error["code"], code, "{document}");
        assert!(
            error["message"]
                .as_str()
                .is_some_and(|text| text.len() > 20)
        );
    }
}

#[test]
fn negative_time_is_a_wrong_value_and_no_unknown_option() {
    for (arguments, part) in [
        ("watch --seconds -1", "--seconds is a time of 0 to"),
        ("log - --seconds -1", "--seconds is a time of 0 to"),
        ("record x.csv --seconds -1", "--seconds is a time of 0 to"),
        ("watch --every -1", "-1 is not in 1..=60000"),
        ("record x.csv --every -1", "-1 is not in 1..=60000"),
    ] {
        let output = plumbline("demo:is2", arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {output:?}");
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(message.contains(part), "{arguments}: {message}");
    }
}

#[test]
fn port_without_a_target_names_the_form() {
    for (port, part) in [
        ("slcan:", "for example slcan:/dev/ttyACM0"),
        ("slcan://localhost", "write slcan://HOST:PORT"),
    ] {
        let output = plumbline(port, "get");
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(message.contains(part), "{port}: {message}");
    }
}

#[test]
fn closed_output_does_not_panic() {
    for arguments in [
        &["completions", "bash"][..],
        &["man"],
        &["get"],
        &["--json", "get"],
        &["--json", "watch", "--seconds", "3"],
    ] {
        // The pipe is closed before the program starts.
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let mut command = Command::new(env!("CARGO_BIN_EXE_plumbline"));
        command
            .env("PLUMBLINE_PORT", "demo:is2")
            .env("PLUMBLINE_CLOCK", "bus")
            .env("PLUMBLINE_CONFIG", no_config())
            .args(arguments)
            .stdout(writer)
            .stderr(Stdio::piped());
        let child = command.spawn().expect("the program starts");
        let output = child.wait_with_output().expect("the program ends");
        assert_eq!(output.status.code(), Some(4), "{arguments:?} {output:?}");
    }
}

/// The command lines of the document.
fn documented() -> Vec<&'static str> {
    let document = include_str!("../../../README.md");
    let lines = document
        .lines()
        .filter_map(|line| line.strip_prefix("plumbline "));
    lines.collect()
}

#[test]
fn document_shows_every_command() {
    let commands = Cli::command();
    for command in commands.get_subcommands() {
        let name = command.get_name();
        let is_shown = documented()
            .iter()
            .any(|line| line.split(' ').any(|word| word == name));
        assert!(is_shown, "{name}");
    }
}

#[test]
fn every_command_line_of_the_document_works() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("document");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    for (file, product) in [("encoder.eds", "jn2101"), ("drive.eds", "tiltix080")] {
        let product = plumbline::model::catalog::find(product).expect("a product");
        let text = descriptors::describe(product).text;
        std::fs::write(folder.join(file), text).expect("a file");
    }
    for line in documented() {
        // A search of all identifiers takes 41 s; the server of the page runs until it is stopped.
        if line.contains("--search") || line.contains("serve") {
            continue;
        }
        // The log needs a board and a probe.
        if line.contains(" -- cargo") {
            continue;
        }
        let mut command = Command::new(env!("CARGO_BIN_EXE_plumbline"));
        let mut words: Vec<&str> = line.split(' ').collect();
        let port = match () {
            () if words.contains(&"--node") => "demo:jn2101",
            () if words.contains(&"--mac") => "demo:tiltix080",
            () => "demo:is2",
        };
        command
            .env("PLUMBLINE_PORT", port)
            .env("PLUMBLINE_CLOCK", "bus")
            .env("PLUMBLINE_CONFIG", no_config())
            .current_dir(&folder);
        if line == "watch" {
            words.extend(["--seconds", "1"]);
        }
        if ["zero", "teach", "load-factory", "rate"]
            .iter()
            .any(|word| words.contains(word))
        {
            words.push("--yes");
        }
        // Without a terminal a question is answered with no.
        if words.contains(&"scan") {
            words.extend(["--port", "demo:jn2101"]);
        }
        let output = command.args(words).output().expect("the program starts");
        assert!(output.status.success(), "{line}: {output:?}");
    }
}
