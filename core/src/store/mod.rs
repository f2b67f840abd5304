//! The nonvolatile memory: records in two slots of flash. A new record is appended until the slot is full.
//!
//! There are four kinds of records: the parameters of a product, written by each save, and three records of the device: its calibration
//! and the identity of the unit ([`mod@unit`]), each written once, and its [usage](mod@usage). Layout of a record:
//!
//! ```text
//!  byte 0      1         2       4          8        10          10 + n ...     p            p + 4
//!       +------+---------+-------+----------+--------+-----------+--------------+------------+
//!       | 'P'  | version | kind  | sequence | length | payload   | 00h padding  | CRC-32     |
//!       | 50h  | 01h     | u16   | u32      | u16 n  | n bytes   | to 4 bytes   | of 0..p    |
//!       +------+---------+-------+----------+--------+-----------+--------------+------------+
//!
//!  payload of parameters     layout, u8; check of the device, u8; the stored parameters in the order of the table
//!  payload of a calibration  layout 01h; serial number, u32; calibration, 49 bytes, in old records 48 or 36
//!  payload of an identity    mark 55h; product, u16; the fields that are given
//!  payload of a usage        layout 02h; serial number, u32; the numbers, 22 bytes
//! ```
//!
//! Numbers are little-endian. The kind of parameters is 8000h + the [`ImageId`] of the product, the kind of the records of the
//! device is 0. The CRC is CRC-32/ISO-HDLC (the CRC of Ethernet and zip). It is programmed last, so an incomplete record has a wrong
//! CRC. Erased memory reads FFh.
//!
//! **Parameters** are decoded as a prefix. A newer firmware with additional parameters reads the record of an older one and gives
//! the new parameters their factory values. An older firmware ignores the parameters that it does not have. Records with another
//! layout are not decoded. **A calibration** belongs to the chip with its serial number; another chip ignores it. **An identity**
//! belongs to the product; another product ignores it. It does not belong to a chip, because it says who the unit is, whatever its
//! chip. The record of parameters contains the lowest byte of the CRC of calibration and identity (0: neither), so that a lost
//! record is detected. Old records, from before the calibration had its own record, are also read: their kind is the [`ImageId`],
//! and their payload is the parameters followed by the calibration.
//!
//! ```text
//!  slot 0  | calibration | identity | parameters 7 | parameters 8 | parameters 9 | (full)
//!  slot 1  | calibration | identity | usage | parameters 10 | usage | erased       <- position of the next record
//! ```
//!
//! A slot is half of the memory. The newest parameters are never erased or overwritten. The next record is written after them.
//! When the slot is full, it is written to the start of the other slot, after copies of the records of the device that there are.
//! The other slot is erased in advance at boot ([`Store::prepare`]), because erasing stalls the processor. Only data that can be
//! newer than the newest valid parameters is reported as damaged; older invalid data is ignored.
//!
//! **A usage** is written while the device runs ([`Store::keep`]), only into room that saves do not need, and without an erase. If the slot
//! is full, it is written to the other one, if that is erased, with copies of all other records; the next boot erases the full slot. The
//! first word is programmed last: so an incomplete usage differs from an incomplete save. A usage belongs to the chip with its serial
//! number. It is not part of the check of calibration and identity.

mod buffer;
mod record;
mod slots;
mod survey;
pub mod unit;
pub mod usage;

pub use buffer::{Buffer, Records};
pub use record::{buffer_size, crc32};
pub use slots::Store;
pub use unit::{Name, Unit};
pub use usage::Usage;

use crate::diagnosis::ResetCauses;
use crate::measure::Calibration;
use crate::measure::calibration::Part;
use crate::update::Installed;

/// Identifies the stored parameters of a product, so that a product does not use the parameters of another one. From 1 to 7FFFh; a product
/// outside of this crate takes one from 7000h on, because those below are for the products of the crate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ImageId(u16);

impl ImageId {
    /// The id with this number.
    ///
    /// # Panics
    /// If the number is not from 1 to 7FFFh. In a constant this is a compile error.
    #[track_caller]
    pub const fn new(number: u16) -> Self {
        assert!(
            number >= 1 && number < 0x8000,
            "the number of an `ImageId` is 1 to 7FFFh"
        );
        Self(number)
    }

    /// The number in the record, 1 to 7FFFh.
    pub const fn number(self) -> u16 {
        self.0
    }
}

/// The owner of the records in a [`Store`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Owner {
    /// The product to which the parameters belong.
    pub image: ImageId,
    /// The version of the stored layout ([`Table::LAYOUT`](crate::param::Table::LAYOUT)) of the product.
    pub layout: u8,
    /// The serial number of the chip.
    pub serial: u32,
}

/// Error: a record could not be written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StoreError;

/// The contents of the memory at the start of the device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Boot<'a> {
    /// The newest stored parameters in the format of [`Parameters::decode`](crate::param::Parameters::decode); None: use the
    /// factory values.
    pub parameters: Option<&'a [u8]>,
    /// The calibration of the device; [`Calibration::IDENTITY`] if there is none.
    pub calibration: Calibration,
    /// True if data newer than the parameters is damaged, if the calibration or the identity is lost, or if the memory is not blank
    /// but has no valid parameters.
    pub damaged: bool,
    /// The serial number of the chip.
    pub serial: u32,
    /// What [`Node::kept`](crate::node::Node::kept) returned before a restart by the program; 0 after power-up.
    pub kept: u32,
    /// The identity of the unit; [`Unit::NONE`] if there is none.
    pub unit: Unit,
    /// The usage of the device until this start.
    pub usage: Usage,
    /// The causes of this start; none if the board does not tell them.
    pub causes: ResetCauses,
    /// The program, if a [bootloader](crate::update) has started it; None: there is no bootloader.
    pub program: Option<Installed>,
}

impl Boot<'_> {
    /// Removes the calibration if it is not that of this part: the errors of another part are others. Returns false if it was removed.
    pub fn fit(&mut self, part: Part) -> bool {
        let fits = self.calibration.part() == part || self.calibration == Calibration::IDENTITY;
        if !fits {
            self.calibration = Calibration::IDENTITY;
        }
        fits
    }
}

impl Default for Boot<'_> {
    /// A blank memory, serial number 0.
    fn default() -> Self {
        Self {
            parameters: None,
            calibration: Calibration::IDENTITY,
            damaged: false,
            serial: 0,
            kept: 0,
            unit: Unit::NONE,
            usage: Usage::NONE,
            causes: ResetCauses::NONE,
            program: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calibration_of_another_part_is_removed() {
        let own = Calibration::new([1, 2, 3], [[0; 3]; 3], [0; 3])
            .unwrap()
            .of(Part::Adxl355);
        for (calibration, part, fits) in [
            (own, Part::Adxl355, true),
            (own, Part::Ism330dhcx, false),
            (Calibration::IDENTITY, Part::Adxl355, true),
            (Calibration::IDENTITY, Part::Ism330dhcx, true),
        ] {
            let mut boot = Boot {
                calibration,
                ..Boot::default()
            };
            assert_eq!(boot.fit(part), fits);
            let kept = if fits {
                calibration
            } else {
                Calibration::IDENTITY
            };
            assert_eq!(boot.calibration, kept);
        }
    }
}
