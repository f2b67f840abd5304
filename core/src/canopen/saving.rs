//! Stored parameters: saves all parameters, or some of them together with the values that are already stored.

use super::dictionary::communication;
use super::product::{ContextOf, ParametersOf, Product};
use super::protocol::Services;
use super::saved::End;
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
        self.saved.end = End::Nothing;
        match what {
            What::Everything => parameters = cx.parameters,
            What::AtOnce => {
                parameters.copy(&cx.parameters, ParametersOf::<P>::stored_at_once());
                if parameters == self.saved.parameters {
                    return Written::Done;
                }
                self.saved.end = End::AtOnce;
            }
            What::FactoryCommunication => parameters.copy(&factory, Self::stored(true)),
        }
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
        self.saved.end = End::Nothing;
        cx.save(parameters);
    }

    pub(super) fn end_save(
        &mut self,
        cx: &mut ContextOf<P>,
        saved: &ParametersOf<P>,
        succeeded: bool,
    ) {
        if succeeded {
            self.saved.parameters = *saved;
        }
        match self.saved.end {
            End::Nothing => {}
            End::AtOnce => {
                // If the save has failed, the previous values are in force again.
                let at_once = ParametersOf::<P>::stored_at_once();
                cx.parameters.copy(&self.saved.parameters, at_once);
            }
            End::Own(place) => self.finish_own(cx, place, succeeded),
        }
        cx.apply();
        let fault = if succeeded { 0 } else { Self::MEMORY };
        self.emergency.update(Self::MEMORY, fault);
        self.settle(cx);
    }

    /// Lets the product begin a save, unless one is running: after a start, after each reset and after each save.
    pub(super) fn settle(&mut self, cx: &mut ContextOf<P>) {
        if !cx.is_saving() {
            self.saved.end = End::Nothing;
            P::settled(&mut self.scope(cx));
        }
    }
}
