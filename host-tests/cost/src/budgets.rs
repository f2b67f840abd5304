//! The budget of each figure. A budget far above its figure is also an error, because it would hide a later increase.

use super::Report;
use super::rows::{Row, Unit};
use std::collections::BTreeMap;
use std::fmt;

/// How many percent a figure may be below its budget.
const SLACK: u64 = 20;

/// The budgets of every model: a table per model, with the keys of the rows.
const FILE: &str = include_str!("budgets.toml");

/// Budgets by model and key.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Budgets(BTreeMap<String, BTreeMap<String, u64>>);

/// An error of a figure or its budget.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Complaint {
    /// The model.
    pub model: String,
    /// The key of the row.
    pub row: String,
    /// The error.
    pub fault: Fault,
}

/// The possible errors.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Fault {
    /// The figure is above the budget.
    Exceeded {
        /// The measured figure.
        figure: u64,
        /// The budget.
        budget: u64,
    },
    /// The figure is more than 20 % below the budget.
    Loose {
        /// The measured figure.
        figure: u64,
        /// The budget.
        budget: u64,
    },
    /// The figure has no budget.
    NoBudget(
        /// The measured figure.
        u64,
    ),
    /// The budget has no figure.
    NoFigure(
        /// The budget.
        u64,
    ),
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { model, row, fault } = self;
        write!(f, "{model}, {row}: ")?;
        match fault {
            Fault::Exceeded { figure, budget } => write!(f, "{figure} exceeds the budget {budget}"),
            Fault::Loose { figure, budget } => write!(
                f,
                "{figure} is more than {SLACK} % below the budget {budget}: tighten it"
            ),
            Fault::NoBudget(figure) => write!(f, "{figure} has no budget"),
            Fault::NoFigure(budget) => write!(f, "the budget {budget} has no figure"),
        }
    }
}

impl Budgets {
    /// The budgets of the project.
    ///
    /// # Errors
    /// The file is damaged.
    pub fn of_the_project() -> Result<Self, toml::de::Error> {
        Self::parse(FILE)
    }

    /// Reads budgets.
    ///
    /// # Errors
    /// It is not TOML with a table of integers for each model.
    pub fn parse(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text).map(Self)
    }

    /// The models that have budgets.
    pub fn models(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// True when a model has budgets.
    pub fn has(&self, model: &str) -> bool {
        self.0.contains_key(model)
    }

    /// The budget of a row.
    pub fn of(&self, model: &str, row: &Row) -> Option<u64> {
        self.0.get(model)?.get(row.key).copied()
    }

    /// All errors of a report.
    pub fn check(&self, report: &Report) -> Vec<Complaint> {
        let complaint = |row: &str, fault| Complaint {
            model: report.model.to_owned(),
            row: row.to_owned(),
            fault,
        };
        let budgeted = report.figures.iter();
        let budgeted = budgeted.filter(|(row, _)| row.unit != Unit::Saves);
        let figures = budgeted.filter_map(|&(row, figure)| {
            let fault = judge(figure, self.of(report.model, row))?;
            Some(complaint(row.key, fault))
        });
        let budgets = self.0.get(report.model).into_iter().flatten();
        let without_figure = budgets
            .filter(|(key, _)| report.figure(key).is_none())
            .map(|(key, budget)| complaint(key, Fault::NoFigure(*budget)));
        figures.chain(without_figure).collect()
    }
}

/// The error of a figure, if any.
fn judge(figure: u64, budget: Option<u64>) -> Option<Fault> {
    let Some(budget) = budget else {
        return Some(Fault::NoBudget(figure));
    };
    if figure > budget {
        Some(Fault::Exceeded { figure, budget })
    } else if figure * 100 < budget * (100 - SLACK) {
        Some(Fault::Loose { figure, budget })
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(figures: &[(&str, u64)]) -> Report {
        Report {
            model: "is2",
            figures: figures
                .iter()
                .map(|(key, figure)| (Row::find(key).unwrap(), *figure))
                .collect(),
            cycles: Default::default(),
            phases: Default::default(),
            speed: 1.0,
        }
    }

    fn complaints(budgets: &str, figures: &[(&str, u64)]) -> Vec<String> {
        let budgets = Budgets::parse(budgets).unwrap();
        let complaints = budgets.check(&report(figures));
        complaints.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn figure_between_80_and_100_percent_of_budget_is_accepted() {
        let budget = "[is2]\nstack = 1000";
        for figure in [800, 801, 999, 1000] {
            assert!(complaints(budget, &[("stack", figure)]).is_empty());
        }
        assert_eq!(
            complaints(budget, &[("stack", 1001)]),
            ["is2, stack: 1001 exceeds the budget 1000"]
        );
        assert_eq!(
            complaints(budget, &[("stack", 799)]),
            ["is2, stack: 799 is more than 20 % below the budget 1000: tighten it"]
        );
    }

    #[test]
    fn zero_figure_has_zero_budget() {
        assert!(complaints("[is2]\nram_core = 0", &[("ram_core", 0)]).is_empty());
        assert_eq!(
            complaints("[is2]\nram_core = 0", &[("ram_core", 1)]),
            ["is2, ram_core: 1 exceeds the budget 0"]
        );
    }

    #[test]
    fn number_of_saves_has_no_budget() {
        assert!(complaints("[is2]", &[("saves_between", 24)]).is_empty());
    }

    #[test]
    fn missing_budget_or_figure_is_an_error() {
        assert_eq!(
            complaints("[is2]\nflash = 10\nsync = 5", &[("flash", 10), ("ram", 7)]),
            [
                "is2, ram: 7 has no budget",
                "is2, sync: the budget 5 has no figure"
            ]
        );
        assert_eq!(
            complaints("[is1]\nflash = 10", &[("flash", 10)]),
            ["is2, flash: 10 has no budget"]
        );
    }

    #[test]
    fn non_integer_budget_is_refused() {
        for text in ["[is2]\nflash = 1.5", "[is2]\nflash = -1", "flash = 1", "["] {
            assert!(Budgets::parse(text).is_err(), "{text}");
        }
    }

    #[track_caller]
    fn assert_ceilings(model: &str, ceilings: &[(&str, u64)]) {
        let budgets = Budgets::of_the_project().unwrap();
        for &(key, ceiling) in ceilings {
            let budget = budgets.of(model, Row::find(key).unwrap()).unwrap();
            assert!(budget <= ceiling, "{key}: {budget}");
        }
    }

    /// The limits that the project has set.
    #[test]
    fn budgets_of_is2_are_within_limits() {
        let ceilings = [
            ("read_request", 450),
            ("sync", 450),
            ("sync_worst", 60_000),
            ("idle_poll", 60),
            ("sample_butterworth", 900),
            ("perpendicular", 260),
            ("angle", 130),
            ("stack", 1_536),
            ("flash", 20_480),
            ("ram", 6_144),
        ];
        assert_ceilings("is2", &ceilings);
    }

    #[test]
    fn budgets_of_ims360_are_within_limits() {
        let ceilings = [
            ("sync_reply", 350),
            ("sync", 310),
            ("sync_worst", 20_000),
            ("read_request", 403),
            ("idle_poll", 60),
            ("flash", 52_224),
            ("ram", 10_240),
        ];
        assert_ceilings("ims360", &ceilings);
    }

    #[test]
    fn budgets_of_jn2101_are_within_limits() {
        let ceilings = [
            ("read_reply", 450),
            ("sync_reply", 350),
            ("idle_poll", 60),
            ("flash_protocol", 14_336),
            ("flash", 29_500),
            ("ram", 6_144),
        ];
        assert_ceilings("jn2101", &ceilings);
    }
}
