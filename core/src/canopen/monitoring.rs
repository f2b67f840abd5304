//! The heartbeat consumer in the node: its entries, the received heartbeats, and the loss of a node.

use super::Abort;
use super::cob_id;
use super::consumer::{Consumers, INDEX, used};
use super::lookup::find_row;
use super::product::{ContextOf, Product};
use super::protocol::{Canopen, Services};
use super::row::Row;
use crate::can::{CanId, Frame};
use crate::time::Instant;

impl<P: Product> Services<P> {
    const HEARS: bool = P::Consumers::COUNT > 0;

    /// Takes the entries and waits for the first heartbeat of each node. Returns true if the identifiers may have changed.
    pub(super) fn configure_consumers(&mut self, cx: &mut ContextOf<P>) -> bool {
        for (sub, consumer) in (1..).zip(self.consumers.all_mut()) {
            let entry = find_row::<P>(INDEX, sub).map(|row| cx.parameters.get(row.id()));
            consumer.configure(entry.unwrap_or(0));
        }
        if Self::HEARS {
            self.report_guarding(cx);
        }
        Self::HEARS
    }

    /// Checks a write of an entry: two entries must not have the same node-ID.
    pub(super) fn check_consumer(
        &self,
        cx: &ContextOf<P>,
        row: &Row,
        value: u32,
    ) -> Result<(), Abort> {
        if !Self::HEARS || row.index() != INDEX {
            return Ok(());
        }
        let node_of = |entry| used(entry).map(|(node_id, _)| node_id);
        let Some(node_id) = node_of(value) else {
            return Ok(());
        };
        for sub in (1..).take(P::Consumers::COUNT) {
            if sub != row.address().sub
                && let Some(other) = find_row::<P>(INDEX, sub)
                && node_of(cx.parameters.get(other.id())) == Some(node_id)
            {
                return Err(Abort::Incompatible);
            }
        }
        Ok(())
    }

    /// Handles a frame that can be a heartbeat. Returns false if it is another frame.
    pub(super) fn hear(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) -> bool {
        if !Self::HEARS {
            return false;
        }
        let id = |node_id: u8| CanId::standard(cob_id::ERROR_CONTROL + u16::from(node_id));
        let heard = self
            .consumers
            .all()
            .iter()
            .find(|consumer| consumer.node_id != 0 && id(consumer.node_id) == frame.can_id());
        let Some(node_id) = heard.map(|consumer| consumer.node_id) else {
            return false;
        };
        let is_boot_up = frame.bytes().first().is_none_or(|state| *state == 0);
        if frame.is_remote() || is_boot_up {
            return true;
        }
        let had_failed = self.lost();
        for consumer in self.consumers.all_mut() {
            consumer.hear(now, node_id);
        }
        if had_failed {
            self.report_guarding(cx);
        }
        cx.shell.wake_up();
        true
    }

    /// Whether the heartbeat of a node is lost.
    pub(super) fn lost(&self) -> bool {
        self.consumers.all().iter().any(|consumer| consumer.failed)
    }

    /// The identifiers of the monitored nodes.
    pub(super) fn heard_ids(&self) -> impl Iterator<Item = CanId> {
        let used = self.consumers.all().iter().filter(|one| one.node_id != 0);
        used.map(|one| CanId::standard(cob_id::ERROR_CONTROL + u16::from(one.node_id)))
    }
}

impl<P: Product> Canopen<P> {
    /// Handles the times of the monitored nodes.
    pub(super) fn tick_consumers(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        let mut over = false;
        for consumer in self.services.consumers.all_mut() {
            over |= consumer.poll(now);
        }
        if over {
            self.lose_master(cx, now);
        }
        for consumer in self.services.consumers.all() {
            self.services.earliest.consider(consumer.until);
        }
    }
}
