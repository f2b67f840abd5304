//! The CIP objects. A request is checked in this order: class, instance, service, attribute, settable, length, range, state.
//!
//! | class | object |
//! |---|---|
//! | 1 | identity |
//! | 2 | message router: it has no service |
//! | 3 | DeviceNet |
//! | 4 | assembly |
//! | 5 | connection |
//! | 2Bh | acknowledge handler |
//! | 64h to C7h | the objects of the vendor, as the product describes them |
//! | C7h | diagnostic data ([`diagnosis`](crate::diagnosis)), unless the product has an object there |

mod acknowledge_handler;
mod assembly;
mod connection;
pub(super) mod devicenet;
mod diagnosis;
pub(super) mod identity;
mod vendor;

use super::explicit::{Data, Failure, Request};
use super::protocol::{ContextOf, Devicenet};
use super::table::Product;
use crate::application::Application;
use crate::time::Instant;

/// The classes of the protocol.
mod class {
    pub const IDENTITY: u8 = 0x01;
    pub const MESSAGE_ROUTER: u8 = 0x02;
    pub const DEVICENET: u8 = 0x03;
    pub const ASSEMBLY: u8 = crate::devicenet::table::ASSEMBLY;
    pub const CONNECTION: u8 = 0x05;
    pub const ACKNOWLEDGE_HANDLER: u8 = 0x2B;
    pub const DIAGNOSIS: u8 = crate::diagnosis::CLASS;
}

/// Whether the unconnected port has the object of a request: the DeviceNet object.
pub(super) fn is_unconnected(request: &Request) -> bool {
    request.class == class::DEVICENET && request.instance == 1
}

/// Answers a request of this master.
pub(super) fn serve<P: Product>(
    device: &mut Devicenet<P>,
    cx: &mut ContextOf<P>,
    now: Instant,
    master: u8,
    request: &Request,
) -> Result<Data, Failure> {
    if let Some(object) = P::OBJECT_ROWS
        .iter()
        .find(|object| object.class == request.class)
    {
        return vendor::serve(device, cx, now, object, request);
    }
    other(device, cx, now, master, request)
}

/// Answers a request to an object of the protocol.
fn other<P: Product>(
    device: &mut Devicenet<P>,
    cx: &mut ContextOf<P>,
    now: Instant,
    master: u8,
    request: &Request,
) -> Result<Data, Failure> {
    match request.class {
        class::IDENTITY => identity::serve(device, cx, now, request),
        class::MESSAGE_ROUTER if request.instance <= 1 => Err(Failure::SERVICE),
        class::DEVICENET => devicenet::serve(device, cx, now, master, request),
        class::ASSEMBLY => assembly::serve::<P>(cx, request),
        class::CONNECTION => connection::serve(device, cx, now, request),
        class::ACKNOWLEDGE_HANDLER => acknowledge_handler::serve(&mut device.handler, request),
        class::DIAGNOSIS if P::Application::HAS_DIAGNOSIS => {
            diagnosis::serve(cx.diagnosis(), request)
        }
        _ => Err(Failure::OBJECT),
    }
}
