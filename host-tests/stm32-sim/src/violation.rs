//! Programming errors of the firmware: what a reference manual forbids, and what the hardware would do about it in silence.

use std::fmt;

/// What the firmware did and must not do.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Violation {
    /// The processor cycle of the access.
    pub cycle: u64,
    /// The register, as the manual names it, e.g. `FLASH_CR`.
    pub register: String,
    /// What is wrong.
    pub reason: &'static str,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            cycle,
            register,
            reason,
        } = self;
        write!(f, "cycle {cycle}: {register}: {reason}")
    }
}

/// Collects violations.
#[derive(Debug, Default)]
pub struct Violations {
    cycle: u64,
    list: Vec<Violation>,
}

impl Violations {
    /// How many are kept: a firmware that does one thing wrong mostly does it again and again.
    const MOST: usize = 1000;

    /// Sets the cycle of what is added from now on.
    pub fn at(&mut self, cycle: u64) -> &mut Self {
        self.cycle = cycle;
        self
    }

    /// Adds one.
    pub fn add(&mut self, register: impl Into<String>, reason: &'static str) {
        if self.list.len() < Self::MOST {
            self.list.push(Violation {
                cycle: self.cycle,
                register: register.into(),
                reason,
            });
        }
    }

    /// Adds one when `wrong`.
    pub fn check(&mut self, wrong: bool, register: &'static str, reason: &'static str) {
        if wrong {
            self.add(register, reason);
        }
    }

    /// All so far, the oldest first; at most 1000.
    pub fn list(&self) -> &[Violation] {
        &self.list
    }
}
