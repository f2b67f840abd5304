//! The cycle counter of the DWT unit (ARM ARM C1.8), which DEMCR.TRCENA enables. Its other functions are not modelled.

use super::CortexM3;
use super::fault::{FaultKind, Result};
use crate::io::Width;

/// DEMCR: the DWT unit is enabled.
const TRCENA: u32 = 1 << 24;
/// CTRL: CYCCNT counts.
const CYCCNTENA: u32 = 1 << 0;
/// CTRL: four comparators.
const COMPARATORS: u32 = 4 << 28;

/// The cycle counter of the data watchpoint and trace unit.
#[derive(Clone, Debug, Default)]
pub struct Dwt {
    counts: bool,
    /// The value at cycle `since`, and always while it does not count.
    value: u32,
    since: u64,
}

impl Dwt {
    fn current(&self, cycle: u64) -> u32 {
        if self.counts {
            self.value.wrapping_add((cycle - self.since) as u32)
        } else {
            self.value
        }
    }

    fn set(&mut self, cycle: u64, counts: bool, value: u32) {
        (self.counts, self.value, self.since) = (counts, value, cycle);
    }
}

impl CortexM3 {
    /// Reads a register at 0xE000_1000..0xE000_2000. Without TRCENA all of them read as 0.
    pub(super) fn read_dwt(&mut self, address: u32, width: Width) -> Result<u32> {
        self.check_dwt(address, width)?;
        Ok(match address & 0xFFF {
            _ if !self.traces() => 0,
            0x000 => COMPARATORS | u32::from(self.dwt.counts),
            _ => self.dwt.current(self.cycle),
        })
    }

    /// Writes a register, with TRCENA.
    pub(super) fn write_dwt(&mut self, address: u32, width: Width, value: u32) -> Result<()> {
        self.check_dwt(address, width)?;
        let (cycle, current) = (self.cycle, self.dwt.current(self.cycle));
        match address & 0xFFF {
            _ if !self.traces() => {}
            0x000 => self.dwt.set(cycle, value & CYCCNTENA != 0, current),
            _ => self.dwt.set(cycle, self.dwt.counts, value),
        }
        Ok(())
    }

    fn traces(&self) -> bool {
        self.system.debug_monitor & TRCENA != 0
    }

    fn check_dwt(&self, address: u32, width: Width) -> Result<()> {
        if !self.registers.is_privileged() {
            return Err(FaultKind::System(address, "the program is unprivileged").into());
        }
        match (address & 0xFFF, width) {
            (0x000 | 0x004, Width::Word) => Ok(()),
            _ => Err(FaultKind::System(address, "it is not modelled").into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEMCR: u32 = 0xE000_EDFC;
    const CTRL: u32 = 0xE000_1000;
    const CYCCNT: u32 = 0xE000_1004;

    #[test]
    fn cycle_counter_counts_only_with_trcena_and_cyccntena() {
        let mut core = CortexM3::new();
        let word = Width::Word;
        core.write_dwt(CTRL, word, CYCCNTENA).unwrap();
        assert_eq!(core.read_dwt(CTRL, word).unwrap(), 0, "not enabled");
        core.write_system(DEMCR, word, TRCENA).unwrap();
        assert_eq!(core.read_dwt(CTRL, word).unwrap(), 0x4000_0000);
        core.cycle += 10;
        assert_eq!(core.read_dwt(CYCCNT, word).unwrap(), 0);
        core.write_dwt(CTRL, word, CYCCNTENA).unwrap();
        assert_eq!(core.read_dwt(CTRL, word).unwrap(), 0x4000_0001);
        core.cycle += 10;
        assert_eq!(core.read_dwt(CYCCNT, word).unwrap(), 10);
        core.write_dwt(CYCCNT, word, u32::MAX).unwrap();
        core.cycle += 3;
        assert_eq!(core.read_dwt(CYCCNT, word).unwrap(), 2, "it wraps");
        core.write_dwt(CTRL, word, 0).unwrap();
        core.cycle += 10;
        assert_eq!(
            core.read_dwt(CYCCNT, word).unwrap(),
            2,
            "it keeps its value"
        );
        assert!(core.read_dwt(0xE000_1008, word).is_err());
        assert!(core.read_dwt(CYCCNT, Width::Byte).is_err());
    }
}
