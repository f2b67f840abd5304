//! A CAN inclination sensor on a PC: see `virtual-sensor --help`.

use clap::Parser;
use std::process::ExitCode;
use virtual_sensor::program::{Failure, Program, run};

fn main() -> ExitCode {
    match run(&Program::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("virtual-sensor: {failure}");
            match failure {
                Failure::Usage(_) => ExitCode::from(2),
                Failure::Outside(_) => ExitCode::FAILURE,
            }
        }
    }
}
