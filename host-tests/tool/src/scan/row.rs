//! What a scan has found, as a document and as a line.

use crate::error::Error;
use crate::identify::Found;
use crate::labels::Labels;
use crate::master::{Protocol, Target};
use crate::number::shown;
use crate::output::Terminal;
use plumbline::can::{BitRate, CanId};
use serde_json::{Number, Value, json};

/// A sensor, or a node that is only known from its frames.
#[derive(Clone, Debug)]
pub enum Row {
    /// A sensor that has answered.
    Found(Found),
    /// A node whose frames were heard.
    Heard(Heard),
}

/// What the frames of a node tell.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Heard {
    /// The name of the protocol in documents.
    pub protocol: &'static str,
    /// The address as text; None: the frames do not tell it.
    pub address: Option<String>,
    /// The serial number, if the frames contain it.
    pub serial: Option<u32>,
    /// What the frames tell besides: its maker, or which frames have shown it.
    pub text: Option<String>,
    /// The frames that have shown it.
    pub by: By,
}

/// What shows a node that was heard only.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum By {
    /// A message with its address.
    Message,
    /// Angles with this identifier, which does not contain the address. GEMAC: `request` is the Set-Parameter-ID, if the Reply-Parameter-ID
    /// is that as delivered.
    Cyclic {
        /// The identifier of the frames.
        reply: CanId,
        /// The identifier for requests, if it is known.
        request: Option<CanId>,
    },
    /// Its bootloader, which waits for a program.
    Bootloader,
    /// Messages of another master, which owns it.
    Owned,
    /// Process data that another device could also send.
    Likely,
}

impl Row {
    /// As a document; `rate` in kbit/s.
    pub fn json(&self, rate: Option<BitRate>) -> Value {
        let rate = rate.map(kbits);
        match self {
            Self::Found(found) => found.json(rate),
            Self::Heard(heard) => {
                let mut document = json!({
                    "rate": rate, "protocol": heard.protocol, "product": null, "address": heard.address,
                    "serial": heard.serial, "article": null, "firmware": null,
                });
                if let Some(text) = &heard.text {
                    document["heard"] = json!(text);
                }
                if !self.is_certain() {
                    document["likely"] = json!(true);
                }
                document
            }
        }
    }

    pub(super) fn address(&self) -> (&'static str, Option<String>) {
        match self {
            Self::Found(found) => (found.protocol(), Some(found.target.address())),
            Self::Heard(heard) => (heard.protocol, heard.address.clone()),
        }
    }

    /// Whether this row is the same node as an earlier one. An answer tells the Reply-Parameter-ID of a sensor in cyclic mode.
    fn is_same(&self, earlier: &Self) -> bool {
        let cyclic = |row: &Self| match row {
            Self::Heard(Heard {
                by: By::Cyclic { reply, .. },
                ..
            }) => Some(*reply),
            Self::Found(found) => found.target.reply(),
            Self::Heard(_) => None,
        };
        let is_cyclic = matches!(earlier, Self::Heard(heard) if heard.address.is_none());
        match is_cyclic {
            true => cyclic(self).is_some() && cyclic(self) == cyclic(earlier),
            false => self.address() == earlier.address(),
        }
    }

    /// Whether it shows the protocol of the bus.
    pub(super) fn is_protocol(&self) -> bool {
        match self {
            Self::Found(_) => true,
            Self::Heard(heard) => match heard.by {
                By::Message | By::Bootloader | By::Owned => true,
                By::Cyclic { request, .. } => request.is_some(),
                By::Likely => false,
            },
        }
    }

    /// Whether the frames or the answers show it for sure. The data of another device can have the form of cyclic mode, so only the
    /// Reply-Parameter-ID as delivered counts.
    pub(super) fn is_certain(&self) -> bool {
        match self {
            Self::Found(_) => true,
            Self::Heard(heard) => {
                !matches!(heard.by, By::Likely | By::Cyclic { request: None, .. })
            }
        }
    }

    /// The maximum number of questions to it. Where process data alone show an address, a question can be a command to another device.
    pub(super) fn questions(&self) -> usize {
        match self {
            Self::Heard(Heard {
                by: By::Likely | By::Cyclic { .. },
                ..
            }) => 2,
            _ => usize::MAX,
        }
    }

    fn is_answer(&self) -> bool {
        match self {
            Self::Found(_) => true,
            Self::Heard(heard) => heard.address.as_deref() == Some(UNCONFIGURED),
        }
    }

    /// As a line.
    pub fn text(&self, rate: Option<BitRate>) -> String {
        let document = self.json(rate);
        let text = |name: &str| match &document[name] {
            Value::String(text) => text.clone(),
            Value::Null => "-".to_owned(),
            other => other.to_string(),
        };
        let label = match self {
            Self::Found(Found {
                label: Some(label), ..
            }) => format!("  {label:?}"),
            _ => String::new(),
        };
        // What was heard of a node is no order number, but it is in the same place of the line.
        let article = match &self {
            Self::Heard(_) if document.get("heard").is_some() => text("heard"),
            _ => text("article"),
        };
        format!(
            "{} kbit/s  {}  {}  address {}  serial {}  {}  firmware {}{label}",
            text("rate"),
            text("protocol"),
            text("product"),
            text("address"),
            text("serial"),
            article,
            text("firmware")
        )
    }

    /// The same with the next step.
    fn line(&self, rate: Option<BitRate>) -> String {
        let known = self.text(rate);
        let rate = rate.map_or(String::new(), |rate| format!("--rate {} ", kbits(rate)));
        match self.next(&rate) {
            Some(next) => format!("{known}\n    {next}"),
            None => known,
        }
    }

    /// The next step; `rate` is the option with the bit rate.
    fn next(&self, rate: &str) -> Option<String> {
        let heard = match self {
            Self::Found(found) => {
                let option = found.target.protocol().option;
                let address = found.target.address();
                return Some(format!("plumbline {rate}{option} {address} get"));
            }
            Self::Heard(heard) => heard,
        };
        let address = heard.address.as_deref().unwrap_or("?");
        let option = Protocol::named(heard.protocol).map_or("", |own| own.option);
        match heard.by {
            By::Message => None,
            By::Bootloader => Some(format!(
                "plumbline {rate}{option} {address} update FILE    its bootloader waits for a program"
            )),
            By::Cyclic {
                request: Some(request),
                ..
            } => Some(format!(
                "plumbline {rate}{option} {} get    if the sensor still has its factory identifiers",
                shown(request).trim_end_matches('h')
            )),
            By::Cyclic { request: None, .. } => Some(format!(
                "its frames do not contain its Set-Parameter-ID: switch it off and on during `plumbline {rate}scan`, or search with `plumbline {rate}scan --search` if no other device is on the bus"
            )),
            By::Owned => Some(format!(
                "plumbline {rate}{option} {address} --product NAME watch --cyclic    listens only: another master owns the sensor"
            )),
            By::Likely => Some(format!(
                "plumbline {rate}{option} {address} get    if it is this sensor"
            )),
        }
    }
}

/// The address of a node without node-ID.
pub(crate) const UNCONFIGURED: &str = "unconfigured";

pub(crate) fn kbits(rate: BitRate) -> Value {
    let bits = rate.bits_per_second();
    if bits.is_multiple_of(1000) {
        return json!(bits / 1000);
    }
    Number::from_f64(f64::from(bits) / 1000.0).map_or(Value::Null, Value::Number)
}

/// What a scan has found. Each row is printed at once.
#[derive(Debug, Default)]
pub struct Rows {
    pub(super) labels: Labels,
    /// The bit rate of the bus; None: that of the interface, which does not tell it.
    pub rate: Option<BitRate>,
    /// The sensors and other nodes.
    pub rows: Vec<Row>,
}

impl Rows {
    /// Adds a row and prints it. An answer replaces what was only heard.
    ///
    /// # Errors
    /// The output is closed.
    pub(super) fn add(
        &mut self,
        rate: Option<BitRate>,
        mut row: Row,
        terminal: &mut Terminal,
    ) -> Result<(), Error> {
        if let Row::Found(found) = &mut row {
            found.label = self.labels.name(found);
        }
        self.rate = rate;
        terminal.line(row.line(rate))?;
        if let Row::Found(found) = &row
            && !found.twins.is_empty()
        {
            terminal.note(&found.twins());
        }
        match self.rows.iter_mut().find(|own| row.is_same(own)) {
            Some(own) => *own = row,
            None => self.rows.push(row),
        }
        terminal.found(&self.json());
        Ok(())
    }

    /// The result as a document for programs.
    pub fn json(&self) -> Value {
        self.rows.iter().map(|row| row.json(self.rate)).collect()
    }

    /// The sensor that has answered, if nobody else is on the bus.
    pub fn only_one(&self) -> Option<&Found> {
        match &self.rows[..] {
            [Row::Found(found)] => Some(found),
            _ => None,
        }
    }

    /// The sensors that have answered.
    pub fn found(&self) -> impl Iterator<Item = &Found> {
        self.rows.iter().filter_map(|row| match row {
            Row::Found(found) => Some(found),
            Row::Heard(_) => None,
        })
    }

    /// The nodes that are only known from their frames.
    pub fn heard(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| matches!(row, Row::Heard(_)))
    }

    /// The nodes that have answered.
    pub(super) fn answers(&self) -> usize {
        self.rows.iter().filter(|row| row.is_answer()).count()
    }

    /// Whether the sensor at an address has answered.
    pub(super) fn has_answered(&self, target: Target) -> bool {
        let is_same = |row: &Row| matches!(row, Row::Found(found) if found.target.is_at(target));
        self.rows.iter().any(is_same)
    }
}
