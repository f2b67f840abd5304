//! The dynamic mapping of TPDOs (CiA 301, 7.5.2.38): writes to 1A00h and following, and the mapping at the start.
//!
//! ```text
//!  entry      bits 31..16        15..8             7..0
//!       +---------------------+--------------+----------------+
//!       | index               | sub-index    | length in bits |
//!       +---------------------+--------------+----------------+
//! ```
//!
//! A master disables the TPDO, writes 0 as the number of mapped objects, then the entries, then the number, and enables the TPDO.

use super::Abort;
use super::cob_id;
use super::lookup::{find_row, lookup};
use super::pdo::{Entries, Entry, MAPPED, Tpdos};
use super::product::{ContextOf, Product};
use super::protocol::Services;
use super::row::Kind;
use super::sdo::message::Address;
use crate::param::ParameterId;
use crate::time::Instant;

/// The most bytes in a TPDO.
const BYTES: u8 = 8;

/// The first index of the mappings.
const FIRST: u16 = 0x1A00;

/// Whether an object is part of a mapping.
pub(super) const fn is_mapping(index: u16) -> bool {
    matches!(index, FIRST..0x1C00)
}

impl<P: Product> Services<P> {
    /// Writes the number of mapped objects (sub-index 0) or an entry, which must differ from the present one.
    pub(super) fn write_dynamic_mapping(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        address: Address,
        id: ParameterId,
        value: u32,
    ) -> Result<(), Abort> {
        let number = usize::from(address.index - FIRST);
        let Some(tpdo) = self.tpdos.all().get(number) else {
            return Err(Abort::NoObject);
        };
        if tpdo.is_valid() || (address.sub != 0 && tpdo.is_mapped()) {
            return Err(Abort::Access);
        }
        if address.sub != 0 {
            if value != 0 {
                resolve::<P>(value)?;
            }
            cx.parameters.set(id, value);
            return Ok(());
        }
        let entries = Self::resolve_mapping(cx, id, value)?;
        cx.parameters.set(id, value);
        self.take_mapping(now, number, &entries);
        Ok(())
    }

    /// Takes over the mapped objects of a TPDO.
    fn take_mapping(&mut self, now: Instant, number: usize, entries: &[Entry]) {
        let entry = |sub| entries.get(usize::from(sub).wrapping_sub(1)).copied();
        self.tpdos.map(number, entry);
        if let Some(tpdo) = self.tpdos.all_mut().get_mut(number) {
            tpdo.set(now, MAPPED, !entries.is_empty());
        }
    }

    /// The mapped objects for this number of them. `count` is the parameter with the number; the entries follow.
    fn resolve_mapping(
        cx: &ContextOf<P>,
        ParameterId(count): ParameterId,
        number: u32,
    ) -> Result<Entries, Abort> {
        if number as usize > P::Tpdos::ENTRIES {
            return Err(Abort::TooManyMapped);
        }
        let (mut entries, mut bytes) = (Entries::new(), 0);
        for sub in 1..=number as u8 {
            let entry = cx.parameters.get(ParameterId(count.wrapping_add(sub)));
            if entry == 0 {
                return Err(Abort::NotMappable);
            }
            let entry = resolve::<P>(entry)?;
            bytes += entry.size;
            if bytes > BYTES || entries.push(entry).is_err() {
                return Err(Abort::TooManyMapped);
            }
        }
        Ok(entries)
    }

    /// Takes over the COB-IDs and mappings that were restored from memory. A TPDO whose COB-ID or mapping is not permitted is
    /// disabled and has no objects; this is an error of the memory.
    pub(super) fn restore_mappings(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        for (number, settings) in P::TPDO_SETTINGS.iter().enumerate() {
            let Some(row) = find_row::<P>(FIRST + number as u16, 0) else {
                return;
            };
            let [cob_id, ..] = *settings;
            let fits = cob_id::fits_tpdo(self.on_bus(cx.parameters.get(cob_id)));
            let mapping = Self::check_mapping(cx, row.id());
            let entries = mapping.ok().filter(|_| fits).unwrap_or_else(|| {
                self.disable(cx, cob_id, row.id());
                Entries::new()
            });
            self.take_mapping(now, number, &entries);
        }
    }

    /// The mapped objects of a mapping whose entries are all permitted.
    fn check_mapping(cx: &ContextOf<P>, id: ParameterId) -> Result<Entries, Abort> {
        for place in 1..=P::Tpdos::ENTRIES as u8 {
            let entry = cx.parameters.get(ParameterId(id.0.wrapping_add(place)));
            if entry != 0 {
                resolve::<P>(entry)?;
            }
        }
        Self::resolve_mapping(cx, id, cx.parameters.get(id))
    }

    #[cold]
    fn disable(&mut self, cx: &mut ContextOf<P>, cob_id: ParameterId, count: ParameterId) {
        let factory = super::product::ParametersOf::<P>::factory_value(cob_id);
        cx.parameters.set(cob_id, factory | cob_id::DISABLED);
        for place in 0..=P::Tpdos::ENTRIES as u8 {
            let id = ParameterId(count.0.wrapping_add(place));
            cx.parameters.set(id, 0);
        }
        self.emergency.update(Self::MEMORY, Self::MEMORY);
    }
}

/// The object of a mapping entry.
fn resolve<P: Product>(entry: u32) -> Result<Entry, Abort> {
    let [bits, sub, low, high] = entry.to_le_bytes();
    let index = u16::from_le_bytes([low, high]);
    let row = lookup::<P>(Address { index, sub })?;
    let mapped = row.mapped().map(|entry| Services::<P>::widened(row, entry));
    let fits = |entry: &Entry| u32::from(entry.size) * 8 == bits.into();
    mapped.filter(fits).ok_or(Abort::NotMappable)
}

/// The mapped object at a sub-index of the fixed mapping of TPDO `number`.
pub(super) fn fixed_entry<P: Product>(number: u16, sub: u8) -> Option<Entry> {
    let row = find_row::<P>(FIRST + number, sub)?;
    let [_, sub, low, high] = match row.kind() {
        Kind::Constant => row.number().to_le_bytes(),
        _ => return None,
    };
    let row = find_row::<P>(u16::from_le_bytes([low, high]), sub)?;
    Some(Services::<P>::widened(row, row.mapped_value()))
}
