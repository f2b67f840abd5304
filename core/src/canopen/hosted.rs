//! Access to the CANopen objects of a product while another protocol is on the bus. The other protocol transports the bytes of SDO
//! requests and replies. The NMT state is pre-operational. No other CANopen service is active.

use super::Abort;
use super::feature::Feature;
use super::nmt::State;
use super::product::{ContextOf, ParametersOf, Product};
use super::protocol::{Canopen, Services};
use super::sdo::block;
use super::sdo::message::{self, Address, Request};
use crate::application::Values;
use crate::can::BitRate;
use crate::store::StoreError;
use crate::time::{Deadline, Instant};

impl<P: Product> Canopen<P> {
    /// Whether another protocol is on the bus.
    pub fn is_hosted(&self) -> bool {
        self.services.is_hosted()
    }

    /// The bit rate in force.
    pub fn rate(&self) -> BitRate {
        self.services.rate
    }

    /// Whether the parameter memory has a fault, and whether the controller is error passive.
    pub fn own_faults(&self) -> (bool, bool) {
        let active = self.services.emergency.active();
        let has = |bits| active & bits != 0;
        (has(Services::<P>::MEMORY), has(Services::<P>::PASSIVE))
    }

    /// Whether a request begins a transfer, also in a running one of another client.
    pub fn begins_transfer(bytes: [u8; 8]) -> bool {
        message::is_initiate(bytes) || P::Block::PRESENT && block::is_initiate(bytes)
    }

    /// Whether a request is an abort.
    pub fn is_abort(bytes: [u8; 8]) -> bool {
        matches!(Request::parse(bytes), Request::Abort(_))
    }

    /// The answer to a request of a client without a transfer, while another client can have one: the same as in CANopen. An abort has
    /// none.
    pub fn refusal(bytes: [u8; 8]) -> Option<[u8; 8]> {
        let address = match Request::parse(bytes) {
            Request::Abort(_) => return None,
            Request::Unsupported(address) if !P::Block::PRESENT || !block::is_command(bytes) => {
                address
            }
            _ => Address::default(),
        };
        Some(message::abort(address, Abort::Command))
    }

    /// Ends the transfer of a client without a message. A save continues.
    pub fn end_transfer(&mut self) {
        self.sdo.finish();
    }

    /// Ends all transfers without a message.
    pub fn end_transfers(&mut self) {
        self.sdo.end();
    }

    /// Handles the end of a save, in place of [`Protocol::stored`](crate::node::Protocol::stored). Returns the reply to the write that
    /// waited for it.
    pub fn stored_hosted(
        &mut self,
        cx: &mut ContextOf<P>,
        saved: &ParametersOf<P>,
        result: Result<(), StoreError>,
    ) -> Option<[u8; 8]> {
        self.services.end_save(cx, saved, result.is_ok());
        self.sdo.stored(result.is_ok())
    }

    /// Whether a block upload can go on with its [next segment](Self::next_segment).
    pub fn is_streaming(&self) -> bool {
        self.sdo.is_streaming()
    }

    /// The next segment of a block upload.
    pub fn next_segment(&mut self, now: Instant) -> Option<[u8; 8]> {
        self.sdo.next_segment(now)
    }

    /// Takes over the faults of the application, and aborts a transfer that has timed out. Returns the abort message.
    pub fn tick_hosted(&mut self, cx: &mut ContextOf<P>, now: Instant) -> Option<[u8; 8]> {
        self.services.take_faults(cx.values.faults());
        while self.services.emergency.announce_next() {}
        self.sdo.poll(now)
    }

    /// Whether an object has requested a reset, and its delay has not ended.
    pub fn is_resetting(&self) -> bool {
        self.services.state == State::Initialising
    }

    /// Resets the node if an object has requested it and the delay has ended. Returns true if so. After it, another protocol can be on the
    /// bus ([`is_hosted`](Self::is_hosted)).
    pub fn resets_hosted(&mut self, cx: &mut ContextOf<P>, now: Instant) -> bool {
        let resets = self.services.resets(now);
        if resets {
            self.reset_node(cx, now);
        }
        resets
    }

    /// The time of the next [`tick_hosted`](Self::tick_hosted) or [`resets_hosted`](Self::resets_hosted).
    pub fn deadline_hosted(&self) -> Deadline {
        let mut earliest = self.sdo.deadline();
        if self.is_resetting() {
            earliest.consider(self.services.heartbeat.deadline());
        }
        earliest
    }
}

impl<P: Product> Services<P> {
    /// Whether another protocol is on the bus.
    pub(super) fn is_hosted(&self) -> bool {
        P::HOSTED.is_some() && self.is_hosted
    }

    /// Selects the protocol that is on the bus from the parameters of a start.
    pub(super) fn select_protocol(&mut self, parameters: &ParametersOf<P>) {
        if let Some(hosted) = P::HOSTED {
            // The next reset of the communication configures the controller.
            if self.is_hosted {
                self.node_id = 0;
            }
            self.is_hosted = hosted(parameters);
        }
    }
}
