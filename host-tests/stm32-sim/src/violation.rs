//! Programming errors of the firmware: accesses that a reference manual forbids. The hardware often reports no error.

use std::fmt;

/// Something that the program did and the manual does not permit.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Violation {
    /// The processor cycle of the access.
    pub cycle: u64,
    /// The register by its name in the manual, e.g. `FLASH_CR`.
    pub register: String,
    /// What is not permitted, as text.
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

/// The violations of a program, of which the first thousand are kept.
#[derive(Debug, Default)]
pub struct Violations {
    cycle: u64,
    list: Vec<Violation>,
}

impl Violations {
    /// The number of violations kept: a firmware often repeats the same one.
    const MOST: usize = 1000;

    /// Sets the cycle of the violations added from now on.
    pub fn at(&mut self, cycle: u64) -> &mut Self {
        self.cycle = cycle;
        self
    }

    /// Adds a violation at the present cycle.
    pub fn add(&mut self, register: impl Into<String>, reason: &'static str) {
        if self.list.len() < Self::MOST {
            self.list.push(Violation {
                cycle: self.cycle,
                register: register.into(),
                reason,
            });
        }
    }

    /// Adds a violation if `wrong`.
    pub fn check(&mut self, wrong: bool, register: &'static str, reason: &'static str) {
        if wrong {
            self.add(register, reason);
        }
    }

    /// Adds a violation if `wrong`. `place` builds the name of the place, and is called only then.
    pub fn check_at(&mut self, wrong: bool, place: impl FnOnce() -> String, reason: &'static str) {
        if wrong {
            self.add(place(), reason);
        }
    }

    /// All violations, oldest first; at most 1000.
    pub fn list(&self) -> &[Violation] {
        &self.list
    }
}
