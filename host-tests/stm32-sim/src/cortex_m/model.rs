//! The two processors: what differs between the Cortex-M3 and the Cortex-M4.

use super::decode::instruction::{Decoded, Instruction};
use super::decode::rule::Rule;
use super::decode::{self, dsp};

/// The processor of a microcontroller.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Model {
    /// Cortex-M3 r1p1 of the STM32F103 (PM0056).
    CortexM3,
    /// Cortex-M4 r0p1 of the STM32F446 (PM0214), with the DSP extension. Its floating-point unit can be enabled, but its instructions are
    /// not modelled, because the images contain none: such an instruction stops the run. Therefore exceptions never stack the registers of
    /// the unit.
    CortexM4,
}

impl Model {
    /// CPUID of ST's microcontroller (PM0056 4.4.2, PM0214 4.4.2).
    pub fn cpuid(self) -> u32 {
        match self {
            Self::CortexM3 => 0x411F_C231,
            Self::CortexM4 => 0x410F_C241,
        }
    }

    /// The number of interrupts: STM32F103 without the connectivity line (RM0008 10.1.2), STM32F446 (RM0390, table 38).
    pub(super) fn interrupts(self) -> u16 {
        match self {
            Self::CortexM3 => 60,
            Self::CortexM4 => 97,
        }
    }

    /// APSR.GE in a program status; only the DSP extension has it.
    pub(super) fn greater_equal(self, status: u32) -> u8 {
        match self {
            Self::CortexM3 => 0,
            Self::CortexM4 => (status >> 16 & 0xF) as u8,
        }
    }

    /// The writable bits of CPACR, which enables the floating-point unit (PM0214 4.6.1); None if the processor does not have this register.
    pub(super) fn coprocessors(self) -> Option<u32> {
        match self {
            Self::CortexM3 => None,
            Self::CortexM4 => Some(0xF << 20),
        }
    }

    /// MPU_TYPE: the STM32F103 has no MPU; the MPU of the STM32F446 has eight regions (PM0214 4.2.5), which are not modelled.
    pub(super) fn protection(self) -> u32 {
        match self {
            Self::CortexM3 => 0,
            Self::CortexM4 => 8 << 8,
        }
    }

    /// Decodes the instruction that starts with this half-word; `second` is used only if it is wide.
    pub fn decode(self, first: u16, second: u16) -> Decoded {
        let decoded = decode::decode(first, second);
        match self {
            Self::CortexM3 => decoded,
            Self::CortexM4 => match decoded.instruction {
                Instruction::Undefined(Rule::DspExtension) => dsp::extend(decoded, first, second),
                Instruction::Undefined(Rule::NoCoprocessor) if is_floating_point(second) => {
                    Decoded {
                        instruction: Instruction::Undefined(Rule::FloatingPoint),
                        ..decoded
                    }
                }
                _ => decoded,
            },
        }
    }
}

/// Coprocessors 10 and 11 are the floating-point unit (ARM ARM A5.3.18).
const fn is_floating_point(second: u16) -> bool {
    second >> 9 & 0b111 == 0b101
}
