//! The objects of CiA 302-3 with which a client stops the program and enters the [bootloader](crate::update).
//!
//! | object | type | access | |
//! |---|---|---|---|
//! | 1F51h:01 | u8 | rw | 0: stop the program; 1: start it, which has no effect; reads 1 |
//! | 1F56h:01 | u32 | ro | the CRC-32 of the program |
//! | 1F56h:02 | u32 | ro | its [`Hardware`](crate::update::Hardware), which is not of CiA 302-3 |
//! | 1F57h:01 | u32 | ro | 0: the program is in order |
//!
//! A product has them only behind a bootloader, and they are in none of its EDS files: the original does not have them. So they are no rows of
//! its dictionary. A request for them is answered before the SDO server: as rows, they made each answer of the ims360 2 us slower.

use super::Abort;
use super::cob_id;
use super::lookup::find_row;
use super::nmt::State;
use super::product::{ContextOf, Product};
use super::protocol::Services;
use super::sdo::message::{self, Address, Announced, Request};
use crate::can::CanId;
use crate::time::Instant;
use crate::update::{Contact, Installed};

/// The high byte of the indices.
pub(super) const GROUP: u8 = 0x1F;

/// Program control.
const CONTROL: u16 = 0x1F51;
/// Program software identification.
const IDENTIFICATION: u16 = 0x1F56;
/// Flash status identification.
const STATUS: u16 = 0x1F57;

impl<P: Product> Services<P> {
    /// The answer to a request for one of these objects; None: it is for another object, or there is no bootloader.
    pub(super) fn answer_program(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        address: Address,
        request: Request,
    ) -> Option<[u8; 8]> {
        let program = cx.shell.program()?;
        let answer = match request {
            Request::Download(_, announced) => {
                let written = self.control_program(cx, now, program, address, announced);
                written.map(|()| message::download_reply(address))
            }
            _ => read(address, program)
                .map(|(number, size)| message::number_reply(address, number, size)),
        };
        match answer {
            Err(Abort::NoObject) => None,
            Err(abort) => Some(message::abort(address, abort)),
            reply => reply.ok(),
        }
    }

    /// Writes 1F51h:01.
    fn control_program(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        program: Installed,
        address: Address,
        announced: Announced,
    ) -> Result<(), Abort> {
        read(address, program)?;
        if (address.index, address.sub) != (CONTROL, 1) {
            return Err(Abort::ReadOnly);
        }
        match announced {
            Announced::Expedited(..) if cx.is_saving() => Err(Abort::DeviceState),
            Announced::Expedited([0, ..], None | Some(1)) => {
                // The reply is the last frame.
                self.be_silent(State::Initialising);
                self.operate(now, false);
                cx.shell.enter_bootloader();
                cx.shell.restart(now);
                Ok(())
            }
            Announced::Expedited([1, ..], None | Some(1)) => Ok(()),
            Announced::Expedited(_, None | Some(1)) => Err(Abort::Value),
            // One byte needs no segments.
            Announced::Segmented(None | Some(1)) => Err(Abort::Access),
            _ => Err(Abort::TooLong),
        }
    }

    /// The contact data of a bootloader with the identifiers of the SDO server.
    pub(super) fn contact(&self, cx: &ContextOf<P>) -> Contact {
        let id = |function| CanId::standard(function + u16::from(self.node_id));
        Contact {
            rate: self.rate,
            request: id(cob_id::SDO_REQUEST),
            reply: id(cob_id::SDO_REPLY),
            boot_up: id(cob_id::ERROR_CONTROL),
            vendor: self.identity(cx, 1),
            product_code: self.identity(cx, 2),
            serial: cx.shell.serial(),
        }
    }

    /// A number of the identity object (1018h).
    fn identity(&self, cx: &ContextOf<P>, sub: u8) -> u32 {
        find_row::<P>(0x1018, sub).map_or(0, |row| self.number(cx, row, sub))
    }
}

/// The number in an object, and its size in bytes.
fn read(Address { index, sub }: Address, program: Installed) -> Result<(u32, u8), Abort> {
    match (index, sub) {
        (IDENTIFICATION, 0) => Ok((2, 1)),
        (CONTROL | STATUS, 0) | (CONTROL, 1) => Ok((1, 1)),
        (IDENTIFICATION, 1) => Ok((program.crc, 4)),
        (IDENTIFICATION, 2) => Ok((program.hardware.number().into(), 4)),
        (STATUS, 1) => Ok((0, 4)),
        (CONTROL | IDENTIFICATION | STATUS, _) => Err(Abort::NoSubIndex),
        _ => Err(Abort::NoObject),
    }
}
