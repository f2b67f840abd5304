//! What instructions work on and how: registers, sizes, shifts, conditions.

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

    /// The register with this number; only the low four bits count.
    pub const fn new(number: u32) -> Self {
        Self((number & 15) as u8)
    }

    /// Its number, 0 to 15.
    #[inline(always)]
    pub const fn index(self) -> usize {
        (self.0 & 15) as usize
    }

    /// Many encodings take neither SP nor PC.
    pub fn is_sp_or_pc(self) -> bool {
        self == Self::SP || self == Self::PC
    }
}

/// Whether a data-processing instruction writes the flags.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SetFlags {
    /// It does not.
    No,
    /// It does.
    Yes,
    /// Most 16-bit instructions: unless they are in an IT block.
    OutsideIt,
}

impl SetFlags {
    /// From the S bit of a 32-bit encoding.
    pub fn from_bit(set: bool) -> Self {
        if set { Self::Yes } else { Self::No }
    }
}

/// What a data-processing instruction computes from its first and second operand.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum DataOp {
    /// Both.
    And,
    /// The first without the bits of the second.
    Bic,
    /// Either.
    Orr,
    /// The first, or not the second.
    Orn,
    /// Exclusive or.
    Eor,
    /// The second operand.
    Mov,
    /// Not the second operand.
    Mvn,
    /// Sum.
    Add,
    /// Sum with carry.
    Adc,
    /// Difference with borrow.
    Sbc,
    /// Difference.
    Sub,
    /// The second minus the first.
    Rsb,
}

/// The kinds of shift.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Shift {
    /// Logical shift left.
    Lsl,
    /// Logical shift right.
    Lsr,
    /// Arithmetic shift right.
    Asr,
    /// Rotate right.
    Ror,
    /// Rotate right by one through the carry.
    Rrx,
}

/// The carry that an immediate operand yields.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Carry {
    /// It stays.
    Keep,
    /// 0.
    Clear,
    /// 1.
    Set,
}

/// What SXTB and its kin extend.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Extend {
    /// A signed byte.
    SignedByte,
    /// A signed half-word.
    SignedHalfWord,
    /// An unsigned byte.
    Byte,
    /// An unsigned half-word.
    HalfWord,
}

/// Instructions that rearrange the bits of one register.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Rearrange {
    /// REV.
    ReverseBytes,
    /// REV16.
    ReverseBytesOfHalfWords,
    /// REVSH.
    ReverseSignedHalfWord,
    /// RBIT.
    ReverseBits,
    /// CLZ.
    CountLeadingZeros,
}

/// What a load or store transfers.
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
    /// 32 bits.
    Word,
}

/// How a load or store writes its base register back.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Index {
    /// `[Rn, #offset]`: it does not.
    Offset,
    /// `[Rn, #offset]!`: the address goes to the base.
    Pre,
    /// `[Rn], #offset`: the access is at the base, and the offset is added afterwards.
    Post,
}

/// The order of LDM and STM.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Multiple {
    /// From the base upwards.
    IncrementAfter,
    /// Ends below the base.
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
    /// From its code. 1111 means "always" wherever it is allowed at all.
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
