//! The recorded figures (`figures.toml`), and the guard against growth by accident: a figure may not be more than 10 % above the recorded
//! one. It may always be smaller.

use super::Report;
use super::rows::{Row, Unit};
use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

/// How many percent a figure may grow.
const GROWTH: u64 = 10;

/// The figures of every model: a table per model, with the keys of the rows.
const FILE: &str = include_str!("figures.toml");

/// The head of the file.
const HEAD: &str = "\
# Recorded figures: bytes, instructions, nanoseconds (cycles at 64 MHz), by model and by the key of the row (rows.rs says what each
# counts). `cargo run --release --bin cost -- --record` writes this file. A figure that grew by more than 10 % fails; say in the
# commit why it grew.
";

/// Recorded figures by model and key.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Recorded(BTreeMap<String, BTreeMap<String, u64>>);

/// A figure that is not as recorded.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Complaint {
    /// The product whose figure differs.
    pub model: String,
    /// The key of the row.
    pub row: String,
    /// How the figure differs from the recorded one.
    pub fault: Fault,
}

/// How a measured figure can differ from the recorded one.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Fault {
    /// The figure is larger than the recorded one.
    Grew {
        /// The figure that was measured now.
        figure: u64,
        /// The figure in `figures.toml`.
        recorded: u64,
    },
    /// The figure is not recorded.
    NotRecorded(
        /// The figure that was measured now.
        u64,
    ),
    /// The recorded figure is not measured any more.
    NotMeasured(
        /// The figure in `figures.toml`.
        u64,
    ),
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { model, row, fault } = self;
        write!(f, "{model}, {row}: ")?;
        match fault {
            Fault::Grew { figure, recorded } => {
                write!(
                    f,
                    "{figure} is more than {GROWTH} % above the recorded {recorded}"
                )
            }
            Fault::NotRecorded(figure) => write!(f, "{figure} is not recorded"),
            Fault::NotMeasured(recorded) => {
                write!(f, "the recorded {recorded} is not measured any more")
            }
        }
    }
}

/// True when a figure is too far above the recorded one. A growth of `few` is always permitted: ten percent of a tiny figure are nothing.
pub fn grew(figure: u64, recorded: u64, few: u64) -> bool {
    figure > recorded + few.max(recorded * GROWTH / 100)
}

/// The growth that is always permitted.
const fn few(unit: Unit) -> u64 {
    match unit {
        Unit::Bytes => 64,
        // A filter is the difference of two loads of a sample, which has some 16,000 instructions.
        Unit::Instructions => 100,
        Unit::Nanoseconds => 500,
        Unit::Saves => 0,
    }
}

impl Recorded {
    /// The recorded figures of the project.
    ///
    /// # Errors
    /// The file is damaged.
    pub fn of_the_project() -> Result<Self, toml::de::Error> {
        Self::parse(FILE)
    }

    /// The path of the file.
    pub fn path() -> PathBuf {
        [env!("CARGO_MANIFEST_DIR"), "src", "figures.toml"]
            .iter()
            .collect()
    }

    /// Reads recorded figures.
    ///
    /// # Errors
    /// It is not TOML with a table of integers for each model.
    pub fn parse(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text).map(Self)
    }

    /// The figures of these reports, to be recorded.
    pub fn from_reports(reports: &[Report]) -> Self {
        let of = |report: &Report| {
            let figures = guarded(report).map(|(row, figure)| (row.key.to_owned(), figure));
            (report.model.to_owned(), figures.collect())
        };
        Self(reports.iter().map(of).collect())
    }

    /// The content of the file.
    ///
    /// # Errors
    /// A figure is too large for TOML.
    pub fn text(&self) -> Result<String, toml::ser::Error> {
        Ok(format!("{HEAD}\n{}", toml::to_string(&self.0)?))
    }

    /// The recorded figure of a row.
    pub fn of(&self, model: &str, row: &Row) -> Option<u64> {
        self.0.get(model)?.get(row.key).copied()
    }

    /// The figures of a report that grew or are not recorded.
    pub fn grown(&self, report: &Report) -> Vec<Complaint> {
        let fault = |row: &Row, figure| match self.of(report.model, row) {
            None => Some(Fault::NotRecorded(figure)),
            Some(recorded) => {
                grew(figure, recorded, few(row.unit)).then_some(Fault::Grew { figure, recorded })
            }
        };
        let complaint = |(row, figure): (&Row, u64)| {
            Some(Complaint {
                model: report.model.to_owned(),
                row: row.key.to_owned(),
                fault: fault(row, figure)?,
            })
        };
        guarded(report).filter_map(complaint).collect()
    }

    /// The recorded figures that these reports do not have; the reports are those of all products.
    pub fn missing(&self, reports: &[Report]) -> Vec<Complaint> {
        let measured = Self::from_reports(reports).0;
        let is_measured = |model, row| {
            measured
                .get(model)
                .is_some_and(|rows| rows.contains_key(row))
        };
        let recorded = self
            .0
            .iter()
            .flat_map(|(model, rows)| rows.iter().map(move |(row, figure)| (model, row, figure)));
        recorded
            .filter(|(model, row, _)| !is_measured(*model, *row))
            .map(|(model, row, recorded)| Complaint {
                model: model.clone(),
                row: row.clone(),
                fault: Fault::NotMeasured(*recorded),
            })
            .collect()
    }
}

/// The figures of a report that may not grow.
fn guarded(report: &Report) -> impl Iterator<Item = (&'static Row, u64)> {
    report.figures.iter().copied().filter(|(row, _)| row.guard)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Phases;

    fn report(figures: &[(&str, u64)]) -> Report {
        Report {
            model: "is2",
            figures: figures
                .iter()
                .map(|(key, figure)| (Row::find(key).unwrap(), *figure))
                .collect(),
            phases: Default::default(),
            sweep: Phases::All,
            speed: 1.0,
        }
    }

    fn grown(recorded: &str, figures: &[(&str, u64)]) -> Vec<String> {
        let recorded = Recorded::parse(recorded).unwrap();
        let complaints = recorded.grown(&report(figures));
        complaints.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn figure_may_shrink_and_grow_by_ten_percent() {
        let recorded = "[is2]\nstack = 1000";
        for figure in [0, 500, 1000, 1100] {
            assert!(grown(recorded, &[("stack", figure)]).is_empty());
        }
        assert_eq!(
            grown(recorded, &[("stack", 1101)]),
            ["is2, stack: 1101 is more than 10 % above the recorded 1000"]
        );
    }

    #[test]
    fn tiny_figure_may_grow_by_a_few_units() {
        let recorded = "[is2]\nload_off = 10";
        assert!(grown(recorded, &[("load_off", 110)]).is_empty());
        assert_eq!(grown(recorded, &[("load_off", 111)]).len(), 1);
    }

    #[test]
    fn parts_and_number_of_saves_are_not_guarded() {
        let figures = [("saves_between", 24), ("flash_padding", 90)];
        assert!(grown("[is2]", &figures).is_empty());
    }

    #[test]
    fn figure_that_is_not_recorded_is_reported() {
        assert_eq!(
            grown("[is1]\nflash = 10", &[("flash", 10)]),
            ["is2, flash: 10 is not recorded"]
        );
    }

    #[test]
    fn recorded_figure_that_is_not_measured_is_reported() {
        let recorded = Recorded::parse("[is1]\nram = 2\n[is2]\nflash = 10\nstack = 5").unwrap();
        let complaints = recorded.missing(&[report(&[("flash", 10)])]);
        let complaints: Vec<String> = complaints.iter().map(ToString::to_string).collect();
        assert_eq!(
            complaints,
            [
                "is1, ram: the recorded 2 is not measured any more",
                "is2, stack: the recorded 5 is not measured any more"
            ]
        );
    }

    #[test]
    fn text_has_the_recorded_figures() {
        let recorded = Recorded::from_reports(&[report(&[("flash", 10), ("flash_core", 5)])]);
        assert_eq!(
            recorded,
            Recorded::parse(&recorded.text().unwrap()).unwrap()
        );
        assert_eq!(recorded, Recorded::parse("[is2]\nflash = 10").unwrap());
    }

    #[test]
    fn non_integer_figure_is_refused() {
        for text in ["[is2]\nflash = 1.5", "[is2]\nflash = -1", "flash = 1", "["] {
            assert!(Recorded::parse(text).is_err(), "{text}");
        }
    }
}
