//! Exception entry and return (ARM ARM B1.5.6 to B1.5.8).
//!
//! The frame on the stack, in order of addresses from the SP of the handler: R0, R1, R2, R3, R12, LR, the return address, xPSR.

use super::CortexM3;
use super::decode::instruction::Register;
use super::exceptions::{NMI, only};
use super::fault::{FaultKind, Result};
use super::registers::{ItState, THUMB};
use super::sleep::Sleep;
use super::timing::cost::Leaves;
use super::timing::fetch::is_code;

/// Cycles of an exception entry.
const ENTRY: u64 = 12;
/// Cycles of an exception return, if instructions have no costs.
const RETURN: u64 = 12;
/// Cycles from one handler to the next.
const TAIL_CHAIN: u64 = 6;

/// The bytes of a frame.
const FRAME_SIZE: u32 = 32;
/// The registers in a frame, in this order, before the return address and xPSR.
const FRAME_REGISTERS: [Register; 6] = [
    Register::new(0),
    Register::new(1),
    Register::new(2),
    Register::new(3),
    Register::new(12),
    Register::LR,
];
/// xPSR in a frame: SP was moved by a word for alignment.
const ALIGNED: u32 = 1 << 9;

/// EXC_RETURN: to a handler.
const TO_HANDLER: u32 = 0xFFFF_FFF1;
/// EXC_RETURN: to the thread on the main stack.
const TO_THREAD: u32 = 0xFFFF_FFF9;
/// EXC_RETURN: to the thread on the process stack.
const TO_THREAD_ON_PROCESS_STACK: u32 = 0xFFFF_FFFD;

impl CortexM3 {
    /// Exception entry: frame, vector, handler mode (ExceptionEntry).
    pub(super) fn enter_exception(&mut self, number: u16) -> Result<()> {
        self.enter(number, false)
    }

    /// The same for a fault. An error of the stacking is ignored: the handler starts with an invalid frame.
    pub(super) fn enter_fault(&mut self, number: u16) -> Result<()> {
        // An instruction that has caused a fault does not complete an exception return.
        self.returned = false;
        self.exceptions.pending |= only(number);
        self.enter(number, true)
    }

    fn enter(&mut self, number: u16, without_frame: bool) -> Result<()> {
        let return_value = if self.registers.in_handler() {
            TO_HANDLER
        } else if self.registers.is_on_process_stack() {
            TO_THREAD_ON_PROCESS_STACK
        } else {
            TO_THREAD
        };
        self.drain();
        let pushed = self.push_frame();
        self.registers.select_stack(false);
        if !without_frame {
            pushed?;
        }
        self.cycle += ENTRY;
        // Late arrival: the one that preempts now is taken, whichever began the entry.
        self.note_systick();
        let number = self.exceptions.next(&self.registers).unwrap_or(number);
        self.start_handler(number, return_value)
    }

    /// Starts a handler when the frame is on the stack.
    fn start_handler(&mut self, number: u16, return_value: u32) -> Result<()> {
        self.registers.set(Register::LR, return_value);
        self.registers.exception = number;
        self.registers.it = ItState::default();
        self.exceptions.pending &= !only(number);
        self.exceptions.active |= only(number);
        self.exclusive = false;
        self.event = true;
        self.fetch.forget();
        self.left = Leaves::default();
        if let Some(cycles) = &self.cycles
            && is_code(self.system.vector_table)
        {
            self.cycle = self.cycle.max(self.fetch.busy_until())
                + u64::from(cycles.vector_read) * self.fetch.wait_states();
        }
        let vector = self.system.vector_table.wrapping_add(4 * u32::from(number));
        let handler = self
            .memory
            .word(vector)
            .ok_or(FaultKind::Unmapped(vector))?;
        self.branch_to_state(handler)
    }

    fn push_frame(&mut self) -> Result<()> {
        let stack = self.registers.get(Register::SP);
        let moved = self.system.aligns_stack() && stack & 4 != 0;
        let frame = stack.wrapping_sub(FRAME_SIZE) & if moved { !4 } else { !0 };
        let status = self.registers.xpsr() | if moved { ALIGNED } else { 0 };
        let registers = FRAME_REGISTERS.map(|register| self.registers.get(register));
        let words = registers.into_iter().chain([self.next, status]);
        self.registers.set_stack_pointer(frame);
        for (address, word) in (frame..).step_by(4).zip(words) {
            if !self.memory.write(address, word.to_le_bytes()) {
                return Err(FaultKind::Stacking(address).into());
            }
        }
        Ok(())
    }

    /// A jump to an EXC_RETURN value in handler mode (ExceptionReturn).
    pub(super) fn return_from_exception(&mut self, value: u32) -> Result<()> {
        let invalid = |reason| Err(FaultKind::InvalidReturn(value, reason).into());
        let number = self.registers.exception;
        if self.exceptions.active & only(number) == 0 {
            return invalid("the exception in IPSR is not active");
        }
        let nested = self.exceptions.active.count_ones() > 1;
        let (handler, process_stack) = match value {
            TO_HANDLER => (true, false),
            TO_THREAD => (false, false),
            TO_THREAD_ON_PROCESS_STACK => (false, true),
            _ => return invalid("not a valid value"),
        };
        if handler && !nested {
            return invalid("to a handler while no other is active");
        }
        if !handler && nested && !self.system.allows_nested_thread() {
            return invalid("to the thread while a handler is active");
        }
        self.exceptions.active &= !only(number);
        if number != NMI {
            self.registers.faultmask = false;
        }
        self.returned = true;
        self.nvic.sample(&mut self.exceptions);
        self.note_systick();
        if let Some(next) = self.exceptions.next(&self.registers) {
            // Tail-chaining: the frame stays on the stack.
            self.cycle += TAIL_CHAIN;
            self.interrupt();
            return self.start_handler(next, value);
        }
        self.registers.select_stack(process_stack);
        self.drain();
        self.pop_frame()?;
        if handler != self.registers.in_handler() {
            return invalid("xPSR in the frame does not match");
        }
        self.cycle += self
            .cycles
            .map_or(RETURN, |cycles| cycles.exception_return.into());
        self.fetch.forget();
        self.exclusive = false;
        self.event = true;
        self.interrupt();
        if !handler && self.exceptions.active == 0 && self.system.sleeps_on_exit() {
            self.sleep(Sleep::Interrupt);
        }
        Ok(())
    }

    fn pop_frame(&mut self) -> Result<()> {
        let frame = self.registers.get(Register::SP);
        let mut words = [0; 8];
        for (address, word) in (frame..).step_by(4).zip(&mut words) {
            *word = self
                .memory
                .word(address)
                .ok_or(FaultKind::Unmapped(address))?;
        }
        let [registers @ .., return_address, status] = words;
        for (register, word) in FRAME_REGISTERS.into_iter().zip(registers) {
            self.registers.set(register, word);
        }
        if return_address & 1 != 0 {
            return Err(
                FaultKind::InvalidReturn(return_address, "an odd address in the frame").into(),
            );
        }
        if status & THUMB == 0 {
            return Err(FaultKind::InvalidReturn(status, "xPSR in the frame has T clear").into());
        }
        self.next = return_address;
        self.restore_flags(status);
        self.registers.it = ItState::from_bits(status);
        self.registers.exception = (status & 0x1FF) as u16;
        let moved = self.system.aligns_stack() && status & ALIGNED != 0;
        let stack = frame.wrapping_add(FRAME_SIZE) | if moved { 4 } else { 0 };
        self.registers.set_stack_pointer(stack);
        Ok(())
    }
}
