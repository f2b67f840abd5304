//! `soak`: each product for hours of random use.

use clap::Parser;
use plumbline::time::Duration;
use soak::stand::kinds;
use soak::steps;
use soak::use_case::UseCase;
use std::process::ExitCode;

/// Uses each product at random, in simulated time, with faults of bus, supply and memory. Fails if a sensor does not answer, loses a stored
/// setting, or shows a wrong angle. The same seed gives the same run.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// The simulated time of each sensor in minutes
    #[arg(long, default_value_t = 60)]
    minutes: u32,
    /// The seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only these sensors; a name with /j1939 is one in its second protocol
    #[arg(long, value_delimiter = ',', default_values_t = kinds())]
    product: Vec<String>,
    /// Gives the nodes this number of random inputs instead, without a bus: frames, samples, times, events, faults of the memory
    #[arg(long, conflicts_with_all = ["minutes", "product", "verbose"])]
    steps: Option<u64>,
    /// Prints each step
    #[arg(long)]
    verbose: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Some(number) = arguments.steps {
        return match steps::run(number, arguments.seed) {
            Ok(done) => {
                println!(
                    "{} random steps: {} frames, {} saves, {} power cuts",
                    done.steps, done.sent, done.saves, done.power_cuts
                );
                ExitCode::SUCCESS
            }
            Err(repeat) => {
                eprintln!("{repeat}");
                ExitCode::FAILURE
            }
        };
    }
    let mut is_failed = false;
    for kind in &arguments.product {
        match soak(kind, &arguments) {
            Ok(done) => println!("{kind}: {done}"),
            Err(failure) => {
                eprintln!("{kind}: {failure}");
                is_failed = true;
            }
        }
    }
    ExitCode::from(u8::from(is_failed))
}

/// Runs one sensor. Returns what happened, or what did not hold.
fn soak(kind: &str, arguments: &Arguments) -> Result<String, String> {
    let repeat = format!(
        "soak --product {kind} --seed {} --minutes {}",
        arguments.seed, arguments.minutes
    );
    let mut sensor = UseCase::new(kind, arguments.seed).map_err(|failure| failure.to_string())?;
    sensor.is_verbose = arguments.verbose;
    let end = Duration::minutes(arguments.minutes.into());
    let mut steps = 0_u64;
    while sensor.time() < end {
        steps += 1;
        sensor.step().map_err(|(step, failure)| {
            let seconds = sensor.time().ticks() / 1_000_000;
            let frames = sensor.last_frames().join("\n");
            format!("step {steps} ({step:?}) at {seconds} s: {failure}. This repeats it: {repeat}. The last frames:\n{frames}")
        })?;
    }
    Ok(format!(
        "{steps} steps in {} min: {}",
        arguments.minutes, sensor.counts
    ))
}
