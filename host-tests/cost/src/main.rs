//! Prints the cost of the flashed images: see `cost --help`, and the library for the definition of each row.

use clap::Parser;
use clap::builder::PossibleValuesParser;
use cost::products::{self, MeasuredProduct};
use cost::recorded::Recorded;
use cost::scenario::Phases;
use cost::{Report, documents, limits, measure, tables};
use plumbline::model::catalog::PRODUCTS;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::rc::Rc;
use stm32_sim::cortex_m::timing::{End, Timing};
use stm32_sim::elf::Image;
use stm32_sim::firmware;

/// Measures the images on a simulated microcontroller: memory, instructions, and on the Blue Pill times.
#[derive(Parser)]
struct Options {
    /// Measure only this model [default: all that do not differ from another one by constants only]
    #[arg(long, value_parser = PossibleValuesParser::new(PRODUCTS.iter().map(|product| product.name)))]
    model: Option<String>,

    /// Measure the image of the model for the Nucleo: bytes and instructions of is2, jn2101 and ims360
    #[arg(long, requires = "model")]
    nucleo: bool,

    /// Measure this image of the model instead of building it
    #[arg(long, value_name = "FILE", requires = "model")]
    elf: Option<PathBuf>,

    /// Fail if a figure exceeds a limit, or grew by more than 10 % over the recorded one
    #[arg(long)]
    check: bool,

    /// Record the figures of all products, and write them into the documents
    #[arg(long, conflicts_with_all = ["model", "quick", "fastest", "check"])]
    record: bool,

    /// Send messages at few phases only: no sweep over saves, boot, heater and LEDs
    #[arg(long)]
    quick: bool,

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
        Ok(complaints) => {
            complaints.iter().for_each(|one| eprintln!("cost: {one}"));
            ExitCode::from(u8::from(!complaints.is_empty()))
        }
        Err(error) => {
            eprintln!("cost: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Measures, prints and records as the options say. Returns the complaints of the check.
fn run(options: &Options) -> Result<Vec<String>, Box<dyn Error>> {
    let recorded = Recorded::of_the_project()?;
    let products: Vec<MeasuredProduct> = match &options.model {
        Some(model) => {
            let product = products::of_model(model, options.nucleo);
            vec![product.ok_or_else(|| format!("{model} is not measured on this board"))?]
        }
        None => products::all(),
    };
    let reports = reports(&products, options)?;
    if options.json {
        println!("{:#}", tables::json(&reports, &recorded));
    } else if options.markdown {
        print!("{}", tables::markdown(&reports));
    } else {
        println!("{}", tables::CONDITIONS);
        for report in &reports {
            println!("\n{}", tables::text(report, &recorded).trim_end());
        }
    }
    for report in &reports {
        eprintln!(
            "{}: {:.0} million simulated instructions per second on this computer",
            report.model, report.speed
        );
    }
    if options.record {
        std::fs::write(Recorded::path(), Recorded::from_reports(&reports).text()?)?;
        documents::write(&reports)?;
    }
    if !options.check {
        return Ok(Vec::new());
    }
    let mut complaints: Vec<String> = reports.iter().flat_map(limits::exceeded).collect();
    let mut differences: Vec<_> = reports
        .iter()
        .flat_map(|report| recorded.grown(report))
        .collect();
    if options.model.is_none() && !options.quick {
        differences.extend(recorded.missing(&reports));
    }
    complaints.extend(differences.iter().map(ToString::to_string));
    Ok(complaints)
}

/// Measures each model, with the given image or with a new build.
fn reports(products: &[MeasuredProduct], options: &Options) -> Result<Vec<Report>, Box<dyn Error>> {
    let end = if options.fastest {
        End::Best
    } else {
        End::Worst
    };
    let sweep = if options.quick {
        Phases::Few
    } else {
        Phases::All
    };
    let mut built = BTreeMap::new();
    let mut reports = Vec::new();
    for product in products {
        let path = match &options.elf {
            Some(path) => path.clone(),
            None => {
                let images = match built.entry(product.board) {
                    Entry::Occupied(images) => images.into_mut(),
                    Entry::Vacant(place) => {
                        let on_board = products.iter().filter(|one| one.board == product.board);
                        let names: Vec<_> = on_board.map(|one| one.name).collect();
                        place.insert(firmware::build(product.board, &names)?)
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
        if image.board() != product.board {
            let board = product.board.facts().name;
            return Err(format!("{} is not an image for the board {board}", path.display()).into());
        }
        reports.push(measure(
            *product,
            Rc::new(image),
            Timing::MANUALS.at(end),
            sweep,
        )?);
    }
    Ok(reports)
}
