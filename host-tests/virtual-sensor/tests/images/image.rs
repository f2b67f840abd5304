//! Firmware images: of the right model, damaged, and as a sensor on the bus.

use crate::process::client::{Client, advance};
use crate::process::control::{Control, start};
use crate::process::sensor::{PATIENCE, Sensor};
use crate::process::{assert_fails, new_path, text};
use serde_json::json;
use std::fs;
use std::path::PathBuf;
use std::time::Instant;
use stm32_sim::board::Board;
use stm32_sim::firmware;

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
pub fn image(model: &str) -> PathBuf {
    image_for(Board::BluePill, model)
}

pub fn image_for(board: Board, model: &str) -> PathBuf {
    let mut images = stm32_sim::firmware::build(board, &[model]).expect("it builds");
    images.remove(model).expect("an image of this name")
}

#[test]
fn image_of_other_model_is_refused() {
    for (model, other) in [("is1", "is2"), ("is2d", "is2"), ("is1d", "is1")] {
        let image = image(other);
        let sentence = format!("is an image of the model {other}, not of {model}");
        assert_fails(
            &["--model", model, "--elf", text(&image)],
            2,
            &[text(&image), &sentence],
        );
    }
}

#[test]
fn program_behind_a_bootloader_starts_and_a_bootloader_alone_waits() {
    let mut built = firmware::build(Board::BluePill, &["bootloader"]).expect("it builds");
    let program = firmware::build_behind_bootloader(Board::BluePill, &["jn2101"]);
    built.extend(program.expect("it builds"));
    let model = ["--model", "jn2101", "--bus-rate", "125"];
    let (bootloader, program) = (text(&built["bootloader"]), text(&built["jn2101"]));
    assert_fails(
        &[&model[..], &["--elf", program]].concat(),
        2,
        &["add --bootloader FILE"],
    );
    let alone = image("is2");
    assert_fails(
        &["--elf", text(&alone), "--bootloader", bootloader],
        2,
        &["--features behind-bootloader"],
    );
    let both = ["--bootloader", bootloader, "--elf", program];
    let sensor = Sensor::start(&[&model[..], &both].concat());
    let mut client = Client::open(&sensor);
    // 1000h:00 is the profile CiA 410 of the program.
    client.say("t60A84000100000000000");
    let reply = client.find("t58A8");
    assert_eq!(&reply[5..9], "4300", "{reply}");
    assert_eq!(&reply[13..17], "9A01", "{reply}");
    let alone = ["--bootloader", bootloader, "--clock", "client"];
    let sensor = Sensor::start(&[&model[..], &alone].concat());
    let mut client = Client::open(&sensor);
    // The bootloader listens at each bit rate in turn.
    let reply = (0..60).find_map(|_| {
        client.expect("t67F84000100000000000", "z");
        let (lines, _) = advance(&mut client, 100_000);
        lines.into_iter().find(|line| line.starts_with("t5FF8"))
    });
    let reply = reply.expect("a reply");
    // 1000h:00 is 0: it has no profile.
    assert_eq!(&reply[5..21], "4300100000000000", "{reply}");
}

#[cfg(unix)]
#[test]
fn flashed_image_answers_like_host_build() {
    answers_like_host_build(Board::BluePill);
}

#[cfg(unix)]
#[test]
#[ignore = "other boards: `.ci/long ignored`"]
fn flashed_images_of_the_nucleos_answer_like_host_build() {
    [Board::NucleoF103, Board::NucleoF446]
        .into_iter()
        .for_each(answers_like_host_build);
}

#[cfg(unix)]
fn answers_like_host_build(board: Board) {
    let log = new_path(&format!("flashed-{board:?}.log"));
    let image = image_for(board, "is2");
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
    assert!(stamps.iter().all(|at| *at <= now.as_secs_f64() + 1.0));
}

#[test]
fn image_for_another_processor_or_address_is_named() {
    let built = fs::read(image("is2")).expect("it was just built");
    // Machine 62 is x86-64; the other file has its first segment in RAM (ELF-32: header of 52 bytes, p_paddr at 12).
    let machine = [&built[..18], &[62, 0], &built[20..]].concat();
    let ram = [&built[..64], &[0, 0, 0, 0x20], &built[68..]].concat();
    for (name, bytes, words) in [
        ("machine.elf", machine, "another processor"),
        ("ram.elf", ram, "0x20000000"),
    ] {
        let path = new_path(name);
        fs::write(&path, bytes).expect("a folder");
        assert_fails(
            &["--elf", text(&path)],
            1,
            &["cannot read the firmware image", text(&path), words],
        );
    }
}

#[test]
#[ignore = "another measuring element: `.ci/long ignored`"]
fn fault_that_the_adxl355_of_an_image_cannot_have_is_refused() {
    let built = firmware::build_for_element(Board::BluePill, &["is2"], "adxl355");
    let built = built.expect("it builds");
    let image = ["--elf", text(&built["is2"])];
    let (_sensor, port) = start(&[&["--clock", "client"], &image[..]].concat());
    let mut control = Control::connect(port);
    for fault in ["silent", "stopped", "frozen"] {
        let request = json!({ "do": "accelerometer", "fault": fault });
        let (_, answer) = control.ask(&request.to_string());
        let error = format!("the ADXL355 of the simulated board has no fault {fault}");
        assert_eq!(answer, json!({ "error": error }));
    }
    control.ok(&json!({ "do": "accelerometer", "fault": "zero" }));
}

/// The store of the Nucleo has two sectors of 16 KiB; a shorter one is the start of the first sector.
#[cfg(unix)]
#[test]
#[ignore = "another board: `.ci/long ignored`"]
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

    let image = image_for(Board::NucleoF446, "is2");
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
