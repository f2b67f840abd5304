//! What any CAN node is, whatever it speaks.
//!
//! A [`Node`] is driven from outside: frames, samples, bus events and store results are handed in with the time at which they
//! came, and what the node wants done comes out of [`Node::poll`] and [`Node::transmit`]. It performs no I/O and reads no clock,
//! so the same code runs on a board, in a test and in the virtual sensor.

mod autobaud;
mod boot;
mod can_node;
mod led;
mod protocol;
mod queue;
mod shell;

pub use crate::application::Readout;
pub use crate::store::Boot;
pub use autobaud::{Autobaud, CANDIDATES, DWELL_MAX, DWELL_MIN};
pub use can_node::CanNode;
pub use led::{Channels, ErrorPatterns, Indicator, Leds, Pattern, Patterns};
pub use protocol::{BusChange, Context, Protocol};
pub use queue::TransmitQueue;
pub use shell::{NodeState, Shell};

use crate::can::{BitRate, Filter, Frame};
use crate::measure::Reading;
use crate::measure::self_test::Working;
use crate::store::StoreError;
use crate::time::Instant;

/// What a node asks of the hardware around it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Action {
    /// Go to this bit rate and mode, dropping what waits in the transmit mailboxes, and received frames and bus errors of before
    /// that have not been handed in: they belong to the rate before. In [`BusMode::Normal`], accept what
    /// [`Node::filters`] lets pass; in [`BusMode::Listen`], accept everything.
    Bus(BusMode, BitRate),
    /// Leave bus-off: start the recovery sequence of 128 times 11 recessive bits.
    Recover,
    /// Show this on the status LEDs.
    Leds(Leds),
    /// Write [`Node::image`] to nonvolatile memory and report through [`Node::stored`]. Take the image at once, before the
    /// node is given anything else.
    Save,
    /// Restart the device as after power-up, once the mailboxes have been sent.
    Restart,
    /// Connect (true) or disconnect the terminating resistor of the bus.
    Termination(bool),
    /// Heat the measuring cell with this part of the heater's power, in permille.
    Heater(u16),
    /// Test the accelerometer's axes and report through [`Node::tested`], within
    /// [`self_test::LIMIT`](crate::measure::self_test::LIMIT).
    SelfTest,
}

/// How the CAN controller takes part in the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BusMode {
    /// Listen only: never sends a dominant bit, neither acknowledge nor error flag.
    Listen,
    /// Full participation.
    Normal,
}

/// The fault confinement state of the CAN controller (ISO 11898-1).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BusState {
    /// Error active, both error counters below 96.
    Active,
    /// An error counter has reached the warning limit of 96.
    Warning,
    /// An error counter has passed 127.
    Passive,
    /// The transmit error counter has passed 255: off the bus.
    BusOff,
}

/// Something that the CAN controller noticed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BusEvent {
    /// The fault confinement state changed.
    State(BusState),
    /// A bus error was seen (stuff, form, CRC, ...); of interest while listening for the bit rate.
    Error,
    /// Received frames were lost because nobody fetched them in time.
    Overrun,
}

/// A CAN sensor, driven from outside.
///
/// After each call that hands something in, call [`poll`](Self::poll) until it returns None, then fetch frames with
/// [`transmit`](Self::transmit) while a mailbox is free; who is in a hurry may also fetch the reply before. Nothing changes by
/// itself before [`deadline`](Self::deadline).
pub trait Node {
    /// Whether a further received frame may be handed in. While false, leave frames in the receive queue: there is no room for
    /// a reply, or a save or restart must come to its end first.
    fn ready(&self) -> bool;

    /// A frame came from the bus. Frames that [`filters`](Self::filters) would refuse are tolerated and ignored.
    fn receive(&mut self, now: Instant, frame: &Frame);

    /// A reading came from the accelerometer, every [`SAMPLE_PERIOD`](crate::measure::SAMPLE_PERIOD); the first one should come
    /// before the first poll. While there is none, the sensor tells that it has an error.
    fn sample(&mut self, now: Instant, reading: &Reading);

    /// The CAN controller noticed something.
    fn bus(&mut self, now: Instant, event: BusEvent);

    /// The save that [`Action::Save`] asked for has ended.
    fn stored(&mut self, now: Instant, result: Result<(), StoreError>);

    /// The test that [`Action::SelfTest`] asked for has ended. A model without such a test does nothing.
    fn tested(&mut self, now: Instant, result: Working) {
        let _ = (now, result);
    }

    /// What is to be done now; None when there is nothing left. The answer can change after each call that hands something in
    /// and when the deadline comes.
    fn poll(&mut self, now: Instant) -> Option<Action>;

    /// The next frame to send; ask only when a mailbox can take it. The node keeps frames back in its queue while the bus is
    /// busy, so that a newer cyclic value can still replace an older one.
    fn transmit(&mut self, now: Instant) -> Option<Frame>;

    /// When to poll again at the latest; None: only after new input.
    fn deadline(&self) -> Option<Instant>;

    /// Calls `accept` for each acceptance filter in force in [`BusMode::Normal`].
    fn filters(&self, accept: &mut dyn FnMut(Filter));

    /// Writes the parameters that [`Action::Save`] wants stored into `buffer`; returns how many bytes they are, or None when the
    /// buffer is too small.
    fn image(&self, buffer: &mut [u8]) -> Option<usize>;

    /// The inclination as last reported.
    fn readout(&self) -> Readout;
}
