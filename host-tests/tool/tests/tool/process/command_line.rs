//! The command line: its help and its errors.

use super::elf::program_behind_a_bootloader;
use super::sensor::plumbline;
use clap::CommandFactory;
use plumbline_tool::cli::Cli;
use serde_json::Value;
use std::path::PathBuf;
use std::process::Stdio;

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
fn completions_offer_products_rates_and_parameters() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = plumbline("", &format!("completions {shell}"));
        let script = String::from_utf8_lossy(&output.stdout);
        let names = match shell {
            // Their scripts have no arguments without a name.
            "powershell" | "elvish" => &[][..],
            _ => &["tiltix360", "62.5", "cyclic-time", "auto", "filter="],
        };
        for name in names {
            assert!(script.contains(name), "{shell}: {name}");
        }
    }
}

#[test]
fn wrong_name_is_followed_by_the_one_that_was_probably_meant() {
    for (words, meant) in [
        ("--product is22 parameters", "Did you mean is2?"),
        ("get filtre", "Did you mean filter?"),
        ("set cyclictime=1s", "Did you mean cyclic-time?"),
        ("--rate 255 get", "Did you mean 250?"),
        ("rate 126", "Did you mean 125?"),
        ("man scna", "Did you mean scan?"),
        ("scna", "'scan'"),
        ("--json scna", "'scan'"),
        ("--json get filtre", "Did you mean filter?"),
    ] {
        let output = plumbline("demo:is2", words);
        assert_eq!(output.status.code(), Some(2), "{words}: {output:?}");
        let told = [output.stdout, output.stderr].concat();
        let told = String::from_utf8_lossy(&told);
        assert!(told.contains(meant), "{words}: {told}");
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

/// A command line of every command: the port, the words, and the exit code if it is not 0.
const ALL: &[(&str, &str, i32)] = &[
    ("demo:jn2101", "scan", 0),
    ("demo:is2", "parameters", 0),
    ("demo:is2", "get", 0),
    ("demo:is2", "--json get", 0),
    ("demo:is2", "set cyclic-time=300ms", 0),
    ("demo:is2", "save", 0),
    ("demo:is2", "load-factory --yes", 0),
    ("demo:is2", "zero --yes", 0),
    // The demonstration is never at rest.
    ("demo:is2", "align", 1),
    ("demo:jn2101", "teach --yes", 0),
    ("demo:is2", "restart", 0),
    ("demo:jn2101", "node-id 11", 0),
    ("demo:tiltix080", "mac 7", 0),
    ("demo:ims360/j1939", "--address 128 address 130", 0),
    ("demo:is2", "rate 500 --yes", 0),
    ("demo:is2", "label", 0),
    ("demo:is2", "raw 10", 0),
    ("demo:is2", "backup new.toml --yes", 0),
    ("demo:is2", "restore old.toml --yes", 0),
    // The demonstration has the values as delivered.
    ("demo:is2", "diff old.toml --exit-code", 1),
    ("demo:is2", "--json watch --seconds 3", 0),
    ("demo:is2", "record new.csv --seconds 1 --yes", 0),
    ("demo:jn2101", "log - --decode --seconds 1", 0),
    ("demo:is2", "--rate 250 replay bus.log", 0),
    ("", "decode bus.log", 0),
    ("", "decode bus.log --filter 000:7FF", 0),
    (
        "demo:is2",
        "--rate 250 send 123#01 --every 100 --seconds 1",
        0,
    ),
    ("demo:is2", "calibrate sides.csv", 0),
    ("demo:is2", "identity", 0),
    ("demo:is2", "serve --demo --listen 127.0.0.1:0", 0),
    ("", "image is2.elf -o new.plu", 0),
    ("", "key new own.key", 0),
    // The demonstration has no bootloader.
    ("demo:is2", "update new.plu", 1),
    // The sensor as delivered sends nothing by itself.
    ("demo:is2", "doctor --seconds 1 --rate 250", 1),
    ("demo:is2", "commission plan.toml", 0),
    ("demo:is2", "replace read old.toml --yes", 1),
    // A bridge without a broker goes on until its end.
    (
        "demo:jn2101",
        "bridge --mqtt mqtt://127.0.0.1:1 --buffer records --seconds 1",
        0,
    ),
    ("demo:is2", "ports", 0),
    ("demo:is2", "completions bash", 0),
];

/// A plan for the demonstration of an IS2.
pub const PLAN: &str =
    "[[sensor]]\nname = \"boom\"\nproduct = \"is2\"\nparameters.cyclic-time = 300\n";

#[test]
fn every_command_ends_quietly_if_nobody_reads_its_output() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("closed");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("old.toml");
    let path = file.display();
    assert!(
        plumbline("demo:is2", &format!("backup {path}"))
            .status
            .success()
    );
    let set = format!("set cyclic-time=300ms --file {path}");
    assert!(plumbline("demo:is2", &set).status.success());
    let sides = "up,ax_g,ay_g,az_g,temp_c\n+x,1,0,0,25\n-x,-1,0,0,25\n+y,0,1,0,25\n-y,0,-1,0,25\n+z,0,0,1,25\n-z,0,0,-1,25\n";
    std::fs::write(folder.join("sides.csv"), sides).expect("a file");
    let program = program_behind_a_bootloader();
    std::fs::write(folder.join("is2.elf"), program).expect("a file");
    std::fs::write(folder.join("plan.toml"), PLAN).expect("a file");
    std::fs::write(folder.join("bus.log"), "(1.5) can0 000#0100\n").expect("a file");
    let others = [("", "man", 0), ("", "--help", 0), ("", "get --help", 0)];
    for (port, words, code) in ALL.iter().copied().chain(others) {
        // The pipe is closed before the program starts.
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let mut command = super::sensor::command(port, "bus", words);
        command
            .current_dir(&folder)
            .stdout(writer)
            .stderr(Stdio::piped());
        let child = command.spawn().expect("the program starts");
        let output = child.wait_with_output().expect("the program ends");
        let notes = String::from_utf8_lossy(&output.stderr);
        // A command whose first line is its last one has succeeded, or tells its difference.
        let is_quiet = !notes.contains("output") && !notes.contains("panic");
        assert!(is_quiet, "{words}: {notes}");
        assert!(
            [0, code].map(Some).contains(&output.status.code()),
            "{words}: {output:?}"
        );
    }
    for command in Cli::command().get_subcommands() {
        let name = command.get_name();
        let is_listed = |words: &str| words.split(' ').any(|word| word == name);
        let mut all = ALL.iter().chain(&others);
        assert!(all.any(|(_, words, _)| is_listed(words)), "{name}");
    }
}

#[test]
fn help_of_a_command_shows_only_the_options_that_it_uses() {
    for (command, shown, hidden) in [
        ("ports", &["--json"][..], &["--port", "--node", "--eds"][..]),
        ("completions", &[], &["--port", "--json", "--yes"]),
        ("scan", &["--port", "--rate"], &["--node", "--product"]),
        (
            "log",
            &["--port", "--filter", "--product", "--id"],
            &["--config"],
        ),
        (
            "decode",
            &["--product", "--filter", "--node"],
            &["--port", "--rate"],
        ),
        ("replay", &["--port", "--filter", "--node"], &["--config"]),
        ("send", &["--port", "--rate"], &["--node", "--product"]),
        ("node-id", &["--node", "--port"], &["--mac", "--id"]),
        ("mac", &["--mac"], &["--node", "--id"]),
        ("calibrate", &["--product", "--json"], &["--port", "--node"]),
        ("get", &["--port", "--node", "--mac", "--id", "--eds"], &[]),
    ] {
        let output = plumbline("", &format!("{command} --help"));
        let help = String::from_utf8_lossy(&output.stdout);
        let has = |option: &&&str| help.split([' ', '\n']).any(|word| word == **option);
        assert_eq!(
            shown.iter().find(|own| !has(own)),
            None,
            "{command}: {help}"
        );
        assert_eq!(hidden.iter().find(has), None, "{command}: {help}");
    }
    // A hidden option is still accepted: scripts give the same options to all commands.
    let output = plumbline("demo:jn2101", "--node 10 scan");
    assert!(output.status.success(), "{output:?}");
}

#[test]
fn diff_with_exit_code_tells_whether_settings_differ() {
    let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("exit-code.toml");
    let _ = std::fs::remove_file(&file);
    let path = file.display();
    let code = |words: &str| plumbline("demo:is2", words).status.code();
    assert_eq!(code(&format!("backup {path}")), Some(0));
    for (options, same, different) in [
        ("--exit-code", 0, 1),
        ("", 0, 0),
        ("--json --exit-code", 0, 1),
    ] {
        let words = format!("diff {path} {options}");
        assert_eq!(code(words.trim_end()), Some(same), "{options}");
        let set = |value| format!("set cyclic-time={value} --file {path}");
        assert_eq!(code(&set("300ms")), Some(0));
        assert_eq!(code(words.trim_end()), Some(different), "{options}");
        assert_eq!(code(&set("250ms")), Some(0));
    }
    let output = plumbline("demo:is2", &format!("--json diff {path} --exit-code"));
    let document: Value = serde_json::from_slice(&output.stdout).expect("one document");
    assert_eq!(document, serde_json::json!({}));
}

#[test]
fn losses_of_a_data_sheet_are_told_also_without_a_sensor() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("damaged.eds");
    let text = include_str!("encoder.eds");
    let stray = "// terminator\n[3000sub1]\nObjectType=0x7\nDataType=0x0005\nAccessType=ro\n";
    std::fs::write(&path, format!("{text}\n{stray}")).expect("a file");
    let output = plumbline("", &format!("parameters --eds {}", path.display()));
    let notes = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{notes}");
    let line = format!("line {} of the data sheet is no", text.lines().count() + 2);
    for part in [&*line, "of the data sheet with a type"] {
        assert!(notes.contains(part), "{part}: {notes}");
    }
}
