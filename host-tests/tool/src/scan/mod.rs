//! `scan`: unknown bit rate, unknown protocol, unknown address.
//!
//! 1. `listen`: at all rates, only listening. The first valid frame shows the rate.
//! 2. `passive`: what the frames tell. Addresses that nobody else talks to are asked who they are, with reads only.
//! 3. `active`: only after a yes. First the addresses as delivered at all rates, then all node-IDs and MAC IDs, and on request all
//!    identifiers.
//!
//! One question at a time. A bus has one rate: where somebody answers, no other rate is tried.

mod active;
mod listen;
mod passive;

use crate::adapter::{Adapter, Mode};
use crate::client::Link;
use crate::connect::RATES;
use crate::failure::Failure;
use crate::identify::{self, Found};
use crate::output::Terminal;
use crate::session::Target;
use listen::Heard;
use plumbline::can::BitRate;
use plumbline::time::after;
use serde_json::{Number, Value, json};

/// The options of a scan.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Only this rate.
    pub rate: Option<BitRate>,
    /// Ask at a silent bus without a question.
    pub active: bool,
    /// Ask for GEMAC sensors at all identifiers of 11 bits.
    pub search: bool,
}

/// A sensor, or a node that is only known from its frames.
#[derive(Clone, Debug)]
pub enum Row {
    /// It has answered.
    Found(Found),
    /// It was heard only: protocol, address, and what its message tells.
    Heard {
        /// The name of the protocol in documents.
        protocol: &'static str,
        /// The address as text.
        address: String,
        /// The serial number, if the message has it.
        serial: Option<u32>,
        /// What the message tells of its maker.
        article: Option<String>,
    },
}

impl Row {
    /// As a document; `rate` in kbit/s.
    pub fn json(&self, rate: Option<BitRate>) -> Value {
        let rate = rate.map(kbits);
        match self {
            Self::Found(found) => found.json(rate),
            Self::Heard {
                protocol,
                address,
                serial,
                article,
            } => json!({
                "rate": rate, "protocol": protocol, "product": null, "address": address,
                "serial": serial, "article": article, "firmware": null,
            }),
        }
    }

    fn address(&self) -> (&'static str, String) {
        match self {
            Self::Found(found) => (found.protocol(), found.target.address()),
            Self::Heard {
                protocol, address, ..
            } => (protocol, address.clone()),
        }
    }

    /// As a line, with the command that reads it.
    fn line(&self, rate: Option<BitRate>) -> String {
        let document = self.json(rate);
        let text = |name: &str| match &document[name] {
            Value::String(text) => text.clone(),
            Value::Null => "-".to_owned(),
            other => other.to_string(),
        };
        let known = format!(
            "{} kbit/s  {}  {}  address {}  serial {}  {}  firmware {}",
            text("rate"),
            text("protocol"),
            text("product"),
            text("address"),
            text("serial"),
            text("article"),
            text("firmware")
        );
        let Self::Found(found) = self else {
            return known;
        };
        let option = match found.target {
            Target::Fsc(_) => "--id",
            Target::Canopen(_) => "--node",
            Target::Devicenet(_) => "--mac",
        };
        let rate = rate.map_or(String::new(), |rate| format!("--rate {} ", kbits(rate)));
        format!(
            "{known}\n    plumbline {rate}{option} {} get",
            found.target.address()
        )
    }
}

/// A rate in kbit/s.
fn kbits(rate: BitRate) -> Value {
    let bits = rate.bits_per_second();
    if bits.is_multiple_of(1000) {
        return json!(bits / 1000);
    }
    Number::from_f64(f64::from(bits) / 1000.0).map_or(Value::Null, Value::Number)
}

/// Finds sensors and prints them.
///
/// # Errors
/// Nobody was found, or those of the adapter.
pub fn run(
    adapter: Box<dyn Adapter>,
    options: Options,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let mut link = Link::new(adapter);
    let rates = match (options.rate, link.adapter().capabilities().sets_rate) {
        (Some(rate), _) => vec![Some(rate)],
        (None, false) => vec![None],
        (None, true) => RATES.into_iter().map(Some).collect(),
    };
    let result = find(&mut link, &rates, options, terminal);
    link.adapter().close();
    report(&link, terminal);
    let (rate, rows) = result?;
    if rows.is_empty() {
        return Err(Failure::silent(
            "nothing-found",
            "no sensor was found: check power, wiring and terminators, then switch the sensor off and on during `plumbline scan`, or try `plumbline scan --search`",
        ));
    }
    for row in &rows {
        terminal.line(row.line(rate))?;
    }
    terminal.document(&rows.iter().map(|row| row.json(rate)).collect())
}

type Rows = (Option<BitRate>, Vec<Row>);

fn find(
    link: &mut Link,
    rates: &[Option<BitRate>],
    options: Options,
    terminal: &mut Terminal,
) -> Result<Rows, Failure> {
    let heard = match listen::all(link, rates, terminal) {
        // The user has been warned, and has said --active.
        Err(failure) if failure.code == "no-listen-only" && options.active => {
            terminal.note("the adapter has no listen-only mode: asking without listening first");
            None
        }
        heard => heard?,
    };
    let mut rows = Vec::new();
    let mut rate = None;
    if let Some(heard) = &heard {
        rate = heard.rate;
        rows = known(link, heard)?;
    }
    let enough = heard.is_some() && !rows.is_empty() && !options.active && !options.search;
    if enough {
        return Ok((rate, rows));
    }
    let question = match &heard {
        Some(_) => {
            "Somebody talks, but no sensor was recognised. Ask at all addresses? Other devices can take a question for a command."
        }
        None => "Nobody talks. Ask at all addresses and bit rates?",
    };
    if !options.active && !(terminal.confirm)(question) {
        if rows.is_empty() {
            terminal
                .note("nothing was asked: `plumbline scan --active` asks without this question");
        }
        return Ok((rate, rows));
    }
    let rates: Vec<Option<BitRate>> = match &heard {
        Some(heard) => vec![heard.rate],
        None => rates.to_vec(),
    };
    let (found_rate, found) = active::find(link, &rates, heard.as_ref(), options.search, terminal)?;
    for row in found {
        match rows.iter_mut().find(|own| own.address() == row.address()) {
            Some(own) => *own = row,
            None => rows.push(row),
        }
    }
    Ok((found_rate.or(rate), rows))
}

/// What the frames tell, with the answers of the addresses that nobody else talks to.
fn known(link: &mut Link, heard: &Heard) -> Result<Vec<Row>, Failure> {
    let mut rows = passive::rows(&heard.frames);
    if rows.is_empty() {
        return Ok(rows);
    }
    for row in &mut rows {
        let Some(target) = passive::target(row, &heard.frames) else {
            continue;
        };
        link.open(heard.rate, Mode::Active)?;
        let until = after(link.now(), passive::patience(&target));
        loop {
            if let Some(found) = identify::ask(link, target)? {
                *row = Row::Found(found);
                break;
            }
            if link.now() >= until {
                break;
            }
        }
    }
    Ok(rows)
}

/// Says what was sent.
fn report(link: &Link, terminal: &mut Terminal) {
    if link.sent().is_empty() {
        terminal.note("nothing was sent");
    }
    for (rate, count) in link.sent() {
        let rate = rate.map_or("the bit rate of the interface", BitRate::name);
        terminal.note(format!("sent {count} frames at {rate}"));
    }
}
