//! The figures as text, as Markdown and as JSON.

use super::Report;
use super::recorded::Recorded;
use super::rows::{ROWS, Row, Unit};
use serde_json::{Value, json};
use std::fmt::Write;

/// The text above the tables: the conditions of the figures.
pub const CONDITIONS: &str = "Instructions are exact. Times are cycles at 64 MHz by the timing table of the TRM, with the wait states of flash and buses, at the \
     worst end of what the manuals leave open; they are not measured on hardware. On the Nucleo only bytes and instructions are measured.";

/// The table of one model, with its recorded figures.
pub fn text(report: &Report, recorded: &Recorded) -> String {
    let mut text = format!("{:46} {:>12} {:>12}\n", report.model, "", "recorded");
    for (row, figure) in &report.figures {
        let recorded = recorded.of(report.model, row);
        let recorded = recorded.map_or(String::new(), |figure| row.show(figure).to_string());
        let shown = row.show(*figure);
        let phase = report.phases.get(row.key);
        let phase = phase.map_or(String::new(), |phase| format!("at {phase}"));
        let line = format!("{:46} {shown:>12} {recorded:>12}  {phase}", row.title);
        writeln!(text, "{}", line.trim_end()).expect("a string takes it");
    }
    text
}

/// The models side by side as a Markdown table.
pub fn markdown(reports: &[Report]) -> String {
    let names: String = reports
        .iter()
        .map(|report| format!(" `{}` |", report.model))
        .collect();
    let rule = "---|".repeat(reports.len());
    let mut text = format!("| what |{names}\n|---|{rule}\n");
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
            .map(|figure| {
                figure.map_or(" |".to_owned(), |figure| format!(" {} |", row.show(figure)))
            })
            .collect();
        writeln!(text, "| {} |{cells}", title(row)).expect("a string takes it");
        let phases = reports.iter().map(|report| report.phases.get(row.key));
        if phases.clone().any(|phase| phase.is_some()) {
            let cells: String = phases
                .map(|phase| phase.map_or(" |".to_owned(), |phase| format!(" `{phase}` |")))
                .collect();
            writeln!(text, "| - at |{cells}").expect("a string takes it");
        }
    }
    text
}

/// The rows that the project's README shows, by key.
const SUMMARY: [&str; 5] = ["flash", "ram", "sync_median", "sync_worst", "read_worst"];

/// The figures of one model that the project's README shows, as a Markdown table.
pub fn summary(report: &Report) -> String {
    let mut text = format!("| what | `{}` |\n|---|---|\n", report.model);
    for row in SUMMARY.into_iter().filter_map(Row::find) {
        if let Some(figure) = report.figure(row.key) {
            writeln!(text, "| {} | {} |", title(row), row.show(figure)).expect("a string takes it");
        }
    }
    text
}

/// The title of a row in Markdown: instructions have no unit beside the figure.
fn title(row: &Row) -> String {
    match row.unit {
        Unit::Instructions => format!("{}, instructions", row.title),
        Unit::Bytes | Unit::Nanoseconds | Unit::Saves => row.title.to_owned(),
    }
}

/// The models with their figures, recorded figures and definitions of the rows.
pub fn json(reports: &[Report], recorded: &Recorded) -> Value {
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
                    "recorded": recorded.of(report.model, row),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Phases;

    fn report(model: &'static str, figures: &[(&str, u64)]) -> Report {
        let found = |(key, figure): &(&str, u64)| (Row::find(key).unwrap(), *figure);
        Report {
            model,
            figures: figures.iter().map(found).collect(),
            phases: Default::default(),
            sweep: Phases::All,
            speed: 1.0,
        }
    }

    #[test]
    fn markdown_has_a_column_per_model_and_omits_unused_rows() {
        let mut reports = [
            report(
                "is2",
                &[("flash", 18_000), ("ram_core", 0), ("load_off", 900)],
            ),
            report("is1", &[("flash", 17_000), ("sync_worst", 12_346)]),
        ];
        let phase = "Node::sample".to_owned();
        reports[1].phases.insert("sync_worst", phase);
        let expected = "\
| what | `is2` | `is1` |
|---|---|---|
| flash | 18000 B | 17000 B |
| load of a sample, filter off, instructions | 900 | |
| end of SYNC to reply, worst case | | 12.35 us |
| - at | | `Node::sample` |
";
        assert_eq!(markdown(&reports), expected);
    }

    #[test]
    fn summary_has_the_rows_of_the_readme() {
        let report = report("is2", &[("flash", 18_000), ("ram", 3_000), ("boot", 200)]);
        let expected = "\
| what | `is2` |
|---|---|
| flash | 18000 B |
| RAM with the stack's peak | 3000 B |
";
        assert_eq!(summary(&report), expected);
    }

    #[test]
    fn figures_are_shown_with_units() {
        let show = |key: &str, figure| Row::find(key).unwrap().show(figure).to_string();
        assert_eq!(show("flash", 20_480), "20480 B");
        assert_eq!(show("load_off", 420), "420");
        assert_eq!(show("sync_worst", 999_999), "1000.00 us");
        assert_eq!(show("boot_time", 123_456_789), "123.5 ms");
    }

    #[test]
    fn json_has_measured_and_recorded_figure() {
        let recorded = Recorded::parse("[is2]\nflash = 20").unwrap();
        let value = json(&[report("is2", &[("flash", 18), ("ram", 7)])], &recorded);
        let rows = &value["models"][0]["rows"];
        assert_eq!(value["models"][0]["model"], "is2");
        assert_eq!(
            (&rows[0]["figure"], &rows[0]["recorded"]),
            (&json!(18), &json!(20))
        );
        assert_eq!(
            (&rows[1]["key"], &rows[1]["recorded"]),
            (&json!("ram"), &Value::Null)
        );
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
