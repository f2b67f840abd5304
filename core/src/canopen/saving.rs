//! What goes to and comes from nonvolatile memory: all parameters, or some of them beside what is stored already.

use super::dictionary::communication;
use super::product::{ParametersOf, Product};
use super::protocol::{ContextOf, Services};
use super::sdo::Written;
use crate::param::{ParameterId, ParameterSet, Parameters};

/// What a save changes of what is stored.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum What {
    /// All parameters as they are.
    Everything,
    /// Those that are stored as soon as they are written.
    AtOnce,
    /// The communication profile, back to the factory values; in force after a reset.
    FactoryCommunication,
    /// All other parameters, back to the factory values.
    FactoryApplication,
}

/// What the nonvolatile memory holds.
pub(super) struct Saved<P: Product> {
    pub parameters: ParametersOf<P>,
    /// What the running save, or the last one, is about.
    what: What,
    /// The last restoration of the application's parameters has succeeded.
    pub restored: bool,
}

impl<P: Product> Saved<P> {
    /// Before the memory was read.
    pub const INITIAL: Self = Self {
        parameters: ParametersOf::<P>::INITIAL,
        what: What::Everything,
        restored: false,
    };
}

impl<P: Product> Services<P> {
    /// The parameters of the communication profile.
    const COMMUNICATION: ParameterSet = communication(P::OBJECTS);

    /// The stored parameters of the communication profile, or all others.
    fn stored(communication: bool) -> impl Iterator<Item = ParameterId> {
        ParametersOf::<P>::rules()
            .filter(move |(id, rule)| {
                rule.is_stored() && Self::COMMUNICATION.contains(*id) == communication
            })
            .map(|(id, _)| id)
    }

    /// Begins a save; the SDO reply comes when the memory holds it.
    pub(super) fn save(&mut self, cx: &mut ContextOf<P>, what: What) -> Written {
        let mut parameters = self.saved.parameters;
        let factory = Parameters::factory();
        match what {
            What::Everything => parameters = cx.parameters,
            What::AtOnce => parameters.copy(&cx.parameters, ParametersOf::<P>::stored_at_once()),
            What::FactoryCommunication => parameters.copy(&factory, Self::stored(true)),
            What::FactoryApplication => parameters.copy(&factory, Self::stored(false)),
        }
        self.saved.what = what;
        cx.save(parameters);
        Written::Storing
    }

    /// The memory has answered.
    pub(super) fn end_save(
        &mut self,
        cx: &mut ContextOf<P>,
        saved: &ParametersOf<P>,
        succeeded: bool,
    ) {
        if succeeded {
            self.saved.parameters = *saved;
        }
        match self.saved.what {
            What::Everything | What::FactoryCommunication => {}
            What::AtOnce => {
                // What could not be stored is not in force either.
                let at_once = ParametersOf::<P>::stored_at_once();
                cx.parameters.copy(&self.saved.parameters, at_once);
            }
            What::FactoryApplication => {
                if succeeded {
                    cx.parameters
                        .copy(&Parameters::factory(), Self::stored(false));
                }
                self.saved.restored = succeeded;
            }
        }
        cx.apply();
        let fault = if succeeded { 0 } else { Self::MEMORY };
        self.emergency.update(Self::MEMORY, fault);
    }
}
