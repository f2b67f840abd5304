//! What the flashed images cost keeps to its budgets, and the documents have these figures.
//!
//! `UPDATE=1 cargo test -p cost --test cost` writes the figures into the documents.

mod limits;

use cost::budgets::Budgets;
use cost::products::{self, MeasuredProduct};
use cost::{CostError, Report, measure, tables};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::LazyLock;
use std::thread;
use stm32_sim::chip::Chip;
use stm32_sim::elf::Image;
use stm32_sim::firmware;

/// The heading of the table in a document,
const BEGIN: &str = "checked by host-tests/cost/tests/cost.rs -->\n";
/// and its end.
const END: &str = "<!-- end -->";

/// By how many percent a figure in a document may be off.
const TOLERANCE: f64 = 10.0;

static IMAGES: LazyLock<BTreeMap<Chip, BTreeMap<String, PathBuf>>> = LazyLock::new(|| {
    let build = |chip| {
        let products = products().into_iter();
        let on_board = products.filter(|product| product.chip == chip);
        let names: Vec<_> = on_board.map(|product| product.name).collect();
        firmware::build(chip, &names).unwrap_or_else(|error| panic!("{error}"))
    };
    Chip::ALL.map(|chip| (chip, build(chip))).into()
});

/// One run of the scenario for each model, shared by all tests.
static REPORTS: LazyLock<Vec<Report>> = LazyLock::new(|| {
    let report = |product: MeasuredProduct| measure(product, image(product.chip, product.name));
    // A single scenario uses one processor.
    let reports: Result<_, CostError> = thread::scope(|scope| {
        let products = products().into_iter();
        let runs: Vec<_> = products
            .map(|product| scope.spawn(move || report(product)))
            .collect();
        runs.into_iter()
            .map(|run| run.join().expect("a scenario does not panic"))
            .collect()
    });
    reports.unwrap_or_else(|error| panic!("{error}"))
});

/// The products that have figures of their own.
fn products() -> Vec<MeasuredProduct> {
    let budgets = Budgets::of_the_project().expect("the file is valid");
    products::all(|model| budgets.has(model))
}

fn image(chip: Chip, model: &str) -> Rc<Image> {
    let elf = std::fs::read(&IMAGES[&chip][model]).expect("it has just been built");
    Rc::new(Image::parse(&elf).expect("the linker writes ELF"))
}

#[test]
fn every_figure_is_within_its_budget() {
    let budgets = Budgets::of_the_project().expect("the file is valid");
    let complaints: Vec<String> = REPORTS
        .iter()
        .flat_map(|report| budgets.check(report))
        .map(|complaint| complaint.to_string())
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn every_model_with_budgets_is_measured() {
    let budgets = Budgets::of_the_project().expect("the file is valid");
    let products = products();
    let measured: BTreeSet<&str> = products.iter().map(|product| product.label).collect();
    assert_eq!(budgets.models().collect::<BTreeSet<_>>(), measured);
}

/// Asserts that the document has this table, or writes it when the environment asks for that.
fn assert_table(document: &str, expected: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(document);
    let text = std::fs::read_to_string(&path).expect("the document can be read");
    let (before, rest) = text.split_once(BEGIN).expect("the heading of the table");
    let (table, after) = rest.split_once(END).expect("the end of the table");
    if std::env::var_os("UPDATE").is_some() {
        let updated = [before, BEGIN, expected, END, after].concat();
        std::fs::write(&path, updated).expect("the document can be written");
    } else if let Err(difference) = tables::agree(table, expected, TOLERANCE) {
        let path = path.display();
        panic!("{difference}\n{path} should have this table (UPDATE=1 writes it):\n\n{expected}");
    }
}

#[test]
fn document_has_the_measured_figures() {
    assert_table("README.md", &tables::markdown(&REPORTS));
}

/// A phase belongs to the time above it.
#[test]
fn each_phase_has_a_figure_above_it() {
    let table = tables::markdown(&REPORTS);
    let rows: Vec<Vec<&str>> = table
        .lines()
        .map(|row| row.split('|').map(str::trim).collect())
        .collect();
    let mut phases = 0;
    for pair in rows.windows(2) {
        let [above, below] = pair else { continue };
        if below.get(1) != Some(&"- at") {
            continue;
        }
        for (figure, phase) in above.iter().zip(below).skip(2) {
            assert_eq!(figure.is_empty(), phase.is_empty(), "{above:?}\n{below:?}");
            phases += usize::from(!phase.is_empty());
        }
    }
    assert!(phases > 0);
}

#[test]
fn readme_of_the_project_has_the_measured_figures_of_is2() {
    let report = REPORTS.iter().find(|report| report.model == "is2");
    let report = report.expect("is2 is measured");
    assert_table("../../README.md", &tables::summary(report));
}

/// One axis has no perpendicular angles, so its image lacks their function.
#[test]
fn missing_function_is_an_error_with_its_name() {
    let two_axes = products::find("is2").expect("there is an is2");
    let wrong = MeasuredProduct {
        name: "is1",
        ..two_axes
    };
    assert_eq!(two_axes.angles.0[0].0, "perpendicular");
    let error = measure(wrong, image(Chip::F103, "is1")).expect_err("there is no such function");
    assert_eq!(
        error.to_string(),
        "is1: the image has no function plumbline::measure::definition::perpendicular"
    );
}
