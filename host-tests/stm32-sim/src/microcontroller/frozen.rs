//! Periods in which the processor executes no instruction: a debugger halts it, its clock has stopped, or the supply is too low.

use super::Microcontroller;
use crate::rcc::ResetCause;
use can_wire::protocol::Picoseconds;

impl Microcontroller {
    /// Halts the processor, as a debugger does. The peripherals continue, except those that DBGMCU_CR stops.
    pub fn halt(&mut self) {
        self.halted = true;
    }

    /// Continues the processor at this time, as a debugger does.
    pub fn resume(&mut self, now: Picoseconds) {
        let length = now - self.time();
        if self.io.dbgmcu.stops_watchdog() {
            self.io.iwdg.delay(length);
        }
        self.io.rcc.go_on(self.core.cycle(), now);
        self.forget();
        self.halted = false;
    }

    /// True while the processor executes no instruction: it is halted, has no clock, or the supply is too low.
    pub(super) fn is_frozen(&self) -> bool {
        self.halted || self.io.rcc.is_stopped() || self.io.pwr.is_down()
    }

    /// Switches the microcontroller on at this time.
    pub(super) fn start(&mut self, time: Picoseconds) {
        self.on = true;
        self.io.power_on(self.core.cycle(), time);
        self.core.overwrite_ram();
        self.reset(ResetCause::PowerOn);
        self.parameters_touched = true;
    }

    /// The time of the reset that ends such a period: by the watchdog or by the supply.
    pub(super) fn wakes_at(&self) -> Option<Picoseconds> {
        if self.io.pwr.is_down() {
            return self.io.pwr.next_event();
        }
        let stops = self.halted && self.io.dbgmcu.stops_watchdog();
        self.io.iwdg.expires_at().filter(|_| !stops)
    }

    /// Lets the time pass up to `now` while no instruction is executed. True if a reset has started the program.
    pub(super) fn wait(&mut self, now: Picoseconds) -> bool {
        let Some(time) = self.wakes_at().filter(|time| *time <= now) else {
            return false;
        };
        if self.io.pwr.is_down() {
            self.io.pwr.goes_down(time);
            self.start(time);
        } else {
            self.halted = false;
            self.io.rcc.go_on(self.core.cycle(), time);
            self.reset(ResetCause::Watchdog);
        }
        true
    }
}
