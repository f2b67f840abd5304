//! How far a commissioning is, in a file beside the plan.

use super::plan::{Item, Plan};
use crate::backup::{Unread, read_text, write_file};
use crate::counted::Settings;
use crate::error::{Error, Fault, FileError};
use crate::identify::Found;
use crate::master::Target;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use texts::told;

/// The first line of the file.
const HEADING: &str = "# How far `plumbline commission` is. Without this file it begins again.\n";

/// A sensor that was commissioned, or whose commissioning has begun.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Its name in the plan.
    pub name: String,
    /// Its product.
    pub product: String,
    /// Its serial number.
    pub serial: Option<u32>,
    /// The version of its firmware.
    pub firmware: Option<String>,
    /// Its address with the kind of the address.
    pub address: String,
    /// Its bit rate.
    pub rate: Option<String>,
    /// The settings that are compared.
    pub settings: usize,
    /// The angles after the zero.
    #[serde(default)]
    pub zero: Vec<String>,
    /// The settings are stored and compared after a restart.
    pub done: bool,
    /// The plan of this sensor.
    pub plan: String,
}

impl Row {
    /// A sensor of the plan whose commissioning begins, where it is now.
    pub fn begun(item: &Item, serial: Option<u32>, target: Target) -> Self {
        Self {
            name: item.name.clone(),
            product: item.product().name.to_owned(),
            serial,
            firmware: None,
            address: target.named(),
            rate: None,
            settings: item.settings.values.len(),
            zero: Vec::new(),
            done: false,
            plan: item.text.clone(),
        }
    }

    /// For people.
    pub fn line(&self) -> String {
        let serial = self.serial.map_or("none".to_owned(), |own| own.to_string());
        let rate = self.rate.as_deref();
        let rate = rate.map_or(String::new(), |rate| format!(" at {rate}"));
        let zero = match &self.zero[..] {
            [] => String::new(),
            angles => format!(", zero ({})", angles.join(", ")),
        };
        let (name, product, address) = (&self.name, &self.product, &self.address);
        let settings = Settings::from(self.settings);
        format!(
            "{name}  {product}, serial {serial}, {address}{rate}; {settings} stored and compared{zero}"
        )
    }
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    sensor: Vec<Row>,
}

/// How far a commissioning is.
#[derive(Clone, Debug)]
pub struct State {
    path: PathBuf,
    /// The sensors.
    pub rows: Vec<Row>,
}

impl State {
    /// Reads the file beside a plan. Without a file nothing has begun.
    ///
    /// # Errors
    /// The file cannot be read or is damaged, or the plan of a commissioned sensor was changed.
    pub fn beside(plan: &Path, content: &Plan) -> Result<Self, Error> {
        let path = plan.with_extension("state.toml");
        let name = path.display().to_string();
        let rows = match read_text(&path) {
            Ok(text) => {
                let file: Result<File, _> = toml::from_str(&text);
                let damaged = |error: toml::de::Error| {
                    FileError::State(name, Fault::Reason(told(error.message())))
                };
                file.map_err(damaged)?.sensor
            }
            Err(Unread::Failed(error)) if error.kind() == std::io::ErrorKind::NotFound => {
                Vec::new()
            }
            Err(Unread::Failed(error)) => {
                return Err(FileError::State(name, Fault::Reason(error.to_string())).into());
            }
            Err(Unread::Unfit(why)) => return Err(FileError::State(name, why.into()).into()),
        };
        let state = Self { path, rows };
        for item in &content.sensors {
            if let Some(row) = state.row(&item.name)
                && row.done
                && (row.plan != item.text || item.serial.is_some_and(|own| row.serial != Some(own)))
            {
                let why = Fault::ChangedPlan(item.name.clone());
                return Err(FileError::State(state.path.display().to_string(), why).into());
            }
        }
        Ok(state)
    }

    /// The sensor with this name.
    pub fn row(&self, name: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.name == name)
    }

    /// Whether this sensor is done. Makers can have the same serial number.
    pub fn is_done(&self, found: &Found) -> bool {
        let is_of = |row: &Row| found.products.iter().any(|own| own.name == row.product);
        let is_same = |row: &Row| row.done && row.serial == found.serial && is_of(row);
        found.serial.is_some() && self.rows.iter().any(is_same)
    }

    /// Takes a sensor and writes the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn keep(&mut self, row: Row) -> Result<(), Error> {
        let mut file = File {
            sensor: self.rows.clone(),
        };
        match file.sensor.iter_mut().find(|own| own.name == row.name) {
            Some(own) => *own = row,
            None => file.sensor.push(row),
        }
        let text = toml::to_string(&file).unwrap_or_default();
        write_file(&self.path, &format!("{HEADING}{text}"))?;
        self.rows = file.sensor;
        Ok(())
    }

    /// The path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn state_that_cannot_be_written_has_not_begun() {
        let folder = tempfile::tempdir().expect("a folder");
        let plan = folder.path().join("plan.toml");
        std::fs::write(&plan, "[[sensor]]\nname = \"a\"\nproduct = \"jn2101\"\n").expect("a file");
        let content = Plan::read(&plan, None).unwrap_or_else(|why| panic!("{why}"));
        let mut state = State::beside(&folder.path().join("gone/plan.toml"), &content)
            .unwrap_or_else(|why| panic!("{why}"));
        let item = &content.sensors[0];
        let target = item.target().expect("an address");
        let kept = state.keep(Row::begun(item, Some(7), target));
        assert!(kept.is_err(), "{:?}", state.rows);
        // Otherwise a note says that the file has the state.
        assert!(state.rows.is_empty(), "{:?}", state.rows);
    }
}
