//! The order of writes: after each of them the sensor must have permitted values.
//!
//! - The unit that others follow comes first; bit rate and addresses come last.
//! - CAN identifiers must differ at each step; where they change places, one has another identifier in between.
//! - A TPDO of CANopen is switched off while its COB-ID or mapping changes.
//! - A write that the sensor refuses is tried again after the others: filter and cut-off frequency depend on each other.

use crate::failure::Failure;
use crate::session::Session;
use crate::sheet::{Address, Entry, Origin};
use plumbline::can::CanId;
use plumbline::model::catalog::{Product, Protocol};
use plumbline::param::{Constraint, ParameterId};

/// Checked values with their entries.
pub type Values = Vec<(Entry, u32)>;

/// The bit of a COB-ID that switches a TPDO off.
const OFF: u32 = 1 << 31;

/// Writes values in an order in which the sensor accepts them. Does not read them back.
///
/// # Errors
/// The sensor refuses a value, nobody answers, or those of the adapter.
pub fn write(session: &mut Session, values: &Values) -> Result<(), Failure> {
    let product = session.sheet.product;
    let mut sorted = values.clone();
    sorted.sort_by_key(|(entry, _)| rank(product, entry));
    let (exclusive, rest): (Values, Values) = sorted
        .into_iter()
        .partition(|(entry, _)| is_exclusive(product, entry));
    let (first, last): (Values, Values) = rest
        .into_iter()
        .partition(|(entry, _)| rank(product, entry) < LAST);
    let first = tpdos(session, first)?;
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
    let (rate, addresses) = match &product.protocol {
        Protocol::Fsc(tables) => {
            let roles = &tables.roles;
            (
                roles.bit_rate,
                vec![roles.set_id, roles.reply_id, roles.sync_id],
            )
        }
        Protocol::Canopen(tables) => (tables.bit_rate, vec![tables.node_id]),
        Protocol::Devicenet(tables) => (tables.roles.baud_rate, vec![tables.roles.mac_id]),
    };
    match id {
        _ if id == rate => LAST,
        _ if addresses.contains(&id) => LAST + 1,
        _ => 1,
    }
}

/// Whether a parameter must differ from another one.
fn is_exclusive(product: &Product, entry: &Entry) -> bool {
    product
        .constraints
        .iter()
        .any(|constraint| match *constraint {
            Constraint::Different(one, other) => [one, other]
                .iter()
                .any(|id| entry.origin == Origin::Parameter(*id)),
            Constraint::AtMost { .. } => false,
        })
}

/// Writes values one after the other. What is refused is tried again after the others, as long as there is progress.
fn retried(session: &mut Session, values: Values) -> Result<(), Failure> {
    let is_fsc = matches!(session.sheet.product.protocol, Protocol::Fsc(_));
    if is_fsc {
        // Values with the same code are written together.
        return session.write(&values);
    }
    let mut left = values;
    while !left.is_empty() {
        let (before, mut refused, mut failure) = (left.len(), Values::new(), None);
        for (entry, raw) in left {
            match session.write(&[(entry.clone(), raw)]) {
                Err(error) if error.code == "refused" => {
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
fn identifiers(session: &mut Session, values: Values) -> Result<(), Failure> {
    let mut present: Vec<(ParameterId, u32)> = Vec::new();
    let constraints = session.sheet.product.constraints;
    for constraint in constraints.iter().filter(|_| !values.is_empty()) {
        if let Constraint::Different(one, other) = *constraint {
            for id in [one, other] {
                if !present.iter().any(|(own, _)| *own == id) {
                    let entry = session.entry(id)?;
                    present.push((id, session.read(&entry)?));
                }
            }
        }
    }
    let mut left = values;
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
                // They change places: one of them waits at an identifier that nobody has or gets.
                let entry = left[0].0.clone();
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

/// Writes the COB-IDs and mappings of TPDOs, and returns the other values.
fn tpdos(session: &mut Session, values: Values) -> Result<Values, Failure> {
    let number = |entry: &Entry| match entry.address {
        Address::Object {
            index: index @ 0x1800..=0x19FF,
            sub: 1,
        } => Some(index - 0x1800),
        Address::Object {
            index: index @ 0x1A00..=0x1BFF,
            ..
        } => Some(index - 0x1A00),
        _ => None,
    };
    let mut numbers: Vec<u16> = values
        .iter()
        .filter_map(|(entry, _)| number(entry))
        .collect();
    numbers.sort_unstable();
    numbers.dedup();
    for tpdo in &numbers {
        let find = |session: &Session, wanted: Address| {
            let mut entries = session.sheet.entries.iter();
            entries.find(|entry| entry.address == wanted).cloned()
        };
        let communication = Address::Object {
            index: 0x1800 + tpdo,
            sub: 1,
        };
        let mapping = Address::Object {
            index: 0x1A00 + tpdo,
            sub: 0,
        };
        let given = |address: Address| {
            values
                .iter()
                .find(|(entry, _)| entry.address == address)
                .map(|(_, raw)| *raw)
        };
        let (cob_id, count) = (find(session, communication), find(session, mapping));
        let mut present = None;
        if let Some(cob_id) = &cob_id {
            let raw = session.read(cob_id)?;
            present = Some(raw);
            session.write(&[(cob_id.clone(), raw | OFF)])?;
        }
        let entries: Values = values
            .iter()
            .filter(|(entry, _)| matches!(entry.address, Address::Object { index, sub } if index == 0x1A00 + tpdo && sub > 0))
            .cloned()
            .collect();
        if let Some(count) = &count
            && (!entries.is_empty() || given(mapping).is_some())
        {
            let wanted = match given(mapping) {
                Some(wanted) => wanted,
                None => session.read(count)?,
            };
            session.write(&[(count.clone(), 0)])?;
            for entry in entries {
                session.write(&[entry])?;
            }
            session.write(&[(count.clone(), wanted)])?;
        }
        if let (Some(cob_id), Some(raw)) = (cob_id, given(communication).or(present)) {
            session.write(&[(cob_id, raw)])?;
        }
    }
    Ok(values
        .into_iter()
        .filter(|(entry, _)| number(entry).is_none())
        .collect())
}
