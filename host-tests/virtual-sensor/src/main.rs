//! A CAN inclination sensor on a PC: see `virtual-sensor --help`.

use std::process::ExitCode;
use virtual_sensor::program::{Failure, Program, run};

fn main() -> ExitCode {
    match run(&Program::of_command_line(std::env::args_os())) {
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
