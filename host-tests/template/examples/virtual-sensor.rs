//! The sensor on a PC: `cargo run --example virtual-sensor -- --help`.

use clap::Parser;
use std::process::ExitCode;
use virtual_sensor::{Options, run_with};

fn main() -> ExitCode {
    match run_with(&mast::LISTING, &Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("mast: {failure}");
            ExitCode::FAILURE
        }
    }
}
