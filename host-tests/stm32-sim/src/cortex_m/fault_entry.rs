//! Faults as exceptions (ARM ARM B1.5.14 and B3.2.15): the fault status registers, escalation to HardFault, and lockup.
//!
//! In this model each bus fault is precise. On the chip, the fault of a store can be reported some instructions later, without its address
//! (IMPRECISERR). The chip reports no fault for accesses and instructions that the manuals forbid without a defined effect. In this model
//! they end the run.

use super::CortexM3;
use super::exceptions::{BUS_FAULT, HARD_FAULT, MEMORY_FAULT, USAGE_FAULT};
use super::fault::{Fault, FaultKind};
use crate::io::AccessError;

// CFSR.
const INSTRUCTION_ACCESS_VIOLATION: u32 = 1 << 0;
const INSTRUCTION_BUS_ERROR: u32 = 1 << 8;
const PRECISE_BUS_ERROR: u32 = 1 << 9;
const STACKING_ERROR: u32 = 1 << 12;
const BUS_ADDRESS_VALID: u32 = 1 << 15;
const UNDEFINED_INSTRUCTION: u32 = 1 << 16;
const INVALID_STATE: u32 = 1 << 17;
const INVALID_RETURN: u32 = 1 << 18;
const UNALIGNED: u32 = 1 << 24;
const DIVISION_BY_ZERO: u32 = 1 << 25;

/// HFSR: escalated to HardFault.
const FORCED: u32 = 1 << 30;

/// The registers that say why a fault was taken.
#[derive(Clone, Copy, Debug, Default)]
pub struct FaultStatus {
    /// CFSR: the bits of memory management, bus and usage faults.
    pub configurable: u32,
    /// HFSR, the status of the HardFault.
    pub hard: u32,
    /// BFAR, the address of a bus fault.
    pub bus_address: u32,
}

impl Fault {
    /// The exception of this fault and its bits in CFSR; None for an operation that the chip does not report.
    fn status(&self) -> Option<(u16, u32)> {
        let data_bus_error = PRECISE_BUS_ERROR | BUS_ADDRESS_VALID;
        Some(match self.kind {
            FaultKind::Unmapped(address) if address == self.pc => {
                (BUS_FAULT, INSTRUCTION_BUS_ERROR)
            }
            FaultKind::Unmapped(_) | FaultKind::Access(_, AccessError::Unmapped) => {
                (BUS_FAULT, data_bus_error)
            }
            FaultKind::Protected(_) => (MEMORY_FAULT, INSTRUCTION_ACCESS_VIOLATION),
            FaultKind::Stacking(_) => (BUS_FAULT, STACKING_ERROR),
            FaultKind::Undefined(_) => (USAGE_FAULT, UNDEFINED_INSTRUCTION),
            FaultKind::InvalidState(_) => (USAGE_FAULT, INVALID_STATE),
            FaultKind::InvalidReturn(..) => (USAGE_FAULT, INVALID_RETURN),
            FaultKind::Unaligned(_) => (USAGE_FAULT, UNALIGNED),
            FaultKind::DivisionByZero => (USAGE_FAULT, DIVISION_BY_ZERO),
            FaultKind::Escalation => (HARD_FAULT, 0),
            FaultKind::Unpredictable(_) | FaultKind::Access(..) | FaultKind::System(..) => {
                return None;
            }
        })
    }
}

impl CortexM3 {
    /// Takes a fault of the last run as an exception: its handler runs next. If the fault is in the handler of HardFault or NMI, the
    /// processor locks up until a reset. False if the chip does not report this operation as a fault.
    #[must_use]
    pub fn take_fault(&mut self, fault: &Fault) -> bool {
        let Some((number, bits)) = fault.status() else {
            return false;
        };
        self.faults.configurable |= bits;
        if bits & BUS_ADDRESS_VALID != 0 {
            self.faults.bus_address = fault.address;
        }
        let taken = self.system.has_handler(number)
            && self.exceptions.preempts(number, &self.registers, true);
        let number = if taken { number } else { HARD_FAULT };
        if number == HARD_FAULT {
            self.faults.hard |= FORCED;
        }
        if !self.exceptions.preempts(number, &self.registers, true) {
            self.locked_up = true;
            return true;
        }
        self.locked_up = self.enter_fault(number).is_err();
        true
    }

    /// Ignores the bus fault of a load or store at priority -1 or -2 while CCR.BFHFNMIGN is set (PM0056 4.4.7): the status is set, and the
    /// program continues behind the instruction. The loaded value is undefined on the chip; here the register keeps its value. A store is only
    /// ignored by the chip if its fault is precise.
    pub(super) fn ignore_fault(&mut self, fault: &Fault) -> bool {
        let ignores = self.system.ignores_bus_faults()
            && self.exceptions.execution_priority(&self.registers, true) < 0;
        let bits = match fault.status() {
            Some((BUS_FAULT, bits)) if ignores && bits & PRECISE_BUS_ERROR != 0 => bits,
            _ => return false,
        };
        self.faults.configurable |= bits;
        self.faults.bus_address = fault.address;
        let first = self.memory.read(fault.pc).map_or(0, u16::from_le_bytes);
        // Instructions of 32 bits begin with 11101, 11110 or 11111.
        self.next = fault.pc + if first >= 0xE800 { 4 } else { 2 };
        true
    }

    /// True after a fault in the handler of HardFault or NMI: only a reset ends this state.
    pub fn is_locked_up(&self) -> bool {
        self.locked_up
    }
}
