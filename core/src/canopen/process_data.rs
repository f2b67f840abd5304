//! The process data of a node: which TPDOs a SYNC or a remote frame sends, and their present data.

use super::pdo::{OPERATIONAL, Reaction, Source, Tpdo, Tpdos};
use super::product::{ContextOf, Product};
use super::protocol::Services;
use super::wide::SIZE;
use crate::application::Values;
use crate::can::{CanId, Frame};
use crate::param::{ParameterId, ValueId};
use crate::time::Instant;

impl<P: Product> Services<P> {
    /// Handles the beginning or the end of operational.
    pub(super) fn operate(&mut self, now: Instant, operational: bool) {
        for tpdo in self.tpdos.all_mut() {
            tpdo.set(now, OPERATIONAL, operational);
        }
    }

    /// Lets the next TPDO handle the last SYNC, with the values of the newest sample. Returns false if all TPDOs have handled it.
    pub(super) fn synchronise_next(&mut self, cx: &mut ContextOf<P>) -> bool {
        let number = P::Tpdos::COUNT.wrapping_sub(self.unsynchronised.into());
        let Some(tpdo) = self.tpdos.all_mut().get_mut(number) else {
            return false;
        };
        self.unsynchronised -= 1;
        let reaction = tpdo.sync();
        self.react(cx, number, reaction);
        true
    }

    /// Handles a remote frame that can be for a TPDO.
    pub(super) fn request(&mut self, cx: &mut ContextOf<P>, now: Instant, id: CanId) {
        // Of two TPDOs with the same identifier, the first that is sent answers.
        let same = |tpdo: &Tpdo| {
            CanId::standard(tpdo.id()) == id && (!P::Tpdos::DYNAMIC || tpdo.is_sent())
        };
        let Some(number) = self.tpdos.all().iter().position(same) else {
            return;
        };
        if let Some(tpdo) = self.tpdos.all_mut().get_mut(number) {
            let reaction = tpdo.request(now, P::TRIGGERS);
            self.react(cx, number, reaction);
            cx.shell.wake_up();
        }
    }

    /// Sends or keeps the data of a TPDO.
    pub(super) fn react(&mut self, cx: &mut ContextOf<P>, number: usize, reaction: Reaction) {
        let Some(tpdo) = self.tpdos.all().get(number) else {
            return;
        };
        let id = CanId::standard(tpdo.id());
        if reaction == Reaction::None || !tpdo.is_sent() {
            return;
        }
        let kept = tpdo.kept().filter(|_| reaction == Reaction::SendKept);
        let frame = kept.unwrap_or_else(|| self.compose(cx, number, id));
        let keeps = matches!(reaction, Reaction::SendChanged | Reaction::Keep);
        if keeps {
            let Some(tpdo) = self.tpdos.all_mut().get_mut(number) else {
                return;
            };
            if !tpdo.keep(&frame) || reaction == Reaction::Keep {
                return;
            }
        } else if P::TRIGGERS.changes
            && let Some(tpdo) = self.tpdos.all_mut().get_mut(number)
            && tpdo.watches()
        {
            tpdo.keep(&frame);
        }
        cx.shell.send_cyclic(frame);
    }

    /// Sends a TPDO if one of its events has occurred. Returns false if there is no such TPDO.
    pub(super) fn send_event(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        number: usize,
    ) -> bool {
        let Some(tpdo) = self.tpdos.all().get(number) else {
            return false;
        };
        let mut changed = false;
        if P::TRIGGERS.changes && tpdo.watches() {
            self.watches = true;
            let frame = self.compose(cx, number, CanId::standard(tpdo.id()));
            changed = tpdo.kept() != Some(frame);
        }
        if let Some(tpdo) = self.tpdos.all_mut().get_mut(number) {
            if changed {
                tpdo.changed();
            }
            let due = tpdo.poll(now, P::TRIGGERS);
            tpdo.consider(&mut self.earliest);
            if due {
                self.react(cx, number, Reaction::Send);
            }
        }
        true
    }

    /// The frame with the present data of a TPDO.
    fn compose(&self, cx: &ContextOf<P>, number: usize, id: CanId) -> Frame {
        let (mut data, mut length) = (0_u64, 0);
        // From the last object to the first, because 64-bit shifts by a constant are short.
        for entry in self.tpdos.mapping(number).iter().rev() {
            // Such an object fills the frame.
            if Self::WIDE && entry.size == SIZE {
                data = match entry.source {
                    Source::Parameter => cx.parameters.get_wide(ParameterId(entry.id)),
                    _ => cx.values.wide(ValueId(entry.id)),
                };
                length = SIZE;
                break;
            }
            let value = u64::from(match entry.source {
                Source::Parameter if P::Tpdos::DYNAMIC => cx.parameters.get(ParameterId(entry.id)),
                Source::Own if P::Tpdos::DYNAMIC => self.own_number(cx, entry.id),
                _ => cx.values.number(ValueId(entry.id)),
            });
            // A signed number can have more bits than its type.
            data = match entry.size {
                1 => data << 8 | value & 0xFF,
                2 => data << 16 | value & 0xFFFF,
                _ => data << 32 | value,
            };
            length += entry.size;
        }
        Frame::word(id, data, length)
    }
}
