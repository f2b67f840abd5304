//! What goes to and comes from nonvolatile memory: all values, or some of them beside what is stored already.

use super::abort::Abort;
use super::device::Device;
use super::dictionary::Rule;
use super::emcy;
use super::model::Model;
use super::sdo::{Stage, Written};
use super::values::Values;
use crate::measure::Calibration;
use crate::measure::calibration;
use crate::store::{Payload, StoreError};
use crate::time::Instant;

/// What a save changes of what is stored.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum What {
    /// All values as they are.
    Everything,
    /// Those that the model stores at once.
    AtOnce,
    /// The communication profile, back to the factory values; in force after a reset.
    FactoryCommunication,
    /// The model's own values, back to the factory values.
    FactoryOwn,
}

/// A save under way.
#[derive(Clone, Debug)]
pub(super) struct Saving {
    what: What,
    /// What will be stored.
    values: Values,
}

/// The slots of the stored values of the communication profile, or of the model.
fn stored(rules: &'static [Rule], communication: bool) -> impl Iterator<Item = u8> {
    rules
        .iter()
        .filter(move |rule| rule.is_stored() && rule.is_communication() == communication)
        .filter_map(|rule| rule.home.slot())
}

impl<M: Model> Device<M> {
    /// Begins a save; the SDO reply comes when the memory holds it.
    pub(super) fn begin_save(&mut self, what: What) -> Written {
        let mut values = self.saved;
        match what {
            What::Everything => values = self.values,
            What::AtOnce => values.copy(&self.values, M::AT_ONCE),
            What::FactoryCommunication => values.copy(M::FACTORY, stored(M::RULES, true)),
            What::FactoryOwn => values.copy(M::FACTORY, own::<M>()),
        }
        self.saving = Some(Saving { what, values });
        self.wanted.save = true;
        Written::Storing
    }

    /// The memory has answered.
    pub(super) fn end_save(&mut self, now: Instant, result: Result<(), StoreError>) {
        let Some(saving) = self.saving.take() else {
            return;
        };
        let succeeded = result.is_ok();
        if succeeded {
            self.saved = saving.values;
        }
        match saving.what {
            What::Everything | What::FactoryCommunication => {}
            What::AtOnce => {
                // What could not be stored is not in force either.
                let saved = self.saved;
                self.values.copy(&saved, M::AT_ONCE);
            }
            What::FactoryOwn => {
                if succeeded {
                    self.values.copy(M::FACTORY, own::<M>());
                }
                self.values.set(M::FACTORY_RESET, succeeded.into());
            }
        }
        self.model.configure(&self.values);
        let fault = if succeeded { 0 } else { emcy::HARDWARE };
        self.emergency.update(emcy::HARDWARE, fault);
        if matches!(self.transfer.stage, Stage::Storing) {
            if succeeded {
                let reply = self.transfer.reply;
                self.transfer.end();
                self.send_sdo(&reply);
            } else {
                self.abort_transfer(Abort::Hardware);
            }
        }
        if let Some(frame) = self.deferred.take() {
            self.dispatch(now, &frame);
        }
    }

    /// The payload of the image that the running save wants.
    pub(super) fn payload(&self) -> Payload {
        let values = self
            .saving
            .as_ref()
            .map_or(&self.saved, |saving| &saving.values);
        let mut payload = Payload::new();
        values.encode(M::RULES, M::HIDDEN, &mut payload);
        // PAYLOAD bytes, and PAYLOAD_MAX is not less: see the assertion there.
        let _ = payload.extend_from_slice(&self.model.calibration().encode());
        payload
    }

    /// The values and the calibration in an image; None unless all of it makes sense.
    pub(super) fn decode(payload: &[u8]) -> Option<(Values, Calibration)> {
        let size = payload.len().checked_sub(calibration::SIZE)?;
        let (values, calibration) = payload.split_at_checked(size)?;
        let calibration = Calibration::decode(calibration.try_into().ok()?)?;
        let values = M::FACTORY.decode(M::RULES, M::HIDDEN, values)?;
        M::is_whole(&values).then_some((values, calibration))
    }
}

/// The slots of all stored values of a model.
fn own<M: Model>() -> impl Iterator<Item = u8> {
    stored(M::RULES, false).chain(M::HIDDEN)
}
