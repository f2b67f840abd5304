//! The order of writes: after each of them the sensor must have permitted values.
//!
//! - The unit that others follow comes first; bit rate and addresses come last.
//! - CAN identifiers must differ at each step; where two are exchanged, one has a temporary identifier in between.
//! - A PDO of CANopen is switched off while its COB-ID, mapping, inhibit time or SYNC start value changes, the EMCY while its COB-ID
//!   changes.
//! - If the NMT state Operational forbids a write, the node is Pre-operational meanwhile. A node that stores forbids it too: that is
//!   waited for.
//! - A write that the sensor refuses is tried again after the others: filter and cut-off frequency depend on each other.

use crate::error::{Error, NumberError, SensorError};
use crate::master::Roles;
use crate::master::canopen::cob_ids;
use crate::session::Session;
use crate::sheet::{Entry, Origin};
use plumbline::can::CanId;
use plumbline::model::catalog::Product;
use plumbline::param::{ParameterId, Relation};
use plumbline::time::{Duration, millis};

/// Checked values with their entries.
pub type Values = Vec<(Entry, u32)>;

/// Writes values in an order in which the sensor accepts them. Does not read them back.
///
/// # Errors
/// The sensor refuses a value, nobody answers, or the adapter fails.
pub fn write(session: &mut Session, values: &Values) -> Result<(), Error> {
    let written = write_all(session, values);
    if !is_wrong_state(&written) {
        return written;
    }
    let target = session.target;
    let was_in_operation = target.suspend(&mut session.link)?;
    let written = match was_in_operation {
        true => write_all(session, values),
        false => written,
    };
    let written = patiently(session, values, written);
    if was_in_operation {
        target.resume(&mut session.link)?;
    }
    written
}

fn is_wrong_state(written: &Result<(), Error>) -> bool {
    matches!(written, Err(Error::Sensor(SensorError::WrongState(..))))
}

/// Repeats a write that the present state of the sensor forbids, until it has stored what it stores.
fn patiently(
    session: &mut Session,
    values: &Values,
    mut written: Result<(), Error>,
) -> Result<(), Error> {
    for _ in 0..REPETITIONS {
        if !is_wrong_state(&written) {
            break;
        }
        session.link.wait_for(STORING, |_| None::<()>)?;
        written = write_all(session, values);
    }
    written
}

/// The pause before a write is repeated that the present state of the sensor forbids.
const STORING: Duration = millis(100);

/// The number of times it is repeated.
const REPETITIONS: u8 = 10;

fn write_all(session: &mut Session, values: &Values) -> Result<(), Error> {
    let product = session.sheet.product;
    let mut sorted = values.clone();
    sorted.sort_by_key(|(entry, _)| rank(product, entry));
    let (exclusive, rest): (Values, Values) = sorted
        .into_iter()
        .partition(|(entry, _)| is_exclusive(product, entry));
    let (first, last): (Values, Values) = rest
        .into_iter()
        .partition(|(entry, _)| rank(product, entry) < LAST);
    let first = cob_ids::pdos(session, first)?;
    let first = cob_ids::others(session, first)?;
    retried(session, first)?;
    retried(session, last)?;
    identifiers(session, exclusive)
}

/// The rank of bit rate and addresses.
const LAST: u8 = 2;

fn rank(product: &Product, entry: &Entry) -> u8 {
    let Origin::Parameter(id) = entry.origin else {
        return 1;
    };
    if product
        .guide
        .resolution
        .is_some_and(|resolution| resolution.parameter == id)
    {
        return 0;
    }
    match Roles::of(product) {
        Some(roles) if roles.is_rate(id) => LAST,
        Some(roles) if roles.is_address(id) => LAST + 1,
        _ => 1,
    }
}

/// Whether a parameter must differ from another one.
fn is_exclusive(product: &Product, entry: &Entry) -> bool {
    product
        .constraints
        .iter()
        .any(|constraint| match constraint.relation {
            Relation::Different(one, other) => [one, other]
                .iter()
                .any(|id| entry.origin == Origin::Parameter(*id)),
            Relation::AtMost { .. } => false,
        })
}

/// Writes values one after the other. A refused value is tried again after the other values, as long as there is progress.
fn retried(session: &mut Session, values: Values) -> Result<(), Error> {
    if session.target.writes_together() {
        return session.write(&values);
    }
    let mut left = values;
    while !left.is_empty() {
        let (before, mut refused, mut failure) = (left.len(), Values::new(), None);
        for (entry, raw) in left {
            match session.write(&[(entry.clone(), raw)]) {
                Err(error @ Error::Refused(_)) => {
                    refused.push((entry, raw));
                    failure.get_or_insert(error);
                }
                written => written?,
            }
        }
        if let Some(failure) = failure.filter(|_| refused.len() == before) {
            return Err(failure);
        }
        left = refused;
    }
    Ok(())
}

/// Writes identifiers that must differ from each other at each step.
fn identifiers(session: &mut Session, values: Values) -> Result<(), Error> {
    let mut present: Vec<(ParameterId, u32)> = Vec::new();
    let constraints = session.sheet.product.constraints;
    for constraint in constraints.iter().filter(|_| !values.is_empty()) {
        if let Relation::Different(one, other) = constraint.relation {
            for id in [one, other] {
                if !present.iter().any(|(own, _)| *own == id) {
                    let entry = session.entry(id)?;
                    present.push((id, session.read(&entry)?));
                }
            }
        }
    }
    let mut left = values;
    let mut waiting: Vec<String> = Vec::new();
    while !left.is_empty() {
        let own = |entry: &Entry, id: ParameterId| entry.origin == Origin::Parameter(id);
        let is_free = |entry: &Entry, raw: u32| {
            present
                .iter()
                .all(|(id, number)| own(entry, *id) || *number != raw)
        };
        let place = left.iter().position(|(entry, raw)| is_free(entry, *raw));
        let (entry, raw) = match place {
            Some(place) => left.remove(place),
            None => {
                // Two are exchanged: one has a temporary identifier that no other has or gets.
                let entry = left[0].0.clone();
                if waiting.contains(&entry.name) {
                    return Err(NumberError::SameIdentifier(entry.name.clone()).into());
                }
                waiting.push(entry.name.clone());
                let is_used =
                    |raw: u32| !is_free(&entry, raw) || left.iter().any(|(_, other)| *other == raw);
                let mut free = (1..0x7FF).rev().map(|id| CanId::standard(id).bits());
                let raw = free.find(|raw| !is_used(*raw)).unwrap_or(0x7FE);
                (entry, raw)
            }
        };
        session.write(&[(entry.clone(), raw)])?;
        for (id, number) in &mut present {
            if own(&entry, *id) {
                *number = raw;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
