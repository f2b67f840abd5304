//! One image of each family keeps the limits and the recorded figures, as far as few phases show it. `cost -- --check` measures all
//! products at all phases.

use cost::products::{self, MeasuredProduct};
use cost::recorded::Recorded;
use cost::scenario::Phases;
use cost::{CostError, Report, limits, measure};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::LazyLock;
use std::thread;
use stm32_sim::board::Board;
use stm32_sim::cortex_m::timing::Cycles;
use stm32_sim::elf::Image;
use stm32_sim::firmware;

/// A product of each family.
const FAMILIES: [&str; 4] = ["is2", "jn2101", "ims360", "tiltix080"];

/// One run of the scenario for each model, shared by all tests.
static REPORTS: LazyLock<Vec<Report>> = LazyLock::new(|| {
    let images =
        firmware::build(Board::BluePill, &FAMILIES).unwrap_or_else(|error| panic!("{error}"));
    let report = |name: &str| {
        let product = products::find(name).expect("it is in the catalogue");
        measure(
            product,
            image(&images, product),
            Cycles::default(),
            Phases::Few,
        )
    };
    // A single scenario uses one processor.
    let reports: Result<_, CostError> = thread::scope(|scope| {
        let report = &report;
        let runs = FAMILIES.map(|name| scope.spawn(move || report(name)));
        runs.into_iter()
            .map(|run| run.join().expect("a scenario does not panic"))
            .collect()
    });
    reports.unwrap_or_else(|error| panic!("{error}"))
});

fn image(images: &BTreeMap<String, PathBuf>, product: MeasuredProduct) -> Rc<Image> {
    let elf = std::fs::read(&images[product.name]).expect("it has just been built");
    Rc::new(Image::parse(&elf).expect("the linker writes ELF"))
}

#[test]
fn images_keep_the_limits() {
    let complaints: Vec<String> = REPORTS.iter().flat_map(limits::exceeded).collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

/// After a growth with a reason: `cargo run --release --bin cost -- --record`.
#[test]
fn no_figure_grew_by_more_than_ten_percent() {
    let recorded = Recorded::of_the_project().expect("the file is valid");
    let complaints: Vec<String> = REPORTS
        .iter()
        .flat_map(|report| recorded.grown(report))
        .map(|complaint| complaint.to_string())
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}
