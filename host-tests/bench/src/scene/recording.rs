//! A motion recorded in a CSV file.

use super::{SUPPLIES, Sample, TEMPERATURES};
use crate::file;
use std::ops::Range;
use std::path::Path;

/// The columns that a file can have, in any order.
const COLUMNS: [&str; 9] = [
    "t_s", "ax_g", "ay_g", "az_g", "gx_dps", "gy_dps", "gz_dps", "temp_c", "supply_v",
];

/// The length of the longest file in bytes: a day with 100 rows/s.
const LONGEST: u64 = 1 << 30;

/// The columns that every file has.
const REQUIRED: usize = 4;

/// The columns that can be omitted, in groups.
const OPTIONAL: [Range<usize>; 3] = [4..7, TEMPERATURE..8, SUPPLY..9];

/// The index of the column of the temperature.
const TEMPERATURE: usize = 7;

/// The index of the column of the supply.
const SUPPLY: usize = 8;

/// What surrounds a sensor: a column with its lowest and its highest value.
const LIMITS: [(usize, (f64, f64)); 2] = [(TEMPERATURE, TEMPERATURES), (SUPPLY, SUPPLIES)];

/// Rows of a CSV file, in order of time.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Recording {
    /// Time in seconds; at least one row.
    rows: Vec<(f64, Sample)>,
}

impl Recording {
    /// Reads the file; an error is one sentence that names the file and the line.
    pub(super) fn open(path: &Path) -> Result<Self, String> {
        let name = path.display();
        let bytes =
            file::read(path, LONGEST).map_err(|why| format!("cannot read {name}: {why}"))?;
        let text = file::decoded(&bytes).text;
        Self::parse(text.as_bytes())
            .map_err(|Mistake { line, what }| format!("{name}:{line}: {what}"))
    }

    /// Reads the text of a file; an error is one sentence that names the line.
    pub(super) fn of_text(text: &str) -> Result<Self, String> {
        Self::parse(text.as_bytes())
            .map_err(|Mistake { line, what }| format!("line {line}: {what}"))
    }

    fn parse(bytes: &[u8]) -> Result<Self, Mistake> {
        let mut lines = bytes
            .split(|byte| *byte == b'\n')
            .enumerate()
            .map(|(index, text)| (index + 1, text.trim_ascii()))
            .filter(|(_, text)| !text.is_empty() && !text.starts_with(b"#"));
        let (mut last, header) = lines.next().ok_or_else(|| {
            mistake(
                1,
                "the header is missing; it must be t_s,ax_g,ay_g,az_g".into(),
            )
        })?;
        let columns = read_header(last, header)?;
        let mut rows: Vec<(f64, Sample)> = Vec::new();
        for (line, text) in lines {
            let row = read_row(line, text, &columns)?;
            if let Some((previous, _)) = rows.last()
                && row.0 <= *previous
            {
                let time = row.0;
                return Err(mistake(
                    line,
                    format!("the time must rise, but {time} follows {previous}"),
                ));
            }
            rows.push(row);
            last = line;
        }
        if rows.is_empty() {
            return Err(mistake(
                last,
                "there is no data row after the header".into(),
            ));
        }
        Ok(Self { rows })
    }

    /// The time of the last row.
    pub(super) fn end(&self) -> f64 {
        self.rows.last().map_or(0.0, |(time, _)| *time)
    }

    /// The sample at this time in seconds.
    pub(super) fn at(&self, seconds: f64) -> Sample {
        let next = self.rows.partition_point(|(time, _)| *time <= seconds);
        let before = self.rows[next.saturating_sub(1)];
        let after = self.rows[next.min(self.rows.len() - 1)];
        let length = after.0 - before.0;
        if length <= 0.0 {
            return before.1;
        }
        let part = (seconds - before.0) / length;
        let between = |from: f64, to: f64| from * (1.0 - part) + to * part;
        let vector = |from: [f64; 3], to: [f64; 3]| [0, 1, 2].map(|i| between(from[i], to[i]));
        Sample {
            force: vector(before.1.force, after.1.force),
            rate: vector(before.1.rate, after.1.rate),
            temperature: between(before.1.temperature, after.1.temperature),
            supply: between(before.1.supply, after.1.supply),
        }
    }
}

/// An error and its line.
struct Mistake {
    line: usize,
    what: String,
}

fn mistake(line: usize, what: String) -> Mistake {
    Mistake { line, what }
}

/// The fields of a line, without surrounding blanks.
fn fields(line: usize, text: &[u8]) -> Result<Vec<&str>, Mistake> {
    let text =
        std::str::from_utf8(text).map_err(|_| mistake(line, "the line is not text".into()))?;
    Ok(text.split(',').map(str::trim).collect())
}

/// The columns of the file, as indices of [`COLUMNS`].
fn read_header(line: usize, text: &[u8]) -> Result<Vec<usize>, Mistake> {
    let names = fields(line, text)?;
    let mut columns: Vec<usize> = (0..REQUIRED).collect();
    for group in OPTIONAL {
        let name = names.get(columns.len());
        // The group of the gyroscope also if a column of it is missing, so that the error names that column.
        if name.is_some_and(|name| COLUMNS[group.clone()].contains(name)) {
            columns.extend(group);
        }
    }
    for (index, &column) in columns.iter().enumerate() {
        let name = COLUMNS[column];
        match names.get(index) {
            Some(found) if *found == name => {}
            Some(found) => {
                return Err(mistake(
                    line,
                    format!("column {} must be {name}, not \"{found}\"", index + 1),
                ));
            }
            None => return Err(mistake(line, format!("column {name} is missing"))),
        }
    }
    match names.get(columns.len()) {
        Some(extra) => Err(mistake(line, format!("there is no column \"{extra}\""))),
        None => Ok(columns),
    }
}

fn read_row(line: usize, text: &[u8], columns: &[usize]) -> Result<(f64, Sample), Mistake> {
    let fields = fields(line, text)?;
    if let Some(&missing) = columns.get(fields.len()) {
        let name = COLUMNS[missing];
        return Err(mistake(line, format!("column {name} is missing")));
    }
    if fields.len() > columns.len() {
        let (values, columns) = (fields.len(), columns.len());
        return Err(mistake(
            line,
            format!("there are {values} values for {columns} columns"),
        ));
    }
    let mut values = [0.0; COLUMNS.len()];
    values[TEMPERATURE] = Sample::ROOM;
    values[SUPPLY] = Sample::SUPPLY;
    for (&column, text) in columns.iter().zip(&fields) {
        let name = COLUMNS[column];
        let value: f64 = text
            .parse()
            .map_err(|_| mistake(line, format!("{name} is not a number: \"{text}\"")))?;
        if !value.is_finite() {
            return Err(mistake(line, format!("{name} is not finite: \"{text}\"")));
        }
        if let Some((_, (low, high))) = LIMITS.iter().find(|(limited, _)| *limited == column)
            && !(*low..=*high).contains(&value)
        {
            let what = format!("{name} is {low} to {high}, not {text}");
            return Err(mistake(line, what));
        }
        values[column] = value;
    }
    let [time, ax, ay, az, gx, gy, gz, temperature, supply] = values;
    Ok((
        time,
        Sample {
            force: [ax, ay, az],
            rate: [gx, gy, gz],
            temperature,
            supply,
        },
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &[u8]) -> String {
        match Recording::parse(text) {
            Ok(recording) => panic!("accepted: {recording:?}"),
            Err(Mistake { line, what }) => format!("{line}: {what}"),
        }
    }

    fn parse(text: &str) -> Recording {
        Recording::parse(text.as_bytes())
            .unwrap_or_else(|mistake| panic!("{}: {}", mistake.line, mistake.what))
    }

    #[test]
    fn columns_of_gyroscope_can_be_omitted() {
        let recording = parse("t_s,ax_g,ay_g,az_g,temp_c\n0,0.1,0.2,0.3,40\n");
        let sample = recording.at(0.0);
        assert_eq!((sample.force, sample.rate), ([0.1, 0.2, 0.3], [0.0; 3]));
        assert_eq!(sample.temperature, 40.0);
    }

    #[test]
    fn each_error_has_line_and_reason() {
        let cases: &[(&[u8], &str)] = &[
            (
                b"",
                "1: the header is missing; it must be t_s,ax_g,ay_g,az_g",
            ),
            (
                b"# c\n\n",
                "1: the header is missing; it must be t_s,ax_g,ay_g,az_g",
            ),
            (b"0,0,0,1\n", "1: column 1 must be t_s, not \"0\""),
            (b"#\nt_s,ax_g,ay_g\n", "2: column az_g is missing"),
            (
                b"t_s,ax_g,az_g,ay_g\n",
                "1: column 3 must be ay_g, not \"az_g\"",
            ),
            (
                b"t_s,ax_g,ay_g,az_g,gx_dps\n",
                "1: column gy_dps is missing",
            ),
            (
                b"t_s,ax_g,ay_g,az_g,temp_c,gx_dps\n",
                "1: there is no column \"gx_dps\"",
            ),
            (
                b"t_s,ax_g,ay_g,az_g,temp_c\n0,0,0,1\n",
                "2: column temp_c is missing",
            ),
            (
                b"t_s,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps,temp_c,x\n",
                "1: there is no column \"x\"",
            ),
            (
                b"t_s,ax_g,ay_g,az_g\n# none\n",
                "1: there is no data row after the header",
            ),
            (
                b"t_s,ax_g,ay_g,az_g\n\n0,0,0\n",
                "3: column az_g is missing",
            ),
            (
                b"t_s,ax_g,ay_g,az_g\n0,0,0,1,5\n",
                "2: there are 5 values for 4 columns",
            ),
            (
                b"t_s,ax_g,ay_g,az_g\r\n0,0,up,1\r\n",
                "2: ay_g is not a number: \"up\"",
            ),
            (
                b"t_s,ax_g,ay_g,az_g\n0,0,,1\n",
                "2: ay_g is not a number: \"\"",
            ),
            (
                b"t_s,ax_g,ay_g,az_g\n0,0,0,NaN\n",
                "2: az_g is not finite: \"NaN\"",
            ),
            (
                b"t_s,ax_g,ay_g,az_g\n1e999,0,0,1\n",
                "2: t_s is not finite: \"1e999\"",
            ),
            (
                b"t_s,ax_g,ay_g,az_g\n1,0,0,1\n# c\n1,0,0,1\n",
                "4: the time must rise, but 1 follows 1",
            ),
            (
                b"t_s,ax_g,ay_g,az_g\n1,0,0,1\n0.5,0,0,1\n",
                "3: the time must rise, but 0.5 follows 1",
            ),
            (
                b"t_s,ax_g,ay_g,az_g,temp_c\n0,0,0,1,20\n1,0,0,1,1e9\n",
                "3: temp_c is -100 to 200, not 1e9",
            ),
            (
                b"t_s,ax_g,ay_g,az_g,supply_v\n0,0,0,1,-5\n",
                "2: supply_v is 0 to 60, not -5",
            ),
            (b"\xFF\xFE\n", "1: the line is not text"),
        ];
        for (text, expected) in cases {
            assert_eq!(error(text), *expected);
        }
    }

    #[test]
    fn values_are_linear_between_rows_and_held_at_ends() {
        let recording = parse("t_s,ax_g,ay_g,az_g\n1, 0, 0, 1\n3, 1, -1, 0\n4, 1, -1, 0\n");
        let force = |seconds| recording.at(seconds).force;
        assert_eq!(force(0.0), [0.0, 0.0, 1.0]);
        assert_eq!(force(1.0), [0.0, 0.0, 1.0]);
        assert_eq!(force(1.5), [0.25, -0.25, 0.75]);
        assert_eq!(force(3.0), [1.0, -1.0, 0.0]);
        assert_eq!(force(3.7), [1.0, -1.0, 0.0]);
        assert_eq!(force(1e9), [1.0, -1.0, 0.0]);
        assert_eq!(recording.at(2.0).temperature, 25.0);
        assert_eq!(recording.at(2.0).rate, [0.0; 3]);
    }

    #[test]
    fn optional_columns_give_rates_and_temperature() {
        let recording = parse(
            "# a comment\nt_s,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps,temp_c\n0,0,0,1,1,2,3,-40\n2,0,0,1,3,2,1,85\n",
        );
        assert_eq!(recording.at(1.0).rate, [2.0, 2.0, 2.0]);
        assert_eq!(recording.at(1.0).temperature, 22.5);
        let recording = parse("t_s,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps\n0,0,0,1,1,2,3\n");
        assert_eq!(recording.at(5.0).rate, [1.0, 2.0, 3.0]);
        assert_eq!(recording.at(5.0).temperature, 25.0);
        assert_eq!(recording.at(5.0).supply, 24.0);
    }

    #[test]
    fn supply_column_is_last() {
        for columns in [
            "",
            ",temp_c",
            ",gx_dps,gy_dps,gz_dps",
            ",gx_dps,gy_dps,gz_dps,temp_c",
        ] {
            let zeros = ",0".repeat(columns.matches(',').count());
            let recording = parse(&format!(
                "t_s,ax_g,ay_g,az_g{columns},supply_v\n0,0,0,1{zeros},10\n2,0,0,1{zeros},12\n"
            ));
            assert_eq!(recording.at(1.0).supply, 11.0, "{columns}");
        }
        let wrong = b"t_s,ax_g,ay_g,az_g,supply_v,temp_c\n0,0,0,1,1,1\n";
        assert_eq!(error(wrong), "1: there is no column \"temp_c\"");
    }
}
