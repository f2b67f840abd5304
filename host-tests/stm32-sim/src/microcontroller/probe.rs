//! A debug probe at the SWD pins.
//!
//! While the processor sleeps, the probe reaches bus and memories only if they have a clock: DBG_SLEEP in DBGMCU_CR, and the clock of the DMA
//! controller, which keeps that of the bus matrix (zephyr, issue 34324; probe-rs, issues 1337 and 1340).

use super::Microcontroller;
use crate::elf::Image;
use crate::rcc::ResetCause;
use can_wire::protocol::Picoseconds;
use std::rc::Rc;

impl Microcontroller {
    /// Connects the probe, which other functions of it need.
    pub fn probe_connect(&mut self) {
        self.io.dbgmcu.connect();
    }

    /// Disconnects the probe. DBGMCU_CR keeps its value.
    pub fn probe_disconnect(&mut self) {
        self.io.dbgmcu.disconnect();
    }

    /// True if the probe reaches the memories.
    fn answers_probe(&self) -> bool {
        let io = &self.io;
        let has_clock = io.rcc.is_clocked(io.chip().dma()) && io.dbgmcu.runs_in_sleep();
        self.on && io.dbgmcu.is_connected() && (self.halted || !self.core.is_asleep() || has_clock)
    }

    /// Reads flash or RAM. None if the probe does not reach it.
    pub fn probe_read(&self, address: u32, length: usize) -> Option<Vec<u8>> {
        let bytes = self.core.bytes(address, length)?;
        self.answers_probe().then(|| bytes.to_vec())
    }

    /// Halts the processor. False if the probe does not reach it.
    pub fn probe_halt(&mut self) -> bool {
        let answers = self.answers_probe();
        if answers {
            self.halt();
        }
        answers
    }

    /// Writes a program into the flash of the halted processor, and resets it. False if the probe does not reach it.
    pub fn probe_program(&mut self, now: Picoseconds, image: Rc<Image>) -> bool {
        if !self.halted || !self.answers_probe() {
            return false;
        }
        self.image = image;
        self.load_program();
        self.resume(now);
        self.reset(ResetCause::Software);
        true
    }
}
