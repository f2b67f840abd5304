//! The microcontroller as a sensor on the bus of the bench: power, time, and its CAN controller on the wire.

use super::Microcontroller;
use crate::cortex_m::Pause;
use crate::rcc::ResetCause;
use bench::motion::Motion;
use bench::{Flash, Sensor};
use can_wire::protocol::{Event, Picoseconds, Protocol};
use plumbline::can::{BitRate, Frame};
use plumbline::node::{BusMode, Leds, Readout};
use plumbline::time::Instant;
use std::collections::VecDeque;

impl Sensor for Microcontroller {
    fn power_on(&mut self, now: Instant) {
        self.start(now.ticks() * 1_000_000);
    }

    fn power_off(&mut self, _: Instant) {
        if self.on {
            self.switch_off();
        }
    }

    fn is_on(&self) -> bool {
        self.on
    }

    fn boots(&self) -> u32 {
        self.boots
    }

    fn next_event(&self) -> Option<Picoseconds> {
        if !self.on {
            return None;
        }
        if self.is_frozen() {
            return self.wakes_at();
        }
        if !self.core.is_asleep() {
            return Some(self.time());
        }
        let events = [self.core.next_wake(), self.noted().next_event];
        let next = events.into_iter().flatten().min()?;
        Some(self.io.now(next))
    }

    fn runs_freely(&self) -> bool {
        true
    }

    fn advance(&mut self, now: Picoseconds) -> Picoseconds {
        while self.on {
            if self.is_frozen() && !self.wait(now) {
                break;
            }
            self.load_parameters();
            let target = self.io.rcc.timebase().cycle_at(now);
            if self.core.cycle() >= target {
                break;
            }
            let event = self.noted().next_event;
            let until = event.map_or(target, |event| event.clamp(self.core.cycle() + 1, target));
            let pause = self.core.run(&mut self.io, until);
            if self.io.take_touched() {
                self.forget();
            }
            match pause {
                Ok(Pause::Reached)
                    if event.is_some_and(|event| event <= until) || self.is_due() =>
                {
                    self.settle();
                }
                Ok(Pause::Reached) => self.note_leds(),
                Ok(Pause::Changed) => {
                    self.settle();
                    if self.io.can.take_changed() {
                        return self.time().min(now);
                    }
                }
                Ok(Pause::Reset) => self.reset(ResetCause::Software),
                // Nobody waits for it.
                Ok(Pause::Breakpoint) => {}
                Ok(Pause::Bkpt(number)) => {
                    self.stop(self.core.pc(), format!("breakpoint {number}"))
                }
                Err(fault) => self.fault(&fault),
            }
        }
        if let Some(heated) = &self.heated {
            heated.set_duty(self.heater());
        }
        now
    }

    fn protocol(&self) -> Option<&Protocol> {
        let connected = self.on && self.noted().is_connected;
        connected.then(|| self.io.can.protocol())
    }

    fn is_dominant(&self) -> bool {
        self.on && self.io.is_dominant(self.noted().driver)
    }

    fn next_step(&self) -> Option<Picoseconds> {
        self.protocol()?;
        if self.io.rcc.is_stopped() {
            return None;
        }
        self.io.can.next_event()
    }

    fn offered(&self) -> Option<Frame> {
        self.protocol()?;
        self.io.can.offered()
    }

    fn wire(&mut self, now: Picoseconds, dominant: bool) {
        if self.protocol().is_some() && !self.io.rcc.is_stopped() {
            self.io.can.wire(now, dominant);
            self.io.receive_pin(now, dominant);
            self.set_lines();
        }
    }

    fn step(&mut self, now: Picoseconds, dominant: bool) -> Option<Event> {
        self.protocol()?;
        let event = self.io.can.step(now, dominant);
        self.set_lines();
        event
    }

    fn name(&self) -> &'static str {
        self.name
    }

    fn mode(&self) -> Option<BusMode> {
        self.rate()?;
        Some(if self.io.can.is_silent() {
            BusMode::Listen
        } else {
            BusMode::Normal
        })
    }

    fn rate(&self) -> Option<BitRate> {
        let rate = self.io.can.bit_rate().filter(|_| self.on)?;
        BitRate::ALL
            .into_iter()
            .find(|known| known.bits_per_second() == rate)
    }

    fn leds(&self) -> Leds {
        self.leds
    }

    fn led_history(&self) -> &VecDeque<(Instant, Leds)> {
        &self.led_history
    }

    fn readout(&self) -> Option<Readout> {
        None
    }

    fn set_motion(&mut self, motion: Box<dyn Motion>) {
        let now = self.time();
        let motion = match &self.heated {
            Some(heated) => heated.around(motion),
            None => motion,
        };
        match &mut self.io.adxl355 {
            Some(part) => part.set_motion(now, motion),
            None => self.io.imu.set_motion(now, motion),
        }
    }

    fn memory(&mut self) -> &Flash {
        self.io.flash.parameters()
    }

    fn flash(&mut self) -> &mut Flash {
        self.parameters_touched = true;
        self.io.flash.parameters_mut()
    }
}
