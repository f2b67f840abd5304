//! The cycles of an instruction at zero wait states, as far as they are known when it is decoded. Operands, memory and the target
//! of a branch add to them when it executes.

use super::super::decode::instruction::{Instruction, Register};
use super::Cycles;

/// In [`Cost::flags`]: the instruction loads or stores.
const ACCESS: u8 = 1 << 0;
/// In [`Cost::flags`]: it loads or stores one value, so that it can follow a load without a gap.
const PIPELINED: u8 = 1 << 1;
/// In [`Cost::flags`]: the written registers are loaded. Its value is the shift of their bits in [`Leaves`].
const LOADED: u8 = 16;

/// What an instruction costs and what it leaves for the next one.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Cost {
    /// Cycles beyond the first one; -1 if it takes none.
    extra: i8,
    flags: u8,
    /// The registers of the address of a load or store.
    address: u16,
    /// The registers that it leaves for the next one.
    written: u16,
}

/// The registers that the instruction before has written, by how: bits 0 to 15 by data processing, bits 16 to 31 by a load whose
/// data phase overlaps with the next instruction.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Leaves(u32);

fn only(register: Register) -> u16 {
    1 << register.index()
}

impl Cost {
    /// A skipped instruction of an IT block, or one without cost model.
    pub const ONE: Self = Self {
        extra: 0,
        flags: 0,
        address: 0,
        written: 0,
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
                written: only(low) | only(high),
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
                flags: ACCESS,
                address: only(n),
                ..Self::ONE
            },
            // Nothing can be pipelined after a store.
            I::StoreRegister { n, m, .. } => Self {
                extra: 1,
                flags: ACCESS | PIPELINED,
                address: only(n) | only(m),
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
                flags: ACCESS,
                address: only(n) | only(m),
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
            written: only(d),
            ..Self::ONE
        }
    }

    /// A load of one value: 2 cycles. A load to PC blocks: nothing overlaps with it.
    fn load(t: Register, address: u16) -> Self {
        let overlaps = t != Register::PC;
        Self {
            extra: 1,
            flags: if overlaps {
                ACCESS | PIPELINED | LOADED
            } else {
                ACCESS
            },
            address,
            written: if overlaps { only(t) } else { 0 },
        }
    }

    fn several(n: Register, count: u32) -> Self {
        Self {
            extra: count as i8,
            flags: ACCESS,
            // The base of LDRD can be PC, which no instruction leaves.
            address: only(n),
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
        self.flags & ACCESS != 0
    }

    /// The cycles beyond the first one, without those by the instruction before it.
    #[inline(always)]
    pub fn extra(&self) -> i8 {
        self.extra
    }

    /// The cycles beyond the first one of a load or store after an instruction that has left this.
    #[inline(always)]
    pub fn after(&self, before: Leaves) -> i8 {
        let address = u32::from(self.address);
        let loaded = before.0 >> 16;
        let waits = before.0 & address != 0;
        let overlaps = self.flags & PIPELINED != 0 && loaded != 0 && loaded & address == 0;
        // At most a dozen.
        self.extra
            .wrapping_add(i8::from(waits))
            .wrapping_sub(i8::from(overlaps))
    }

    /// What it leaves for the next instruction.
    #[inline(always)]
    pub fn leaves(&self) -> Leaves {
        Leaves(u32::from(self.written) << (self.flags & LOADED))
    }
}
