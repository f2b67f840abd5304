//! The objects of the bootloader (CiA 301 and CiA 302-3).
//!
//! | object | type | access | |
//! |---|---|---|---|
//! | 1000h | u32 | ro | 0: no device profile, so that a master sees that this is not the sensor |
//! | 1001h | u8 | ro | error register: 01h without a program |
//! | 1018h | u32 | ro | vendor, product code, revision (version of the program, or 0) and serial number of the sensor, as in the boot record |
//! | 1F50h:01 | domain | wo | the image file |
//! | 1F51h:01 | u8 | rw | 1: start the program, 2: restart the bootloader, 3: clear, 81h: permit a lower version in the next download; reads 0 |
//! | 1F56h:01 | u32 | ro | the CRC of the program; 0: none |
//! | 1F57h:01 | u32 | ro | the [`Status`] of the last download |
//!
//! A download is refused with 0609 0030h if the image is for another device, with 0800 0021h
//! if the signature that the key of the sensor demands is missing or wrong, with 0800 0022h if it is older or if 1F51h = 3 did not come before,
//! with 0800 0020h if it is damaged, with 0607 0010h if its length is not that of its header, and with 0606 0000h if the flash fails.

use super::failure::Status;
use super::header::{self, Device, Header};
use super::lms::Signature;
use super::loader::Loader;
use super::record::Record;
use super::slot::{Program, Slot};
use crate::canopen::Abort;
use crate::canopen::sdo::message::Address;

/// The value of 1F51h:01 that permits a lower version in the next download.
const PERMIT_DOWNGRADE: u8 = 0x81;

/// The update of the program in a slot `S`: the bootloader without its driver.
#[derive(Debug)]
pub struct Update<S> {
    slot: S,
    device: Device,
    record: Option<Record>,
    program: Program,
    loader: Loader,
    /// The client has commanded a restart.
    restart: bool,
}

impl<S: Slot> Update<S> {
    /// The longest image file.
    const LONGEST: usize = header::SIZE
        + S::SIZE
        + match S::SIGNATURES {
            true => Signature::SIGNATURE,
            false => 0,
        };

    /// The bootloader of this device, whose slot has this program.
    pub fn new(slot: S, program: Program, device: Device, record: Option<Record>) -> Self {
        Self {
            slot,
            device,
            record,
            program,
            loader: Loader::new(),
            restart: false,
        }
    }

    /// The program that can be started.
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// Its slot.
    pub fn slot(&self) -> &S {
        &self.slot
    }

    /// Its slot, to change it.
    pub fn slot_mut(&mut self) -> &mut S {
        &mut self.slot
    }

    /// Its slot, to start the program.
    pub fn into_slot(self) -> S {
        self.slot
    }

    /// Whether the client has commanded a restart, once. The driver performs it when the reply is sent. Then the bootloader starts the
    /// program.
    pub fn take_restart(&mut self) -> bool {
        core::mem::take(&mut self.restart)
    }

    /// 1F57h:01. Without a download, it tells whether there is a program.
    fn status(&self) -> Status {
        match (self.loader.status(), self.program) {
            (Status::Good, Program::None) if !self.loader.is_open() => Status::NoProgram,
            (status, _) => status,
        }
    }

    /// The value of an object, and its size in bytes.
    pub fn read(&self, Address { index, sub }: Address) -> Result<(u32, u8), Abort> {
        let program = self.program.header();
        let record = self.record.as_ref();
        let number = match (index, sub) {
            (0x1018, 0) => return Ok((4, 1)),
            (0x1F50 | 0x1F51 | 0x1F56 | 0x1F57, 0) => return Ok((1, 1)),
            (0x1001, 0) => return Ok((program.is_none().into(), 1)),
            // The bootloader runs: the program is stopped.
            (0x1F51, 1) => return Ok((0, 1)),
            (0x1000, 0) => 0,
            (0x1018, 1) => record.map_or(0, Record::vendor),
            (0x1018, 2) => record.map_or(0, Record::product_code),
            (0x1018, 3) => program.map_or(0, Header::version),
            (0x1018, 4) => record.map_or(0, Record::serial),
            (0x1F50, 1) => return Err(Abort::WriteOnly),
            (0x1F56, 1) => program.map_or(0, Header::body),
            (0x1F57, 1) => u32::from(self.status() as u8),
            (0x1000 | 0x1001 | 0x1018 | 0x1F50 | 0x1F51 | 0x1F56 | 0x1F57, _) => {
                return Err(Abort::NoSubIndex);
            }
            _ => return Err(Abort::NoObject),
        };
        Ok((number, 4))
    }

    /// An expedited download of 1 to 4 bytes; None: as many as the object has.
    pub fn write(
        &mut self,
        address: Address,
        data: [u8; 4],
        length: Option<u8>,
    ) -> Result<(), Abort> {
        let [value, ..] = data;
        match (address.index, address.sub, length) {
            (0x1F51, 1, None | Some(1)) => self.control(value),
            (0x1F51, 1, Some(_)) => Err(Abort::TooLong),
            (0x1F50, 1, _) => Err(Abort::TooShort),
            _ => self.read(address).and(Err(Abort::ReadOnly)),
        }
    }

    fn control(&mut self, value: u8) -> Result<(), Abort> {
        match (value, self.program) {
            (1, Program::None | Program::Uncommitted(_)) => return Err(Abort::DeviceState),
            (1 | 2, _) => self.restart = true,
            (3, _) => self.loader.clear(),
            (PERMIT_DOWNGRADE, _) => self.loader.permit_downgrade(),
            _ => return Err(Abort::Value),
        }
        Ok(())
    }

    /// Begins a segmented or block download of this many bytes.
    pub fn begin(&self, address: Address, size: Option<u32>) -> Result<(), Abort> {
        match (address.index, address.sub) {
            (0x1F50, 1) if size.is_some_and(|size| size as usize > Self::LONGEST) => {
                Err(Abort::TooLong)
            }
            // Otherwise the rest of an interrupted download would be completed by the start of this one.
            (0x1F50, 1) if !self.loader.is_cleared() => Err(Abort::DeviceState),
            (0x1F50, 1) => Ok(()),
            // The other objects have at most four bytes.
            (0x1F51, 1) => Err(Abort::TooLong),
            _ => self.read(address).and(Err(Abort::ReadOnly)),
        }
    }

    /// Takes the next bytes of a download.
    pub fn take(&mut self, data: &[u8]) -> Result<(), Abort> {
        let (slot, program) = (&mut self.slot, &mut self.program);
        Ok(self.loader.take(slot, &self.device, program, data)?)
    }

    /// Ends a download.
    pub fn finish(&mut self) -> Result<(), Abort> {
        Ok(self.loader.finish(&mut self.slot, &mut self.program)?)
    }
}

#[cfg(test)]
mod tests;
