//! What firmware did against the reference manual's rules.

use can_wire::protocol::Picoseconds;
use std::fmt;

/// A programming error.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Violation {
    /// When.
    pub at: Picoseconds,
    /// The register, by the reference manual's name.
    pub register: &'static str,
    /// What is wrong.
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

/// The first thousand of them, oldest first.
#[derive(Debug, Default)]
pub(super) struct Violations {
    /// The time of the access that is being carried out.
    pub(super) now: Picoseconds,
    pub(super) all: Vec<Violation>,
}

impl Violations {
    /// How many are kept: a firmware that does one thing wrong mostly does it again and again.
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
