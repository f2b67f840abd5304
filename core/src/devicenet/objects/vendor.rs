//! The objects of the vendor: parameters, published values and constants, as the product describes them.

use crate::application::Values;
use crate::devicenet::explicit::{Data, Failure, Request, exactly, nothing, service};
use crate::devicenet::projection::{AttributeRow, ObjectRow, Place};
use crate::devicenet::protocol::{ContextOf, Devicenet, ParametersOf};
use crate::devicenet::table::{Own, Product};
use crate::param::{ParameterId, Refused};
use crate::time::Instant;

pub(super) fn serve<P: Product>(
    device: &mut Devicenet<P>,
    cx: &mut ContextOf<P>,
    now: Instant,
    object: &ObjectRow,
    request: &Request,
) -> Result<Data, Failure> {
    match request.instance {
        0 => return request.class_attribute(object.revision),
        1 => {}
        _ => return Err(Failure::OBJECT),
    }
    if !matches!(request.service, service::GET | service::SET) {
        return Err(Failure::SERVICE);
    }
    let (attribute, data) = request.attribute()?;
    let row = object.attribute(P::ATTRIBUTE_ROWS, attribute);
    let Some(row) = row else {
        return Err(Failure::ATTRIBUTE);
    };
    if request.service == service::SET {
        return set(device, cx, now, row, data);
    }
    nothing(data)?;
    let number = match row.place() {
        Place::Parameter(id) => cx.parameters.get(id),
        Place::Value(id) => cx.values.number(id),
        Place::Constant(place) => {
            let constant = P::CONSTANTS.get(usize::from(place));
            constant.copied().unwrap_or(0)
        }
        Place::Own(place) => own::<P>(place).map_or(0, |own| (own.read)(cx)),
    };
    Ok(Data::number(number, row.size()))
}

fn set<P: Product>(
    device: &mut Devicenet<P>,
    cx: &mut ContextOf<P>,
    now: Instant,
    row: AttributeRow,
    data: &[u8],
) -> Result<Data, Failure> {
    if !row.is_settable() {
        return Err(Failure::NOT_SETTABLE);
    }
    let value = exactly(data, row.size())?;
    match row.place() {
        Place::Parameter(id) => set_parameter(device, cx, id, value)?,
        Place::Own(place) => {
            let own = own::<P>(place).ok_or(Failure::NOT_SETTABLE)?;
            (own.write)(cx, value).map_err(failure)?;
        }
        Place::Value(_) | Place::Constant(_) => return Err(Failure::NOT_SETTABLE),
    }
    device.saving.changed(now);
    cx.apply();
    Ok(Data::NONE)
}

/// The functions of the own attribute at this place.
fn own<P: Product>(place: u8) -> Option<&'static Own<P::Application>> {
    P::OWN.get(usize::from(place))
}

fn set_parameter<P: Product>(
    device: &mut Devicenet<P>,
    cx: &mut ContextOf<P>,
    id: ParameterId,
    value: u32,
) -> Result<(), Failure> {
    ParametersOf::<P>::check(id, value).map_err(failure)?;
    if value != cx.parameters.get(id) && is_in_use(device, id) {
        return Err(Failure::STATE);
    }
    cx.write(id, value).map_err(failure)?;
    Ok(())
}

/// Whether a parameter selects the assembly of a connection that exists.
fn is_in_use<P: Product>(device: &mut Devicenet<P>, id: ParameterId) -> bool {
    let connections = &mut device.connections;
    id == P::ROLES.polled_assembly && connections.poll().is_allocated()
        || id == P::ROLES.cyclic_assembly && connections.producing().is_allocated()
}

/// The error response to a value that is refused.
fn failure(refused: Refused) -> Failure {
    match refused {
        Refused::TooLow | Refused::TooHigh | Refused::NotPermitted => Failure::VALUE,
        Refused::State => Failure::STATE,
    }
}
