//! Every instruction of the Cortex-M3, with its registers and immediates resolved: the output of the decoder.
//!
//! Encodings that differ only in size or range are the same instruction here.

pub use super::operand::{
    Carry, Condition, DataOp, Extend, Index, Multiple, Rearrange, Register, SetFlags, Shift, Size,
};

use super::dsp::Dsp;
use super::rule::Rule;

/// An instruction. The registers are named as in the manual: `d` destination, `n` first operand or base, `m` second operand or
/// index, `t` transferred, `a` accumulated.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[expect(missing_docs, reason = "the fields are those of the manual")]
pub enum Instruction {
    /// The second operand is a number.
    DataImmediate {
        op: DataOp,
        d: Register,
        n: Register,
        flags: SetFlags,
        carry: Carry,
        value: u32,
    },
    /// The second operand is a register.
    DataRegister {
        op: DataOp,
        d: Register,
        n: Register,
        m: Register,
        flags: SetFlags,
    },
    /// The second operand is a register, shifted.
    DataShifted {
        op: DataOp,
        d: Register,
        n: Register,
        m: Register,
        flags: SetFlags,
        shift: Shift,
        amount: u8,
    },
    /// CMP, CMN, TST, TEQ with a number.
    CompareImmediate {
        op: DataOp,
        n: Register,
        carry: Carry,
        value: u32,
    },
    /// CMP, CMN, TST, TEQ with a register.
    CompareRegister {
        op: DataOp,
        n: Register,
        m: Register,
    },
    /// CMP, CMN, TST, TEQ with a shifted register.
    CompareShifted {
        op: DataOp,
        n: Register,
        m: Register,
        shift: Shift,
        amount: u8,
    },
    /// LSL, LSR, ASR, ROR by the low byte of a register.
    ShiftByRegister {
        shift: Shift,
        d: Register,
        n: Register,
        m: Register,
        flags: SetFlags,
    },
    /// MOVT: the upper half of d = value.
    MoveTop { d: Register, value: u16 },
    /// ADR: the word-aligned PC plus an offset.
    Address { d: Register, offset: i32 },

    /// MUL: d = n * m.
    Multiply {
        d: Register,
        n: Register,
        m: Register,
        flags: SetFlags,
    },
    /// MLA: d = a + n * m.
    MultiplyAdd {
        d: Register,
        n: Register,
        m: Register,
        a: Register,
    },
    /// MLS: d = a - n * m.
    MultiplySubtract {
        d: Register,
        n: Register,
        m: Register,
        a: Register,
    },
    /// SMULL, UMULL, SMLAL, UMLAL: high:low = n * m, or is increased by it.
    MultiplyLong {
        signed: bool,
        accumulate: bool,
        low: Register,
        high: Register,
        n: Register,
        m: Register,
    },
    /// SDIV, UDIV: d = n / m.
    Divide {
        signed: bool,
        d: Register,
        n: Register,
        m: Register,
    },
    /// SSAT, USAT. `bits` is the width of the result.
    Saturate {
        signed: bool,
        d: Register,
        n: Register,
        bits: u8,
        shift: Shift,
        amount: u8,
    },
    /// SBFX, UBFX: d = `width` bits of n from bit `lsb` on.
    BitFieldExtract {
        signed: bool,
        d: Register,
        n: Register,
        lsb: u8,
        width: u8,
    },
    /// BFI: `width` bits of d from bit `lsb` on = the lowest bits of n.
    BitFieldInsert {
        d: Register,
        n: Register,
        lsb: u8,
        width: u8,
    },
    /// BFC: `width` bits of d from bit `lsb` on = 0.
    BitFieldClear { d: Register, lsb: u8, width: u8 },
    /// SXTB, SXTH, UXTB, UXTH, after a rotation to the right by this many bits.
    ExtendRegister {
        kind: Extend,
        d: Register,
        m: Register,
        rotation: u8,
    },
    /// REV, REV16, REVSH, RBIT, CLZ.
    RearrangeBits {
        kind: Rearrange,
        d: Register,
        m: Register,
    },

    /// Load from `[Rn, #offset]`, without write-back.
    LoadOffset {
        size: Size,
        t: Register,
        n: Register,
        offset: i16,
    },
    /// Load that writes the base back.
    LoadIndexed {
        size: Size,
        t: Register,
        n: Register,
        index: Index,
        offset: i16,
    },
    /// Load, `[Rn, Rm, LSL #shift]`.
    LoadRegister {
        size: Size,
        t: Register,
        n: Register,
        m: Register,
        shift: u8,
    },
    /// Load from the word-aligned PC plus an offset.
    LoadLiteral {
        size: Size,
        t: Register,
        offset: i16,
    },
    /// Store to `[Rn, #offset]`, without write-back.
    StoreOffset {
        size: Size,
        t: Register,
        n: Register,
        offset: i16,
    },
    /// Store that writes the base back.
    StoreIndexed {
        size: Size,
        t: Register,
        n: Register,
        index: Index,
        offset: i16,
    },
    /// Store, `[Rn, Rm, LSL #shift]`.
    StoreRegister {
        size: Size,
        t: Register,
        n: Register,
        m: Register,
        shift: u8,
    },
    /// LDRD: loads two registers from consecutive words.
    LoadDual {
        t: Register,
        t2: Register,
        n: Register,
        index: Index,
        offset: i16,
    },
    /// STRD: stores two registers to consecutive words.
    StoreDual {
        t: Register,
        t2: Register,
        n: Register,
        index: Index,
        offset: i16,
    },
    /// LDM, LDMDB, POP. Bit i of the list stands for register i.
    LoadMultiple {
        n: Register,
        kind: Multiple,
        write_back: bool,
        list: u16,
    },
    /// STM, STMDB, PUSH. Bit i of the list stands for register i.
    StoreMultiple {
        n: Register,
        kind: Multiple,
        write_back: bool,
        list: u16,
    },
    /// LDREX, LDREXB, LDREXH: loads, and marks the access as exclusive.
    LoadExclusive {
        size: Size,
        t: Register,
        n: Register,
        offset: u16,
    },
    /// STREX, STREXB, STREXH: stores if the access is still exclusive; d = 0 if so, otherwise 1.
    StoreExclusive {
        size: Size,
        d: Register,
        t: Register,
        n: Register,
        offset: u16,
    },
    /// CLREX: ends an exclusive access.
    ClearExclusive,

    /// B: a branch without condition.
    Branch { offset: i32 },
    /// B with its own condition.
    BranchIf { condition: Condition, offset: i32 },
    /// BL: a branch with the return address in LR.
    BranchLink { offset: i32 },
    /// BX: a branch to the address in a register.
    BranchExchange { m: Register },
    /// BLX: a branch to the address in a register, with the return address in LR.
    BranchLinkExchange { m: Register },
    /// MOV PC, Rm: a branch to the address in a register.
    MoveToPc { m: Register },
    /// ADD PC, Rm: a branch by an offset in a register.
    AddToPc { m: Register },
    /// CBZ, CBNZ: a branch if n is 0, or is not 0.
    CompareBranch { n: Register, zero: bool, offset: u8 },
    /// TBB, TBH: a branch by an offset from a table of bytes or half-words.
    TableBranch {
        n: Register,
        m: Register,
        half_words: bool,
    },

    /// IT: the new ITSTATE.
    IfThen { state: u8 },
    /// NOP, hints without effect here and preloads.
    Nop,
    /// DMB and DSB; ISB, which also refills the pipeline.
    Barrier { instructions: bool },
    /// WFI: sleeps until an interrupt.
    WaitForInterrupt,
    /// WFE: sleeps until an event or an interrupt.
    WaitForEvent,
    /// SEV: sets the event register.
    SendEvent,
    /// CPSIE and CPSID: change PRIMASK and FAULTMASK.
    ChangeState {
        disable: bool,
        primask: bool,
        faultmask: bool,
    },
    /// MRS: d = a special register.
    MoveFromSpecial { d: Register, special: u8 },
    /// MSR: a special register = n.
    MoveToSpecial { n: Register, special: u8 },
    /// SVC: causes the exception SVCall.
    SupervisorCall,
    /// BKPT with this number.
    Breakpoint(u8),

    /// An instruction of the DSP extension.
    Dsp(Dsp),

    /// The encoding is UNDEFINED by this rule.
    Undefined(Rule),
    /// The encoding is UNPREDICTABLE by this rule.
    Unpredictable(Rule),
}

/// The permitted position of an instruction in an IT block.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ItRule {
    /// Any position in an IT block, or outside.
    Anywhere,
    /// A branch: only as the last instruction.
    Last,
    /// Only outside of an IT block.
    Outside,
}

/// An instruction with its length and its place in IT blocks.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Decoded {
    /// The instruction with its operands, or the rule that refuses it.
    pub instruction: Instruction,
    /// Its length in bytes, 2 or 4.
    pub length: u8,
    /// Its permitted position in an IT block.
    pub it: ItRule,
}
