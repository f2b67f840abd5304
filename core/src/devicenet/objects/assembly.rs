//! The assembly object (class 4): the data of the I/O messages.

use crate::devicenet::exchange::{pack, words};
use crate::devicenet::explicit::{Data, Failure, Request, nothing, service};
use crate::devicenet::protocol::ContextOf;
use crate::devicenet::table::{DATA, Product};

/// The revision of the class.
const REVISION: u8 = 2;

pub(super) fn serve<P: Product>(cx: &ContextOf<P>, request: &Request) -> Result<Data, Failure> {
    if request.instance == 0 {
        return request.class_attribute(REVISION);
    }
    let instance = request.instance;
    let Some(row) = P::ASSEMBLY_ROWS.iter().find(|row| row.instance == instance) else {
        return Err(Failure::OBJECT);
    };
    if !matches!(request.service, service::GET | service::SET) {
        return Err(Failure::SERVICE);
    }
    let (attribute, rest) = request.attribute()?;
    if attribute != DATA {
        return Err(Failure::ATTRIBUTE);
    }
    if request.service == service::SET {
        return Err(Failure::NOT_SETTABLE);
    }
    nothing(rest)?;
    Ok(Data::Bytes {
        bytes: pack(words::<P>(row, &cx.values)),
        length: row.size(),
    })
}
