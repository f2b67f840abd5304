//! The program `virtual-sensor` with the images that are flashed (`--elf`, `--bootloader`).

mod image;
mod update;

// The same as with the model built for the PC.
#[path = "../server/both/mod.rs"]
mod both;
#[allow(dead_code)] // the other tests use the rest
#[path = "../server/process/mod.rs"]
mod process;

/// The options for the image of a product for the Blue Pill.
fn firmware(model: &str) -> Vec<String> {
    let image = image::image(model);
    ["--elf".to_owned(), process::text(&image).to_owned()].into()
}
