//! The objects of CiA 302-3 with which a client stops the program and enters the [bootloader](crate::update).
//!
//! | object | type | access | |
//! |---|---|---|---|
//! | 1F51h:01 | u8 | rw | 0: stop the program; 1: start it, which has no effect; reads 1 |
//! | 1F56h:01 | u32 | ro | the CRC-32 of the program |
//! | 1F57h:01 | u32 | ro | 0: the program is in order |
//!
//! A product has them only behind a bootloader, and they are in none of its EDS files: the original does not have them.

use super::Abort;
use super::cob_id;
use super::dictionary::{Access, Object, Service, Target};
use super::lookup::find_row;
use super::nmt::State;
use super::product::{ContextOf, Product};
use super::protocol::Services;
use super::row::{Row, rows};
use super::sdo::Written;
use super::sdo::message::Address;
use crate::can::CanId;
use crate::param::DataType;
use crate::time::Instant;
use crate::update::Contact;

/// The objects, in addition to those of a product.
const OBJECTS: [Object; 6] = [
    count(0x1F51),
    Object {
        access: Access::Rw,
        ..service(0x1F51, DataType::U8, Service::ProgramControl)
    },
    count(0x1F56),
    service(0x1F56, DataType::U32, Service::ProgramIdentification),
    count(0x1F57),
    Object {
        index: 0x1F57,
        sub: 1,
        data_type: DataType::U32,
        ..Object::plain()
    },
];

static ROWS: [Row; OBJECTS.len()] = rows(&OBJECTS, &[], &[]);

/// The number of programs.
const fn count(index: u16) -> Object {
    Object {
        index,
        target: Target::Constant(1),
        ..Object::plain()
    }
}

const fn service(index: u16, data_type: DataType, service: Service) -> Object {
    Object {
        index,
        sub: 1,
        data_type,
        target: Target::Service(service),
        ..Object::plain()
    }
}

/// The row of one of these objects. Not inlined, so that the way to the objects of the product stays short.
#[cold]
#[inline(never)]
pub(super) fn lookup(address: Address) -> Result<&'static Row, Abort> {
    let mut same = ROWS.iter().filter(|row| row.index() == address.index);
    let mut abort = Abort::NoObject;
    same.find(|row| {
        abort = Abort::NoSubIndex;
        row.address().sub == address.sub
    })
    .ok_or(abort)
}

impl<P: Product> Services<P> {
    /// Writes 1F51h:01.
    pub(super) fn control_program(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        value: u32,
    ) -> Result<Written, Abort> {
        match value {
            0 => {
                // The reply is the last frame.
                self.be_silent(State::Initialising);
                self.operate(now, false);
                cx.shell.enter_bootloader();
                cx.shell.restart(now);
            }
            1 => {}
            _ => return Err(Abort::Value),
        }
        Ok(Written::Done)
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
