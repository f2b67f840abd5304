//! Violations of the reference manual's rules by the firmware.

use can_wire::protocol::Picoseconds;
use std::fmt;

/// Something that the program did and the reference manual does not permit.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Violation {
    /// The time of the access.
    pub at: Picoseconds,
    /// The name of the register in the reference manual.
    pub register: &'static str,
    /// What is not permitted, as text.
    pub reason: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            at,
            register,
            reason,
        } = self;
        write!(f, "{} us: {register}: {reason}", at / 1_000_000)
    }
}

/// The first thousand violations, oldest first.
#[derive(Debug, Default)]
pub(super) struct Violations {
    /// The time of the current access.
    pub(super) now: Picoseconds,
    pub(super) all: Vec<Violation>,
}

impl Violations {
    /// The number of violations kept: a firmware often repeats the same one.
    const MOST: usize = 1000;

    pub(super) fn record(&mut self, register: &'static str, reason: impl Into<String>) {
        if self.all.len() == Self::MOST {
            return;
        }
        self.all.push(Violation {
            at: self.now,
            register,
            reason: reason.into(),
        });
    }
}
