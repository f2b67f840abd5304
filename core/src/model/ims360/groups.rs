//! Store and restore (1010h, 1011h; manual 7.2.8 and 7.2.9): groups of stored parameters, the restore at the next start, and the stored
//! errors of 1003h.
//!
//! A request of a restore is stored. The first start after it takes the factory values of its group and uses the request up; the stored
//! values do not change. Hidden parameters of the stored set hold the request and the errors, and are 0 in RAM:
//!
//! ```text
//!  request  bit 0  parameters of the communication profile, and the errors
//!           bit 1  all other parameters, except node-ID and bit rate
//!           bit 2  node-ID and bit rate
//! ```

use super::parameters::id;
use super::{HISTORY, Ims360Product, objects};
use crate::canopen::dictionary::communication;
use crate::canopen::emcy::History;
use crate::canopen::{Abort, Initial, Own, Taken, Then};
use crate::param::{ParameterId, ParameterSet, Parameters};

/// Request: the parameters of the communication profile, and the errors.
const COMMUNICATION: u8 = 1 << 0;
/// Request: all other parameters, except node-ID and bit rate.
const APPLICATION: u8 = 1 << 1;
/// Request: node-ID and bit rate.
const CONNECTION: u8 = 1 << 2;

/// The parameters of the communication profile.
const PROFILE: ParameterSet = communication(objects::OBJECTS);

/// Node-ID and bit rate.
const NETWORK: [ParameterId; 2] = [id::NODE_ID, id::BIT_RATE];

/// The bits of the request that were used and must be cleared in memory.
pub struct State {
    used: u8,
}

impl Initial for State {
    const INITIAL: Self = Self { used: 0 };
}

type Scope<'a> = crate::canopen::Scope<'a, Ims360Product>;
type Values = Parameters<Ims360Product>;

/// A sub-index of 1010h. The device stores on command (7.5.2.13 of CiA 301), so it reads 1.
pub(super) const fn store<const SUB: u8>() -> Own<Ims360Product> {
    Own::number(0x1010, SUB, |_, _| 1).written(|scope, data| {
        check(scope, data, b"save")?;
        store_group(scope, SUB)
    })
}

/// A sub-index of 1011h.
pub(super) const fn restore<const SUB: u8>() -> Own<Ims360Product> {
    Own::number(0x1011, SUB, |_, _| 1).written(|scope, data| {
        check(scope, data, b"load")?;
        request_restore(scope, SUB)
    })
}

/// Refuses a command during a save, and another signature.
fn check(scope: &Scope, data: &[u8], signature: &[u8; 4]) -> Result<(), Abort> {
    if scope.cx.is_saving() {
        return Err(Abort::DeviceState);
    }
    if data != signature {
        return Err(Abort::Signature);
    }
    Ok(())
}

/// The stored parameters of the communication profile, or all others.
fn members(of_profile: bool) -> impl Iterator<Item = ParameterId> {
    Values::rows()
        .filter(move |(id, row)| row.is_stored() && PROFILE.contains(*id) == of_profile)
        .map(|(id, _)| id)
}

/// The hidden parameters of the errors, the newest error first.
fn errors() -> impl DoubleEndedIterator<Item = ParameterId> {
    let ParameterId(first) = id::HISTORY;
    (first..first + HISTORY as u8).map(ParameterId)
}

/// Stores a group of parameters.
fn store_group(scope: &mut Scope, group: u8) -> Result<Then, Abort> {
    let mut parameters = *scope.stored;
    match group {
        1 => {
            let request = parameters.get(id::RESTORE_REQUEST);
            parameters = scope.cx.parameters;
            parameters.set(id::RESTORE_REQUEST, request);
        }
        2 => parameters.copy(&scope.cx.parameters, members(true)),
        4 => {
            let is_hidden =
                |id: &ParameterId| *id == id::RESTORE_REQUEST || errors().any(|error| error == *id);
            let others = members(false).filter(|id| !is_hidden(id));
            parameters.copy(&scope.cx.parameters, others);
        }
        // The device profile has no parameters.
        _ => return Ok(Then::Reply),
    }
    // The errors are part of the communication profile.
    if group != 4 {
        for (place, id) in errors().enumerate() {
            let error = scope.history.get(place).copied().unwrap_or(0);
            parameters.set(id, error & 0xFFFF);
        }
    }
    scope.save(parameters)
}

/// Requests the factory values of a group of parameters for the next start.
fn request_restore(scope: &mut Scope, group: u8) -> Result<Then, Abort> {
    let wanted = match group {
        1 => COMMUNICATION | APPLICATION,
        2 => COMMUNICATION,
        4 => APPLICATION | CONNECTION,
        5 => COMMUNICATION | APPLICATION | CONNECTION,
        _ => return Ok(Then::Reply),
    };
    let request = request(scope.stored) | wanted;
    // A new request for a part that was used during a running save stays.
    scope.state.restore.used &= !wanted;
    save_request(scope, request)
}

fn request(stored: &Values) -> u8 {
    stored.get(id::RESTORE_REQUEST) as u8
}

fn save_request(scope: &mut Scope, request: u8) -> Result<Then, Abort> {
    let mut parameters = *scope.stored;
    parameters.set(id::RESTORE_REQUEST, request.into());
    scope.save(parameters)
}

/// Takes the factory values of the request, in place of parameters that were taken from the memory.
pub(super) fn take_factory_values(taken: &mut Taken<'_, Ims360Product>, starts: bool) {
    let factory = Values::factory();
    let request = if starts {
        request(taken.parameters)
    } else {
        request(taken.stored) & COMMUNICATION
    };
    if request & COMMUNICATION != 0 {
        taken.parameters.copy(&factory, members(true));
        taken.history.clear();
    } else if starts {
        taken.history.clear();
        for id in errors().rev() {
            let error = taken.parameters.get(id);
            if error != 0 {
                taken.history.push(error);
            }
        }
    }
    if request & APPLICATION != 0 {
        let others = members(false).filter(|id| !NETWORK.contains(id));
        taken.parameters.copy(&factory, others);
    }
    if request & CONNECTION != 0 {
        taken.parameters.copy(&factory, NETWORK);
    }
    if starts {
        taken.parameters.set(id::RESTORE_REQUEST, 0);
        errors().for_each(|id| taken.parameters.set(id, 0));
    }
    taken.state.restore.used |= request;
}

/// Clears the used part of the request in memory, after a running save at the earliest.
pub(super) fn use_up_request(scope: &mut Scope) {
    let used = core::mem::take(&mut scope.state.restore.used);
    let request = request(scope.stored);
    if request & used != 0 {
        // No save is running, so it is not refused.
        let _ = save_request(scope, request & !used);
    }
}
