//! Where the sensor of the last command was, for each adapter. A command uses it if its options do not say it:
//!
//! ```toml
//! port = "slcan:/dev/ttyACM0"
//!
//! ["slcan:/dev/ttyACM0"]
//! rate = "250"
//! protocol = "fsc"
//! address = "300"
//! ```

use crate::backup::{read_text, write_file};
use crate::cli::Options;
use crate::error::{Error, Why};
use crate::labels::folder;
use crate::master::{Addresses, Protocol, Target};
use crate::note::Note;
use crate::output::Terminal;
use crate::scan::kbits;
use plumbline::can::BitRate;
use std::path::{Path, PathBuf};
use texts::Kind;
use toml::{Table, Value};

/// The name of the file.
const FILE: &str = "last.toml";

/// The first line of the file.
const HEADING: &str =
    "# Where the sensor of the last command was. Delete this file to forget it.\n";

/// A virtual sensor inside of the program is a new one each time.
const DEMO: &str = "demo:";

/// What the tool remembers.
#[derive(Clone, Debug, Default)]
pub struct Last {
    /// None: there is no folder for it.
    path: Option<PathBuf>,
    table: Table,
}

impl Last {
    /// Reads the file in a folder, or in the folder of the user. A damaged file remembers nothing.
    pub fn open(wanted: Option<&Path>) -> Self {
        let path = folder(wanted).map(|path| path.join(FILE));
        let text = path.as_deref().and_then(|path| read_text(path).ok());
        let table = text.and_then(|text| text.parse().ok()).unwrap_or_default();
        Self { path, table }
    }

    /// The port of the last command.
    pub fn port(&self) -> Option<&str> {
        self.table.get("port")?.as_str()
    }

    fn text(&self, port: &str, key: &str) -> Option<&str> {
        self.table.get(port)?.get(key)?.as_str()
    }

    /// Fills in what the options do not say, and tells it. The address is only for a command for a sensor, and only at the same bit rate.
    /// True: bit rate or address are those of the last command.
    pub fn complete(
        &self,
        options: &Options,
        is_for_sensor: bool,
        terminal: &mut Terminal,
    ) -> (Options, bool) {
        let mut full = options.clone();
        let mut told = Vec::new();
        if full.port.is_none() {
            full.port = self.port().map(str::to_owned);
            told.extend(full.port.iter().map(|port| format!("--port {port}")));
        }
        let count = told.len();
        let port = full.port.clone().unwrap_or_default();
        let rate = self
            .text(&port, "rate")
            .and_then(|rate| bench::bit_rate(rate).ok());
        let has_address =
            full.sensor.first().is_some() || full.product.is_some() || full.eds.is_some();
        if is_for_sensor {
            let is_same_bus = full.rate.is_none() || full.rate == rate;
            if full.rate.is_none() && rate.is_some() {
                full.rate = rate;
                told.extend(
                    self.text(&port, "rate")
                        .map(|rate| format!("--rate {rate}")),
                );
            }
            if is_same_bus && !has_address {
                told.extend(self.address(&port, &mut full));
            }
        }
        if !told.is_empty() {
            terminal.note(&Note::LastCommand(told.join(" ")));
        }
        (full, told.len() > count)
    }

    /// Fills in the address. Returns its option.
    fn address(&self, port: &str, full: &mut Options) -> Option<String> {
        let address = self.text(port, "address")?;
        let protocol = Protocol::named(self.text(port, "protocol")?)?;
        (protocol.target)(address).ok()?;
        full.sensor = Addresses::one(protocol, address);
        Some(format!("{} {address}", protocol.option))
    }

    /// Remembers where a sensor is. Without a folder for it, or if it cannot be written, it is forgotten.
    pub fn keep(&mut self, port: &str, rate: Option<BitRate>, target: Target) {
        let Some(path) = self.path.as_deref().filter(|_| !port.starts_with(DEMO)) else {
            return;
        };
        let mut place = Table::new();
        let rate = rate.map(|rate| ("rate", kbits(rate).to_string()));
        let own = [
            ("protocol", target.protocol().name.to_owned()),
            ("address", target.address()),
        ];
        for (key, text) in rate.into_iter().chain(own) {
            place.insert(key.to_owned(), Value::String(text));
        }
        let old = self.table.clone();
        self.table
            .insert("port".to_owned(), Value::String(port.to_owned()));
        self.table.insert(port.to_owned(), Value::Table(place));
        if self.table != old {
            let _ = path.parent().map(std::fs::create_dir_all);
            let _ = write_file(path, &format!("{HEADING}{}", self.table));
        }
    }
}

/// The failure of a sensor that does not answer where the last one was.
pub fn explain(failure: Error) -> Error {
    match failure.kind() {
        Kind::Silent => failure.explained(Why::Remembered),
        _ => failure,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::master::{Ca, Node, canopen};
    use std::rc::Rc;

    /// The address in the options.
    fn address(options: &Options) -> Option<&str> {
        options.sensor.first().map(|(_, address)| address)
    }

    /// The options that these arguments get, and the note.
    fn completed(last: &Last, options: &Options, is_for_sensor: bool) -> (Options, String) {
        let (mut out, mut notes) = (Vec::new(), Vec::new());
        let mut terminal = Terminal {
            json: false,
            out: &mut out,
            notes: &mut notes,
            confirm: &mut |_| false,
            stopped: Rc::new(|| false),
            bar: None,
            yes: &[],
        };
        let (full, _) = last.complete(options, is_for_sensor, &mut terminal);
        (full, String::from_utf8(notes).unwrap())
    }

    #[test]
    fn each_adapter_has_its_own_rate_and_address() {
        let folder = tempfile::tempdir().unwrap();
        let mut last = Last::open(Some(folder.path()));
        last.keep("can0", Some(BitRate::K62_5), Target::Canopen(Node(33)));
        last.keep("slcan:COM3", None, Target::J1939(Ca(128)));
        last.keep("demo:is2", Some(BitRate::K250), Target::Canopen(Node(1)));
        let last = Last::open(Some(folder.path()));
        let none = Options::default();
        let (full, note) = completed(&last, &none, true);
        assert_eq!(
            (full.port.as_deref(), full.rate, address(&full)),
            (Some("slcan:COM3"), None, Some("128"))
        );
        assert_eq!(
            note,
            "as in the last command: --port slcan:COM3 --address 128\n"
        );
        let at = |port: &str| Options {
            port: Some(port.to_owned()),
            ..Options::default()
        };
        let (full, note) = completed(&last, &at("can0"), true);
        assert_eq!(
            (full.rate, address(&full)),
            (Some(BitRate::K62_5), Some("33"))
        );
        assert_eq!(note, "as in the last command: --rate 62.5 --node 33\n");
        for port in ["demo:is2", "can1"] {
            let (full, note) = completed(&last, &at(port), true);
            assert_eq!(
                (full.rate, address(&full), &note[..]),
                (None, None, ""),
                "{port}"
            );
        }
    }

    #[test]
    fn options_of_the_user_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let mut last = Last::open(Some(folder.path()));
        last.keep("can0", Some(BitRate::K125), Target::Canopen(Node(33)));
        let can0 = Options {
            port: Some("can0".to_owned()),
            ..Options::default()
        };
        let other_rate = Options {
            rate: Some(BitRate::K500),
            ..can0.clone()
        };
        assert_eq!(address(&completed(&last, &other_rate, true).0), None);
        let other_node = Options {
            sensor: Addresses::one(&canopen::PROTOCOL, "5"),
            ..can0.clone()
        };
        let (full, note) = completed(&last, &other_node, true);
        assert_eq!(
            (address(&full), full.rate),
            (Some("5"), Some(BitRate::K125))
        );
        assert_eq!(note, "as in the last command: --rate 125\n");
        let product = Options {
            product: Some("is2".to_owned()),
            ..can0.clone()
        };
        assert_eq!(address(&completed(&last, &product, true).0), None);
        // A scan and a log listen at all rates.
        let (full, note) = completed(&last, &Options::default(), false);
        assert_eq!(
            (full.port.as_deref(), full.rate, address(&full)),
            (Some("can0"), None, None)
        );
        assert_eq!(note, "as in the last command: --port can0\n");
    }

    #[test]
    fn damaged_file_remembers_nothing_and_missing_folder_is_made() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(FILE), "port = [").unwrap();
        let last = Last::open(Some(folder.path()));
        assert_eq!(completed(&last, &Options::default(), true).0.port, None);
        let missing = folder.path().join("a/b");
        Last::open(Some(&missing)).keep("can0", None, Target::Canopen(Node(1)));
        assert_eq!(Last::open(Some(&missing)).port(), Some("can0"));
        std::fs::write(
            folder.path().join(FILE),
            "port = \"can0\"\n[can0]\nrate = \"7\"\nprotocol = \"canopen\"\naddress = \"999\"",
        )
        .unwrap();
        let (full, note) = completed(&Last::open(Some(folder.path())), &Options::default(), true);
        assert_eq!((full.rate, address(&full)), (None, None), "{note}");
    }
}
