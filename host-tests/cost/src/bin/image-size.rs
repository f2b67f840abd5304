//! Prints the size of every product's firmware image on both boards and fails when one exceeds its budget (`image_sizes.toml`).
//!
//! Build the images first: `cargo build-bluepill`, `cargo build-nucleo`.

use clap::Parser;
use cost::products::budgeted;
use plumbline::model::catalog::PRODUCTS;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use stm32_sim::image::Size;

/// Prints the size of every product's firmware image on both boards and compares it with its budget.
#[derive(Parser)]
struct Options {
    /// The target directory with the images.
    #[arg(long, default_value = "target")]
    target: PathBuf,
}

/// A board.
#[derive(Deserialize)]
struct Board {
    /// The compiler's target.
    target: String,
    /// The budget of each product. A product that differs from another one only by constants needs none.
    budgets: BTreeMap<String, Budget>,
}

/// The largest size of an image in bytes.
#[derive(Clone, Copy, Deserialize)]
struct Budget {
    flash: u64,
    /// Static RAM, without the stack.
    ram: u64,
}

/// Prints the size of one image; an error when it exceeds its budget.
fn check(path: &Path, budget: Option<Budget>) -> Result<(), String> {
    let elf = std::fs::read(path).map_err(|error| error.to_string())?;
    let size = Size::of(&elf).map_err(|error| error.to_string())?;
    println!("{size}  {}", path.display());
    // A linker script that was not found results in an image without code.
    if size.flash < 1024 {
        return Err("no image".into());
    }
    let Budget { flash, ram } = budget.ok_or("no budget")?;
    if size.flash > flash || size.ram > ram {
        return Err(format!("exceeds {flash} B flash, {ram} B RAM"));
    }
    Ok(())
}

fn main() -> ExitCode {
    let options = Options::parse();
    let boards: BTreeMap<String, Board> =
        toml::from_str(include_str!("../image_sizes.toml")).expect("the file is correct");
    let mut exit = ExitCode::SUCCESS;
    for board in boards.values() {
        let folder = options.target.join(&board.target).join("release");
        for product in PRODUCTS {
            let path = folder.join(product.name);
            let budgeted = budgeted(product.name, |name| board.budgets.contains_key(name));
            let budget = budgeted.and_then(|name| board.budgets.get(name));
            if let Err(error) = check(&path, budget.copied()) {
                eprintln!("{}: {error}", path.display());
                exit = ExitCode::FAILURE;
            }
        }
    }
    exit
}
