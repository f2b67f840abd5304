//! The identity object (class 1).

use crate::application::{Faults, Values};
use crate::devicenet::access::Leaving;
use crate::devicenet::explicit::{Data, Failure, Request, nothing, service};
use crate::devicenet::protocol::{ContextOf, Devicenet, ParametersOf};
use crate::devicenet::table::Product;
use crate::param::Parameters;
use crate::time::Instant;

/// The revision of the class.
const REVISION: u8 = 1;

/// Bits of the status (attribute 5).
mod status {
    /// A master has allocated connections.
    pub const OWNED: u16 = 1 << 0;
    /// A parameter of the application does not have its factory value.
    pub const CONFIGURED: u16 = 1 << 2;
    /// The parameter memory has failed.
    pub const MINOR_RECOVERABLE: u16 = 1 << 8;
    /// There are no valid measurements.
    pub const MAJOR_RECOVERABLE: u16 = 1 << 10;
}

pub(super) fn serve<P: Product>(
    device: &mut Devicenet<P>,
    cx: &mut ContextOf<P>,
    now: Instant,
    request: &Request,
) -> Result<Data, Failure> {
    match request.instance {
        0 => return request.class_attribute(REVISION),
        1 => {}
        _ => return Err(Failure::OBJECT),
    }
    match request.service {
        service::GET => {
            let (attribute, rest) = request.attribute()?;
            let data = attribute_of(device, cx, attribute)?;
            nothing(rest)?;
            Ok(data)
        }
        service::SET => {
            let (attribute, _) = request.attribute()?;
            attribute_of(device, cx, attribute)?;
            Err(Failure::NOT_SETTABLE)
        }
        service::RESET => reset(device, cx, now, request.data),
        _ => Err(Failure::SERVICE),
    }
}

fn attribute_of<P: Product>(
    device: &Devicenet<P>,
    cx: &ContextOf<P>,
    attribute: u8,
) -> Result<Data, Failure> {
    let identity = const { &P::IDENTITY };
    Ok(match attribute {
        1 => Data::word(identity.vendor),
        2 => Data::word(identity.device_type),
        3 => Data::word(identity.product_code),
        4 => {
            let (major, minor) = identity.revision;
            Data::word(u16::from_le_bytes([major, minor]))
        }
        5 => Data::word(status_of(device, cx)),
        6 => Data::number(cx.shell.serial(), 4),
        7 => Data::Text(identity.name),
        _ => return Err(Failure::ATTRIBUTE),
    })
}

fn status_of<P: Product>(device: &Devicenet<P>, cx: &ContextOf<P>) -> u16 {
    let bit = |set: bool, bit: u16| if set { bit } else { 0 };
    bit(device.connections.is_owned(), status::OWNED)
        | bit(is_configured::<P>(&cx.parameters), status::CONFIGURED)
        | bit(device.saving.is_faulted(), status::MINOR_RECOVERABLE)
        | bit(
            cx.values.faults().intersects(Faults::SENSOR),
            status::MAJOR_RECOVERABLE,
        )
}

/// Whether a parameter of the application does not have its factory value. The settings of the DeviceNet object do not count: they are
/// no configuration of the application.
fn is_configured<P: Product>(parameters: &ParametersOf<P>) -> bool {
    let roles = &P::ROLES;
    let network = [roles.mac_id, roles.baud_rate, roles.bus_off_interrupt];
    ParametersOf::<P>::rows()
        .map(|(id, _)| id)
        .filter(|id| !network.contains(id))
        .any(|id| parameters.get(id) != ParametersOf::<P>::factory_value(id))
}

/// Restarts the node after the answer. Type 1 restores the factory values before.
fn reset<P: Product>(
    device: &mut Devicenet<P>,
    cx: &mut ContextOf<P>,
    now: Instant,
    data: &[u8],
) -> Result<Data, Failure> {
    match data {
        [] | [0] => {}
        [1] => {
            cx.parameters = Parameters::factory();
            device.saving.changed(now);
        }
        [_] => return Err(Failure::PARAMETER),
        _ => return Err(Failure::TOO_MUCH),
    }
    device.leave_network(cx, now, Leaving::Restart);
    Ok(Data::NONE)
}
