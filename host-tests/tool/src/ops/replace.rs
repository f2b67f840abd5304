//! `replace`: keeps what a dying sensor is, and makes a new one equal. Both steps are commands of their own, because only one of both
//! sensors is at the bus.

pub mod old;
pub mod report;

use super::rest::{self, Rest, thousandths, wrapped};
use super::{backup, get, identity, restore};
use crate::backup::Backup;
use crate::error::{Error, FileError, RequestError, SensorError};
use crate::identify::Found;
use crate::note::{Note, Step};
use crate::output::Terminal;
use crate::question::{Name, Question};
use crate::sample::Sampler;
use crate::session::Session;
use crate::sheet::{Entry, Origin, Sheet};
use descriptors::unit;
use old::{Measured, Old};
use plumbline::store::Unit;
use report::{Angle, Compared, NotCarried, Replaced};

/// Reads the old sensor: settings, identity, every reply, and the angles at rest. Nothing is written.
pub(crate) fn read(
    session: &mut Session,
    found: &Found,
    terminal: &mut Terminal,
) -> Result<(Old, Unit), Error> {
    described(session)?;
    let backup = backup::read(session, found, terminal)?;
    let identity = identity::read(session, terminal)?;
    let text = unit::sheet(identity.product, &identity.unit);
    let old = Old {
        backup,
        identity: unit::Sheet::parse(&text).unwrap_or_default(),
        replies: replies(session)?,
        angles: angles(session, terminal)?,
    };
    Ok((old, identity.unit))
}

/// Writes the settings of the old sensor into the new one, stores them, and compares everything.
pub(crate) fn write(
    session: &mut Session,
    found: &Found,
    (old, file): (&Old, String),
    terminal: &mut Terminal,
) -> Result<Replaced, Error> {
    described(session)?;
    check_product(session, old)?;
    let (wanted, not_carried) = carried(&session.sheet, &old.backup);
    if !not_carried.is_empty() {
        let names = not_carried.iter();
        let names =
            names.map(|NotCarried { name, value, why }| format!("{name} = {value} ({why})"));
        let names = names.collect::<Vec<_>>().join("; ");
        if !terminal.ask(&Question::NotCarried(names))? {
            let sensor = found.about(session.link.rate()).to_string();
            let name = Name::Restore.to_string();
            return Err(RequestError::NotConfirmed(sensor, name).into());
        }
    }
    restore::restore(session, found, (wanted.clone(), file), &[], terminal)?;
    let own = backup::read(session, found, terminal)?;
    let identity = identity::read(session, terminal)?;
    let new_replies = replies(session)?;
    let measured = angles(session, terminal)?;
    Ok(Replaced {
        old: shown(&old.backup),
        new: found.about(session.link.rate()).to_string(),
        settings: settings(&wanted, &own),
        not_carried,
        identity: identities(old, &identity.unit, session.sheet.product),
        replies: compared(&old.replies, &new_replies),
        not_compared: not_compared(&session.sheet, &old.angles, &measured),
        angles: compared_angles(&old.angles, &measured),
    })
}

/// A data sheet does not describe identity and angles for sure.
fn described(session: &Session) -> Result<(), Error> {
    match session.sheet.data_sheet {
        Some(_) => Err(RequestError::NotDescribed.into()),
        None => Ok(()),
    }
}

/// Refuses a sensor of another maker or with other angles. Generations of one maker have the same.
fn check_product(session: &Session, old: &Old) -> Result<(), Error> {
    let (own, wanted) = (session.sheet.product, old.backup.sheet.product);
    let is_same =
        own.maker == wanted.maker && angle_names(&session.sheet) == angle_names(&old.backup.sheet);
    match is_same {
        true => Ok(()),
        false => Err(FileError::OtherProduct(wanted.name, own.name).into()),
    }
}

/// The names of the angles of a product.
fn angle_names(sheet: &Sheet) -> Vec<String> {
    let angles = sheet.product.guide.angles.iter();
    let angles = angles.filter_map(|id| sheet.value(*id));
    angles.map(|entry| entry.name.clone()).collect()
}

/// The settings of the old sensor as those of the product of the new one, and those that it does not have or does not permit.
fn carried(sheet: &Sheet, old: &Backup) -> (Backup, Vec<NotCarried>) {
    let mut wanted = old.clone();
    wanted.sheet = sheet.clone();
    wanted.values.clear();
    let mut not_carried = Vec::new();
    // The resolution comes first: it is the unit of other values.
    let mut values: Vec<&(Entry, u32)> = old.values.iter().collect();
    values.sort_by_key(|(entry, _)| !old.sheet.is_resolution(entry));
    for (entry, raw) in values {
        let text = old.text_of(entry, *raw);
        // A name can have another number in the other product.
        let taken = wanted.set(&entry.name, &text);
        if let Err(why) = taken {
            not_carried.push(NotCarried {
                name: entry.name.clone(),
                value: text,
                why: why.to_string(),
            });
        }
    }
    (wanted, not_carried)
}

/// The values that the sensor reports and that are no settings and no measurements.
fn replies(session: &mut Session) -> Result<Vec<(String, String)>, Error> {
    let is_setting = |sheet: &Sheet, entry: &Entry| {
        let mut settings = sheet.settings();
        settings.any(|own| own.name == entry.name)
    };
    let sheet = session.sheet.clone();
    let entries = sheet.entries.iter().filter(|entry| {
        let is_measured = matches!(entry.origin, Origin::Value(_));
        entry.readable && !is_measured && !is_setting(&sheet, entry)
    });
    let mut replies = Vec::new();
    for entry in entries {
        match get::show(session, entry) {
            Err(Error::Refused(_)) => {}
            shown => replies.push((entry.name.clone(), shown?.text)),
        }
    }
    Ok(replies)
}

/// The angles, when the sensor is at rest; none if they are not valid.
fn angles(session: &mut Session, terminal: &mut Terminal) -> Result<Vec<Measured>, Error> {
    let mut sampler = Sampler::new(session)?;
    let angles = sampler.entries();
    let why = match rest::wait(session, &mut sampler, &angles, terminal) {
        Ok(rest) => return Ok(measured(&angles, rest)),
        // A broken sensor is replaced all the same.
        Err(Error::Sensor(SensorError::NoValidAngle)) => Step::NoAngleYet,
        Err(Error::Sensor(SensorError::Defective)) => Step::Defective,
        Err(failure) => return Err(failure),
    };
    terminal.note(&Note::NoAngles(why));
    Ok(Vec::new())
}

fn measured(angles: &[Entry], rest: Vec<Rest>) -> Vec<Measured> {
    let measured = angles.iter().zip(rest).map(|(entry, rest)| Measured {
        name: entry.name.clone(),
        angle: thousandths(rest.angle),
        spread: thousandths(rest.spread),
    });
    measured.collect()
}

fn shown(backup: &Backup) -> String {
    let mut text = backup.sheet.product.name.to_owned();
    if let Some(article) = &backup.article {
        text += &format!(", article {article}");
    }
    if let Some(serial) = backup.serial {
        text += &format!(", serial {serial}");
    }
    if let Some(firmware) = &backup.firmware {
        text += &format!(", firmware {firmware}");
    }
    text
}

fn settings(wanted: &Backup, own: &Backup) -> Vec<Compared> {
    let rows = wanted.values.iter().map(|(entry, raw)| {
        let mut values = own.values.iter();
        let new = values.find(|(other, _)| other.name == entry.name);
        Compared {
            name: entry.name.clone(),
            old: Some(wanted.text_of(entry, *raw)),
            new: new.map(|(entry, raw)| own.text_of(entry, *raw)),
        }
    });
    rows.collect()
}

fn identities(
    old: &Old,
    unit: &Unit,
    product: &plumbline::model::catalog::Product,
) -> Vec<Compared> {
    let text = |value: &unit::Value| match value {
        unit::Value::Number(number) => number.to_string(),
        unit::Value::Text(text) => text.clone(),
    };
    let rows = unit::fields(product).into_iter().map(|field| {
        let mut values = old.identity.values.iter();
        let own = values.find(|(key, _)| *key == field.key);
        Compared {
            name: field.key.to_owned(),
            old: own.map(|(_, value)| text(value)),
            new: field.value(unit).map(|value| text(&value)),
        }
    });
    rows.collect()
}

fn compared(old: &[(String, String)], new: &[(String, String)]) -> Vec<Compared> {
    let rows = old.iter().map(|(name, value)| {
        let mut own = new.iter();
        let own = own.find(|(other, _)| other == name);
        Compared {
            name: name.clone(),
            old: Some(value.clone()),
            new: own.map(|(_, value)| value.clone()),
        }
    });
    rows.collect()
}

fn compared_angles(old: &[Measured], new: &[Measured]) -> Vec<Angle> {
    let rows = old.iter().filter_map(|own| {
        let new = new.iter().find(|other| other.name == own.name)?;
        let difference = thousandths(wrapped(new.angle - own.angle));
        Some(Angle::new(own, new, difference))
    });
    rows.collect()
}

/// The angles that one of both sensors does not have.
fn not_compared(sheet: &Sheet, old: &[Measured], new: &[Measured]) -> Vec<String> {
    let has = |angles: &[Measured], name: &str| angles.iter().any(|own| own.name == name);
    let names = angle_names(sheet).into_iter();
    names
        .filter(|name| !has(old, name) || !has(new, name))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn setting_that_the_new_product_does_not_have_or_permit_is_not_carried() {
        let text = "[sensor]\nproduct = \"is2d\"\n[parameters]\ncyclic-time = \"100 ms\"\ncut-off = \"25000 mHz\"\nfilter-type = \"Butterworth\"\n";
        let old = Backup::parse(text).unwrap_or_else(|why| panic!("{why}"));
        let mut sheet = Sheet::of(crate::identify::product("is2").expect("a product"));
        sheet.entries.retain(|entry| entry.name != "filter-type");
        for entry in &mut sheet.entries {
            if entry.name == "cut-off" {
                entry.permitted = plumbline::param::Permitted::Range(100, 5000);
            }
        }
        let (wanted, not_carried) = carried(&sheet, &old);
        let names: Vec<&str> = wanted
            .values
            .iter()
            .map(|(own, _)| own.name.as_str())
            .collect();
        assert_eq!(names, ["cyclic-time"]);
        let rows: Vec<_> = not_carried
            .iter()
            .map(|own| (own.name.as_str(), own.value.as_str()))
            .collect();
        assert_eq!(
            rows,
            [("cut-off", "25000 mHz"), ("filter-type", "Butterworth")]
        );
        assert!(not_carried[0].why.contains("5000"), "{not_carried:?}");
    }
}
