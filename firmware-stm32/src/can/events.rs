//! The CAN controller without its mailboxes for the driver, with the measured bit times among its events.

use super::Bus;
use core::marker::PhantomData;
use plumbline::can::BitRate;
use plumbline::node::driver::{Change, Controller, Filters};
use plumbline::node::{BitTime, BusEvent, BusMode, ProductNode};

/// The bus, with the events for node `N`.
pub struct BusEvents<N> {
    /// The controller.
    pub bus: &'static mut Bus,
    /// True until the events of the controller are read in this turn.
    is_unread: bool,
    /// The measured bit time of the last frame, for the node.
    bit_time: Option<BitTime>,
    /// True until the check whether the controller has missed this frame.
    ends_frame: bool,
    node: PhantomData<N>,
}

impl<N: ProductNode> BusEvents<N> {
    /// The bus, without events.
    pub fn new(bus: &'static mut Bus) -> Self {
        Self {
            bus,
            is_unread: false,
            bit_time: None,
            ends_frame: false,
            node: PhantomData,
        }
    }

    /// Begins a turn of the main loop.
    pub fn begin(&mut self) {
        self.is_unread = true;
        if N::DETECTS && self.bit_time.is_none() {
            // This comes before the step of the bus. If the controller can join the bus at the end of this frame, the step completes the
            // join.
            self.bit_time = self.bus.bit_time();
            self.ends_frame = self.bit_time.is_some();
        }
    }

    /// Whether the bus must be polled without a pause.
    pub fn is_urgent(&self) -> bool {
        N::DETECTS && self.bus.is_urgent()
    }

    /// Whether the bus must be polled every millisecond.
    pub fn is_restless(&self) -> bool {
        self.bus.restless() || N::DETECTS && self.bus.measures()
    }
}

impl<N: ProductNode> Controller for BusEvents<N> {
    fn open(&mut self, mode: BusMode, rate: BitRate, filters: Filters<'_>) {
        info!("{} at {}", mode, rate);
        if N::DETECTS {
            self.bus.measure(mode);
        }
        self.bus.configure(mode, rate, filters);
    }

    fn change(&mut self) -> Change {
        self.bus.step()
    }

    fn refilter(&mut self, filters: Filters<'_>) -> bool {
        self.bus.refilter(filters)
    }

    fn recover(&mut self) {
        info!("recover from bus-off");
        self.bus.recover();
    }

    fn event(&mut self) -> Option<BusEvent> {
        if self.is_unread {
            let event = self.bus.event();
            // A wrong bit rate causes continuous errors. At most one of them is handled in a turn, so that the bit time is read.
            self.is_unread = !matches!(event, None | Some(BusEvent::Error));
            if event.is_some() {
                return event;
            }
        }
        if !N::DETECTS {
            return None;
        }
        if core::mem::take(&mut self.ends_frame) && self.bus.misses_frame() {
            return Some(BusEvent::Error);
        }
        self.bit_time.take().map(BusEvent::BitTime)
    }
}
