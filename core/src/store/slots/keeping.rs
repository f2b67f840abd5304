//! Keeps the usage of the device, without the room and the erased slot that saves need.

use super::saving::{Save, Stage};
use super::{Buffer, RESERVE, Store};
use crate::store::record::{self, USAGE_SIZE};
use crate::store::survey::WORD;
use crate::store::usage::Usage;
use embedded_storage::nor_flash::NorFlash;

/// With less room than for this number of records, the usage is only kept after 1, 2, 4, 8 and so on hours of a run.
const SCARCE: usize = 8;

impl<M: NorFlash, B: Buffer> Store<M, B> {
    /// Begins to write the usage of the device, with the saves and erases of this store. `hour` is the number of full hours since the
    /// start. Returns whether it has begun. Then call [`step`](Self::step) until it has ended; the result does not
    /// matter. It does not begin during a save, or if saves need the room: no slot is erased for it.
    pub fn keep(&mut self, usage: &Usage, hour: u32) -> bool {
        let room = self.room();
        let is_due = hour == 0 || hour.is_power_of_two() || room >= SCARCE * USAGE_SIZE;
        let fits = room >= USAGE_SIZE;
        if !B::USAGE || self.busy() || !is_due || !fits && !self.can_move() {
            return false;
        }
        self.usage = Usage {
            saves: self.usage.saves,
            erases: self.usage.erases,
            ..*usage
        };
        if self.has_usage {
            self.device -= USAGE_SIZE;
        } else {
            let spare = self.spare();
            self.slot_mut(spare).has_device = false;
        }
        self.has_usage = true;
        let from = self.device;
        self.seal_usage();
        let (slot, from, end) = if fits {
            (self.home, from, self.device)
        } else {
            (self.spare(), 0, self.device + self.copy_newest())
        };
        self.save = Some(Save {
            slot,
            stage: Stage::Program(from + WORD),
            from,
            end,
            first_last: true,
        });
        true
    }

    /// The number of bytes for records of the usage in the slot of the newest parameters: saves have the other slot, or half of this one.
    fn room(&self) -> usize {
        let limit = if self.slot(self.spare()).used == 0 {
            self.size
        } else {
            self.size / 2
        };
        limit.saturating_sub(self.slot(self.home).used)
    }

    /// Whether all records can be written to the other slot, with room for some records of the usage behind them. Parameters of a newer
    /// firmware can be longer than the buffer.
    fn can_move(&self) -> bool {
        let parameters = record::parameters_size(self.newest.length);
        let end = self.device + USAGE_SIZE + parameters;
        self.is_current
            && !self.damaged
            && self.slot(self.spare()).used == 0
            && end <= B::SIZE
            && end + RESERVE <= self.size / 2
    }

    /// Writes the record of the newest parameters into the buffer. Returns its size; 0: there are none.
    fn copy_newest(&mut self) -> usize {
        if !self.newest.is_there() {
            return 0;
        }
        let check = self.check();
        let place = self.buffer.as_mut().get_mut(self.device..);
        let sequence = self.sequence.wrapping_add(1);
        let size = record::encode_parameters(
            place.unwrap_or_default(),
            self.owner,
            check,
            sequence,
            |place| {
                let place = place.get_mut(..self.newest.length)?;
                let read = self.memory.read(self.newest.address as u32, place);
                read.is_ok().then_some(self.newest.length)
            },
        );
        size.unwrap_or(0)
    }
}
