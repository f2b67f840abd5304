//! The limits that the project has set for the images of the Blue Pill. They are written here as numbers, so that a new budget does not
//! change them.

use super::REPORTS;
use cost::Report;
use plumbline::model::catalog::PRODUCTS;

/// The longest time that a half-word takes (DS5319, flash memory characteristics), in ns.
const HALF_WORD: u64 = 70_000;

fn report(model: &str) -> &'static Report {
    let report = REPORTS.iter().find(|report| report.model == model);
    report.expect("it is measured")
}

/// The figure of a row, which the product must have.
#[track_caller]
fn figure(model: &str, row: &str) -> u64 {
    let figure = report(model).figure(row);
    figure.unwrap_or_else(|| panic!("{model} has no row {row}"))
}

/// Asserts that these rows of a product are at most `limit`.
#[track_caller]
fn assert_at_most(model: &str, rows: &[&str], limit: u64) {
    let above: Vec<String> = rows
        .iter()
        .map(|row| (row, figure(model, row)))
        .filter(|(_, figure)| *figure > limit)
        .map(|(row, figure)| format!("{row} {figure}"))
        .collect();
    assert!(above.is_empty(), "{model}, limit {limit}: {above:?}");
}

#[test]
fn is1_and_is2_answer_within_15_us() {
    let answers = ["sync_worst", "read_worst"];
    for model in ["is1", "is1d", "is2d"] {
        assert_at_most(model, &answers, 15_000);
    }
    let others = ["led_worst", "led_read_worst", "boot_worst"];
    assert_at_most("is2", &[&answers[..], &others].concat(), 15_000);
}

#[test]
fn jn2101_answers_within_20_us() {
    let rows = [
        "sync_worst",
        "read_worst",
        "heater_worst",
        "heater_read_worst",
        "led_worst",
        "led_read_worst",
        "boot_worst",
    ];
    assert_at_most("jn2101", &rows, 20_000);
}

#[test]
fn ims360_answers_within_22_us() {
    let rows = [
        "sync_worst",
        "read_worst",
        "led_worst",
        "led_read_worst",
        "boot_worst",
    ];
    assert_at_most("ims360", &rows, 22_000);
}

/// The scenario must contain changes of the heater of each heated product.
#[test]
fn each_heated_product_is_measured_while_its_heater_is_regulated() {
    let heated = PRODUCTS.iter().filter(|product| product.heater.is_some());
    let models: Vec<&str> = heated.map(|product| product.name).collect();
    // The others differ from these by constants only.
    let measured = REPORTS.iter().map(|report| report.model);
    let measured: Vec<&str> = measured.filter(|model| models.contains(model)).collect();
    assert_eq!(measured, ["is1tk", "is2tk", "jn2101"]);
    for model in measured {
        figure(model, "heater_worst");
        figure(model, "heater_read_worst");
    }
}

/// An answer while a save programs is late by at most the half-word that is being programmed.
#[test]
fn save_delays_an_answer_by_at_most_one_half_word() {
    for model in ["is2", "jn2101", "ims360"] {
        for (saving, otherwise) in [
            ("save_worst", "sync_worst"),
            ("save_read_worst", "read_worst"),
        ] {
            let limit = figure(model, otherwise) + HALF_WORD;
            assert_at_most(model, &[saving], limit);
        }
    }
}

#[test]
fn boot_up_message_is_sent_within_30_ms_and_first_angle_within_60_ms() {
    for model in ["is2", "jn2101"] {
        assert_at_most(model, &["boot_time"], 30_000_000);
        assert_at_most(model, &["first_angle"], 60_000_000);
    }
}

#[test]
fn images_fit_into_their_share_of_flash_and_ram() {
    for (model, flash) in [("is2", 19_000), ("jn2101", 29_500)] {
        assert_at_most(model, &["ram"], 6 * 1024 - 1);
        assert_at_most(model, &["flash"], flash);
    }
    // It must fit into a slot of an update over the bus.
    assert_at_most("ims360", &["ram"], 10 * 1024);
    assert_at_most("ims360", &["flash"], 51 * 1024);
}

/// At 500 kbit/s the intermission takes 6 us of the time of an answer.
#[test]
fn tiltix_answers_polls_within_20_us_beyond_the_intermission() {
    for model in ["tiltix080", "tiltix360"] {
        assert_at_most(model, &["sync_worst"], 26_000);
        assert_at_most(model, &["sync"], 350);
        assert_at_most(model, &["read_request"], 450);
        assert_at_most(model, &["flash"], 30 * 1024);
        assert_at_most(model, &["ram"], 8 * 1024);
    }
}
