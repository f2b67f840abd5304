//! The command line: the values of the options, the files that they name, and the errors of the program for wrong values.

use crate::process::client::Client;
use crate::process::sensor::Sensor;
use crate::process::{assert_fails, new_path, text};
use plumbline::model::catalog::{PRODUCTS, Protocol};
use std::fs;

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
            let lower_case = article.number.to_lowercase();
            for wanted in [article.name, article.number, &lower_case] {
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
fn model_name_can_be_written_in_capitals() {
    let sensor = Sensor::start(&["--model", "IS2D"]);
    let mut client = Client::awake(&sensor);
    client.poll();
}

#[test]
fn port_in_use_is_named() {
    let sensor = Sensor::start(&[]);
    let address = format!("127.0.0.1:{}", sensor.port);
    assert_fails(&["--listen", &address], 1, &["cannot listen at", &address]);
    assert_fails(&["--listen", "nonsense"], 1, &["cannot listen at nonsense"]);
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
    let path = new_path("garbage.elf");
    fs::write(&path, "no image").expect("a folder");
    assert_fails(
        &["--elf", text(&path)],
        1,
        &[read, text(&path), "not an ELF file"],
    );
}

#[test]
fn wrong_fault_lists_valid_values() {
    let values = "silent, frozen, stopped, zero, axis-x, axis-y, axis-z or clipping";
    for fault in [
        "accelerometer",
        "accelerometer=dead",
        "accelerometer=zero@-1",
        "silent",
    ] {
        assert_fails(&["--fault", fault], 2, &[fault, values]);
    }
}
