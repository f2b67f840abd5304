//! System instructions: CPS, MRS, MSR, SVC, BKPT (ARM ARM B5.2, A7.7).

use super::super::decode::instruction::Register;
use super::super::exceptions::{SVCALL, only};
use super::super::fault::{FaultKind, Result};
use super::super::registers::Flags;
use super::super::{CortexM3, Pause};

/// CONTROL: thread mode is unprivileged.
const UNPRIVILEGED: u32 = 1 << 0;
/// CONTROL: thread mode is on the process stack.
const PROCESS_STACK: u32 = 1 << 1;

impl CortexM3 {
    /// CPSIE and CPSID, which have no effect when unprivileged.
    pub(super) fn change_state(&mut self, disable: bool, primask: bool, faultmask: bool) {
        if !self.registers.is_privileged() {
            return;
        }
        if primask {
            self.registers.primask = disable;
        }
        if faultmask {
            self.set_faultmask(disable);
        }
        // Masking cannot start an exception.
        if !disable {
            self.interrupt();
        }
    }

    /// The NMI handler cannot set FAULTMASK.
    fn set_faultmask(&mut self, masked: bool) {
        let registers = &mut self.registers;
        registers.faultmask = masked && self.exceptions.execution_priority(registers, true) > -1;
    }

    /// MRS: reads a special register by number. EPSR always reads as 0.
    pub(super) fn special(&self, number: u8) -> u32 {
        let registers = &self.registers;
        let exception = if number & 1 != 0 {
            u32::from(registers.exception)
        } else {
            0
        };
        let flags = if number & 4 == 0 {
            registers.flags.to_bits()
        } else {
            0
        };
        match number {
            0..=7 => flags | exception,
            _ if !registers.is_privileged() && number != 20 => 0,
            8 | 9 => registers.stack_pointer(number == 9),
            16 => registers.primask.into(),
            17 | 18 => registers.basepri.into(),
            19 => registers.faultmask.into(),
            _ => {
                let unprivileged = if registers.unprivileged_thread {
                    UNPRIVILEGED
                } else {
                    0
                };
                let process = if registers.is_on_process_stack() {
                    PROCESS_STACK
                } else {
                    0
                };
                unprivileged | process
            }
        }
    }

    /// MSR: except for the flags it requires privilege; IPSR and EPSR ignore writes.
    pub(super) fn set_special(&mut self, number: u8, value: u32) {
        if number < 4 {
            let flags = &mut self.registers.flags;
            *flags = Flags {
                greater_equal: flags.greater_equal,
                ..Flags::from_bits(value)
            };
        }
        if !self.registers.is_privileged() {
            return;
        }
        self.interrupt();
        let priority = value as u8 & 0xF0;
        match number {
            8 | 9 => self.registers.write_stack_pointer(number == 9, value),
            16 => self.registers.primask = value & 1 != 0,
            17 => self.registers.basepri = priority,
            // BASEPRI_MAX can only raise the mask level.
            18 if priority != 0
                && (priority < self.registers.basepri || self.registers.basepri == 0) =>
            {
                self.registers.basepri = priority;
            }
            19 => self.set_faultmask(value & 1 != 0),
            20 => {
                self.registers.unprivileged_thread = value & UNPRIVILEGED != 0;
                if !self.registers.in_handler() {
                    self.registers.select_stack(value & PROCESS_STACK != 0);
                }
            }
            _ => {}
        }
    }

    /// SVC is taken at once; without sufficient priority it would escalate to HardFault (B1.5.6).
    pub(super) fn supervisor_call(&mut self) -> Result<()> {
        if !self.exceptions.preempts(SVCALL, &self.registers, true) {
            return Err(FaultKind::Escalation.into());
        }
        self.exceptions.pending |= only(SVCALL);
        self.interrupt();
        Ok(())
    }

    /// BKPT halts with PC at its address.
    pub(super) fn stop_at_bkpt(&mut self, number: u8) {
        self.next = self.registers.get(Register::PC).wrapping_sub(4);
        self.pause = Some(Pause::Bkpt(number));
        self.interrupt();
    }
}
