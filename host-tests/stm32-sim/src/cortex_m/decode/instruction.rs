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
    /// MOVT.
    MoveTop { d: Register, value: u16 },
    /// ADR: the word-aligned PC plus an offset.
    Address { d: Register, offset: i32 },

    /// MUL.
    Multiply {
        d: Register,
        n: Register,
        m: Register,
        flags: SetFlags,
    },
    /// MLA.
    MultiplyAdd {
        d: Register,
        n: Register,
        m: Register,
        a: Register,
    },
    /// MLS.
    MultiplySubtract {
        d: Register,
        n: Register,
        m: Register,
        a: Register,
    },
    /// SMULL, UMULL, SMLAL, UMLAL.
    MultiplyLong {
        signed: bool,
        accumulate: bool,
        low: Register,
        high: Register,
        n: Register,
        m: Register,
    },
    /// SDIV, UDIV.
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
    /// SBFX, UBFX.
    BitFieldExtract {
        signed: bool,
        d: Register,
        n: Register,
        lsb: u8,
        width: u8,
    },
    /// BFI.
    BitFieldInsert {
        d: Register,
        n: Register,
        lsb: u8,
        width: u8,
    },
    /// BFC.
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

    /// Load, `[Rn, #offset]`.
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
    /// Store, `[Rn, #offset]`.
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
    /// LDRD.
    LoadDual {
        t: Register,
        t2: Register,
        n: Register,
        index: Index,
        offset: i16,
    },
    /// STRD.
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
    /// STM, STMDB, PUSH.
    StoreMultiple {
        n: Register,
        kind: Multiple,
        write_back: bool,
        list: u16,
    },
    /// LDREX, LDREXB, LDREXH.
    LoadExclusive {
        size: Size,
        t: Register,
        n: Register,
        offset: u16,
    },
    /// STREX, STREXB, STREXH.
    StoreExclusive {
        size: Size,
        d: Register,
        t: Register,
        n: Register,
        offset: u16,
    },
    /// CLREX.
    ClearExclusive,

    /// B.
    Branch { offset: i32 },
    /// B with its own condition.
    BranchIf { condition: Condition, offset: i32 },
    /// BL.
    BranchLink { offset: i32 },
    /// BX.
    BranchExchange { m: Register },
    /// BLX.
    BranchLinkExchange { m: Register },
    /// MOV PC, Rm.
    MoveToPc { m: Register },
    /// ADD PC, Rm.
    AddToPc { m: Register },
    /// CBZ, CBNZ.
    CompareBranch { n: Register, zero: bool, offset: u8 },
    /// TBB, TBH.
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
    /// WFI.
    WaitForInterrupt,
    /// WFE.
    WaitForEvent,
    /// SEV.
    SendEvent,
    /// CPSIE and CPSID.
    ChangeState {
        disable: bool,
        primask: bool,
        faultmask: bool,
    },
    /// MRS.
    MoveFromSpecial { d: Register, special: u8 },
    /// MSR.
    MoveToSpecial { n: Register, special: u8 },
    /// SVC.
    SupervisorCall,
    /// BKPT.
    Breakpoint(u8),

    /// An instruction of the DSP extension.
    Dsp(Dsp),

    /// UNDEFINED by this rule.
    Undefined(Rule),
    /// UNPREDICTABLE by this rule.
    Unpredictable(Rule),
}

/// The permitted position of an instruction in an IT block.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ItRule {
    /// Any position.
    Anywhere,
    /// A branch: only as the last instruction.
    Last,
    /// Not permitted.
    Outside,
}

/// A decoded instruction.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Decoded {
    /// The instruction.
    pub instruction: Instruction,
    /// Its length in bytes, 2 or 4.
    pub length: u8,
    /// Its permitted position in an IT block.
    pub it: ItRule,
}
