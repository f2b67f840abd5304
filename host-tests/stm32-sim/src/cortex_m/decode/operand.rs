//! The operands of instructions: registers, sizes, shifts, conditions.

/// A core register, R0 to R15.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Register(u8);

impl Register {
    /// The stack pointer, R13.
    pub const SP: Self = Self(13);
    /// The link register, R14.
    pub const LR: Self = Self(14);
    /// The program counter, R15.
    pub const PC: Self = Self(15);

    /// The register with this number; only the low four bits are used.
    pub const fn new(number: u32) -> Self {
        Self((number & 15) as u8)
    }

    /// Its number, 0 to 15.
    #[inline(always)]
    pub const fn index(self) -> usize {
        (self.0 & 15) as usize
    }

    /// True for SP and PC, which many encodings do not permit.
    pub fn is_sp_or_pc(self) -> bool {
        self == Self::SP || self == Self::PC
    }
}

/// Whether a data-processing instruction writes the flags.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SetFlags {
    /// The flags stay as they are.
    No,
    /// The flags are written.
    Yes,
    /// Most 16-bit instructions: only outside an IT block.
    OutsideIt,
}

impl SetFlags {
    /// From the S bit of a 32-bit encoding.
    pub fn from_bit(set: bool) -> Self {
        if set { Self::Yes } else { Self::No }
    }
}

/// The operation of a data-processing instruction on its first and second operand.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum DataOp {
    /// The bitwise and of both.
    And,
    /// The first without the bits of the second.
    Bic,
    /// The bitwise or of both.
    Orr,
    /// The first, or the complement of the second.
    Orn,
    /// The exclusive or of both.
    Eor,
    /// The second operand, unchanged.
    Mov,
    /// The complement of the second operand.
    Mvn,
    /// The sum of both.
    Add,
    /// The sum of both and the carry.
    Adc,
    /// The first minus the second, with borrow.
    Sbc,
    /// The first minus the second.
    Sub,
    /// The second minus the first.
    Rsb,
}

/// How a register operand is shifted.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Shift {
    /// LSL: logical shift left.
    Lsl,
    /// LSR: logical shift right.
    Lsr,
    /// ASR: arithmetic shift right.
    Asr,
    /// ROR: rotate to the right.
    Ror,
    /// Rotate right by one through the carry.
    Rrx,
}

/// The carry of an immediate operand.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Carry {
    /// The carry stays as it is.
    Keep,
    /// The carry becomes 0.
    Clear,
    /// The carry becomes 1.
    Set,
}

/// The operand of SXTB and similar instructions.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Extend {
    /// SXTB: the lowest byte, sign-extended.
    SignedByte,
    /// SXTH: the lowest half-word, sign-extended.
    SignedHalfWord,
    /// UXTB: the lowest byte, zero-extended.
    Byte,
    /// UXTH: the lowest half-word, zero-extended.
    HalfWord,
}

/// Instructions that rearrange the bits of one register.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Rearrange {
    /// REV: the bytes in the opposite order.
    ReverseBytes,
    /// REV16: the bytes of each half-word in the opposite order.
    ReverseBytesOfHalfWords,
    /// REVSH: the two lowest bytes in the opposite order, sign-extended.
    ReverseSignedHalfWord,
    /// RBIT: the bits in the opposite order.
    ReverseBits,
    /// CLZ: the number of leading zeros.
    CountLeadingZeros,
}

/// The size of a load or store.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Size {
    /// 8 bits, zero-extended.
    Byte,
    /// 8 bits, sign-extended.
    SignedByte,
    /// 16 bits, zero-extended.
    HalfWord,
    /// 16 bits, sign-extended.
    SignedHalfWord,
    /// 32 bits: the whole register.
    Word,
}

/// The base register update of a load or store.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Index {
    /// `[Rn, #offset]`: the base is not written back.
    Offset,
    /// `[Rn, #offset]!`: the address is written to the base.
    Pre,
    /// `[Rn], #offset`: the access uses the base, then the offset is added to it.
    Post,
}

/// The order of LDM and STM.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Multiple {
    /// Upwards from the base.
    IncrementAfter,
    /// Ends just below the base.
    DecrementBefore,
}

/// The conditions, in the order of their codes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
#[expect(missing_docs, reason = "the names are those of the manual, A7.3")]
pub enum Condition {
    Eq,
    Ne,
    Cs,
    Cc,
    Mi,
    Pl,
    Vs,
    Vc,
    Hi,
    Ls,
    Ge,
    Lt,
    Gt,
    Le,
    Always,
}

impl Condition {
    /// The condition of a code. 1111 means "always" wherever it is permitted.
    #[inline]
    pub const fn from_code(code: u32) -> Self {
        match code & 15 {
            0 => Self::Eq,
            1 => Self::Ne,
            2 => Self::Cs,
            3 => Self::Cc,
            4 => Self::Mi,
            5 => Self::Pl,
            6 => Self::Vs,
            7 => Self::Vc,
            8 => Self::Hi,
            9 => Self::Ls,
            10 => Self::Ge,
            11 => Self::Lt,
            12 => Self::Gt,
            13 => Self::Le,
            _ => Self::Always,
        }
    }
}
