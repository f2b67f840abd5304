//! Firmware images: of the right model, damaged, and as a sensor on the bus.

use crate::process::client::Client;
use crate::process::sensor::{PATIENCE, Sensor};
use crate::{assert_fails, new_path, text};
use std::fs;
use std::path::PathBuf;
use std::time::Instant;
use stm32_sim::board::Board;

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

#[cfg(unix)]
#[test]
fn flashed_image_answers_like_host_build() {
    answers_like_host_build(Board::BluePill);
}

#[cfg(unix)]
#[test]
#[ignore = "other boards: `.ci/run boards`"]
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
