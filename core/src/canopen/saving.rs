//! Stored parameters: saves all parameters, or some of them together with the values that are already stored.

use super::dictionary::communication;
use super::groups::Start;
use super::product::{ParametersOf, Product};
use super::protocol::{ContextOf, Services};
use super::sdo::Written;
use crate::param::{ParameterId, ParameterSet, Parameters};

/// The stored parameters that a save changes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum What {
    /// All parameters get their present values.
    Everything,
    /// The parameters that are stored when they are written.
    AtOnce,
    /// The parameters of the communication profile get their factory values, which act after a reset.
    FactoryCommunication,
    /// All other parameters get their factory values.
    FactoryApplication,
}

/// The contents of the nonvolatile memory.
pub(super) struct Saved<P: Product> {
    pub parameters: ParametersOf<P>,
    /// The kind of the running save, or of the last one.
    what: What,
    /// The last restore of the parameters of the application has succeeded.
    pub restored: bool,
    /// The restart and the request of a restore, for a product with groups.
    pub(super) start: Start,
}

impl<P: Product> Saved<P> {
    /// Whether the running save, or the last one, restores the factory values of the application.
    pub fn is_factory_reset(&self) -> bool {
        self.what == What::FactoryApplication
    }

    /// The state before the memory is read.
    pub const INITIAL: Self = Self {
        parameters: ParametersOf::<P>::INITIAL,
        what: What::Everything,
        restored: false,
        start: Start::INITIAL,
    };
}

impl<P: Product> Services<P> {
    /// The parameters of the communication profile.
    const COMMUNICATION: ParameterSet = communication(P::OBJECTS);

    /// The persistent parameters of the communication profile, or all other persistent parameters.
    pub(super) fn stored(communication: bool) -> impl Iterator<Item = ParameterId> {
        ParametersOf::<P>::rows()
            .filter(move |(id, row)| {
                row.is_stored() && Self::COMMUNICATION.contains(*id) == communication
            })
            .map(|(id, _)| id)
    }

    /// Begins a save, while no other save is running. The SDO reply is sent after the save has ended. Parameters that are stored
    /// when they are written are not saved again without a change.
    pub(super) fn save(&mut self, cx: &mut ContextOf<P>, what: What) -> Written {
        let mut parameters = self.saved.parameters;
        let factory = Parameters::factory();
        match what {
            What::Everything => parameters = cx.parameters,
            What::AtOnce => {
                parameters.copy(&cx.parameters, ParametersOf::<P>::stored_at_once());
                if parameters == self.saved.parameters {
                    return Written::Done;
                }
            }
            What::FactoryCommunication => parameters.copy(&factory, Self::stored(true)),
            What::FactoryApplication => parameters.copy(&factory, Self::stored(false)),
        }
        self.saved.what = what;
        cx.save(parameters);
        Written::Storing
    }

    /// Begins a save of the node-ID and the bit rate, while no other save is running. The other stored parameters keep their values.
    pub(super) fn save_configuration(&mut self, cx: &mut ContextOf<P>) {
        let mut parameters = self.saved.parameters;
        parameters.copy(&cx.parameters, [P::NODE_ID, P::BIT_RATE]);
        self.save_these(cx, parameters);
    }

    /// Begins a save of these parameters, while no other save is running.
    pub(super) fn save_these(&mut self, cx: &mut ContextOf<P>, parameters: ParametersOf<P>) {
        // As after a save of all parameters, its end changes no parameter in RAM.
        self.saved.what = What::Everything;
        cx.save(parameters);
    }

    /// Ends a save.
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
                // If the save has failed, the previous values are in force again.
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
        self.use_up_request(cx);
    }
}
