//! Prints the size of firmware images and fails when one exceeds its budget.

use clap::Parser;
use std::path::PathBuf;
use std::process::ExitCode;
use stm32_sim::image::Size;

/// Prints the size of firmware images in flash and RAM.
#[derive(Parser)]
struct Options {
    /// Largest size in flash, in bytes.
    #[arg(long, default_value_t = u64::MAX, hide_default_value = true)]
    flash: u64,
    /// Largest static RAM, in bytes.
    #[arg(long, default_value_t = u64::MAX, hide_default_value = true)]
    ram: u64,
    /// ELF files.
    #[arg(required = true)]
    images: Vec<PathBuf>,
}

fn main() -> ExitCode {
    let options = Options::parse();
    let mut exit = ExitCode::SUCCESS;
    for path in &options.images {
        let size = std::fs::read(path).map_err(|error| error.to_string());
        match size.and_then(|elf| Size::of(&elf).map_err(|error| error.to_string())) {
            Ok(size) => {
                println!("{size}  {}", path.display());
                if size.flash > options.flash || size.ram > options.ram {
                    eprintln!(
                        "{}: over its budget of {} B flash, {} B RAM",
                        path.display(),
                        options.flash,
                        options.ram
                    );
                    exit = ExitCode::FAILURE;
                }
                // A linker script that was not found results in an image without code.
                if size.flash < 1024 {
                    eprintln!("{}: no image", path.display());
                    exit = ExitCode::FAILURE;
                }
            }
            Err(error) => {
                eprintln!("{}: {error}", path.display());
                exit = ExitCode::FAILURE;
            }
        }
    }
    exit
}
