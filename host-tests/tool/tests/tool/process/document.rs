//! The examples of the document of the tool.

use super::command_line::PLAN;
use super::elf::program_behind_a_bootloader;
use super::sensor::no_config;
use clap::CommandFactory;
use plumbline_tool::cli::Cli;
use std::path::PathBuf;
use std::process::Command;

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
    let is1 = plumbline::model::catalog::find("is1").expect("a product");
    let database = descriptors::describe(is1).text;
    std::fs::write(folder.join("crane.dbc"), database).expect("a file");
    let list =
        "[[send]]\nframe = \"70A#05\"\nevery = 1000\n\n[[send]]\nframe = \"80#\"\nevery = 10\n";
    std::fs::write(folder.join("plc.toml"), list).expect("a file");
    std::fs::write(folder.join("plan.toml"), PLAN).expect("a file");
    let program = program_behind_a_bootloader();
    std::fs::write(folder.join("is2.elf"), program).expect("a file");
    for line in documented() {
        // A search of all identifiers takes 41 s; the server of the page runs until it is stopped.
        if line.contains("--search") || line.contains("serve") {
            continue;
        }
        // A bridge runs until it is stopped: `super::bridge` has a broker.
        if line.contains("bridge ") {
            continue;
        }
        // The demonstration has no bootloader: the test `images` has one.
        if line.starts_with("update") {
            continue;
        }
        // The demonstration is never at rest.
        if line.starts_with("align") || line.contains("replace ") {
            continue;
        }
        // The log needs a board and a probe.
        if line.contains(" -- probe-rs") {
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
        // The demonstration has sent nothing into this log.
        if words.contains(&"decode") || words.contains(&"replay") {
            std::fs::write(folder.join("bus.log"), "(0.5) can0 300#01\n").expect("a file");
        }
        // They end by Ctrl-C.
        let endless = [
            "watch",
            "log - --decode",
            "log - --decode --by-id",
            "send plc.toml",
            "replay bus.log --speed 2 --loop",
        ];
        if endless.contains(&line) {
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
