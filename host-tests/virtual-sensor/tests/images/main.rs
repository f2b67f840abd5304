//! The program `virtual-sensor` with the images that are flashed (`--elf`, `--bootloader`).

mod image;
mod update;

// The test `server` runs the same modules with the model built for the PC.
#[path = "../server/both/mod.rs"]
mod both;
// The test `server` uses all of it.
#[allow(dead_code)]
#[path = "../server/process/mod.rs"]
mod process;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::LazyLock;
use stm32_sim::board::Board;
use stm32_sim::firmware::build;

/// The options for the image of a product for the Blue Pill.
fn firmware(model: &str) -> Vec<&'static str> {
    static BUILT: LazyLock<BTreeMap<String, PathBuf>> =
        LazyLock::new(|| build(Board::BluePill, &["is2", "jn2101"]).expect("it builds"));
    vec!["--elf", process::text(&BUILT[model])]
}
