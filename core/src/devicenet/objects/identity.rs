//! The identity object (class 1).

use crate::application::{Faults, Values};
use crate::devicenet::explicit::{Data, Failure, Request, nothing, service};
use crate::devicenet::protocol::{ContextOf, Devicenet, Leaving, ParametersOf};
use crate::devicenet::table::Product;
use crate::param::Parameters;
use crate::store::{Name, Unit};
use crate::time::Instant;

/// The revision of the class.
const REVISION: u8 = 1;

/// The signature of an update.
pub const BOOT: &[u8] = b"BOOT";

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
        service::UPDATE => update(device, cx, now, request.data),
        _ => Err(Failure::SERVICE),
    }
}

fn attribute_of<P: Product>(
    device: &Devicenet<P>,
    cx: &ContextOf<P>,
    attribute: u8,
) -> Result<Data, Failure> {
    let unit = cx.shell.unit();
    let identity = const { &P::IDENTITY };
    Ok(match attribute {
        1 => Data::word(vendor::<P>(unit)),
        2 => Data::word(unit.device_type.unwrap_or(identity.device_type)),
        3 => Data::word(product_code::<P>(unit)),
        4 => {
            let (major, minor) = revision(unit.revision, identity.revision);
            Data::word(u16::from_le_bytes([major, minor]))
        }
        5 => Data::word(status_of(device, cx)),
        6 => Data::number(cx.shell.serial(), 4),
        7 => Data::text(
            &unit
                .name
                .unwrap_or(const { Name::constant(P::IDENTITY.name) }),
        ),
        _ => return Err(Failure::ATTRIBUTE),
    })
}

/// The number of the vendor, also in the messages of the duplicate MAC ID check.
pub fn vendor<P: Product>(unit: &Unit) -> u16 {
    number(unit.vendor, P::IDENTITY.vendor)
}

/// The product code.
pub fn product_code<P: Product>(unit: &Unit) -> u16 {
    number(unit.product_code, P::IDENTITY.product_code)
}

/// The number of the unit, or else that of the product. A number that the attribute does not have is not possible.
fn number(unit: Option<u32>, product: u16) -> u16 {
    let unit = unit.and_then(|number| u16::try_from(number).ok());
    unit.filter(|number| *number > 0).unwrap_or(product)
}

/// Major and minor revision of the unit, or else those of the product.
fn revision(unit: Option<u32>, product: (u8, u8)) -> (u8, u8) {
    let unit = unit.and_then(|number| u16::try_from(number).ok());
    let revision = unit.map(|number| ((number >> 8) as u8, number as u8));
    let is_valid = |(major, minor): &(u8, u8)| (1..=127).contains(major) && *minor > 0;
    revision.filter(is_valid).unwrap_or(product)
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

/// The service of an update, which a sensor has only behind a bootloader: with the signature the node restarts into the bootloader after the
/// answer, without data it answers with the CRC-32 and the hardware of the program.
fn update<P: Product>(
    device: &mut Devicenet<P>,
    cx: &mut ContextOf<P>,
    now: Instant,
    data: &[u8],
) -> Result<Data, Failure> {
    let program = cx.shell.program().ok_or(Failure::SERVICE)?;
    match data {
        [] => {
            let hardware = u64::from(program.hardware.number()) << 32;
            return Ok(Data::Bytes {
                bytes: hardware | u64::from(program.crc),
                length: 6,
            });
        }
        BOOT => {}
        [_, _, _, _, _, ..] => return Err(Failure::TOO_MUCH),
        _ => return Err(Failure::PARAMETER),
    }
    cx.shell.enter_bootloader();
    device.leave_network(cx, now, Leaving::Restart);
    Ok(Data::NONE)
}
