//! The newest frame of each identifier, with count and period.

use super::Decoded;
use plumbline::can::Frame;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

/// The frames with an identifier.
#[derive(Clone, Debug)]
struct Row {
    newest: Frame,
    decoded: Option<Decoded>,
    count: u64,
    /// The times of the first and of the newest frame, in us.
    first: u64,
    last: u64,
}

impl Row {
    /// The mean time between two frames, in us.
    fn period(&self) -> Option<u64> {
        let gaps = self.count.checked_sub(1).filter(|gaps| *gaps > 0)?;
        Some(self.last.saturating_sub(self.first) / gaps)
    }
}

/// The list: 11-bit identifiers first.
#[derive(Clone, Debug, Default)]
pub struct List(BTreeMap<u32, Row>);

impl List {
    /// A frame has come at this time in us.
    pub fn take(&mut self, at: u64, frame: &Frame, decoded: Option<Decoded>) {
        let row = self.0.entry(frame.can_id().bits());
        let row = row.or_insert_with(|| Row {
            newest: *frame,
            decoded: None,
            count: 0,
            first: at,
            last: at,
        });
        row.count += 1;
        (row.newest, row.decoded, row.last) = (*frame, decoded, at);
    }

    /// As a document.
    pub fn json(&self) -> Value {
        let row = |row: &Row| {
            let mut document = json!({
                "frame": format!("{:?}", row.newest),
                "count": row.count,
                "period": row.period().map(|period| period as f64 / 1000.0),
            });
            if let (Some(fields), Some(decoded)) = (document.as_object_mut(), &row.decoded) {
                fields.extend(decoded.json());
            }
            document
        };
        self.0.values().map(row).collect()
    }
}

impl Display for List {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        writeln!(
            f,
            "{:>10} {:>8} {:>10}  {:<23}  meaning",
            "identifier", "count", "period/ms", "data"
        )?;
        for row in self.0.values() {
            let frame = format!("{:?}", row.newest);
            let (id, _) = frame.split_once('#').unwrap_or_default();
            let bytes = row.newest.bytes().iter();
            let bytes: Vec<String> = bytes.map(|byte| format!("{byte:02X}")).collect();
            let data = match row.newest.is_remote() {
                true => "RTR".to_owned(),
                false => bytes.join(" "),
            };
            let period = row.period().map_or("-".to_owned(), |period| {
                format!("{:.1}", period as f64 / 1000.0)
            });
            let text = row.decoded.as_ref().map(Decoded::to_string);
            let text = text.unwrap_or_default();
            let line = format!("{id:>10} {:>8} {period:>10}  {data:<23}  {text}", row.count);
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}
