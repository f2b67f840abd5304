//! The acknowledge handler object (class 2Bh).

use crate::devicenet::explicit::{Data, Failure, Request, exactly, nothing, service};
use crate::devicenet::production::AcknowledgeHandler;

/// The revision of the class.
const REVISION: u8 = 1;

/// The attributes that can be read and set.
const TIMER: u8 = 1;
const RETRIES: u8 = 2;
const INSTANCE: u8 = 3;

/// The connection whose messages are acknowledged.
const PRODUCING: u16 = 4;

pub(super) fn serve(handler: &mut AcknowledgeHandler, request: &Request) -> Result<Data, Failure> {
    match request.instance {
        0 => return request.class_attribute(REVISION),
        1 => {}
        _ => return Err(Failure::OBJECT),
    }
    if !matches!(request.service, service::GET | service::SET) {
        return Err(Failure::SERVICE);
    }
    let (attribute, data) = request.attribute()?;
    let present = match attribute {
        TIMER => Data::word(handler.timer()),
        RETRIES => Data::byte(handler.retries()),
        INSTANCE => Data::word(PRODUCING),
        _ => return Err(Failure::ATTRIBUTE),
    };
    if request.service == service::GET {
        nothing(data)?;
        return Ok(present);
    }
    match attribute {
        TIMER => {
            let timer = exactly(data, 2)? as u16;
            if timer == 0 {
                return Err(Failure::VALUE);
            }
            handler.set_timer(timer);
            Ok(Data::word(timer))
        }
        RETRIES => {
            handler.set_retries(exactly(data, 1)? as u8);
            Ok(Data::NONE)
        }
        _ => Err(Failure::NOT_SETTABLE),
    }
}
