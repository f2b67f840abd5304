//! The program `virtual-sensor`: its command line, its files, its output and its end.

mod process;

use host_tests::python;
use plumbline::model::catalog::{PRODUCTS, Protocol};
use process::client::{BEL, Client};
use process::sensor::{Killed, PATIENCE, Sensor, fails};
use std::fs;
use std::io::Read;
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::time::Instant;
use stm32_sim::chip::Chip;

/// A path for a file of this test, which does not exist yet.
fn new_path(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    // Fails if it does not exist.
    let _ = fs::remove_file(&path);
    path
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

#[test]
fn sensor_reports_tilt_of_scene() {
    let sensor = Sensor::start(&["--scene", "tilt=12.34,-5.67"]);
    let mut client = Client::awake(&sensor);
    let end = Instant::now() + PATIENCE;
    loop {
        let (x, y) = client.poll();
        if (x - 1234).abs() <= 1 && (y + 567).abs() <= 1 {
            break;
        }
        assert!(Instant::now() < end, "{x} {y}");
    }
}

#[test]
fn log_has_candump_format_and_is_written_at_once() {
    let path = new_path("followed.log");
    let sensor = Sensor::start(&["--log", text(&path)]);
    let mut client = Client::awake(&sensor);
    client.poll();
    client.expect("R123456788", "Z");
    client.poll();
    // The log line is written before the client receives the frame, or just after.
    let end = Instant::now() + PATIENCE;
    let log = loop {
        let log = fs::read_to_string(&path).expect("it is there");
        if log.lines().rev().take(2).any(|line| line.contains(" 301#")) && log.contains("#R8") {
            break log;
        }
        assert!(Instant::now() < end, "{log}");
    };
    let mut last = 0.0;
    for line in log.lines() {
        let fields: Vec<&str> = line.split(' ').collect();
        let [time, "can0", _] = fields[..] else {
            panic!("{line}");
        };
        let time = time
            .strip_prefix('(')
            .and_then(|time| time.strip_suffix(')'))
            .expect("(time)");
        assert_eq!(
            time.split_once('.').map(|(_, fraction)| fraction.len()),
            Some(6),
            "{line}"
        );
        let time: f64 = time.parse().expect("a number");
        assert!(time >= last, "{line}");
        last = time;
    }
    let now = std::time::UNIX_EPOCH
        .elapsed()
        .expect("a clock")
        .as_secs_f64();
    assert!((now - last).abs() < 60.0);
    assert!(log.contains(" can0 300#00\n") && log.contains(" can0 12345678#R8\n"));
    assert!(log.contains(" can0 301#FF"));
}

#[test]
fn save_is_written_to_store_file() {
    let path = new_path("saved.store");
    let sensor = Sensor::start(&["--store", text(&path)]);
    let mut client = Client::awake(&sensor);
    client.say("t300550534156" /* 50h 'S' 'A' 'V' */);
    client.find(BEL);
    client.say("t30055053415645" /* 50h 'S' 'A' 'V' 'E' */);
    client.find("t301250");
    let stored = fs::read(&path).expect("it is there");
    assert!(stored.iter().any(|byte| *byte != 0xFF));
    drop(sensor);
    // Starts again with the same file.
    let sensor = Sensor::start(&["--store", text(&path)]);
    Client::awake(&sensor).poll();
}

/// It must exit with this code and one sentence that contains these words.
#[track_caller]
fn assert_fails(arguments: &[&str], code: i32, words: &[&str]) {
    let output = fails(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
    for word in words {
        assert!(
            error.contains(word),
            "{arguments:?}: {error:?} lacks {word:?}"
        );
    }
    assert!(
        !error.contains("panicked") && !error.contains("RUST_BACKTRACE"),
        "{error}"
    );
    assert!(output.stdout.is_empty(), "{arguments:?}");
}

#[test]
fn wrong_command_line_lists_valid_values() {
    assert_fails(&["--model", "is3"], 2, &["is3", "is1", "is2"]);
    let rates = "10, 20, 50, 62.5, 100, 125, 250, 500, 800, 1000";
    for rate in ["33", "0", "fast", "nan", "-125"] {
        assert_fails(&[&format!("--bus-rate={rate}")], 2, &[rates]);
    }
    assert_fails(&["--scene", "tilt=1"], 2, &["tilt=X,Y"]);
    assert_fails(&["--scene", "tilt=80,80"], 2, &["80,80", "sines"]);
    assert_fails(&["--scene", "tilt=91,0"], 2, &["-90 to 90"]);
    assert_fails(&["--nonsense"], 2, &["--nonsense"]);
    let metal = ["--model", "is1d", "--article", "PR-23020-30"];
    assert_fails(
        &metal,
        2,
        &[
            "is1d has no article PR-23020-30",
            "its articles are IS1D 00 P20 (PR-23050-30)",
            "PR-23020-30 is an article of is1dm, is1tk",
        ],
    );
}

#[test]
fn every_article_of_catalogue_can_be_chosen() {
    for product in PRODUCTS {
        for article in product.articles() {
            for wanted in [article.name, article.number] {
                let sensor = Sensor::start(&["--model", product.name, "--article", wanted]);
                let Protocol::Fsc(_) = product.protocol else {
                    continue;
                };
                let mut client = Client::awake(&sensor);
                client.say("t300103");
                // The digits of the order number (G20), as a little-endian number.
                let digits = article.number.chars().filter(char::is_ascii_digit);
                let number: u32 = digits.collect::<String>().parse().expect("digits");
                let number = format!("{:08X}", number.swap_bytes());
                let reply = client.find("t301803");
                assert_eq!(&reply[9..17], number, "{} {wanted}", product.name);
            }
        }
    }
}

#[test]
fn unusable_files_are_named() {
    let scene = new_path("bad.csv");
    fs::write(&scene, "t_s,ax_g,ay_g,az_g\n0,0,0,1\n0,0,0,1\n").expect("a folder");
    let place = format!("{}:3: ", text(&scene));
    assert_fails(
        &["--scene", text(&scene)],
        1,
        &[&place, "the time must rise"],
    );
    let nowhere = new_path("no").join("such");
    let nowhere = text(&nowhere);
    assert_fails(&["--scene", nowhere], 1, &["cannot read", nowhere]);
    assert_fails(&["--log", nowhere], 1, &["cannot write the log", nowhere]);
    let read = "cannot read the firmware image";
    assert_fails(&["--elf", nowhere], 1, &[read, nowhere]);
    let built = fs::read(image("is2")).expect("it was just built");
    // Machine 62 is x86-64; the other file has its first segment in RAM (ELF-32: header of 52 bytes, p_paddr at 12).
    let machine = [&built[..18], &[62, 0], &built[20..]].concat();
    let ram = [&built[..64], &[0, 0, 0, 0x20], &built[68..]].concat();
    for (name, bytes, words) in [
        ("garbage.elf", b"no image".to_vec(), "not an ELF file"),
        ("machine.elf", machine, "another processor"),
        ("ram.elf", ram, "0x20000000"),
    ] {
        let path = new_path(name);
        fs::write(&path, bytes).expect("a folder");
        assert_fails(&["--elf", text(&path)], 1, &[read, text(&path), words]);
    }
}

#[test]
fn damaged_program_ends_with_one_sentence() {
    let built = fs::read(image("is2")).expect("it was just built");
    // From 400h on, each half-word is DEDEh: permanently undefined.
    let damaged = [&built[..0x400], &[0xDE; 0x2000], &built[0x2400..]].concat();
    let path = new_path("damaged.elf");
    fs::write(&path, damaged).expect("a folder");
    assert_fails(
        &["--elf", text(&path)],
        1,
        &["the firmware is2 stopped at 0x0800", "UNDEFINED"],
    );
}

/// The image of a model for the Blue Pill.
fn image(model: &str) -> PathBuf {
    image_for(Chip::F103, model)
}

fn image_for(chip: Chip, model: &str) -> PathBuf {
    let mut images = stm32_sim::firmware::build(chip).expect("it builds");
    images.remove(model).expect("an image of this name")
}

#[test]
fn image_of_other_model_is_refused() {
    for (model, other) in [("is1", "is2"), ("is2", "is2d"), ("is1d", "is1")] {
        let image = image(other);
        let sentence = format!("is an image of the model {other}, not of {model}");
        assert_fails(
            &["--model", model, "--elf", text(&image)],
            2,
            &[text(&image), &sentence],
        );
    }
}

#[cfg(unix)]
#[test]
fn flashed_image_answers_like_host_build() {
    Chip::ALL.into_iter().for_each(answers_like_host_build);
}

#[cfg(unix)]
fn answers_like_host_build(chip: Chip) {
    let log = new_path(&format!("flashed-{chip:?}.log"));
    let image = image_for(chip, "is2");
    let mut sensor = Sensor::start(&[
        "--elf",
        text(&image),
        "--scene",
        "tilt=12.34,-5.67",
        "--log",
        text(&log),
    ]);
    let mut client = Client::awake(&sensor);
    let end = Instant::now() + PATIENCE;
    loop {
        let (x, y) = client.poll();
        if (x - 1234).abs() <= 5 && (y + 567).abs() <= 5 {
            break;
        }
        assert!(Instant::now() < end, "{x} {y}");
    }
    let now = std::time::UNIX_EPOCH.elapsed().expect("a clock");
    assert_eq!(sensor.interrupt(), Some(0));
    // No violation of the reference manual.
    assert_eq!(sensor.errors(), "");
    let log = fs::read_to_string(&log).expect("it is there");
    let stamps: Vec<f64> = log
        .lines()
        .filter_map(|line| line.strip_prefix('(')?.split_once(')')?.0.parse().ok())
        .collect();
    assert!(stamps.len() > 2 && stamps.is_sorted(), "{log}");
    assert!(stamps.iter().all(|at| *at <= now.as_secs_f64() + 0.01));
}

/// The store of the Nucleo has two sectors of 16 KiB; a shorter one is the start of the first sector.
#[cfg(unix)]
#[test]
fn image_for_the_nucleo_keeps_the_parameters_of_a_short_store() {
    let store = new_path("sectors.store");
    let mut sensor = Sensor::start(&["--store", text(&store)]);
    let mut client = Client::awake(&sensor);
    // The cyclic time, 777 ms.
    client.say("t3003250903");
    client.find("t301225");
    client.say("t30055053415645");
    assert_eq!(client.find("t301250"), "t30125002");
    assert_eq!(sensor.interrupt(), Some(0));
    assert_eq!(fs::read(&store).expect("it is there").len(), 2048);

    let image = image_for(Chip::F446, "is2");
    for _ in 0..2 {
        let mut sensor = Sensor::start(&["--elf", text(&image), "--store", text(&store)]);
        let mut client = Client::awake(&sensor);
        client.say("t300115");
        assert_eq!(client.find("t301415"), "t301415020903");
        client.say("t30055053415645");
        client.find("t301250");
        assert_eq!(sensor.interrupt(), Some(0));
        assert_eq!(sensor.errors(), "");
        assert_eq!(fs::read(&store).expect("it is there").len(), 32_768);
    }
}

#[cfg(unix)]
#[test]
fn unusable_store_is_named_and_sensor_continues() {
    let nowhere = new_path("no").join("such");
    let foreign = new_path("foreign.store");
    fs::write(&foreign, [b'x'; 5000]).expect("a folder");
    for store in [&nowhere, &foreign] {
        let mut sensor = Sensor::start(&["--store", text(store)]);
        let mut client = Client::awake(&sensor);
        client.say("t30055053415645");
        // CmdParamError and EEPROMError, and factory values.
        assert_eq!(client.find("t301250"), "t3012500F");
        assert_eq!(sensor.interrupt(), Some(0));
        let expected = format!("virtual-sensor: cannot use the store {}: ", text(store));
        assert!(sensor.errors().starts_with(&expected));
    }
    assert_eq!(fs::read(&foreign).expect("it is there"), [b'x'; 5000]);
}

#[test]
fn store_of_another_sensor_is_refused() {
    let store = new_path("shared.store");
    let first = Sensor::start(&["--store", text(&store)]);
    assert_fails(
        &["--store", text(&store)],
        1,
        &[text(&store), "another program uses it"],
    );
    drop(first);
    Client::awake(&Sensor::start(&["--store", text(&store)]));
}

#[cfg(unix)]
#[test]
fn endless_store_is_damaged_memory() {
    let sensor = Sensor::start(&["--store", "/dev/zero"]);
    let mut client = Client::awake(&sensor);
    client.say("t300102");
    // EEPROMError, and factory values.
    assert_eq!(client.find("t301202"), "t30120207");
}

#[test]
fn model_name_can_be_written_in_capitals() {
    let sensor = Sensor::start(&["--model", "IS2D"]);
    let mut client = Client::awake(&sensor);
    client.poll();
}

#[test]
fn truncated_store_is_damaged_memory() {
    let store = new_path("short.store");
    fs::write(&store, "P").expect("a folder");
    let sensor = Sensor::start(&["--store", text(&store)]);
    let mut client = Client::awake(&sensor);
    client.say("t300102");
    // EEPROMError, and factory values.
    assert_eq!(client.find("t301202"), "t30120207");
}

#[cfg(target_os = "linux")]
#[test]
fn full_disk_ends_program_with_one_sentence() {
    let mut sensor = Sensor::start(&["--log", "/dev/full"]);
    let mut client = Client::open(&sensor);
    client.say("t1230");
    assert_eq!(sensor.exit_code(), Some(1));
    let errors = sensor.errors();
    assert!(
        errors.starts_with("virtual-sensor: cannot write the log /dev/full: "),
        "{errors}"
    );
}

#[test]
fn port_in_use_is_named() {
    let sensor = Sensor::start(&[]);
    let address = format!("127.0.0.1:{}", sensor.port);
    assert_fails(&["--listen", &address], 1, &["cannot listen at", &address]);
    assert_fails(&["--listen", "nonsense"], 1, &["cannot listen at nonsense"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_exits_cleanly_with_only_address_printed() {
    let mut sensor = Sensor::start(&[]);
    let mut client = Client::awake(&sensor);
    client.poll();
    assert_eq!(sensor.interrupt(), Some(0));
    assert_eq!(sensor.rest(), Vec::<String>::new());
    assert_eq!(sensor.errors(), "");
    let mut rest = Vec::new();
    // The connection ends, with or without an error.
    let _ = client.stream.read_to_end(&mut rest);
    assert!(rest.is_empty());
}

#[test]
fn python_can_connects_and_polls() {
    let log = new_path("python-can.log");
    let mut arguments = vec!["--log", text(&log)];
    if cfg!(unix) {
        arguments.push("--pty");
    }
    let mut sensor = Sensor::start(&arguments);
    let socket = sensor.channel();
    let mut script = vec![
        "--log".into(),
        text(&log).to_owned(),
        socket.clone(),
        socket,
    ];
    if cfg!(unix) {
        let line = sensor.line();
        script.push(
            line.strip_prefix("slcan ")
                .expect("slcan /dev/...")
                .to_owned(),
        );
    }
    let script: Vec<&str> = script.iter().map(String::as_str).collect();
    python::run("smoke.py", &["can", "serial"], &script);
}

#[cfg(unix)]
#[test]
fn status_line_is_shown_on_terminal() {
    use rustix::fs::{Mode, OFlags};
    use rustix::process::{Pid, Signal, kill_process};
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    use rustix::termios::tcgetattr;
    use std::process::Stdio;
    let screen =
        openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).expect("a terminal");
    grantpt(&screen).expect("a terminal");
    unlockpt(&screen).expect("a terminal");
    let path = ptsname(&screen, Vec::new()).expect("a terminal");
    let output = rustix::fs::open(
        path.as_c_str(),
        OFlags::RDWR | OFlags::NOCTTY,
        Mode::empty(),
    )
    .expect("it is there");
    let before = format!("{:?}", tcgetattr(&screen).expect("a terminal"));
    let child = process::sensor::program()
        .args(["--listen", "127.0.0.1:0", "--scene", "tilt=30,-10"])
        .stdin(Stdio::null())
        .stdout(output)
        .spawn()
        .expect("the program starts");
    let mut child = Killed(child);
    let mut screen = fs::File::from(screen);
    let mut shown = String::new();
    // Reads until all of these have been shown in this order.
    let mut wait_for = |shown: &mut String, texts: &[&str]| {
        let end = Instant::now() + PATIENCE;
        let mut from = shown.len();
        for text in texts {
            while !shown[from..].contains(text) {
                assert!(Instant::now() < end, "{text} is not in {shown}");
                let mut buffer = [0; 4096];
                let length = screen.read(&mut buffer).expect("a terminal");
                *shown += std::str::from_utf8(&buffer[..length]).unwrap_or_default();
            }
            from += shown[from..].find(text).unwrap_or_default();
        }
    };
    wait_for(
        &mut shown,
        &[
            "slcan socket://127.0.0.1:",
            "\n",
            "30.00°",
            "-10.00°",
            "clients 0",
        ],
    );
    let port = shown["slcan socket://127.0.0.1:".len()..]
        .lines()
        .next()
        .unwrap_or_default();
    let client = TcpStream::connect(format!("127.0.0.1:{}", port.trim_end())).expect("it listens");
    wait_for(&mut shown, &["clients 1"]);
    drop(client);
    wait_for(&mut shown, &["clients 0"]);
    assert!(shown.starts_with("slcan socket://127.0.0.1:"));
    assert!(shown.contains("is2 ") && shown.contains("run") && shown.contains("kbit/s"));
    kill_process(Pid::from_child(&child.0), Signal::INT).expect("it runs");
    assert_eq!(child.0.wait().expect("a child").code(), Some(0));
    assert_eq!(
        format!("{:?}", tcgetattr(&screen).expect("a terminal")),
        before
    );
    let mut rest = [0; 65536];
    let length = screen.read(&mut rest).expect("a terminal");
    assert!(rest[..length].ends_with(b"\n"));
    // Every mode that a line switches off is on again at its end.
    shown += &String::from_utf8_lossy(&rest[..length]);
    assert_eq!(
        shown.matches("\x1b[?7l").count(),
        shown.matches("\x1b[?7h").count()
    );
}
