//! The I/O messages: poll responses, COS and cyclic messages.

use super::identifiers::Group1;
use super::production::{AcknowledgeHandler, Words};
use super::projection::AssemblyRow;
use super::protocol::{ContextOf, Devicenet, ValuesOf};
use super::table::Product;
use crate::application::Values;
use crate::can::{CanId, Frame};
use crate::param::ParameterId;
use crate::time::Instant;

/// The row of the assembly that a parameter selects.
pub(super) fn selected<P: Product>(
    cx: &ContextOf<P>,
    id: ParameterId,
) -> Option<&'static AssemblyRow> {
    let instance = cx.parameters.get(id);
    let mut rows = P::ASSEMBLY_ROWS.iter();
    rows.find(|row| u32::from(row.instance) == instance)
}

/// The data of an assembly: the present value of each of its words.
pub(super) fn words<P: Product>(assembly: &AssemblyRow, values: &ValuesOf<P>) -> Words {
    let mut words = [0; 4];
    for (word, id) in words.iter_mut().zip(assembly.words()) {
        *word = values.number(id) as u16;
    }
    words
}

/// Words as the data of a frame.
pub(super) fn pack([a, b, c, d]: Words) -> u64 {
    let low = u32::from(a) | u32::from(b) << 16;
    let high = u32::from(c) | u32::from(d) << 16;
    u64::from(high) << 32 | u64::from(low)
}

impl<P: Product> Devicenet<P> {
    /// Answers a poll command. One with data is not consumed: the consumed size is 0.
    pub(super) fn answer_poll(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        if frame.dlc() != 0 || !self.connections.is_polled() {
            return;
        }
        let Some(assembly) = self.polled else {
            return;
        };
        let id = CanId::standard(Group1::PollResponse.id(self.mac));
        let data = pack(words::<P>(assembly, &cx.values));
        cx.shell.send(Frame::word(id, data, assembly.size()));
        if self.connections.polled(now) {
            cx.shell.wake_up();
        }
    }

    /// Adapts the I/O to the states of the connections.
    pub(super) fn update_io(&mut self, cx: &mut ContextOf<P>) {
        let connections = &mut self.connections;
        if connections.poll().is_allocated() {
            self.polled = selected::<P>(cx, P::ROLES.polled_assembly);
        }
        if connections.is_producing() {
            self.produced = selected::<P>(cx, P::ROLES.cyclic_assembly);
        } else {
            let is_allocated = connections.producing().is_allocated();
            if self.production.is_running() || !is_allocated {
                self.production.stop();
                self.handler.stop();
                let id = CanId::standard(Group1::ChangeOrCyclic.id(self.mac));
                cx.shell.withdraw(id);
            }
        }
        if !connections.explicit().is_allocated() {
            self.sender.stop();
            self.receiver.stop();
        }
        if !connections.is_owned() {
            self.handler = AcknowledgeHandler::DEFAULT;
        }
        cx.shell.wake_up();
    }

    /// Whether a word of the produced assembly differs from the one in `sent` by the COS delta or more.
    pub(super) fn differs(assembly: Option<&AssemblyRow>, cx: &ContextOf<P>, sent: &Words) -> bool {
        let Some(assembly) = assembly else {
            return false;
        };
        let delta = cx.parameters.get(P::ROLES.cos_delta).max(1);
        let mut words = assembly.words().zip(sent);
        words.any(|(id, &sent)| {
            let word = cx.values.number(id) as u16;
            word != sent && u32::from(P::distance(&cx.parameters, word, sent)) >= delta
        })
    }

    /// Sends a COS or cyclic message that is due, or repeats the last one.
    pub(super) fn produce(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        if !self.production.is_running() {
            return;
        }
        let Some(assembly) = self.produced else {
            return;
        };
        let differs = |sent: &Words| Self::differs(Some(assembly), cx, sent);
        let words = if self.production.is_due(now, differs) {
            let words = words::<P>(assembly, &cx.values);
            self.production.produced(now, words);
            if self.connections.producing().consumes() {
                self.handler.produced(now);
            }
            words
        } else if self.handler.poll(now) {
            *self.production.sent()
        } else {
            return;
        };
        let id = CanId::standard(Group1::ChangeOrCyclic.id(self.mac));
        let frame = Frame::word(id, pack(words), assembly.size());
        cx.shell.send_cyclic(frame);
    }

    /// Handles the acknowledge of a COS or cyclic message: an empty frame.
    pub(super) fn acknowledge(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        if frame.dlc() != 0
            || !self.connections.is_producing()
            || !self.connections.producing().consumes()
        {
            return;
        }
        self.handler.stop();
        if self.connections.acknowledged(now) {
            cx.shell.wake_up();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_sent_in_order_with_the_low_byte_first() {
        let data = pack([0x0201, 0x0403, 0x0605, 0x0807]).to_le_bytes();
        assert_eq!(data, [1, 2, 3, 4, 5, 6, 7, 8]);
    }
}
