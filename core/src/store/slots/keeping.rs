//! Keeps the usage of the device, without the room and the erased slot that saves need.

use super::{Buffer, Save, Stage, Store};
use crate::store::record::{self, USAGE_SIZE};
use crate::store::survey::WORD;
use crate::store::usage::{self, Usage};
use embedded_storage::nor_flash::NorFlash;

/// With less room than for this number of records, the usage is only kept after 1, 2, 4, 8 and so on hours of a run.
const SCARCE: usize = 8;

impl<M: NorFlash, B: Buffer> Store<M, B> {
    /// Begins to keep what the device has been through, with the saves and erases of this store. `hour` is the number of full hours since the
    /// start. Returns whether it has begun. Then call [`step`](Self::step) until it has ended; the result does not
    /// matter. It does not begin during a save, or if saves need the room: no slot is erased for it.
    pub fn keep(&mut self, usage: &Usage, hour: u32) -> bool {
        let room = self.room();
        let is_due = hour == 0 || hour.is_power_of_two() || room >= SCARCE * USAGE_SIZE;
        if self.busy() || room < USAGE_SIZE || !is_due {
            return false;
        }
        let kept = self.usage();
        let usage = Usage {
            saves: kept.saves.saturating_add(self.saves.into()),
            erases: kept.erases.saturating_add(self.erases.into()),
            ..*usage
        };
        (self.saves, self.erases) = (0, 0);
        let had_usage = self.has_usage();
        self.usage = usage.encode(self.owner.serial);
        self.renew_usage(had_usage);
        self.write_usage(self.home);
        true
    }

    /// The usage of the device.
    pub(super) fn usage(&self) -> Usage {
        if self.has_usage() {
            Usage::decode(&self.usage)
        } else {
            Usage::NONE
        }
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

    /// Writes the usage into its record in the buffer.
    fn renew_usage(&mut self, is_there: bool) {
        if is_there {
            self.device -= USAGE_SIZE;
        } else {
            let spare = self.spare();
            self.slot_mut(spare).has_device = false;
        }
        self.seal_usage();
    }

    /// Begins to write the record of the usage in the buffer to the end of a slot.
    fn write_usage(&mut self, slot: usize) {
        let from = self.device - USAGE_SIZE;
        self.save = Some(Save {
            slot,
            stage: Stage::Program(from + WORD),
            from,
            end: self.device,
            first_last: true,
        });
    }

    /// Copies the newest records to the other slot, if that is erased and there is little room for records of the usage. Call it at boot, before
    /// [`prepare`](Self::prepare), if the product keeps its usage. A power cut leaves all records where they are.
    pub fn make_room(&mut self) {
        if self.slot(self.spare()).used > 0 {
            return;
        }
        let parameters = record::parameters_size(self.newest.length);
        let copied = USAGE_SIZE + self.device + parameters;
        let fresh = self.size.saturating_sub(copied);
        let is_short = self.room() < fresh / 3 && fresh >= 4 * USAGE_SIZE;
        // Parameters of a newer firmware can be longer than the buffer.
        let fits = self.device + parameters <= B::SIZE;
        if !self.has_usage() || !is_short || !fits || self.damaged {
            return;
        }
        let (home, spare) = (self.home, self.spare());
        self.mark_usage(usage::MOVING);
        self.renew_usage(true);
        self.write_usage(spare);
        let has_begun = self.complete();
        self.home = home;
        self.mark_usage(usage::MARK);
        self.renew_usage(true);
        if !has_begun {
            return;
        }
        let length = self.newest.length;
        let sequence = self.sequence.wrapping_add(1);
        let check = self.check();
        let buffer = self.buffer.as_mut().get_mut(self.device..);
        let size = record::encode_parameters(
            buffer.unwrap_or_default(),
            self.owner,
            check,
            sequence,
            |place| {
                let place = place.get_mut(..length)?;
                let read = self.memory.read(self.newest.address as u32, place);
                read.is_ok().then_some(length)
            },
        );
        let is_there = self.newest.is_there();
        self.save = Some(Save {
            slot: spare,
            stage: Stage::Program(0),
            from: 0,
            end: self.device + size.filter(|_| is_there).unwrap_or(0),
            first_last: false,
        });
        self.complete();
        // It was no save of a master.
        self.saves = 0;
    }

    /// Performs all steps of a save. Returns whether it has succeeded.
    #[inline(never)] // smaller
    fn complete(&mut self) -> bool {
        loop {
            if let Some(result) = self.step() {
                return result.is_ok();
            }
        }
    }
}
