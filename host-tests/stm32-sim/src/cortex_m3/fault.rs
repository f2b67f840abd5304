//! What stops a run for good.
//!
//! On the chip these escalate to HardFault, whose handler resets; a test is to see the reason instead. So every fault stops the
//! run, whatever the firmware enabled in SHCSR.

use super::decode::rule::Rule;
use crate::io::AccessError;
use thiserror::Error;

/// Why the processor cannot go on.
#[derive(Clone, PartialEq, Eq, Debug, Error)]
pub enum FaultKind {
    /// An UNDEFINED instruction.
    #[error("UNDEFINED: {0}")]
    Undefined(Rule),
    /// An UNPREDICTABLE instruction.
    #[error("UNPREDICTABLE: {0}")]
    Unpredictable(Rule),
    /// There is nothing to be read, written or executed at the address.
    #[error("nothing is mapped at {0:#010x}")]
    Unmapped(u32),
    /// The access must be aligned and is not.
    #[error("unaligned access to {0:#010x}")]
    Unaligned(u32),
    /// A peripheral refused.
    #[error("access to {0:#010x}: {1}")]
    Access(u32, AccessError),
    /// A register of the system control space cannot be accessed like that.
    #[error("access to the system register {0:#010x}: {1}")]
    System(u32, &'static str),
    /// A division by zero while CCR.DIV_0_TRP is set.
    #[error("division by zero")]
    DivisionByZero,
    /// A jump to an even address: there is no ARM state (INVSTATE).
    #[error("jump to the even address {0:#010x}")]
    InvalidState(u32),
    /// A return from an exception that does not fit the state (INVPC).
    #[error("exception return {0:#010x}: {1}")]
    InvalidReturn(u32, &'static str),
    /// A supervisor call that does not preempt: it escalates to HardFault.
    #[error("a supervisor call at a priority that is not below its own")]
    Escalation,
}

/// A fault, with the instruction that made it.
#[derive(Clone, PartialEq, Eq, Debug, Error)]
#[error("{kind}, at {pc:#010x}")]
pub struct Fault {
    /// What went wrong.
    pub kind: FaultKind,
    /// The address of the instruction.
    pub pc: u32,
    /// The address that was accessed, or the instruction's.
    pub address: u32,
}

impl FaultKind {
    /// The address of the access.
    pub fn address(&self) -> Option<u32> {
        match self {
            Self::Unmapped(address)
            | Self::Unaligned(address)
            | Self::Access(address, _)
            | Self::System(address, _)
            | Self::InvalidState(address) => Some(*address),
            _ => None,
        }
    }
}

/// Faults travel boxed, so that results stay small where speed counts.
pub type Result<T> = std::result::Result<T, Box<FaultKind>>;
