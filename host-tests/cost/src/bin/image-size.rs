//! Prints the size of every product's firmware image on all boards, and of the bootloaders. Fails when one grew by more than 10 % over the recorded size
//! (`image_sizes.toml`), exceeds the flash of the Blue Pill, or has an instruction that an erratum of its processor makes unsafe.
//!
//! Build the images first: `cargo build-bluepill`, `cargo build-nucleo`, `cargo build-nucleo-f103rb`.

use clap::Parser;
use cost::limits;
use cost::recorded::grew;
use plumbline::model::catalog::{PRODUCTS, base};
use plumbline::update::layout::LAYOUTS;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use stm32_sim::board::Board;
use stm32_sim::firmware;
use stm32_sim::image::Size;

/// Prints the size of every product's firmware image on all boards, and compares it with the recorded one.
#[derive(Parser)]
struct Options {
    /// The target directory with the images.
    #[arg(long, default_value = "target")]
    target: PathBuf,

    /// Record the sizes.
    #[arg(long)]
    record: bool,

    /// Only check the instructions of these ELF files.
    #[arg(long, num_args = 1.., value_name = "FILE")]
    check: Vec<PathBuf>,
}

/// The recorded sizes of each image, by board and product.
type Recorded = BTreeMap<String, BTreeMap<String, Bytes>>;

const FILE: &str = include_str!("../image_sizes.toml");

/// The head of the file.
const HEAD: &str = "\
# The recorded size of each firmware image in bytes, by board and product: flash, and static RAM without the stack.
# `cargo run --release --bin image-size -- --record` writes this file.
";

/// A size that is always permitted to grow.
const FEW: u64 = 64;

/// The name of the program that is no product.
const BOOTLOADER: &str = "bootloader";

/// A program of a board.
struct Program {
    name: &'static str,
    /// The name under which its size is recorded. The size of products that differ by constants only is recorded once.
    recorded: &'static str,
    /// The largest size in bytes, if it is not the linker script that limits it.
    limit: Option<u64>,
}

/// The programs of a board.
fn programs(board: Board) -> impl Iterator<Item = Program> {
    let is_bluepill = board == Board::BluePill;
    let products = PRODUCTS.iter().map(move |product| Program {
        name: product.name,
        recorded: base(product).unwrap_or(product).name,
        limit: is_bluepill.then(|| limits::flash(product)),
    });
    let name = board.facts().name;
    let has_bootloader = LAYOUTS.iter().any(|layout| layout.name == name);
    let bootloader = has_bootloader.then_some(Program {
        name: BOOTLOADER,
        recorded: BOOTLOADER,
        limit: is_bluepill.then_some(limits::BOOTLOADER),
    });
    products.chain(bootloader)
}

/// The size of an image in bytes.
#[derive(Clone, Copy, Deserialize, Serialize)]
struct Bytes {
    flash: u64,
    /// Static RAM, without the stack.
    ram: u64,
}

/// The error of a size, if any.
fn complaint(program: &Program, size: Bytes, recorded: Option<Bytes>) -> Option<String> {
    if let Some(limit) = program.limit
        && size.flash > limit
    {
        return Some(format!(
            "{} B of flash exceed the limit {limit} B",
            size.flash
        ));
    }
    // A new program has no recorded size yet.
    let recorded = recorded?;
    let (flash, ram) = (recorded.flash, recorded.ram);
    (grew(size.flash, flash, FEW) || grew(size.ram, ram, FEW))
        .then(|| format!("grew by more than 10 % over the recorded {flash} B flash, {ram} B RAM"))
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(complaints) => {
            complaints
                .iter()
                .for_each(|one| eprintln!("image-size: {one}"));
            ExitCode::from(u8::from(!complaints.is_empty()))
        }
        Err(error) => {
            eprintln!("image-size: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Prints the sizes; records them, or returns the complaints.
fn run(options: &Options) -> Result<Vec<String>, Box<dyn Error>> {
    if !options.check.is_empty() {
        let errors = options
            .check
            .iter()
            .filter_map(|path| firmware::check(path).err());
        return Ok(errors.map(|error| error.to_string()).collect());
    }
    let recorded: Recorded = toml::from_str(FILE)?;
    let mut measured = Recorded::new();
    let mut complaints = Vec::new();
    for board in Board::ALL {
        let folder = options.target.join(firmware::folder(board));
        let board_name = board.facts().name;
        for program in programs(board) {
            let path = folder.join(program.name);
            let place = path.display();
            let elf = std::fs::read(&path).map_err(|error| format!("{place}: {error}"))?;
            let size = Size::of(&elf).map_err(|error| format!("{place}: {error}"))?;
            println!("{size}  {place}");
            complaints.extend(firmware::check(&path).err().map(|error| error.to_string()));
            let Size { flash, ram } = size;
            let size = Bytes { flash, ram };
            let known = recorded.get(board_name);
            let known = known.and_then(|sizes| sizes.get(program.recorded));
            let error = complaint(&program, size, known.copied());
            complaints.extend(error.map(|error| format!("{place}: {error}")));
            let sizes = measured.entry(board_name.to_owned()).or_default();
            sizes.entry(program.recorded.to_owned()).or_insert(size);
        }
    }
    if options.record {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/image_sizes.toml");
        std::fs::write(path, format!("{HEAD}\n{}", toml::to_string(&measured)?))?;
        complaints.retain(|one| one.contains("limit") || one.contains("unsafe"));
    }
    Ok(complaints)
}
