//! Faults. A fault ends the run, so that a test can report the reason. The caller can continue with the handler of the program, as
//! the chip does: [`CortexM3::take_fault`](super::CortexM3::take_fault).

use super::decode::rule::Rule;
use crate::io::AccessError;
use thiserror::Error;

/// The reason why the processor cannot continue.
#[derive(Clone, PartialEq, Eq, Debug, Error)]
pub enum FaultKind {
    /// An instruction that the architecture does not define.
    #[error("UNDEFINED: {0}")]
    Undefined(Rule),
    /// An instruction whose effect the architecture does not define.
    #[error("UNPREDICTABLE: {0}")]
    Unpredictable(Rule),
    /// There is no memory or peripheral at the address.
    #[error("nothing is mapped at {0:#010x}")]
    Unmapped(u32),
    /// There is no RAM for the frame of an exception at the address.
    #[error("no RAM for an exception frame at {0:#010x}")]
    Stacking(u32),
    /// The access must be aligned but is not.
    #[error("unaligned access to {0:#010x}")]
    Unaligned(u32),
    /// A peripheral refused the access.
    #[error("access to {0:#010x}: {1}")]
    Access(u32, AccessError),
    /// The system control space does not support such an access.
    #[error("access to the system register {0:#010x}: {1}")]
    System(u32, &'static str),
    /// A division by zero while CCR.DIV_0_TRP is set.
    #[error("division by zero")]
    DivisionByZero,
    /// The MPU has no region for the instruction.
    #[error("no region of the MPU for the instruction at {0:#010x}")]
    Protected(u32),
    /// A jump to an even address: there is no ARM state (INVSTATE).
    #[error("jump to the even address {0:#010x}")]
    InvalidState(u32),
    /// A return from an exception that does not fit the state (INVPC).
    #[error("exception return {0:#010x}: {1}")]
    InvalidReturn(u32, &'static str),
    /// A supervisor call that does not preempt: it escalates to HardFault.
    #[error("a supervisor call without sufficient priority to preempt")]
    Escalation,
}

/// A fault with the instruction that caused it.
#[derive(Clone, PartialEq, Eq, Debug, Error)]
#[error("{kind}, at {pc:#010x}")]
pub struct Fault {
    /// Why the program cannot continue.
    pub kind: FaultKind,
    /// The address of the instruction.
    pub pc: u32,
    /// The accessed address, or that of the instruction.
    pub address: u32,
}

impl FaultKind {
    /// The address of the access.
    pub fn address(&self) -> Option<u32> {
        match self {
            Self::Unmapped(address)
            | Self::Stacking(address)
            | Self::Unaligned(address)
            | Self::Access(address, _)
            | Self::System(address, _)
            | Self::InvalidState(address) => Some(*address),
            _ => None,
        }
    }
}

/// Faults are boxed to keep results small, for speed.
pub type Result<T> = std::result::Result<T, Box<FaultKind>>;
