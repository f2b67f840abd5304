//! The interface between the bus and a sensor. Its firmware is built for the PC ([`Device`](super::Device)) or runs on a
//! simulated microcontroller.

use super::flash::Flash;
use crate::motion::Motion;
use can_wire::protocol::{Event, Period, Picoseconds, Protocol};
use plumbline::can::{BitRate, Frame};
use plumbline::node::{BusMode, BusState, Leds, Readout};
use plumbline::time::Instant;
use std::any::Any;
use std::collections::VecDeque;

/// A sensor that can be attached to a [`Bus`](super::Bus).
pub trait Sensor: Any {
    /// Switches the supply on. The node starts with the content of its memory.
    fn power_on(&mut self, now: Instant);

    /// Switches the supply off: the node is gone, and its memory stays.
    fn power_off(&mut self, now: Instant);

    /// True while the power is on.
    fn is_on(&self) -> bool;

    /// The number of starts: 1 after power-up, one more after each power cycle and restart.
    fn boots(&self) -> u32;

    /// Switches the power off and on again.
    fn power_cycle(&mut self, now: Instant) {
        self.power_off(now);
        self.power_on(now);
    }

    /// When it acts next without any input. For a free-running sensor this serves only callers that wait in real time; it may be
    /// early, but not late.
    fn next_event(&self) -> Option<Picoseconds>;

    /// True when [`advance`](Self::advance) may be called with any later time and the sensor processes everything in between;
    /// false when it has to be called at [`next_event`](Self::next_event).
    fn runs_freely(&self) -> bool {
        false
    }

    /// Acts up to `now` and returns the time that it has reached. A free-running sensor returns early when its CAN controller has
    /// changed: joined or left the bus, or offers another frame. When it is already past `now`, it does nothing and returns
    /// `now`.
    fn advance(&mut self, now: Picoseconds) -> Picoseconds;

    /// Its CAN controller; None while the power is off.
    fn protocol(&self) -> Option<&Protocol>;

    /// True if the sensor drives the bus dominant. After a hardware fault, this level can differ from the level of the CAN
    /// controller.
    fn is_dominant(&self) -> bool {
        self.protocol().is_some_and(Protocol::is_dominant)
    }

    /// When its CAN controller has to be stepped next; a time in the past means now.
    fn next_step(&self) -> Option<Picoseconds>;

    /// The frame that it would send next.
    fn offered(&self) -> Option<Frame>;

    /// Reports a new level of the wire to its CAN controller; true is dominant.
    fn wire(&mut self, now: Picoseconds, dominant: bool);

    /// Steps its CAN controller, which is due, and handles the resulting event. `dominant` is the level just before `now`. With
    /// several free-running sensors, `now` may be a microsecond before the time that this one has reached.
    fn step(&mut self, now: Picoseconds, dominant: bool) -> Option<Event>;

    /// Moves the state of its CAN controller to the end of this many further attempts to send a frame that nobody acknowledges. A
    /// free-running sensor computes each attempt and does nothing.
    fn skip(&mut self, period: Period, count: u64) {
        let _ = (period, count);
    }

    /// The short name of the product.
    fn name(&self) -> &'static str;

    /// The mode of the CAN controller; None before the firmware has set one.
    fn mode(&self) -> Option<BusMode>;

    /// The bit rate of the CAN controller; None before the firmware has set one, or when it is not one of the ten.
    fn rate(&self) -> Option<BitRate>;

    /// The fault confinement state; None while the power is off.
    fn bus_state(&self) -> Option<BusState> {
        self.protocol().map(Protocol::state)
    }

    /// The transmit and the receive error counter; None while the power is off.
    fn error_counters(&self) -> Option<(u16, u16)> {
        let protocol = self.protocol()?;
        Some((protocol.transmit_errors(), protocol.receive_errors()))
    }

    /// The current state of the LEDs; off while the power is off.
    fn leds(&self) -> Leds;

    /// The states of the LEDs, with the time of each change; the newest ten thousand.
    fn led_history(&self) -> &VecDeque<(Instant, Leds)>;

    /// The last reported angles; None while the power is off, or when they are not visible from outside.
    fn readout(&self) -> Option<Readout>;

    /// Replaces the motion of the sensor from now on.
    fn set_motion(&mut self, motion: Box<dyn Motion>);

    /// The nonvolatile memory, to read it.
    fn memory(&mut self) -> &Flash;

    /// The nonvolatile memory, to change it or to cause faults.
    fn flash(&mut self) -> &mut Flash;
}
