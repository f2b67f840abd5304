//! An slcan client on the bus.

use super::clock::Line;
use super::control::Side;
use super::event::Client;
use super::passage::Passage;
use crate::slcan::Channel;
use bench::{AdapterId, Bus};
use plumbline::can::Frame;
use plumbline::time::Instant;

/// The main loop's state of a client.
pub(super) struct Session {
    pub(super) client: Client,
    pub(super) channel: Channel,
    pub(super) adapter: AdapterId,
    pub(super) line: Line,
    /// A frame was received since the client advanced the time.
    pub(super) received: bool,
    /// The faults of the frames in either direction.
    pub(super) to_client: Passage,
    pub(super) to_bus: Passage,
}

impl Session {
    /// The faults of the frames from this side.
    pub(super) fn passage(&mut self, from: Side) -> &mut Passage {
        match from {
            Side::Sensors => &mut self.to_client,
            Side::Clients => &mut self.to_bus,
        }
    }

    /// The frames that reach the client now, with the times of their ends.
    pub(super) fn receive(&mut self, bus: &mut Bus) -> Vec<(Instant, Frame)> {
        let received = bus.take_received(self.adapter).into_iter();
        let mut frames: Vec<_> = received
            .filter_map(|(at, frame)| Some((at, self.to_client.pass(at, frame)?)))
            .collect();
        frames.extend(self.to_client.arrived(bus.now()));
        frames.sort_by_key(|(at, _)| *at);
        frames
    }

    /// Sends bytes to the client; false when it had to be dropped because it does not read.
    pub(super) fn push(&self, bytes: &[u8]) -> bool {
        self.client.push(bytes)
    }
}
