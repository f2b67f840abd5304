//! Disturbances: the configuration registers of the processor, of which one inverts bits.

use super::CortexM3;
use crate::io::Width;
use std::ops::Range;

/// The system control space.
pub const SYSTEM: Range<u32> = 0xE000_E000..0xE000_F000;

/// What is not configuration, by offset: identifiers, ICER with the bits of ISER, states, and the registers of a debugger.
const OTHERS: [Range<u32>; 8] = [
    // ICTR.
    0x004..0x010,
    // SysTick: VAL, CALIB.
    0x018..0x100,
    // NVIC: ICER to IABR.
    0x180..0x400,
    // CPUID, ICSR.
    0xD00..0xD08,
    // The status of faults.
    0xD28..0xD40,
    // MPU_TYPE.
    0xD90..0xD94,
    // DHCSR to DEMCR.
    0xDF0..0xE00,
    // STIR.
    0xF00..0xF04,
];

impl CortexM3 {
    /// The addresses of the configuration registers.
    pub fn configuration(&mut self) -> Vec<u32> {
        let is_other = |address: u32| {
            let offset = address - SYSTEM.start;
            OTHERS.iter().any(|range| range.contains(&offset))
        };
        let mut all: Vec<u32> = SYSTEM.step_by(4).collect();
        all.retain(|address| !is_other(*address) && self.peek(*address).is_some());
        all
    }

    /// The value of a register, without the effect of a read; None if it is not modelled.
    pub fn peek(&mut self, address: u32) -> Option<u32> {
        let systick = self.systick.clone();
        let value = self.read_system_word(address);
        self.systick = systick;
        value.ok()
    }

    /// Inverts bits of a configuration register. False if the register does not have all of them.
    pub fn disturb(&mut self, address: u32, bits: u32) -> bool {
        let Some(value) = self.peek(address).map(|value| value ^ bits) else {
            return false;
        };
        self.note_systick();
        match address - SYSTEM.start {
            // ICER clears what ISER cannot.
            0x100..0x180 if value & bits == 0 => {
                self.nvic.write(&mut self.exceptions, address + 0x80, bits);
            }
            0xD0C => self.exceptions.priority_group = (value >> 8 & 7) as u8,
            0xD10 => self.system.disturb_sleep(value),
            _ => {
                let _ = self.write_system(address, Width::Word, value);
            }
        }
        self.interrupt();
        self.peek(address) == Some(value)
    }
}
