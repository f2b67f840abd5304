//! Groups of stored parameters (1010h, 1011h with several sub-indices), the restore at the next start, and the stored history.
//!
//! A request of a restore (1011h) is stored. The first start after it takes the factory values of its group and uses the request up;
//! the stored values do not change. Hidden parameters of the stored set hold the request and the history, and are 0 in RAM:
//!
//! ```text
//!  request  bit 0  parameters of the communication profile, and the history
//!           bit 1  all other parameters, except node-ID and bit rate
//!           bit 2  node-ID and bit rate
//! ```

use super::Abort;
use super::dictionary::Service;
use super::emcy::History;
use super::product::{Kept, ParametersOf, Product};
use super::protocol::{ContextOf, Services};
use super::saved::{LOAD, SAVE};
use super::sdo::Written;
use crate::param::{ParameterId, Parameters};

/// Request: the parameters of the communication profile, and the history.
const COMMUNICATION: u8 = 1 << 0;
/// Request: all other parameters, except node-ID and bit rate.
const APPLICATION: u8 = 1 << 1;
/// Request: node-ID and bit rate.
const CONNECTION: u8 = 1 << 2;

impl<P: Product> Services<P> {
    /// Writes a service of a product with groups; None if `service` is another one.
    pub(super) fn write_group(
        &mut self,
        cx: &mut ContextOf<P>,
        service: Service,
        sub: u8,
        number: u32,
    ) -> Option<Result<Written, Abort>> {
        let kept = P::KEPT?;
        Some(match (service, number) {
            (Service::StoreGroup | Service::RestoreGroup, _) if cx.is_saving() => {
                Err(Abort::DeviceState)
            }
            (Service::StoreGroup, SAVE) => Ok(self.save_group(cx, kept, sub)),
            (Service::RestoreGroup, LOAD) => Ok(self.request_restore(cx, kept, sub)),
            _ => return None,
        })
    }

    /// Stores a group of parameters (1010h).
    fn save_group(&mut self, cx: &mut ContextOf<P>, kept: Kept, group: u8) -> Written {
        let mut parameters = self.saved.parameters;
        match group {
            1 => {
                let request = parameters.get(kept.request);
                parameters = cx.parameters;
                parameters.set(kept.request, request);
            }
            2 => parameters.copy(&cx.parameters, Self::stored(true)),
            4 => {
                let hidden = |id: &ParameterId| *id == kept.request || is_error::<P>(kept, *id);
                let others = Self::stored(false).filter(|id| !hidden(id));
                parameters.copy(&cx.parameters, others);
            }
            // The device profile has no parameters.
            _ => return Written::Done,
        }
        // The history is part of the communication profile.
        if group != 4 {
            for (sub, id) in (1..).zip(errors::<P>(kept)) {
                parameters.set(id, self.emergency.entry(sub) & 0xFFFF);
            }
        }
        self.save_these(cx, parameters);
        Written::Storing
    }

    /// Requests the factory values of a group of parameters for the next start (1011h).
    fn request_restore(&mut self, cx: &mut ContextOf<P>, kept: Kept, group: u8) -> Written {
        let wanted = match group {
            1 => COMMUNICATION | APPLICATION,
            2 => COMMUNICATION,
            4 => APPLICATION | CONNECTION,
            5 => COMMUNICATION | APPLICATION | CONNECTION,
            _ => return Written::Done,
        };
        let request = self.saved.parameters.get(kept.request) as u8 | wanted;
        // A new request for a part that was used during a running save stays.
        self.saved.start.used &= !wanted;
        self.save_request(cx, kept, request);
        Written::Storing
    }

    fn save_request(&mut self, cx: &mut ContextOf<P>, kept: Kept, request: u8) {
        let mut parameters = self.saved.parameters;
        parameters.set(kept.request, request.into());
        self.save_these(cx, parameters);
    }

    /// Prepares a stored set for a start: takes the factory values of the request, and the history.
    pub(super) fn begin(&mut self, parameters: &mut ParametersOf<P>) {
        let Some(kept) = P::KEPT else { return };
        let request = parameters.get(kept.request) as u8;
        let factory = Parameters::factory();
        if request & COMMUNICATION != 0 {
            parameters.copy(&factory, Self::stored(true));
            self.emergency.clear_history();
        } else {
            let oldest_first = errors::<P>(kept).rev().map(|id| parameters.get(id));
            self.emergency
                .recall(oldest_first.filter(|error| *error != 0));
        }
        let connection = [P::NODE_ID, P::BIT_RATE];
        if request & APPLICATION != 0 {
            let others = Self::stored(false).filter(|id| !connection.contains(id));
            parameters.copy(&factory, others);
        }
        if request & CONNECTION != 0 {
            parameters.copy(&factory, connection);
        }
        parameters.set(kept.request, 0);
        errors::<P>(kept).for_each(|id| parameters.set(id, 0));
        self.saved.start.used |= request;
        self.saved.start.begun = true;
    }

    /// After reset communication has restored the stored values: takes the factory values of a request for this group.
    pub(super) fn restore_requested(&mut self, cx: &mut ContextOf<P>) {
        let Some(kept) = P::KEPT else { return };
        let request = self.saved.parameters.get(kept.request) as u8 & COMMUNICATION;
        if request != 0 {
            cx.parameters
                .copy(&Parameters::factory(), Self::stored(true));
            self.emergency.clear_history();
            self.saved.start.used |= request;
            self.use_up_request(cx);
        }
    }

    /// Clears the used part of the request in memory, after a running save at the earliest.
    pub(super) fn use_up_request(&mut self, cx: &mut ContextOf<P>) {
        let Some(kept) = P::KEPT else { return };
        if cx.is_saving() {
            return;
        }
        let used = core::mem::take(&mut self.saved.start.used);
        let request = self.saved.parameters.get(kept.request) as u8;
        if request & used != 0 {
            self.save_request(cx, kept, request & !used);
        }
    }
}

/// Whether this is a hidden parameter of the history.
fn is_error<P: Product>(kept: Kept, id: ParameterId) -> bool {
    let place = id.0.wrapping_sub(kept.history.0);
    usize::from(place) < P::History::CAPACITY
}

/// The hidden parameters of the history, the newest error first.
fn errors<P: Product>(kept: Kept) -> impl DoubleEndedIterator<Item = ParameterId> {
    let ParameterId(first) = kept.history;
    (first..first.saturating_add(P::History::CAPACITY as u8)).map(ParameterId)
}
