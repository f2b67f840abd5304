//! The objects of the bootloader (CiA 301 and CiA 302-3), for the [SDO server](crate::canopen::sdo).
//!
//! | object | type | access | |
//! |---|---|---|---|
//! | 1000h | u32 | ro | 0: no device profile, so that a master sees that this is not the sensor |
//! | 1001h | u8 | ro | error register: 01h without a program |
//! | 1018h | u32 | ro | vendor, product code, revision (version of the program, or 0) and serial number of the sensor |
//! | 1F50h:01 | domain | wo | the image file |
//! | 1F51h:01 | u8 | rw | 1: start the program, 2: restart, 3: clear, 81h: permit a lower version in the next download; reads 0 |
//! | 1F56h:01 | u32 | ro | the CRC of the program; 0: none |
//! | 1F57h:01 | u32 | ro | the [`Status`] of the last download |
//!
//! A download is refused with 0609 0030h if the image is for another device, with 0800 0022h if it is older or if 1F51h = 3 did not come before,
//! with 0800 0020h if it is damaged, with 0607 0010h if its length is not that of its header, and with 0606 0000h if the flash fails.

use super::header::{self, Device, Unfit};
use super::loader::{Failure, Loader, Status};
use super::record::Record;
use super::slot::{Program, Slot};
use crate::canopen::sdo::message::Address;
use crate::canopen::sdo::{Block, Objects, Server, Written};
use crate::canopen::{Abort, Present};
use crate::time::Instant;
use heapless::Vec;

/// The data of a block of a download, 31 segments of 7 bytes.
const BLOCK: usize = 31 * 7;

/// What the client commands, after the reply is sent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Command {
    /// Starts the program.
    Start,
    /// Restarts the bootloader, which starts the program.
    Restart,
}

/// An object of the bootloader.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Object {
    /// A number of this size in bytes that can only be read.
    Number(u32, u8),
    /// 1F50h:01.
    Data,
    /// 1F51h:01.
    Control,
}

/// The update of the program in a slot `S`: the bootloader without its driver.
#[derive(Debug)]
pub struct Update<S> {
    slot: S,
    device: Device,
    record: Record,
    program: Program,
    loader: Loader,
    command: Option<Command>,
}

/// The SDO server of an [`Update`].
pub type UpdateServer = Server<Object, Vec<u8, BLOCK>, Present<Block>>;

impl<S: Slot> Update<S> {
    /// The bootloader of this device. An update that needs only its commit is completed.
    pub fn new(mut slot: S, device: Device, record: Record) -> Self {
        let program = Program::of(&slot);
        // If the flash fails, the program is loaded again.
        let program = program.complete(&mut slot).unwrap_or(Program::None);
        Self {
            slot,
            device,
            record,
            program,
            loader: Loader::new(),
            command: None,
        }
    }

    /// The program that can be started.
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// What the client has commanded, once. The driver performs it when the reply is sent.
    pub fn command(&mut self) -> Option<Command> {
        self.command.take()
    }

    /// 1F57h:01. Without a download, it tells whether there is a program.
    fn status(&self) -> Status {
        match (self.loader.status(), self.program) {
            (Status::Good, Program::None) if !self.loader.is_open() => Status::NoProgram,
            (status, _) => status,
        }
    }

    fn control(&mut self, value: u8) -> Result<(), Abort> {
        match (value, self.program) {
            (1, Program::Complete(_)) => self.command = Some(Command::Start),
            (1, _) => return Err(Abort::DeviceState),
            (2, _) => self.command = Some(Command::Restart),
            (3, _) => self.loader.clear(),
            (PERMIT_DOWNGRADE, _) => self.loader.permit_downgrade(),
            _ => return Err(Abort::Value),
        }
        Ok(())
    }
}

/// The value of 1F51h:01 that permits a lower version in the next download.
const PERMIT_DOWNGRADE: u8 = 0x81;

impl<S: Slot> Objects for Update<S> {
    type Object = Object;
    type Text = Vec<u8, BLOCK>;
    const WRITABLE: usize = header::SIZE + S::SIZE;

    fn find(&self, Address { index, sub }: Address) -> Result<Object, Abort> {
        let header = self.program.header();
        let number = |value: u32| Ok(Object::Number(value, 4));
        match (index, sub) {
            (0x1000, 0) => number(0),
            (0x1001, 0) => Ok(Object::Number(header.is_none().into(), 1)),
            (0x1018, 0) => Ok(Object::Number(4, 1)),
            (0x1018, 1) => number(self.record.vendor),
            (0x1018, 2) => number(self.record.product_code),
            (0x1018, 3) => number(header.map_or(0, |header| header.version)),
            (0x1018, 4) => number(self.record.serial),
            (0x1F50 | 0x1F51 | 0x1F56 | 0x1F57, 0) => Ok(Object::Number(1, 1)),
            (0x1F50, 1) => Ok(Object::Data),
            (0x1F51, 1) => Ok(Object::Control),
            (0x1F56, 1) => number(header.map_or(0, |header| header.body)),
            (0x1F57, 1) => number(self.status() as u32),
            (0x1000 | 0x1001 | 0x1018 | 0x1F50 | 0x1F51 | 0x1F56 | 0x1F57, _) => {
                Err(Abort::NoSubIndex)
            }
            _ => Err(Abort::NoObject),
        }
    }

    fn check_read(&self, object: Object, _sub: u8) -> Result<(), Abort> {
        match object {
            Object::Data => Err(Abort::WriteOnly),
            Object::Number(..) | Object::Control => Ok(()),
        }
    }

    fn is_writable(object: Object) -> bool {
        matches!(object, Object::Data | Object::Control)
    }

    fn size(object: Object) -> u8 {
        match object {
            Object::Number(_, size) => size,
            Object::Control => 1,
            Object::Data => 0,
        }
    }

    fn number(&self, object: Object, _sub: u8) -> u32 {
        match object {
            Object::Number(value, _) => value,
            // The bootloader runs: the program is stopped.
            Object::Control | Object::Data => 0,
        }
    }

    fn text(&self, _object: Object) -> Self::Text {
        Vec::new()
    }

    fn take(&mut self, _now: Instant, address: Address, data: &[u8]) -> Result<bool, Abort> {
        let is_file = self.find(address) == Ok(Object::Data);
        if is_file {
            self.loader
                .take(&mut self.slot, &self.device, &mut self.program, data)?;
        }
        Ok(is_file)
    }

    fn write(&mut self, _now: Instant, object: Object, data: &[u8]) -> Result<Written, Abort> {
        match (object, data) {
            (Object::Data, _) => {
                let (slot, program) = (&mut self.slot, &mut self.program);
                self.loader.take(slot, &self.device, program, data)?;
                self.loader.finish(slot, program)?;
            }
            (Object::Control, [value]) => self.control(*value)?,
            _ => return Err(Abort::Length),
        }
        Ok(Written::Done)
    }
}

impl From<Failure> for Abort {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Unfit(Unfit::Damaged) | Failure::Data => Self::Signature,
            Failure::Unfit(Unfit::Older) | Failure::NotCleared => Self::DeviceState,
            Failure::Unfit(_) => Self::Value,
            Failure::Length => Self::Length,
            Failure::Slot => Self::Hardware,
        }
    }
}

#[cfg(test)]
mod tests;
