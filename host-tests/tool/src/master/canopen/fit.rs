//! COB-IDs and mappings that a sensor refuses: found in a file, before there is a sensor.

use super::tables;
use crate::error::NumberError;
use crate::sheet::{Address, Entry, Sheet};
use plumbline::canopen::cob_id::{fits_emergency, fits_tpdo};
use plumbline::canopen::dictionary::Target;
use plumbline::model::catalog::Product;

/// The object with the COB-ID of the SYNC, and the one with the COB-ID of the EMCY.
const SYNC: u16 = 0x1005;
const EMCY: u16 = 0x1014;

/// The most bits in a TPDO.
const BITS: u32 = 64;

/// Checks the changed values of a file. The others stay as they are, because a sensor can have them: for example, a new node-ID gives a
/// TPDO the identifier of the SYNC.
///
/// # Errors
/// The sensor would refuse one of them.
pub(crate) fn check(
    sheet: &Sheet,
    values: &[(Entry, u32)],
    node: Option<u8>,
    changed: &[String],
) -> Result<(), NumberError> {
    let Some(tables) = tables(sheet.product) else {
        return Ok(());
    };
    let mut objects = tables.objects.iter();
    let file = File {
        sheet,
        values,
        node: node.unwrap_or(0),
        is_free: objects.any(|object| matches!(object.target, Target::FreeCobId(_))),
    };
    for (entry, raw) in values {
        let Address::Object { index, sub } = entry.address else {
            continue;
        };
        if !changed.contains(&entry.name) {
            continue;
        }
        match index {
            SYNC => file.sync(entry, *raw)?,
            // A fixed identifier is not stored.
            _ if entry.node_relative && file.is_free => cob_id(entry, index, *raw)?,
            0x1A00..0x1C00 => file.mapping(entry, (index, sub), *raw)?,
            _ => {}
        }
    }
    Ok(())
}

struct File<'a> {
    sheet: &'a Sheet,
    values: &'a [(Entry, u32)],
    node: u8,
    /// Whether the identifiers can change.
    is_free: bool,
}

impl File<'_> {
    fn value(&self, entry: &Entry) -> Option<u32> {
        let mut values = self.values.iter();
        values
            .find(|(own, _)| own.name == entry.name)
            .map(|(_, raw)| *raw)
    }

    fn at(&self, index: u16, sub: u8) -> Option<&Entry> {
        let wanted = Address::Object { index, sub };
        self.sheet.entries.iter().find(|own| own.address == wanted)
    }

    /// With fixed identifiers, the sensor does not take one of its own as that of the SYNC.
    fn sync(&self, entry: &Entry, raw: u32) -> Result<(), NumberError> {
        let is_own = |own: &&Entry| {
            let fixed = own.factory.map(|own| own + u32::from(self.node));
            own.node_relative && !self.is_free && fixed.is_some_and(|own| (own ^ raw) & 0x7FF == 0)
        };
        match self.sheet.entries.iter().find(is_own) {
            Some(own) => Err(NumberError::Same(
                entry.name.clone(),
                own.name.clone(),
                entry.text(raw),
            )),
            None => Ok(()),
        }
    }

    fn mapping(&self, entry: &Entry, (index, sub): (u16, u8), raw: u32) -> Result<(), NumberError> {
        if sub != 0 && raw != 0 && !is_mappable(self.sheet.product, raw) {
            let (name, value) = (entry.name.clone(), entry.text(raw));
            return Err(NumberError::NotMappable(name, value));
        }
        let Some(count) = self.at(index, 0) else {
            return Ok(());
        };
        let too_many = || NumberError::TooManyMapped(count.name.clone());
        let mut bits = 0;
        for sub in 1..=self.value(count).unwrap_or(0) {
            let mapped = u8::try_from(sub).ok().and_then(|sub| self.at(index, sub));
            let mapped = mapped.ok_or_else(too_many)?;
            match self.value(mapped) {
                // The sensor has a value that the file does not.
                None => return Ok(()),
                Some(0) => {
                    let (count, mapped) = (count.name.clone(), mapped.name.clone());
                    return Err(NumberError::NotMapped(count, mapped));
                }
                Some(object) => bits += object & 0xFF,
            }
            if bits > BITS {
                return Err(too_many());
            }
        }
        Ok(())
    }
}

fn cob_id(entry: &Entry, index: u16, raw: u32) -> Result<(), NumberError> {
    let fits = match index {
        EMCY => fits_emergency(raw),
        _ => fits_tpdo(raw),
    };
    match fits {
        true => Ok(()),
        false => Err(NumberError::NoCobId(entry.name.clone(), entry.text(raw))),
    }
}

/// Whether an entry of a mapping is an object that can be mapped, with its length.
fn is_mappable(product: &Product, entry: u32) -> bool {
    let [bits, sub, low, high] = entry.to_le_bytes();
    let index = u16::from_le_bytes([low, high]);
    let objects = tables(product).map_or(&[][..], |tables| tables.objects);
    objects.iter().any(|object| {
        let subs = object.sub..object.sub.saturating_add(object.count);
        let data_type = object.data_type(product.parameters, product.quantities);
        object.mappable
            && object.index == index
            && subs.contains(&sub)
            && u32::from(data_type.size()) * 8 == u32::from(bits)
    })
}
