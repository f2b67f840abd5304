//! The cost of the flashed images, measured by running them on the simulated microcontroller: all products on the Blue Pill, and
//! three on the Nucleo.
//!
//! - [`rows`]: the rows of the table, and the exact definition of each;
//! - [`products`]: the measured models and the messages of the scenario;
//! - [`scenario`]: the standard scenario, which runs once per model on a [`rig`];
//! - [`limits`]: what a user relies on; [`recorded`]: the guard against growth by accident;
//! - [`tables`]: text, Markdown and JSON; [`documents`]: the documents with these tables.
//!
//! The processor runs at 64 MHz. Times are cycles by the timing table of the processor's Technical Reference Manual, with the wait
//! states of the flash and of the buses, at the worst end of what the manuals leave open: see [`stm32_sim::cortex_m::timing`].
//! They are not measured on hardware. Instructions are exact. On the Nucleo only bytes and instructions are measured.

pub mod documents;
pub mod limits;
pub mod products;
pub mod recorded;
pub mod rig;
pub mod rows;
pub mod scenario;
pub mod tables;

use products::MeasuredProduct;
use rows::{ROWS, Row, Unit};
use scenario::{Figures, Phases};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::time::Instant;
use stm32_sim::board::Board;
use stm32_sim::cortex_m::timing::Cycles;
use stm32_sim::elf::{Image, Part, Shares};

/// The reason why a figure is not available.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum CostError {
    /// An expected event of the scenario did not occur.
    #[error("{0} did not occur in the scenario")]
    NeverHappened(&'static str),
    /// The sensor did not reply.
    #[error("{0}: no reply to {1}")]
    Silent(&'static str, String),
    /// The firmware has violated the reference manual.
    #[error("{model}: {count} violations, the first: {first}")]
    Violations {
        /// The product that runs.
        model: &'static str,
        /// The number of violations in the whole scenario.
        count: usize,
        /// The first violation, as text.
        first: String,
    },
    /// A part has static RAM without a row.
    #[error("{0}: the static RAM of {1} has no row")]
    HiddenRam(&'static str, Part),
}

/// The figures of one model.
#[derive(Clone, PartialEq, Debug)]
pub struct Report {
    /// The name of the model.
    pub model: &'static str,
    /// The rows of this model with their figures, in the order of the table.
    pub figures: Vec<(&'static Row, u64)>,
    /// What the firmware was doing at the worst phase of a row, by key: the functions before and behind the receive interrupt.
    pub phases: BTreeMap<&'static str, String>,
    /// The phases that were swept.
    pub sweep: Phases,
    /// The speed of the run in million simulated instructions per second: a property of this computer, not of the image.
    pub speed: f64,
}

impl Report {
    /// The figure of a row; None when this model does not have the row.
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
/// The program does something that is a fault on the chip.
pub fn measure(
    product: MeasuredProduct,
    image: Rc<Image>,
    cycles: Cycles,
    sweep: Phases,
) -> Result<Report, CostError> {
    let begin = Instant::now();
    let shares = image.shares();
    let neutral = ["plumbline::node::", "plumbline::param::"];
    let modules = neutral.iter().chain(product.protocol.modules);
    let protocol = modules.map(|module| image.flash_of(module)).sum();
    let scenario::Outcome {
        mut figures,
        mut phases,
        stack,
        instructions,
    } = scenario::run(product, image, cycles, sweep)?;
    let speed = instructions as f64 / begin.elapsed().as_secs_f64() / 1e6;
    add_sizes(&mut figures, product.name, &shares, stack)?;
    figures.insert("flash_protocol", protocol);
    // The cycles of the Cortex-M4 are not modelled, so there are no times on the Nucleo.
    figures.retain(|key, _| {
        let row = Row::find(key);
        product.board == Board::BluePill || row.is_none_or(|row| row.unit != Unit::Nanoseconds)
    });
    phases.retain(|key, _| figures.contains_key(key));
    Ok(Report {
        model: product.label,
        figures: ROWS
            .iter()
            .filter_map(|row| Some((row, *figures.get(row.key)?)))
            .collect(),
        phases,
        sweep,
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

/// The keys of the rows of a part: flash, and static RAM if it can have any.
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
