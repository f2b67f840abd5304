//! Calibrates a unit: computes its calibration from a six-position measurement and writes it into its store file.

use clap::Parser;
use clap::builder::PossibleValuesParser;
use host_tests::calibrate::{Units, calibration};
use host_tests::store_file;
use plumbline::model::catalog::{PRODUCTS, find};
use std::path::PathBuf;
use std::process::ExitCode;

/// Computes the calibration of a unit from a six-position measurement and writes it into a store file. The parameters in the
/// store file do not change.
#[derive(Parser)]
struct Options {
    /// The product
    #[arg(long, value_parser = PossibleValuesParser::new(PRODUCTS.iter().map(|product| product.name)))]
    model: String,
    /// The serial number of the unit, as read over the bus. A unit with another serial number ignores the calibration. The
    /// virtual sensor has the serial number 1
    #[arg(long)]
    serial: u32,
    /// The measurement: a CSV file with the columns up,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps,temp_c (without a gyroscope
    /// up,ax_g,ay_g,az_g,temp_c) and a row for each axis up and down (+x, -x, ... -z); six more rows at another temperature give the
    /// drift. A row `# element adxl355` names another measuring element than the ISM330DHCX
    #[arg(long, value_name = "FILE")]
    positions: PathBuf,
    /// The store file of a Blue Pill or a Nucleo, as for `virtual-sensor --store`; it is created if it does not exist
    #[arg(long, value_name = "FILE")]
    store: PathBuf,
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), String> {
    let name = options.positions.display().to_string();
    let text = bench::file::read_text(&options.positions)
        .map_err(|error| format!("cannot read {name}: {error}"))?;
    let calibration = calibration(&name, &text)?;
    let product = find(&options.model).ok_or("there is no such product")?;
    store_file::calibrate(product.owner(options.serial), &calibration, &options.store)?;
    println!("{}", Units::from(&calibration));
    println!(
        "The calibration of {} with serial number {} is in {}.",
        product.name,
        options.serial,
        options.store.display()
    );
    Ok(())
}
