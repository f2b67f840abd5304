//! What the bus asks of a sensor, whether its firmware is built for the PC ([`Device`](super::Device)) or runs on a simulated
//! microcontroller.

use super::flash::Flash;
use crate::motion::Motion;
use can_wire::protocol::{Event, Picoseconds, Protocol};
use plumbline::can::{BitRate, Frame};
use plumbline::node::{BusMode, BusState, Leds, Readout};
use plumbline::time::Instant;
use std::any::Any;
use std::collections::VecDeque;

/// A sensor that can be attached to a [`Bus`](super::Bus).
pub trait Sensor: Any {
    /// Switches the power on.
    fn power_on(&mut self, now: Instant);

    /// Switches the power off.
    fn power_off(&mut self, now: Instant);

    /// True while the power is on.
    fn is_on(&self) -> bool;

    /// How often it has started: 1 after power-up, one more after each power cycle and restart.
    fn boots(&self) -> u32;

    /// Switches the power off and on again.
    fn power_cycle(&mut self, now: Instant) {
        self.power_off(now);
        self.power_on(now);
    }

    /// When it wants to act next without anything from outside. For a sensor that runs freely this is only for who waits in real
    /// time; it may be early, but not late.
    fn next_event(&self) -> Option<Picoseconds>;

    /// True when [`advance`](Self::advance) may be called with any later time and the sensor does everything in between on its
    /// own; false when it has to be called at [`next_event`](Self::next_event).
    fn runs_freely(&self) -> bool {
        false
    }

    /// Acts up to `now` and returns the time that it has reached. A sensor that runs freely returns early when its CAN controller
    /// has changed: joined or left the bus, or offers another frame. It does nothing when it is past `now` already, and then
    /// returns `now`.
    fn advance(&mut self, now: Picoseconds) -> Picoseconds;

    /// Its CAN controller; None while there is none, because the power is off.
    fn protocol(&self) -> Option<&Protocol>;

    /// When its CAN controller has to be stepped next; it may lie in the past, which means now.
    fn next_step(&self) -> Option<Picoseconds>;

    /// The frame that it would send next.
    fn offered(&self) -> Option<Frame>;

    /// The wire, as its CAN controller sees it, has changed; true is dominant.
    fn wire(&mut self, now: Picoseconds, dominant: bool);

    /// Steps its CAN controller, which is due, and deals with what that brings. `dominant` is the wire just before now.
    /// Where several sensors run freely, `now` may be a microsecond before what this one has reached.
    fn step(&mut self, now: Picoseconds, dominant: bool) -> Option<Event>;

    /// The name of the model.
    fn name(&self) -> &'static str;

    /// The mode of the CAN controller; None before the firmware has set one.
    fn mode(&self) -> Option<BusMode>;

    /// The bit rate of the CAN controller; None before the firmware has set one, or when it is none of the ten.
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

    /// What the LEDs show; dark while the power is off.
    fn leds(&self) -> Leds;

    /// What the LEDs have shown, with the time of each change; the newest ten thousand.
    fn led_history(&self) -> &VecDeque<(Instant, Leds)>;

    /// The angles as last reported; None while the power is off, or when they cannot be known from outside.
    fn readout(&self) -> Option<Readout>;

    /// Moves the sensor otherwise from now on.
    fn set_motion(&mut self, motion: Box<dyn Motion>);

    /// The nonvolatile memory.
    fn flash(&mut self) -> &mut Flash;
}
