//! What the flashed Blue Pill image costs, measured by running it on the simulated microcontroller.
//!
//! - [`rows`]: the rows of the table, and precisely what each counts;
//! - [`subjects`]: which models are measured, and what the scenario says to them; [`mod@function`]: which functions are counted;
//! - [`scenario`]: the standard scenario that is run once per model, on a [`rig`]; [`calls`]: what is read out of the calls that it made;
//! - [`budgets`]: what each figure may be at most, and at least; [`tables`]: text, Markdown and JSON.
//!
//! The processor runs at 64 MHz and takes one cycle for each instruction, and 12 for the entry of an exception and for its return.
//! The real part takes more: flash wait states, jumps, loads, divisions. So instructions are exact, but times and what follows
//! from them are not those of the real part.

pub mod budgets;
pub mod calls;
pub mod function;
pub mod rig;
pub mod rows;
pub mod scenario;
pub mod subjects;
pub mod tables;

use rows::{ROWS, Row};
use scenario::Figures;
use std::rc::Rc;
use std::time::Instant;
use stm32_sim::elf::{Image, Part, Shares};
use subjects::Subject;

/// Why a figure cannot be had.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum CostError {
    /// A function that is to be measured is not in the symbol table: it was renamed, inlined or never used.
    #[error("{0}: the image has no function {1}")]
    NoFunction(&'static str, &'static str),
    /// A function was not called where it should have been.
    #[error("{0} was not called where it should have been")]
    NeverCalled(&'static str),
    /// Something that the scenario provokes did not happen.
    #[error("{0} did not come in the scenario")]
    NeverHappened(&'static str),
    /// The sensor did not answer.
    #[error("{0}: no answer: {1}")]
    Silent(&'static str, String),
    /// The firmware has broken a rule of the reference manual.
    #[error("{model}: {count} violations, the first: {first}")]
    Violations {
        /// The model.
        model: &'static str,
        /// How many there are.
        count: usize,
        /// What the first one is.
        first: String,
    },
    /// A part has static RAM that no row shows.
    #[error("{0}: {1} takes static RAM that no row shows")]
    HiddenRam(&'static str, Part),
}

/// The figures of one model.
#[derive(Clone, PartialEq, Debug)]
pub struct Report {
    /// The name of the model.
    pub model: &'static str,
    /// Each row that this model has, with its figure, in the order of the table.
    pub figures: Vec<(&'static Row, u64)>,
    /// Million simulated instructions per second that the run reached: how fast this computer is, no property of the image.
    pub speed: f64,
}

impl Report {
    /// The figure of a row; None when this model has no such row.
    pub fn figure(&self, key: &str) -> Option<u64> {
        let found = self.figures.iter().find(|(row, _)| row.key == key);
        found.map(|(_, figure)| *figure)
    }
}

/// Measures an image.
///
/// # Errors
/// [`CostError`].
///
/// # Panics
/// When the program does what is a fault on the chip.
pub fn measure(subject: Subject, image: Rc<Image>) -> Result<Report, CostError> {
    let begin = Instant::now();
    let shares = image.shares();
    let modules = [
        subject.protocol.module,
        "plumbline::node::",
        "plumbline::param::",
    ];
    let protocol = modules.map(|module| image.flash_of(module)).iter().sum();
    let scenario::Outcome {
        mut figures,
        stack,
        instructions,
    } = scenario::run(subject, image)?;
    let speed = instructions as f64 / begin.elapsed().as_secs_f64() / 1e6;
    add_sizes(&mut figures, subject.name, &shares, stack)?;
    figures.insert("flash_protocol", protocol);
    Ok(Report {
        model: subject.name,
        figures: ROWS
            .iter()
            .filter_map(|row| Some((row, *figures.get(row.key)?)))
            .collect(),
        speed,
    })
}

fn add_sizes(
    figures: &mut Figures,
    model: &'static str,
    shares: &Shares,
    stack: u64,
) -> Result<(), CostError> {
    let (mut flash, mut ram) = (0, stack);
    for part in Part::ALL {
        let (in_flash, in_ram) = part_rows(part);
        flash += shares.flash(part);
        ram += shares.ram(part);
        figures.insert(in_flash, shares.flash(part));
        match in_ram {
            Some(row) => {
                figures.insert(row, shares.ram(part));
            }
            None if shares.ram(part) > 0 => return Err(CostError::HiddenRam(model, part)),
            None => {}
        }
    }
    figures.extend([("flash", flash), ("ram", ram), ("stack", stack)]);
    Ok(())
}

/// The keys of a part's rows: flash, and static RAM where there can be any.
fn part_rows(part: Part) -> (&'static str, Option<&'static str>) {
    match part {
        Part::Core => ("flash_core", Some("ram_core")),
        Part::Driver => ("flash_driver", Some("ram_driver")),
        Part::Libraries => ("flash_libraries", Some("ram_libraries")),
        Part::Runtime => ("flash_runtime", Some("ram_runtime")),
        Part::Vectors => ("flash_vectors", None),
        Part::Constants => ("flash_constants", None),
        Part::Padding => ("flash_padding", Some("ram_padding")),
    }
}
