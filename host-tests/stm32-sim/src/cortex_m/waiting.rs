//! Skips the passes of a loop in which the program only waits, for example for a flag of a peripheral.
//!
//! A pass of such a loop ends with the state with which it has begun, at a later cycle. So do the next passes, until the value of a
//! register that the loop reads changes, or until the processor must stop. They are not executed, only counted: the cycles, the executed
//! instructions and the state are the same.
//!
//! A loop is a waiting loop if it consists of instructions that change only registers, and if all that it reads is constant: memory, which
//! nothing else writes while the processor runs, and registers of which [`Io::constant_until`] or SysTick knows when they change.

use super::CortexM3;
use super::cache::Cache;
use super::decode::instruction::{Instruction, Register};
use super::registers::Flags;
use super::timing::Fetch;
use super::timing::cost::Leaves;
use crate::io::Io;

/// The pass after which the next one is observed; before, the pipeline may not be in its steady state.
const OBSERVED: u32 = 4;
/// The most bytes of a loop.
const LONGEST: u32 = 64;
/// Registers that a loop reads, at most.
const READS: usize = 4;
/// Loops that are known not to wait, at most.
const REFUSED: usize = 64;
/// No branch has this target.
const NONE: u32 = 1;

/// The address of SYST_CSR.
const SYSTICK_CONTROL: u32 = 0xE000_E010;

/// The branches that were taken last.
#[derive(Clone, Debug)]
pub struct Waiting {
    /// The target of the last branch that was taken.
    target: u32,
    /// The number of branches to it that were taken without another one between them, minus one.
    passes: u32,
    /// The address after the last of them.
    after: u32,
    /// A pass begins or ends that is observed.
    due: bool,
    /// The start of the pass that is observed.
    start: Option<Start>,
    /// The registers that are read in this pass.
    reads: [u32; READS],
    count: usize,
    /// The starts of loops that do not wait, by their address.
    refused: [u32; REFUSED],
}

/// The state at the start of a pass.
#[derive(Clone, Debug)]
struct Start {
    general: [u32; 15],
    flags: Flags,
    left: Leaves,
    fetch: Fetch,
    /// The address after the branch that has begun the pass.
    after: u32,
    cycle: u64,
    instructions: u64,
}

impl Default for Waiting {
    fn default() -> Self {
        Self {
            target: NONE,
            passes: 0,
            after: 0,
            due: false,
            start: None,
            reads: [0; READS],
            count: 0,
            refused: [NONE; REFUSED],
        }
    }
}

impl Waiting {
    /// Something else than the loop has happened.
    pub fn forget(&mut self) {
        self.target = NONE;
        self.due = false;
        self.start = None;
    }

    /// Takes a branch into account. True when a pass begins or ends that is observed.
    #[inline(always)]
    pub fn branch(&mut self, target: u32, after: u32) -> bool {
        if target != self.target {
            self.target = target;
            self.passes = 0;
            return false;
        }
        self.passes = self.passes.wrapping_add(1);
        if self.passes < OBSERVED || self.passes > OBSERVED + 1 {
            return false;
        }
        self.may_wait(after)
    }

    #[inline(never)]
    fn may_wait(&mut self, after: u32) -> bool {
        let is_short = after.wrapping_sub(self.target) <= LONGEST;
        self.due = is_short && self.refused[self.place()] != self.target;
        self.after = after;
        if self.passes == OBSERVED {
            self.start = None;
        }
        self.due
    }

    fn place(&self) -> usize {
        self.target as usize / 2 % REFUSED
    }

    fn refuse(&mut self) {
        let place = self.place();
        self.refused[place] = self.target;
    }

    /// Notes that a register is read.
    pub fn read(&mut self, address: u32) {
        if let Some(place) = self.reads.get_mut(self.count) {
            *place = address;
        }
        self.count += 1;
    }
}

impl CortexM3 {
    /// Notes that a branch was taken.
    #[inline(always)]
    pub(super) fn note_branch(&mut self, after: u32) {
        if self.waiting.branch(self.next, after) {
            self.interrupt();
        }
    }

    /// At the start of a pass that must be observed, stores the state; at its end, skips the further passes up to cycle `limit` if they
    /// are alike.
    #[inline(never)]
    pub(super) fn skip_passes(&mut self, io: &impl Io, cache: &Cache, limit: u64) {
        if !std::mem::take(&mut self.waiting.due) {
            return;
        }
        if self.waiting.passes == OBSERVED {
            self.begin_pass(cache);
            return;
        }
        let Some(start) = self.waiting.start.take() else {
            return;
        };
        let time = self.cycle - start.cycle;
        if start.general != self.general() || start.flags != self.registers.flags {
            self.waiting.refuse();
            return;
        }
        let Some(moves) = self.fetch.moves(&start.fetch, start.cycle, time) else {
            return;
        };
        let constant = self.constant_until(io, start.cycle).min(limit);
        // One further pass is executed, so that the peripherals know the time of the last access.
        let passes = constant.saturating_sub(self.cycle) / time;
        let passes = passes.saturating_sub(1);
        if start.left != self.left || start.after != self.waiting.after || passes == 0 {
            return;
        }
        let instructions = self.instructions - start.instructions;
        self.instructions += passes * instructions;
        self.cycle += passes * time;
        self.fetch.go_on(moves, passes * time);
    }

    fn general(&self) -> [u32; 15] {
        std::array::from_fn(|number| self.registers.get(Register::new(number as u32)))
    }

    fn begin_pass(&mut self, cache: &Cache) {
        if !waits(cache, self.waiting.target, self.waiting.after) {
            self.waiting.refuse();
            return;
        }
        let is_settled = self.buffer_free_at <= self.cycle && self.fetch.busy_until() <= self.cycle;
        if !is_settled || self.registers.it.is_active() {
            return;
        }
        self.waiting.count = 0;
        self.waiting.start = Some(Start {
            general: self.general(),
            flags: self.registers.flags,
            left: self.left,
            fetch: self.fetch.clone(),
            after: self.waiting.after,
            cycle: self.cycle,
            instructions: self.instructions,
        });
    }

    /// The cycle up to which all registers that the pass has read since `start` keep these values; 0 if that is unknown.
    fn constant_until(&self, io: &impl Io, start: u64) -> u64 {
        let Some(reads) = self.waiting.reads.get(..self.waiting.count) else {
            return 0;
        };
        let constant = |address: &u32| match *address {
            SYSTICK_CONTROL => self.systick.constant_until(),
            address => io.constant_until(start, address).unwrap_or(0),
        };
        reads.iter().map(constant).min().unwrap_or(u64::MAX)
    }
}

/// True if a loop consists only of instructions that change registers of the processor.
fn waits(cache: &Cache, first: u32, end: u32) -> bool {
    let mut address = first;
    while address < end {
        let Some(place) = cache.get(address) else {
            return false;
        };
        if !only_registers(&place.instruction) {
            return false;
        }
        address += u32::from(place.length);
    }
    true
}

fn only_registers(instruction: &Instruction) -> bool {
    use Instruction as I;
    match *instruction {
        I::LoadOffset { t, .. } | I::LoadRegister { t, .. } | I::LoadLiteral { t, .. } => {
            t != Register::PC
        }
        I::DataImmediate { .. }
        | I::DataRegister { .. }
        | I::DataShifted { .. }
        | I::CompareImmediate { .. }
        | I::CompareRegister { .. }
        | I::CompareShifted { .. }
        | I::MoveTop { .. }
        | I::Address { .. }
        | I::ExtendRegister { .. }
        | I::BitFieldExtract { .. }
        | I::Branch { .. }
        | I::BranchIf { .. }
        | I::CompareBranch { .. }
        | I::Nop => true,
        _ => false,
    }
}
