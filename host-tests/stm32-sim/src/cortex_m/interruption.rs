//! Interrupts within loads and stores of several words: LDM, STM, PUSH, POP, LDRD and STRD.
//!
//! The processor abandons such an instruction after some of its words, and executes it again from its start after the handler. The base is
//! restored (ARM ARM B1.5.10), except by an LDRD on a processor with erratum 602117. An LDM or STM can also be continued after the handler,
//! which repeats less, so a program that works here works then too.

use super::CortexM3;
use super::decode::instruction::Register;
use super::exceptions::{FIRST_INTERRUPT, only};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

/// The instructions that were interrupted. Several processors can share it, for example those of a program that runs several times.
#[derive(Clone, Debug, Default)]
pub struct Interruptions(Rc<RefCell<BTreeMap<u32, usize>>>);

impl Interruptions {
    /// The addresses of the instructions, each with the number of interrupts within it.
    pub fn places(&self) -> BTreeMap<u32, usize> {
        self.0.borrow().clone()
    }
}

/// The interrupt that comes within instructions.
#[derive(Clone, Debug)]
pub struct Interruption {
    exception: u16,
    done: Interruptions,
}

impl CortexM3 {
    /// From now on this interrupt comes within each load and store of several words that it can interrupt, once after each of its words except
    /// the last one. `done` has those that were interrupted already.
    pub fn interrupt_within_instructions(&mut self, interrupt: u8, done: &Interruptions) {
        self.interruption = Some(Interruption {
            exception: FIRST_INTERRUPT + u16::from(interrupt),
            done: done.clone(),
        });
    }

    /// The number of words after which this instruction is abandoned; None if it is executed.
    #[inline(always)]
    pub(super) fn abandoned_after(&mut self, words: u32) -> Option<usize> {
        match &self.interruption {
            None => None,
            Some(_) => self.interrupted_after(words as usize),
        }
    }

    #[cold]
    #[inline(never)]
    fn interrupted_after(&mut self, words: usize) -> Option<usize> {
        let Interruption { exception, done } = self.interruption.as_ref()?;
        let is_enabled = self.exceptions.enabled & only(*exception) != 0;
        if !is_enabled || !self.exceptions.preempts(*exception, &self.registers, true) {
            return None;
        }
        let mut places = done.0.borrow_mut();
        let count = places.entry(self.executed()).or_default();
        let interrupted = *count + 1 < words;
        *count += usize::from(interrupted);
        interrupted.then_some(*count)
    }

    /// Ends an instruction without its effect on base and PC. The interrupt comes before it is executed again.
    pub(super) fn abandon(&mut self) {
        let Some(interruption) = &self.interruption else {
            return;
        };
        self.exceptions.pending |= only(interruption.exception);
        self.next = self.executed();
        self.abandoned = self.in_it_block;
        self.interrupt();
    }

    /// The address of the instruction that executes.
    fn executed(&self) -> u32 {
        self.registers.get(Register::PC).wrapping_sub(4)
    }
}
