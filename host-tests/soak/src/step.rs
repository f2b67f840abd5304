//! The steps: what can happen, and how often.

use crate::random::Random;
use std::fmt::{self, Display, Formatter};

/// What happens in a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Step {
    /// A master reads a setting.
    Read,
    /// A master writes a setting.
    Write,
    /// A master lets the sensor save.
    Save,
    /// A master restarts the sensor.
    Restart,
    /// A master loads the factory settings.
    Load,
    /// The sensor is switched off and on.
    PowerCycle,
    /// The supply fails in a save.
    PowerCut,
    /// The program is replaced over the bus, most times with a power cut.
    Update,
    /// The memory cannot be programmed or erased during a save.
    BadMemory,
    /// The bus is disturbed.
    BusFault,
    /// Other nodes send.
    Strangers,
    /// The sensor is moved.
    Move,
    /// The angles are measured at rest with the factory settings.
    Measure,
    /// The other master goes on.
    ChangeMaster,
    /// Some time passes.
    Wait,
}

/// How often each step happens, of 100.
const WEIGHTS: [(Step, u32); 15] = [
    (Step::Read, 17),
    (Step::Write, 30),
    (Step::Save, 8),
    (Step::Restart, 4),
    (Step::Load, 2),
    (Step::PowerCycle, 5),
    (Step::PowerCut, 6),
    (Step::Update, 3),
    (Step::BadMemory, 2),
    (Step::BusFault, 5),
    (Step::Strangers, 5),
    (Step::Move, 4),
    (Step::Measure, 1),
    (Step::ChangeMaster, 3),
    (Step::Wait, 5),
];

impl Step {
    /// A step at random, each as often as its weight says.
    pub fn any(random: &mut Random) -> Self {
        let mut left = random.below(WEIGHTS.iter().map(|(_, weight)| weight).sum());
        let mut all = WEIGHTS.iter();
        let chosen = all.find(|(_, weight)| {
            let is_chosen = left < *weight;
            left = left.saturating_sub(*weight);
            is_chosen
        });
        chosen.map_or(Self::Wait, |(step, _)| *step)
    }
}

/// How often each step happened.
#[derive(Clone, Debug, Default)]
pub struct Counts([u64; WEIGHTS.len()]);

impl Counts {
    /// A step has happened.
    pub fn add(&mut self, step: Step) {
        if let Some(at) = WEIGHTS.iter().position(|(own, _)| *own == step) {
            self.0[at] += 1;
        }
    }

    /// How often a step happened.
    pub fn of(&self, step: Step) -> u64 {
        let at = WEIGHTS.iter().position(|(own, _)| *own == step);
        at.map_or(0, |at| self.0[at])
    }
}

impl Display for Counts {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let each = WEIGHTS.iter().zip(self.0);
        let texts: Vec<String> = each
            .map(|((step, _), count)| format!("{step:?} {count}"))
            .collect();
        f.write_str(&texts.join(", "))
    }
}
