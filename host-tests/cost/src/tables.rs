//! The figures as text, as Markdown and as JSON.

use super::Report;
use super::budgets::Budgets;
use super::rows::{ROWS, Row, Unit};
use serde_json::{Value, json};
use std::fmt::Write;

/// The text above the tables: the conditions of the figures.
pub const CONDITIONS: &str = "Instructions are exact. Times are cycles at 64 MHz by the timing table of the TRM, with the wait states of flash and buses, at the \
     worst end of what the manuals leave open; they are not measured on hardware. On the Nucleo only bytes and instructions are measured.";

/// The table of one model, with its budgets.
pub fn text(report: &Report, budgets: &Budgets) -> String {
    let mut text = format!("{:46} {:>12} {:>12}\n", report.model, "", "budget");
    for (row, figure) in &report.figures {
        let budget = budgets.of(report.model, row);
        let budget = budget.map_or("none".to_owned(), |budget| row.show(budget).to_string());
        let shown = row.show(*figure);
        let cycles = report
            .cycles
            .get(row.key)
            .map(|cycles| format!("{cycles} cycles"));
        let phase = report
            .phases
            .get(row.key)
            .map(|phase| format!("at {phase}"));
        let note = cycles.or(phase).unwrap_or_default();
        let line = format!("{:46} {shown:>12} {budget:>12}  {note}", row.title);
        writeln!(text, "{}", line.trim_end()).expect("a string takes it");
    }
    text
}

/// The models side by side as a Markdown table, with what others need.
pub fn markdown(reports: &[Report]) -> String {
    let names: String = reports
        .iter()
        .map(|report| format!(" `{}` |", report.model))
        .collect();
    let rule = "---|".repeat(reports.len());
    let mut text = format!("| what |{names} others |\n|---|{rule}---|\n");
    for row in ROWS {
        let figures: Vec<Option<u64>> = reports
            .iter()
            .map(|report| report.figure(row.key))
            .collect();
        if figures.iter().flatten().all(|figure| *figure == 0) {
            continue;
        }
        let cells: String = figures
            .into_iter()
            .zip(reports)
            .map(
                |(figure, report)| match (figure, report.cycles.get(row.key)) {
                    (Some(figure), Some(cycles)) => format!(" {} ({cycles}) |", row.show(figure)),
                    (Some(figure), None) => format!(" {} |", row.show(figure)),
                    (None, _) => " |".to_owned(),
                },
            )
            .collect();
        let title = title(row);
        let others = match row.others {
            "" => String::new(),
            others => format!(" {others}"),
        };
        writeln!(text, "| {title} |{cells}{others} |").expect("a string takes it");
        let phases = reports.iter().map(|report| report.phases.get(row.key));
        if phases.clone().any(|phase| phase.is_some()) {
            let cells: String = phases
                .map(|phase| phase.map_or(" |".to_owned(), |phase| format!(" `{phase}` |")))
                .collect();
            writeln!(text, "| - at |{cells} |").expect("a string takes it");
        }
    }
    text
}

/// The rows that the project's README shows, by key.
const SUMMARY: [&str; 6] = [
    "flash",
    "ram",
    "sync",
    "sync_median",
    "sync_worst",
    "read_worst",
];

/// The figures of one model that the project's README shows, as a Markdown table.
pub fn summary(report: &Report) -> String {
    let mut text = format!("| what | `{}` |\n|---|---|\n", report.model);
    for row in SUMMARY.into_iter().filter_map(Row::find) {
        if let Some(figure) = report.figure(row.key) {
            let (title, figure) = (title(row), row.show(figure));
            let cycles = report.cycles.get(row.key);
            let cycles = cycles.map_or(String::new(), |cycles| format!(" ({cycles})"));
            writeln!(text, "| {title} | {figure}{cycles} |").expect("a string takes it");
        }
    }
    text
}

/// The title of a row in Markdown: instructions have no unit beside the figure, and cycles in parentheses.
fn title(row: &Row) -> String {
    match row.unit {
        Unit::Instructions => format!("{}, instructions (cycles)", row.title),
        Unit::Bytes | Unit::Nanoseconds | Unit::Saves => row.title.to_owned(),
    }
}

/// The models with their figures, budgets and definitions of the rows.
pub fn json(reports: &[Report], budgets: &Budgets) -> Value {
    let model = |report: &Report| {
        let rows: Vec<Value> = report
            .figures
            .iter()
            .map(|(row, figure)| {
                json!({
                    "key": row.key,
                    "title": row.title,
                    "counts": row.counts,
                    "unit": unit(row),
                    "figure": figure,
                    "budget": budgets.of(report.model, row),
                    "cycles": report.cycles.get(row.key),
                    "phase": report.phases.get(row.key),
                })
            })
            .collect();
        json!({ "model": report.model, "rows": rows })
    };
    json!({
        "conditions": CONDITIONS,
        "models": reports.iter().map(model).collect::<Vec<_>>(),
    })
}

fn unit(row: &Row) -> &'static str {
    match row.unit {
        Unit::Bytes => "B",
        Unit::Instructions => "instructions",
        Unit::Nanoseconds => "ns",
        Unit::Saves => "saves",
    }
}

/// Checks that two tables agree: the same words, and numbers that differ by no more than `percent` of the second one. The error
/// is the first line that differs.
///
/// # Errors
/// The lines that differ.
pub fn agree(written: &str, measured: &str, percent: f64) -> Result<(), String> {
    if written.lines().count() != measured.lines().count() {
        return Err("the tables have different rows".to_owned());
    }
    let differs = |(written, measured): &(&str, &str)| !lines_agree(written, measured, percent);
    match written.lines().zip(measured.lines()).find(differs) {
        None => Ok(()),
        Some((written, measured)) => Err(format!("written:  {written}\nmeasured: {measured}")),
    }
}

/// A number, which may be in parentheses.
fn number(word: &str) -> Result<f64, std::num::ParseFloatError> {
    word.trim_start_matches('(').trim_end_matches(')').parse()
}

fn lines_agree(written: &str, measured: &str, percent: f64) -> bool {
    let words =
        |line: &str| -> Vec<String> { line.split_whitespace().map(str::to_owned).collect() };
    let (written, measured) = (words(written), words(measured));
    written.len() == measured.len()
        && written.iter().zip(&measured).all(|(written, measured)| {
            match (number(written), number(measured)) {
                (Ok(written), Ok(measured)) => {
                    (written - measured).abs() <= measured.abs() * percent / 100.0
                }
                _ => written == measured,
            }
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(model: &'static str, figures: &[(&str, u64)]) -> Report {
        let found = |(key, figure): &(&str, u64)| (Row::find(key).unwrap(), *figure);
        Report {
            model,
            figures: figures.iter().map(found).collect(),
            cycles: Default::default(),
            phases: Default::default(),
            speed: 1.0,
        }
    }

    #[test]
    fn markdown_has_a_column_per_model_and_omits_unused_rows() {
        let mut reports = [
            report(
                "is2",
                &[("flash", 18_000), ("ram_core", 0), ("idle_poll", 20)],
            ),
            report(
                "is1",
                &[("flash", 17_000), ("atan2", 50), ("sync_worst", 12_346)],
            ),
        ];
        reports[1].cycles.insert("atan2", 120);
        let phase = "Node::sample".to_owned();
        reports[1].phases.insert("sync_worst", phase);
        let expected = "\
| what | `is2` | `is1` | others |
|---|---|---|---|
| flash | 18000 B | 17000 B | |
| idle poll, instructions (cycles) | 20 | | CANopenNode 424, zencan 738 |
| - atan2, instructions (cycles) | | 50 (120) | 65-entry table 56, idsp 122, CORDIC 304, CMSIS-DSP 559, micromath 786, libm atan2f 1400 |
| end of SYNC to reply, worst case | | 12.35 us | |
| - at | | `Node::sample` | |
";
        assert_eq!(markdown(&reports), expected);
    }

    #[test]
    fn summary_has_the_rows_of_the_readme() {
        let report = report("is2", &[("flash", 18_000), ("ram", 3_000), ("sync", 200)]);
        let expected = "\
| what | `is2` |
|---|---|
| flash | 18000 B |
| RAM with the stack's peak | 3000 B |
| SYNC to reply, instructions (cycles) | 200 |
";
        assert_eq!(summary(&report), expected);
    }

    #[test]
    fn figures_are_shown_with_units() {
        let show = |key: &str, figure| Row::find(key).unwrap().show(figure).to_string();
        assert_eq!(show("flash", 20_480), "20480 B");
        assert_eq!(show("sync", 420), "420");
        assert_eq!(show("sync_worst", 999_999), "1000.00 us");
        assert_eq!(show("boot_time", 123_456_789), "123.5 ms");
    }

    #[test]
    fn json_has_figure_and_budget() {
        let budgets = Budgets::parse("[is2]\nflash = 20").unwrap();
        let value = json(&[report("is2", &[("flash", 18), ("ram", 7)])], &budgets);
        let rows = &value["models"][0]["rows"];
        assert_eq!(value["models"][0]["model"], "is2");
        assert_eq!(
            (&rows[0]["figure"], &rows[0]["budget"]),
            (&json!(18), &json!(20))
        );
        assert_eq!(
            (&rows[1]["key"], &rows[1]["budget"]),
            (&json!("ram"), &Value::Null)
        );
    }

    #[test]
    fn tables_agree_within_tolerance() {
        let table = "| flash | 1000 B |\n| atan2 | 50 | table 56 |\n";
        for (written, agrees) in [
            (table, true),
            ("| flash | 1100 B |\n| atan2 | 45 | table 56 |\n", true),
            ("| flash | 1101 B |\n| atan2 | 50 | table 56 |\n", false),
            ("| flash | 899 B |\n| atan2 | 50 | table 56 |\n", false),
            ("| flash | 1000 us |\n| atan2 | 50 | table 56 |\n", false),
            ("| flash | 1000 B |\n", false),
            ("| atan2 | 50 | table 56 |\n| flash | 1000 B |\n", false),
            ("| flash | 1000 B |\n| atan2 | | table 56 |\n", false),
        ] {
            assert_eq!(agree(written, table, 10.0).is_ok(), agrees, "{written}");
        }
    }

    #[test]
    fn rows_have_different_keys() {
        for (number, row) in ROWS.iter().enumerate() {
            assert!(
                ROWS[..number].iter().all(|other| other.key != row.key),
                "{}",
                row.key
            );
        }
    }
}
