//! The communication and mapping parameters of a TPDO: read, compared with the angles, and written.
//!
//! ```text
//!  1800h + n  1 COB-ID (bit 31: off)   2 transmission type   3 inhibit time in 100 us   5 event timer in ms
//!  1A00h + n  0 number of objects      1 .. objects: index << 16 | sub-index << 8 | bits
//! ```

use crate::cyclic::Layout;
use crate::error::{Error, Silence};
use crate::link::Link;
use crate::master::canopen::sdo::{Answer, Server};
use crate::sheet::{Address, Entry};
use plumbline::can::CanId;
use plumbline::canopen::cob_id::{BIT_29, BIT_30, DISABLED};
use plumbline::param::number;
use plumbline::time::{Duration, millis};
use std::ops::RangeInclusive;

/// The first objects of the TPDOs.
pub(super) const COMMUNICATION: u16 = 0x1800;
pub(super) const MAPPING: u16 = 0x1A00;

/// The sub-indices of the communication parameter.
pub(super) const COB_ID: u8 = 1;
pub(super) const TYPE: u8 = 2;
pub(super) const INHIBIT: u8 = 3;
pub(super) const TIMER: u8 = 5;

/// The bits of a COB-ID that are no part of its identifier of 11 bits: switched off, and without RTR.
const CONTROL: u32 = DISABLED | BIT_30;

/// The identifiers for PDOs of a node: not restricted (CiA 301, table 74), and not used by NMT, SYNC, EMCY and TIME.
const PERMITTED: RangeInclusive<u32> = 0x181..=0x57F;

/// The transmission types with an event timer. The second one can also send changes.
pub(super) const EVENT: [u8; 2] = [254, 255];

/// The transmission types that come with each n-th SYNC, whether the values have changed or not.
const SYNC: RangeInclusive<u8> = 1..=240;

/// The number of times a request without an answer is sent.
pub(super) const TRIES: u8 = 3;

/// A TPDO as it is set.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Tpdo {
    /// The number of the TPDO, from 0.
    pub(super) number: u16,
    pub(super) cob_id: u32,
    pub(super) kind: u8,
    pub(super) inhibit: Option<u16>,
    pub(super) timer: Option<u16>,
    /// The number of mapped objects.
    pub(super) count: u8,
    pub(super) objects: Vec<u32>,
}

/// An object that is written: index, sub-index, bytes.
pub(super) type Write = (u16, u8, Vec<u8>);

impl Tpdo {
    /// None: the node does not have it.
    pub(super) fn read(link: &mut Link, node: u8, number: u16) -> Result<Option<Self>, Error> {
        let (own, mapping) = (COMMUNICATION + number, MAPPING + number);
        let (Some(cob_id), Some(kind), Some(count)) = (
            read(link, node, own, COB_ID)?,
            read(link, node, own, TYPE)?,
            read(link, node, mapping, 0)?,
        ) else {
            return Ok(None);
        };
        let mut tpdo = Self {
            number,
            cob_id,
            kind: kind as u8,
            inhibit: read(link, node, own, INHIBIT)?.map(|raw| raw as u16),
            timer: read(link, node, own, TIMER)?.map(|raw| raw as u16),
            count: count as u8,
            objects: Vec::new(),
        };
        // More than 64 objects are multiplexed values.
        for sub in 1..=tpdo.count.min(64) {
            tpdo.objects.extend(read(link, node, mapping, sub)?);
        }
        Ok(Some(tpdo))
    }

    /// The same, but None also if it is off.
    pub(super) fn read_on(link: &mut Link, node: u8, number: u16) -> Result<Option<Self>, Error> {
        let cob_id = read(link, node, COMMUNICATION + number, COB_ID)?;
        match cob_id.filter(|cob_id| cob_id & DISABLED == 0) {
            Some(_) => Self::read(link, node, number),
            None => Ok(None),
        }
    }

    /// Where these values are in it; None: one of them is not.
    pub(super) fn layout(&self, values: &[Entry]) -> Option<Layout> {
        let mut places = Vec::new();
        for value in values {
            let mut first = 0;
            let found = self.objects.iter().find_map(|object| {
                let place = first;
                first += object & 0xFF;
                (Some(*object) == mapped(value)).then_some(place)
            });
            places.push((found?, value.data_type));
        }
        let bits: u32 = self.objects.iter().map(|object| object & 0xFF).sum();
        (bits <= 64).then_some(Layout {
            id: self.id(),
            size: bits.div_ceil(8) as usize,
            places,
        })
    }

    pub(super) fn is_on(&self) -> bool {
        self.cob_id & DISABLED == 0
    }

    /// The identifier of its frames.
    pub(super) fn id(&self) -> CanId {
        match self.cob_id & BIT_29 {
            0 => CanId::standard(self.cob_id as u16 & 0x7FF),
            _ => CanId::extended(self.cob_id & 0x1FFF_FFFF),
        }
    }

    /// It is off, and its identifier is one of 11 bits that a PDO can have, so it can be switched on.
    pub(super) fn is_free(&self) -> bool {
        !self.is_on() && PERMITTED.contains(&(self.cob_id & !CONTROL))
    }

    /// The time after which its event timer sends it, if nothing else does before. A longer inhibit time delays it until then.
    pub(super) fn longest(&self) -> Option<Duration> {
        let is_timed = EVENT.contains(&self.kind);
        let timer = self.timer.filter(|timer| *timer > 0 && is_timed);
        let inhibit = Duration::from_ticks(100 * u64::from(self.inhibit.unwrap_or(0)));
        timer.map(|timer| millis(timer.into()).max(inhibit))
    }

    /// The period of a TPDO that its event timer alone sends.
    pub(super) fn period(&self) -> Option<Duration> {
        self.longest().filter(|_| self.kind == EVENT[0])
    }

    /// It comes with SYNC, so it has the period of that. Others without a period come on a change, whenever that is.
    pub(super) fn has_sync(&self) -> bool {
        SYNC.contains(&self.kind)
    }

    /// The writes that change it from any state to this one. It is off meanwhile.
    pub(super) fn writes(&self, with_mapping: bool) -> Vec<Write> {
        let (own, mapping) = (COMMUNICATION + self.number, MAPPING + self.number);
        let off = (self.cob_id | DISABLED).to_le_bytes().to_vec();
        let mut writes = vec![(own, COB_ID, off)];
        if with_mapping {
            writes.push((mapping, 0, vec![0]));
            for (sub, object) in (1..).zip(&self.objects) {
                writes.push((mapping, sub, object.to_le_bytes().to_vec()));
            }
            writes.push((mapping, 0, vec![self.count]));
        }
        writes.push((own, TYPE, vec![self.kind]));
        for (sub, raw) in [(INHIBIT, self.inhibit), (TIMER, self.timer)] {
            writes.extend(raw.map(|raw| (own, sub, raw.to_le_bytes().to_vec())));
        }
        if self.is_on() {
            writes.push((own, COB_ID, self.cob_id.to_le_bytes().to_vec()));
        }
        writes
    }
}

/// The entry of a mapping with this value.
pub(super) fn mapped(value: &Entry) -> Option<u32> {
    let Address::Object { index, sub } = value.address else {
        return None;
    };
    let bits = 8 * u32::from(value.data_type.size());
    Some(u32::from(index) << 16 | u32::from(sub) << 8 | bits)
}

/// An object that is a number; None: the node does not have it.
pub(super) fn read(link: &mut Link, node: u8, index: u16, sub: u8) -> Result<Option<u32>, Error> {
    let server = Server::of(node);
    let mut answer = Answer::Silent;
    for _ in 0..TRIES {
        answer = server.read(link, index, sub)?;
        if answer != Answer::Silent {
            break;
        }
    }
    match answer {
        Answer::Done(bytes) => Ok((1..=4).contains(&bytes.len()).then(|| number(&bytes))),
        Answer::Aborted(_) => Ok(None),
        Answer::Silent => Err(Silence::Node(node).into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tpdo_is_free_only_with_an_identifier_that_a_pdo_can_have() {
        let tpdo = |cob_id| Tpdo {
            number: 4,
            cob_id,
            kind: EVENT[0],
            inhibit: None,
            timer: Some(0),
            count: 0,
            objects: Vec::new(),
        };
        for free in [0x8000_0181, 0x8000_057F, 0xC000_028A] {
            assert!(tpdo(free).is_free(), "{free:08X}");
        }
        // No identifier, an identifier of SDO, one of 29 bits, one that is on.
        for used in [0x8000_0000, 0x8000_0180, 0x8000_0580, 0xA000_0190, 0x18A] {
            assert!(!tpdo(used).is_free(), "{used:08X}");
        }
    }
}
