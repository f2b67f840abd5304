//! Prints the cost of the flashed images: see `cost --help`, and the library for the definition of each row.

use clap::Parser;
use clap::builder::PossibleValuesParser;
use cost::budgets::Budgets;
use cost::products::{self, MeasuredProduct};
use cost::{Report, measure_with, tables};
use plumbline::model::catalog::PRODUCTS;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::rc::Rc;
use stm32_sim::cortex_m::timing::{End, Timing};
use stm32_sim::elf::Image;
use stm32_sim::firmware;

/// Measures the images on a simulated microcontroller: memory, instructions, and on the Blue Pill times.
#[derive(Parser)]
struct Options {
    /// Measure only this model [default: all that have budgets of their own]
    #[arg(long, value_parser = PossibleValuesParser::new(PRODUCTS.iter().map(|product| product.name)))]
    model: Option<String>,

    /// Measure the image of the model for the Nucleo: bytes and instructions of is2, jn2101 and ims360
    #[arg(long, requires = "model")]
    nucleo: bool,

    /// Measure this image of the model instead of building it
    #[arg(long, value_name = "FILE", requires = "model")]
    elf: Option<PathBuf>,

    /// Print JSON, with the exact definition of each row
    #[arg(long, conflicts_with = "markdown")]
    json: bool,

    /// Print the figures as a Markdown table
    #[arg(long)]
    markdown: bool,

    /// Count the fastest cycles that the manuals permit, instead of the slowest
    #[arg(long)]
    fastest: bool,
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cost: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), Box<dyn Error>> {
    let budgets = Budgets::of_the_project()?;
    let products: Vec<MeasuredProduct> = match &options.model {
        Some(model) => products::of_model(model, options.nucleo)
            .into_iter()
            .collect(),
        None => products::all(|model| budgets.has(model)),
    };
    let end = if options.fastest {
        End::Best
    } else {
        End::Worst
    };
    let reports = reports(&products, options.elf.as_deref(), end)?;
    if options.json {
        println!("{:#}", tables::json(&reports, &budgets));
    } else if options.markdown {
        print!("{}", tables::markdown(&reports));
    } else {
        println!("{}", tables::CONDITIONS);
        for report in &reports {
            println!("\n{}", tables::text(report, &budgets).trim_end());
        }
    }
    for report in &reports {
        eprintln!(
            "{}: {:.0} million simulated instructions per second on this computer",
            report.model, report.speed
        );
    }
    Ok(())
}

/// Measures each model, with the given image or with a new build.
fn reports(
    products: &[MeasuredProduct],
    elf: Option<&Path>,
    end: End,
) -> Result<Vec<Report>, Box<dyn Error>> {
    let mut built = BTreeMap::new();
    let mut reports = Vec::new();
    for product in products {
        let path = match elf {
            Some(path) => path.to_owned(),
            None => {
                let images = match built.entry(product.chip) {
                    Entry::Occupied(images) => images.into_mut(),
                    Entry::Vacant(place) => {
                        let on_board = products.iter().filter(|one| one.chip == product.chip);
                        let names: Vec<_> = on_board.map(|one| one.name).collect();
                        place.insert(firmware::build(product.chip, &names)?)
                    }
                };
                let image = images.get(product.name);
                image
                    .ok_or_else(|| format!("there is no image {}", product.name))?
                    .clone()
            }
        };
        let bytes = std::fs::read(&path)
            .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        let image = Image::parse(&bytes)
            .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        if image.chip() != product.chip {
            let chip = product.chip.facts().name;
            return Err(format!("{} is not an image for the {chip}", path.display()).into());
        }
        reports.push(measure_with(
            *product,
            Rc::new(image),
            Timing::MANUALS.at(end),
        )?);
    }
    Ok(reports)
}
