//! The DeviceNet object (class 3): MAC ID, bit rate, bus-off, and the allocation of the connection set.

use crate::devicenet::explicit::{Data, Failure, Request, exactly, nothing, service};
use crate::devicenet::protocol::{ContextOf, Devicenet, Leaving, ParametersOf};
use crate::devicenet::table::Product;
use crate::param::ParameterId;
use crate::time::Instant;

/// The revision of the class.
const REVISION: u8 = 2;

/// The attributes of instance 1.
const MAC_ID: u8 = 1;
const BAUD_RATE: u8 = 2;
const BUS_OFF_INTERRUPT: u8 = 3;
const BUS_OFF_COUNTER: u8 = 4;
const ALLOCATION: u8 = 5;

pub(super) fn serve<P: Product>(
    device: &mut Devicenet<P>,
    cx: &mut ContextOf<P>,
    now: Instant,
    master: u8,
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
            let data = get(device, cx, attribute)?;
            nothing(rest)?;
            Ok(data)
        }
        service::SET => set(device, cx, now, request),
        service::ALLOCATE | service::RELEASE => link(device, now, master, request),
        _ => Err(Failure::SERVICE),
    }
}

/// The parameter in which a settable attribute is stored.
fn parameter<P: Product>(attribute: u8) -> Option<ParameterId> {
    match attribute {
        MAC_ID => Some(P::ROLES.mac_id),
        BAUD_RATE => Some(P::ROLES.baud_rate),
        BUS_OFF_INTERRUPT => Some(P::ROLES.bus_off_interrupt),
        _ => None,
    }
}

fn get<P: Product>(
    device: &Devicenet<P>,
    cx: &ContextOf<P>,
    attribute: u8,
) -> Result<Data, Failure> {
    if let Some(id) = parameter::<P>(attribute) {
        return Ok(Data::byte(cx.parameters.get(id) as u8));
    }
    match attribute {
        BUS_OFF_COUNTER => Ok(Data::byte(device.bus_offs)),
        ALLOCATION => Ok(Data::word(u16::from_le_bytes(
            device.connections.information(),
        ))),
        _ => Err(Failure::ATTRIBUTE),
    }
}

fn set<P: Product>(
    device: &mut Devicenet<P>,
    cx: &mut ContextOf<P>,
    now: Instant,
    request: &Request,
) -> Result<Data, Failure> {
    let (attribute, data) = request.attribute()?;
    match attribute {
        MAC_ID..=BUS_OFF_COUNTER => {}
        ALLOCATION => return Err(Failure::NOT_SETTABLE),
        _ => return Err(Failure::ATTRIBUTE),
    }
    let value = exactly(data, 1)?;
    let Some(id) = parameter::<P>(attribute) else {
        // The value has no meaning.
        device.bus_offs = 0;
        return Ok(Data::NONE);
    };
    ParametersOf::<P>::check(id, value).map_err(|_| Failure::VALUE)?;
    cx.parameters.set(id, value);
    device.saving.changed(now);
    cx.shell.wake_up();
    if attribute == MAC_ID && value != u32::from(device.mac) {
        device.leave_network(cx, now, Leaving::Readdress);
    }
    Ok(Data::NONE)
}

/// Allocates or releases connections. A request to the unconnected port is handled in the same way.
pub(in crate::devicenet) fn link<P: Product>(
    device: &mut Devicenet<P>,
    now: Instant,
    master: u8,
    request: &Request,
) -> Result<Data, Failure> {
    if request.service == service::ALLOCATE {
        let choices = exactly(request.data, 2)?;
        let [choice, allocator, ..] = choices.to_le_bytes();
        device.connections.allocate(now, choice, allocator)?;
        // Message body format: 8 bits for class and instance.
        return Ok(Data::byte(0));
    }
    let choice = exactly(request.data, 1)?;
    device.connections.release(master, choice as u8)?;
    Ok(Data::NONE)
}
