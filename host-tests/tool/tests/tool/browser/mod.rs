//! What only a browser can show: layout, colours, focus, the tree of a screen reader, the chart, files. One headless Chromium for all,
//! driven by chromedriver. Without them the test prints `skipped`; in a continuous integration run (`CI` is set) it fails.
//!
//! The logic of the page is tested in `tests/page-modules`, and the answers of the server in [`crate::serve`].

mod axe;
mod chromium;
mod colours;
mod keyboard;
mod reading;
mod use_of_a_sensor;

use chromium::Browser;
use std::panic::{AssertUnwindSafe, catch_unwind};

type Check = fn(&Browser);

/// The checks, each with a server of its own.
const CHECKS: [(&str, Check); 8] = [
    (
        "find",
        use_of_a_sensor::page_finds_a_sensor_and_shows_its_angles,
    ),
    (
        "refusal",
        use_of_a_sensor::refused_value_is_told_where_the_user_looks,
    ),
    ("chart", use_of_a_sensor::chart_is_drawn_paused_and_saved),
    ("files", use_of_a_sensor::files_are_saved_and_opened),
    ("keyboard", keyboard::sensor_is_set_with_the_keyboard_alone),
    ("names", reading::every_control_has_a_name_in_both_languages),
    (
        "colours",
        colours::texts_of_both_colour_schemes_have_a_contrast_of_4_5_to_1,
    ),
    ("axe", axe::axe_finds_nothing_in_both_languages),
];

#[test]
#[ignore = "needs Chromium for half a minute: `.ci/long ignored`"]
fn page_passes_its_checks_in_a_browser() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let mut failed = Vec::new();
    for (name, check) in CHECKS {
        if catch_unwind(AssertUnwindSafe(|| check(&browser))).is_err() {
            failed.push(name);
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}
