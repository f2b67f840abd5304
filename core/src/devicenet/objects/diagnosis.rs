//! The diagnostic data (class C7h): see [`diagnosis`](crate::diagnosis).

use crate::devicenet::explicit::{Data, Failure, Request, nothing, service};
use crate::diagnosis::Diagnosis;

/// The revision of the class.
const REVISION: u8 = 1;

#[cold]
#[inline(never)]
pub(super) fn serve(diagnosis: &Diagnosis, request: &Request) -> Result<Data, Failure> {
    match request.instance {
        0 => return request.class_attribute(REVISION),
        1 => {}
        _ => return Err(Failure::OBJECT),
    }
    if !matches!(request.service, service::GET | service::SET) {
        return Err(Failure::SERVICE);
    }
    let (attribute, data) = request.attribute()?;
    let value = match attribute {
        0 => None,
        number => diagnosis.value(number),
    };
    let value = value.ok_or(Failure::ATTRIBUTE)?;
    if request.service == service::SET {
        return Err(Failure::NOT_SETTABLE);
    }
    nothing(data)?;
    Ok(Data::number(value, 4))
}
