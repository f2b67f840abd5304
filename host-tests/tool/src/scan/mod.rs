//! `scan`: unknown bit rate, unknown protocol, unknown address.
//!
//! 1. `listen`: at all rates, only listening. The first valid frame shows the rate.
//! 2. `passive`: what the frames tell, by the `signs` of each protocol. Nodes that are certain, and whose identifiers no other device uses, are asked who they are.
//! 3. `active`: only after a yes. First the addresses as delivered at all rates, then all node-IDs and MAC IDs, and on request all
//!    identifiers.
//!
//! One question at a time. A bus has one rate and one protocol: where somebody answers, no other rate is tried, and where a node shows
//! its protocol, the others are not asked.

mod active;
pub mod listen;
mod memory;
pub mod passive;
pub(crate) mod row;
pub mod schedule;
pub(crate) mod signs;

use crate::connect::RATES;
use crate::counted::Frames;
use crate::error::{Error, Rates, SensorError};
use crate::identify;
use crate::labels::Labels;
use crate::link::Link;
use crate::master::Target;
use crate::note::{At, Note};
use crate::number::shown;
use crate::output::Terminal;
use crate::question::Question;
pub use active::Questions;
use adapter::{Adapter, AdapterError, Mode};
use listen::Traffic;
pub use memory::Memory;
use passive::Sighting;
use plumbline::can::BitRate;
use plumbline::time::after;
pub use row::Row;
use row::Rows;
pub(crate) use row::kbits;
use schedule::Schedule;

/// The options of a scan.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Only this bit rate; None: all.
    pub rate: Option<BitRate>,
    /// Ask at a silent bus without a question.
    pub active: bool,
    /// Ask for GEMAC sensors at all identifiers of 11 bits.
    pub search: bool,
    /// What an earlier scan has heard.
    pub memory: Memory,
}

/// Finds sensors, and prints each one at once.
///
/// # Errors
/// Nobody was found, or the adapter fails.
pub fn run(
    adapter: Box<dyn Adapter>,
    options: Options,
    labels: Labels,
    terminal: &mut Terminal,
) -> Result<Rows, Error> {
    let mut link = Link::new(adapter, &terminal.stopped);
    let rates = match (options.rate, link.adapter().capabilities().sets_rate) {
        (Some(rate), _) => vec![Some(rate)],
        (None, false) => vec![None],
        (None, true) => RATES.into_iter().map(Some).collect(),
    };
    let mut rows = Rows {
        labels,
        ..Rows::default()
    };
    let result = find(&mut link, &rates, &options, &mut rows, terminal);
    terminal.hide();
    link.close();
    report(&link, terminal);
    let heard = match result {
        // The rows are complete so far.
        Err(failure) if failure.is_stopped() && !rows.rows.is_empty() && terminal.json => {
            terminal.document(&rows.json())?;
            return Err(failure.after_document());
        }
        heard => heard?,
    };
    if rows.rows.is_empty() {
        return Err(match heard {
            Some(heard) => unknown(&heard),
            None => SensorError::NotFound.into(),
        });
    }
    Ok(rows)
}

/// The identifiers that a message names.
const NAMED: usize = 8;

/// There is traffic, but nobody in it was recognised, and nobody has answered.
fn unknown(heard: &Traffic) -> Error {
    let mut ids = Vec::new();
    for (_, frame) in &heard.frames {
        if !ids.contains(&frame.can_id()) {
            ids.push(frame.can_id());
        }
    }
    let mut named: Vec<String> = ids.iter().take(NAMED).map(|id| shown(*id)).collect();
    if ids.len() > NAMED {
        named.push(format!("{} more", ids.len() - NAMED));
    }
    let at = heard
        .rate
        .map_or(Rates::Own, |rate| Rates::One(rate.name()));
    let option = heard
        .rate
        .map_or(String::new(), |rate| format!("--rate {} ", kbits(rate)));
    SensorError::NotRecognised(at, named.join(", "), option).into()
}

/// Adds what is found to the rows, and returns what was heard.
fn find(
    link: &mut Link,
    rates: &[Option<BitRate>],
    options: &Options,
    rows: &mut Rows,
    terminal: &mut Terminal,
) -> Result<Option<Traffic>, Error> {
    // With --active or --search the tool does not wait for a sensor that is switched on.
    let waits = !options.active && !options.search;
    let schedule = Schedule::of(rates, waits).shown();
    let heard = options.memory.listen(link, &schedule, terminal);
    let heard = match heard {
        // The user has been warned, and has said --active.
        Err(failure) if failure.lacks_listen_only() && options.active => {
            terminal.note(&Note::AsksAtOnce);
            None
        }
        heard => heard?,
    };
    let frames = heard.as_ref().map_or(&[][..], |heard| &heard.frames);
    let sightings = passive::sightings(frames);
    if let Some(heard) = &heard {
        known(link, heard.rate, &sightings, rows, terminal)?;
    }
    if rows.rows.iter().any(Row::is_certain) && waits {
        return Ok(heard);
    }
    let question = match &heard {
        Some(_) if !rows.rows.is_empty() => Question::More,
        Some(_) => Question::AllAddresses,
        None => Question::Silent,
    };
    // --active answers the question for a bus without traffic only.
    let is_answered = options.active && heard.is_none();
    if !is_answered && !terminal.ask(&question)? {
        if rows.rows.is_empty() {
            let option = if heard.is_none() { "--active" } else { "--yes" };
            terminal.note(&Note::NotAsked(option));
        }
        return Ok(heard);
    }
    let protocol = passive::protocol(&sightings);
    if let Some(protocol) = protocol {
        terminal.note(&Note::Protocol(protocol));
    }
    let rates: Vec<Option<BitRate>> = match &heard {
        Some(heard) => vec![heard.rate],
        None => rates.to_vec(),
    };
    let questions = Questions {
        frames,
        protocol,
        search: options.search,
    };
    questions.ask(link, &rates, rows, terminal)?;
    Ok(heard)
}

/// What the frames tell, with the answers of the nodes.
fn known(
    link: &mut Link,
    rate: Option<BitRate>,
    sightings: &[Sighting],
    rows: &mut Rows,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    for told in passive::twins(sightings) {
        terminal.note(&told);
    }
    for sighting in sightings {
        // Another node with this address has answered.
        if sighting.target.is_some_and(|own| rows.has_answered(own)) {
            continue;
        }
        let mut row = sighting.row.clone();
        let question = |target: Target| Question::Likely {
            protocol: target.protocol().name.to_owned(),
            address: target.address(),
        };
        if let Some(target) = sighting.target
            && (sighting.is_sure || terminal.ask(&question(target))?)
        {
            match link.open(rate, Mode::Active) {
                // An interface of Linux: the message says what to type.
                Err(failure @ Error::Adapter(AdapterError::OnlyListens(..))) => {
                    terminal.note(&failure);
                }
                opened => {
                    opened?;
                    row = asked(link, target, row.questions())?.unwrap_or(row);
                }
            }
        }
        rows.add(rate, row, terminal)?;
    }
    Ok(())
}

/// The answer of a node that was heard, to at most this number of questions.
fn asked(link: &mut Link, target: Target, most: usize) -> Result<Option<Row>, Error> {
    let until = after(link.now(), target.patience());
    for _ in 0..most {
        if let Some(found) = identify::ask_all(link, target, identify::PATIENT)? {
            return Ok(Some(Row::Found(found)));
        }
        if link.now() >= until {
            break;
        }
    }
    Ok(None)
}

/// Says what was sent.
pub(crate) fn report(link: &Link, terminal: &mut Terminal) {
    if link.sent().is_empty() {
        terminal.note(match link.takes_part() {
            true => &Note::OnlyAcknowledged,
            false => &Note::NothingSent,
        });
    }
    for (rate, count) in link.sent() {
        terminal.note(&Note::Sent(Frames(*count), At::from(*rate)));
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests;
