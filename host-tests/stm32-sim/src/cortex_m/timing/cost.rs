//! The cycles of an instruction at zero wait states, as far as they are known when it is decoded. Operands, memory and the target
//! of a branch add to them when it executes.

use super::super::decode::instruction::{Instruction, Register};
use super::Cycles;

/// Set in [`Cost::address`]: the instruction loads or stores one value, so that it can follow a load without a gap.
const PIPELINED: u32 = 1 << 16;
/// Set in [`Cost::address`]: it loads or stores.
const ACCESS: u32 = 1 << 17;

/// What an instruction costs and what it leaves for the next one.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Cost {
    /// Cycles beyond the first one; -1 if it takes none.
    extra: i8,
    /// The registers of the address of a load or store, and the flags above.
    address: u32,
    leaves: Leaves,
}

/// The registers that the instruction before has written, by how: bits 0 to 15 by data processing, bits 16 to 31 by a load whose
/// data phase overlaps with the next instruction.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Leaves(u32);

fn only(register: Register) -> u32 {
    1 << register.index()
}

impl Cost {
    /// A skipped instruction of an IT block, or one without cost model.
    pub const ONE: Self = Self {
        extra: 0,
        address: 0,
        leaves: Leaves(0),
    };

    /// The cost of an instruction.
    pub fn of(instruction: &Instruction, cycles: &Cycles) -> Self {
        use Instruction as I;
        match *instruction {
            I::DataImmediate { d, .. }
            | I::DataRegister { d, .. }
            | I::DataShifted { d, .. }
            | I::ShiftByRegister { d, .. }
            | I::MoveTop { d, .. }
            | I::Address { d, .. }
            | I::Multiply { d, .. }
            | I::Divide { d, .. }
            | I::Saturate { d, .. }
            | I::BitFieldExtract { d, .. }
            | I::BitFieldInsert { d, .. }
            | I::BitFieldClear { d, .. }
            | I::ExtendRegister { d, .. }
            | I::RearrangeBits { d, .. } => Self::data(d),
            I::MultiplyAdd { d, .. } | I::MultiplySubtract { d, .. } => Self::data(d).longer(1),
            I::MultiplyLong { low, high, .. } => Self {
                leaves: Leaves(only(low) | only(high)),
                ..Self::ONE
            },
            I::MoveFromSpecial { d, .. } => Self::data(d).longer(cycles.special - 1),
            I::MoveToSpecial { .. } | I::ChangeState { .. } => Self::ONE.longer(cycles.special - 1),

            I::LoadOffset { t, n, .. }
            | I::LoadIndexed { t, n, .. }
            | I::LoadExclusive { t, n, .. } => Self::load(t, only(n)),
            I::LoadRegister { t, n, m, .. } => Self::load(t, only(n) | only(m)),
            I::LoadLiteral { t, .. } => Self::load(t, 0).longer(cycles.literal),
            I::StoreOffset { n, .. } | I::StoreIndexed { n, .. } => Self {
                address: only(n) | ACCESS,
                ..Self::ONE
            },
            // Nothing can be pipelined after a store.
            I::StoreRegister { n, m, .. } => Self {
                extra: 1,
                address: only(n) | only(m) | ACCESS | PIPELINED,
                ..Self::ONE
            },
            // Pipelined exactly as a load.
            I::StoreExclusive { d, n, .. } => Self::load(d, only(n)),
            I::LoadDual { n, .. } | I::StoreDual { n, .. } => Self::several(n, 2),
            I::LoadMultiple { n, list, .. } | I::StoreMultiple { n, list, .. } => {
                Self::several(n, list.count_ones())
            }
            I::TableBranch { n, m, .. } => Self {
                extra: cycles.table_branch as i8 - 1,
                address: only(n) | only(m) | ACCESS,
                ..Self::ONE
            },

            // Folded, it does not have the cycle that every instruction has.
            I::IfThen { .. } => Self {
                extra: cycles.if_then as i8 - 1,
                ..Self::ONE
            },
            I::Barrier { instructions: true } => Self::ONE.longer(cycles.refill),
            I::Barrier { .. } => Self::ONE.longer(cycles.barrier),
            _ => Self::ONE,
        }
    }

    fn data(d: Register) -> Self {
        Self {
            leaves: Leaves(only(d)),
            ..Self::ONE
        }
    }

    /// A load of one value: 2 cycles. A load to PC blocks: nothing overlaps with it.
    fn load(t: Register, address: u32) -> Self {
        let overlaps = t != Register::PC;
        Self {
            extra: 1,
            address: address | ACCESS | if overlaps { PIPELINED } else { 0 },
            leaves: Leaves(if overlaps { only(t) << 16 } else { 0 }),
        }
    }

    fn several(n: Register, count: u32) -> Self {
        Self {
            extra: count as i8,
            // The base of LDRD can be PC, which no instruction leaves.
            address: only(n) | ACCESS,
            ..Self::ONE
        }
    }

    fn longer(self, cycles: u8) -> Self {
        Self {
            extra: self.extra + cycles as i8,
            ..self
        }
    }

    /// True for a load or store.
    #[inline(always)]
    pub fn is_access(&self) -> bool {
        self.address != 0
    }

    /// The cycles beyond the first one after an instruction that has left this.
    #[inline(always)]
    pub fn after(&self, before: Leaves) -> i64 {
        let mut cycles = i64::from(self.extra);
        if self.address != 0 {
            let registers = self.address & 0xFFFF;
            let loaded = before.0 >> 16;
            cycles += i64::from(before.0 & registers != 0);
            cycles -=
                i64::from(self.address & PIPELINED != 0 && loaded != 0 && loaded & registers == 0);
        }
        cycles
    }

    /// What it leaves for the next instruction.
    #[inline(always)]
    pub fn leaves(&self) -> Leaves {
        self.leaves
    }
}
