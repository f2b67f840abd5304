//! The CAN node: the [`Node`] trait and the part of a node that is the same for every protocol.
//!
//! A driver passes frames, samples, bus events and store results to a [`Node`], each with its time stamp. [`Node::poll`] returns
//! the actions that the node requests, [`Node::transmit`] returns the frames to send. The node performs no I/O and reads no
//! clock, so the same code runs on a board, in a test and in the virtual sensor.

mod acquisition;
mod autobaud;
mod boot;
mod can_node;
mod communication;
pub mod driver;
mod led;
mod product_node;
mod protocol;
mod pulse_meter;
mod queue;
mod shell;

pub use crate::application::Readout;
pub use crate::store::Boot;
pub use acquisition::Acquisition;
pub use autobaud::{Autobaud, BitTime};
pub use can_node::CanNode;
pub use communication::{Communication, Task};
pub use led::{Channels, ErrorPatterns, Indicator, Leds, Pattern, Patterns};
pub(crate) use product_node::owner;
pub use product_node::{AcquisitionOf, CommunicationOf, ProductNode, StoreOf};
pub use protocol::{BusChange, Context, Protocol, Restore};
pub use pulse_meter::PulseMeter;
pub use queue::TransmitQueue;
pub use shell::{NodeState, Shell};

use crate::can::{BitRate, Filter, Frame};
use crate::measure::Reading;
use crate::measure::self_test::Working;
use crate::store::{StoreError, Usage};
use crate::time::Instant;
use crate::update::Contact;

/// A request of the node to the hardware.
#[must_use]
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Action {
    /// Set this bit rate and mode. Discard the frames in the transmit mailboxes, and the received frames and bus errors that the
    /// node has not received yet: they belong to the previous bit rate. In [`BusMode::Normal`], accept the frames that pass
    /// [`Node::filters`]. In [`BusMode::Listen`], accept all frames. [`Node::changes_filters`] is an exception. Before the first
    /// action of this kind, the controller is off the bus.
    Bus(BusMode, BitRate),
    /// Leave bus-off: start the recovery sequence of 128 times 11 recessive bits.
    Recover,
    /// Switch each status LED on or off.
    Leds(Leds),
    /// Write [`Node::image`] to nonvolatile memory and report the result with [`Node::stored`]. Read the image before the next
    /// call that changes the node.
    Save,
    /// Restart the device as after power-up, after the frames in the mailboxes are sent. Pass [`Node::kept`] to the next start.
    Restart,
    /// Connect (true) or disconnect the terminating resistor of the bus.
    Termination(bool),
    /// Set the power of the heater of the measuring cell, in permille of its maximum.
    Heater(u16),
    /// Test the axes of the accelerometer and report the result with [`Node::tested`], within
    /// [`self_test::LIMIT`](crate::measure::self_test::LIMIT).
    SelfTest,
}

/// The operating mode of the CAN controller.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BusMode {
    /// Listen only: sends no dominant bit, no acknowledge and no error flag. Measures the bit time ([`BusEvent::BitTime`]).
    Listen,
    /// Takes part in the traffic: sends, acknowledges and receives.
    Normal,
}

/// The fault confinement state of the CAN controller (ISO 11898-1).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BusState {
    /// Error active: both error counters are below 96.
    Active,
    /// Error active: an error counter is 96 (the warning limit) or more.
    Warning,
    /// Error passive: an error counter is above 127.
    Passive,
    /// Bus-off: the transmit error counter is above 255.
    BusOff,
}

/// An event of the CAN controller.
#[must_use]
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BusEvent {
    /// The fault confinement state changed.
    State(BusState),
    /// The controller detected a bus error (stuff, form, CRC, ...). Used only in [`BusMode::Listen`].
    Error,
    /// The bit time of a frame, from [`PulseMeter`]: after each frame in [`BusMode::Listen`], also if the controller could not receive
    /// it.
    BitTime(BitTime),
    /// Received frames were lost because the receive queue was full.
    Overrun,
    /// A frame that is [sent once](Node::sends_once) ended in a bit error and is not repeated. Report it before [`Node::sent`].
    Unsent,
}

/// A CAN sensor without its hardware.
///
/// After each input call, call [`poll`](Self::poll) until it returns None. Then call [`transmit`](Self::transmit) while a mailbox
/// is free. For the lowest latency, call `transmit` before `poll`. Without input, the next change is at
/// [`deadline`](Self::deadline).
pub trait Node {
    /// Whether the node can take the next received frame. While false, leave frames in the receive queue: there is no room for a
    /// reply, or the node waits for a save or a restart.
    fn ready(&self) -> bool;

    /// Handles a received frame. In [`BusMode::Normal`], the node ignores frames that do not pass [`filters`](Self::filters).
    fn receive(&mut self, now: Instant, frame: &Frame);

    /// Handles a reading of the accelerometer. Call it every [`SAMPLE_PERIOD`](crate::measure::SAMPLE_PERIOD). The first reading
    /// starts the protocol: before it, the node is not on the bus. Without readings for 100 ms (89 ms after the start of the
    /// node), it reports a sensor error.
    fn sample(&mut self, now: Instant, reading: &Reading);

    /// Handles a gap before the next reading: values of the accelerometer or the gyroscope were lost.
    fn interrupt(&mut self) {}

    /// Handles an event of the CAN controller.
    fn bus(&mut self, now: Instant, event: BusEvent);

    /// Handles the result of the save that [`Action::Save`] requested.
    fn stored(&mut self, now: Instant, result: Result<(), StoreError>);

    /// Handles the result of the test that [`Action::SelfTest`] requested. A product without self-test does nothing.
    fn tested(&mut self, now: Instant, result: Working) {
        let _ = (now, result);
    }

    /// Handles a measurement of the supply voltage in mV, every [`SAMPLE_PERIOD`](crate::measure::SAMPLE_PERIOD). A product that does
    /// not measure it does nothing.
    fn supply(&mut self, now: Instant, millivolts: u16) {
        let _ = (now, millivolts);
    }

    /// The next action to perform; None if there is none. There can be new actions after each input call and at the deadline.
    #[must_use]
    fn poll(&mut self, now: Instant) -> Option<Action>;

    /// Whether the controller must not repeat the next frame of [`transmit`](Self::transmit) after a bit error. Then report
    /// [`BusEvent::Unsent`]. After a lost arbitration or without acknowledge it is sent again at once.
    fn sends_once(&self) -> bool {
        false
    }

    /// The next frame to send. Call it only when a mailbox is free. Frames stay in the queue of the node while the bus is busy,
    /// so that a newer cyclic value can replace an older one.
    #[must_use]
    fn transmit(&mut self, now: Instant) -> Option<Frame>;

    /// Handles that all mailboxes are empty, because the frames of [`transmit`](Self::transmit) were sent. Call it then, before
    /// [`poll`](Self::poll); more calls have no effect. After [`Action::Bus`] has discarded the frames, there is no call.
    fn sent(&mut self, now: Instant) {
        let _ = now;
    }

    /// The latest time for the next poll; None: no poll is necessary before the next input.
    fn deadline(&self) -> Option<Instant>;

    /// Calls `accept` for each acceptance filter in force in [`BusMode::Normal`].
    fn filters(&self, accept: &mut dyn FnMut(Filter));

    /// Whether an [`Action::Bus`] with the mode and bit rate in force, except in bus-off, only discards the frames in the transmit
    /// mailboxes and sets the filters: the controller stays on the bus, and no received frame is lost.
    fn changes_filters(&self) -> bool {
        false
    }

    /// Writes the parameters that [`Action::Save`] requests to store into `buffer`. Returns their length in bytes, or None if the
    /// buffer is too small.
    fn image(&self, buffer: &mut [u8]) -> Option<usize>;

    /// The state to keep over the restart that [`Action::Restart`] requests, in memory that is not cleared, for [`Boot::kept`].
    /// Only a heated product has one; 0: there is none.
    fn kept(&self) -> u32 {
        0
    }

    /// What the bootloader must know, if the restart that [`Action::Restart`] requests is that into it; None: it is not.
    fn contact(&self) -> Option<Contact> {
        None
    }

    /// The usage of the device, this start included: see [`Platform::keep`](driver::Platform::keep). None: the product does not store it.
    fn usage(&self) -> Option<Usage> {
        None
    }

    /// Replaces the usage. A node without usage does nothing.
    fn set_usage(&mut self, usage: &Usage) {
        let _ = usage;
    }

    /// The last inclination, for displays on a PC.
    fn readout(&self) -> Readout;
}
