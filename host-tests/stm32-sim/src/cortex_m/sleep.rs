//! WFI, WFE and SEV (ARM ARM B1.5.18, B1.5.19).

use super::CortexM3;

/// The instruction class that the processor sleeps in.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Sleep {
    /// WFI, or the end of the last handler with SLEEPONEXIT.
    Interrupt,
    /// WFE: the processor waits for an event.
    Event,
}

impl CortexM3 {
    /// Starts to sleep. An event that already wakes it is processed before time passes.
    pub(super) fn sleep(&mut self, sleep: Sleep) {
        if sleep == Sleep::Event && std::mem::take(&mut self.event) {
            return;
        }
        self.sleep = Some(sleep);
        self.interrupt();
    }

    /// With SEVONPEND an exception that becomes pending is an event, even if it is disabled.
    pub(super) fn note_pending(&mut self) {
        let new = self.exceptions.pending & !self.noted_pending;
        self.noted_pending = self.exceptions.pending;
        self.event |= new != 0 && self.system.sends_event_on_pending();
    }

    /// Ends the sleep if there is a wake-up event; true when awake.
    pub(super) fn wake(&mut self) -> bool {
        let wakes = match self.sleep {
            None => true,
            Some(Sleep::Interrupt) => self.exceptions.wakes(&self.registers),
            Some(Sleep::Event) => {
                std::mem::take(&mut self.event) || self.exceptions.next(&self.registers).is_some()
            }
        };
        if wakes
            && self.sleep.take().is_some()
            && let Some(cycles) = &self.cycles
        {
            self.cycle += u64::from(cycles.wake_up);
        }
        wakes
    }
}
