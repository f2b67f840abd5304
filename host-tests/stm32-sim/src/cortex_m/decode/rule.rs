//! The rules of the architecture that make an encoding UNDEFINED or UNPREDICTABLE.
//!
//! "ARM ARM" is the ARMv7-M Architecture Reference Manual, DDI 0403E.

use std::fmt;

/// The reason why an instruction must not be executed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Rule {
    /// UNDEFINED: unallocated.
    Unallocated,
    /// UNDEFINED: permanently UNDEFINED by the architecture.
    PermanentlyUndefined,
    /// UNDEFINED: the DSP extension is not implemented.
    DspExtension,
    /// UNDEFINED: Advanced SIMD in other profiles.
    AdvancedSimd,
    /// UNDEFINED: there is no coprocessor.
    NoCoprocessor,
    /// A floating-point instruction of the Cortex-M4: it is not modelled.
    FloatingPoint,
    /// UNDEFINED: a store relative to PC.
    StoreToPc,
    /// UNPREDICTABLE: a bit in parentheses.
    ShouldBe,
    /// UNPREDICTABLE: SP or PC is not permitted.
    StackPointerOrPc,
    /// UNPREDICTABLE: two registers that must differ.
    SameRegister,
    /// UNPREDICTABLE: write-back of a base that is also transferred.
    WriteBackOfTransferred,
    /// UNPREDICTABLE: too few registers in the list.
    ShortList,
    /// UNPREDICTABLE: both PC and LR are loaded.
    PcAndLr,
    /// UNPREDICTABLE: both registers are low in an encoding for high ones.
    BothLow,
    /// UNPREDICTABLE: a modified immediate that repeats zero.
    RepeatedZero,
    /// UNPREDICTABLE: a bit field outside the register.
    BitField,
    /// UNPREDICTABLE: the copies of Rm differ.
    InconsistentRegister,
    /// UNPREDICTABLE: a shift that is not permitted for a change of SP.
    StackShift,
    /// UNPREDICTABLE: an IT with an invalid condition.
    ItCondition,
    /// UNPREDICTABLE: not permitted in an IT block.
    InItBlock,
    /// UNPREDICTABLE: in an IT block, and not the last instruction.
    NotLastInItBlock,
    /// UNPREDICTABLE: CPS that changes nothing.
    ChangesNothing,
    /// UNPREDICTABLE: unknown special register.
    SpecialRegister,
    /// UNPREDICTABLE: MSR with a mask that this register does not have.
    SpecialMask,
}

impl Rule {
    /// The rule and its place in the ARM ARM.
    const fn text(self) -> &'static str {
        match self {
            Self::Unallocated => "the encoding is unallocated (A5.1.1)",
            Self::PermanentlyUndefined => "UDF (A7.7.194)",
            Self::DspExtension => "an instruction of the DSP extension (A5.1.1, A1.3)",
            Self::AdvancedSimd => {
                "an instruction of Advanced SIMD, which is not in this profile (A5.3)"
            }
            Self::NoCoprocessor => "an instruction for a coprocessor (A5.3.18, B1.5.14 NOCP)",
            Self::FloatingPoint => "a floating-point instruction, which is not modelled (A5.3.18)",
            Self::StoreToPc => "a store with Rn = PC (A5.3.10, A7.7.161)",
            Self::ShouldBe => "a bit in parentheses has the other value (A5.1.2)",
            Self::StackPointerOrPc => "a register is SP or PC (A5.1.2, A5.1.3)",
            Self::SameRegister => {
                "two registers that must differ are equal (A7.7: LDRD, STREX, SMULL)"
            }
            Self::WriteBackOfTransferred => {
                "the base is written back and transferred (A7.7: LDR, LDM, STM)"
            }
            Self::ShortList => "the list has too few registers (A7.7: LDM, STM, PUSH, POP)",
            Self::PcAndLr => "the list has both PC and LR (A7.7.41)",
            Self::BothLow => "both registers are low (A7.7.28, CMP T2)",
            Self::RepeatedZero => "a modified immediate that repeats zero (A5.3.2)",
            Self::BitField => {
                "the bit field ends outside the register or before its start (A7.7: BFI, SBFX)"
            }
            Self::InconsistentRegister => "Rm is encoded twice and differs (A7.7: CLZ, RBIT, REV)",
            Self::StackShift => {
                "SP changes by a register with a shift other than LSL 0 to 3 (A7.7.6, A7.7.176)"
            }
            Self::ItCondition => "IT with the condition 1111, or 1110 with an else (A7.7.38)",
            Self::InItBlock => "in an IT block (A7.3.2)",
            Self::NotLastInItBlock => "a branch in an IT block, not at its end (A7.3.2)",
            Self::ChangesNothing => "CPS with neither I nor F (B5.2.1)",
            Self::SpecialRegister => "unknown special register (B5.2.2, B5.2.3)",
            Self::SpecialMask => "MSR with a mask that this register does not have (B5.2.3)",
        }
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.text())
    }
}
