//! Decoded flash: stores the instruction of each half-word once it was executed. Code in RAM is decoded each time.

use super::CortexM3;
use super::decode::instruction::{Instruction, ItRule};
use super::decode::is_wide;
use super::fault::{FaultKind, Result};
use super::memory::flash_offset;
use super::timing::Cost;
use std::collections::BTreeSet;

/// A decoded instruction with its cycles, in 20 bytes.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub instruction: Instruction,
    pub cost: Cost,
    /// Its length in bytes, 2 or 4.
    pub length: u8,
    /// Its permitted position in an IT block.
    pub it: ItRule,
}

const _: () = assert!(
    size_of::<Place>() == 20,
    "the cache of the computer is small"
);

/// An instruction that is not decoded yet; no instruction has a length of 0.
const UNKNOWN: Place = Place {
    instruction: Instruction::Nop,
    cost: Cost::ONE,
    length: 0,
    it: ItRule::Anywhere,
};

/// The decoded instructions and the breakpoints. An instruction with a breakpoint is never stored.
#[derive(Clone, Default, Debug)]
pub struct Cache {
    places: Box<[Place]>,
    breakpoints: BTreeSet<u32>,
}

impl Cache {
    /// For this many bytes of flash.
    pub fn new(flash: usize) -> Self {
        Self {
            places: vec![UNKNOWN; flash / 2].into(),
            breakpoints: BTreeSet::new(),
        }
    }

    /// The instruction at this address, if it is stored.
    #[inline(always)]
    pub fn get(&self, pc: u32) -> Option<&Place> {
        let place = self.places.get(flash_offset(pc)? / 2)?;
        (place.length != 0).then_some(place)
    }

    /// Stores an instruction, unless it is in RAM.
    fn keep(&mut self, pc: u32, kept: Place) {
        if let Some(place) = flash_offset(pc).and_then(|offset| self.places.get_mut(offset / 2)) {
            *place = kept;
        }
    }

    /// Removes all instructions, as after a change of the flash.
    pub fn clear(&mut self) {
        self.places.fill(UNKNOWN);
    }

    /// Removes the instructions that contain these bytes; an instruction can start a half-word earlier.
    pub fn forget(&mut self, address: u32, length: usize) {
        let Some(offset) = flash_offset(address) else {
            return;
        };
        let (first, end) = (
            (offset / 2).saturating_sub(1),
            (offset + length).div_ceil(2),
        );
        if let Some(places) = self.places.get_mut(first..end) {
            places.fill(UNKNOWN);
        }
    }

    pub fn add_breakpoint(&mut self, address: u32) {
        self.breakpoints.insert(address & !1);
        self.forget(address, 2);
    }
}

impl CortexM3 {
    /// Decodes the instruction at an address that the cache does not have; None when the run has to stop at a breakpoint.
    pub(super) fn decode(&mut self, cache: &mut Cache, pc: u32) -> Result<Option<Place>> {
        let stops = cache.breakpoints.contains(&pc);
        if stops && self.stopped_at.replace(pc) != Some(pc) {
            return Ok(None);
        }
        let half_word = |address| match self.memory.read(address) {
            Some(bytes) => Ok(u16::from_le_bytes(bytes)),
            None => Err(Box::new(FaultKind::Unmapped(address))),
        };
        let first = half_word(pc)?;
        let second = if is_wide(first) {
            half_word(pc.wrapping_add(2))?
        } else {
            0
        };
        let decoded = self.model.decode(first, second);
        let cost = match &self.cycles {
            Some(cycles) => Cost::of(&decoded.instruction, cycles),
            None => Cost::ONE,
        };
        let place = Place {
            instruction: decoded.instruction,
            cost,
            length: decoded.length,
            it: decoded.it,
        };
        if stops {
            self.stopped_at = None;
        } else {
            cache.keep(pc, place);
        }
        Ok(Some(place))
    }
}
