//! The nonvolatile memory: records in two slots of flash, appended until a slot is full.
//!
//! There are two kinds of records: the parameters of a product, written by each save, and the calibration of the unit, written
//! once. A record lies in memory like this:
//!
//! ```text
//!  byte 0      1         2       4          8        10          10 + n ...     p            p + 4
//!       +------+---------+-------+----------+--------+-----------+--------------+------------+
//!       | 'P'  | version | kind  | sequence | length | payload   | 00h padding  | CRC-32     |
//!       | 50h  | 01h     | u16   | u32      | u16 n  | n bytes   | to 4 bytes   | of 0..p    |
//!       +------+---------+-------+----------+--------+-----------+--------------+------------+
//!
//!  payload of parameters     layout, bits 0 to 6, and bit 7: there is a calibration; the stored parameters in the order of the table
//!  payload of a calibration  layout 01h; serial number, u32; calibration, 36 bytes
//! ```
//!
//! Numbers are little-endian. The kind of parameters is 8000h + the product's [`ImageId`], that of a calibration 0. The CRC is CRC-32/ISO-HDLC (the one of
//! Ethernet and zip); it is programmed last, so a record that was cut off does not check. Erased memory reads FFh.
//!
//! **Parameters** decode as a prefix: a newer firmware that has added parameters to its table reads the record of an older one, and
//! gives the new parameters their factory values; an older firmware ignores what it does not know. Another layout is not
//! decoded. **A calibration** belongs to the unit whose serial number it carries; in the memory of another unit it is
//! ignored. Parameters say whether the unit had a calibration when they were saved, so that the loss of it is noticed. Records of
//! firmware before the calibration had a record of its own are read too: their kind is the [`ImageId`], their payload the
//! parameters, then the calibration.
//!
//! ```text
//!  slot 0  | calibration | parameters 7 | parameters 8 | parameters 9 | (full)
//!  slot 1  | calibration | parameters 10 | erased                              <- the next record goes here
//! ```
//!
//! A slot is half of the memory. The newest parameters are never touched: the next record goes behind them, and when the slot is
//! full to the start of the other one, which is erased ahead at boot ([`Store::prepare`]) because erasing stalls the
//! processor. The calibration is written there first. Only what could be newer than the newest whole parameters counts as
//! damage; older debris does not.

mod record;
mod slots;
mod survey;

pub use record::buffer_size;
pub use slots::Store;

use crate::measure::Calibration;

/// Marks the parameters of a product, so that those of another one are not taken for its own; from 1 to 7FFFh.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ImageId(u16);

impl ImageId {
    /// The mark with this number.
    ///
    /// # Panics
    /// The number is not from 1 to 7FFFh; in a constant this does not compile.
    pub const fn new(number: u16) -> Self {
        assert!(number >= 1 && number < 0x8000);
        Self(number)
    }

    /// The number.
    pub const fn number(self) -> u16 {
        self.0
    }
}

/// Whose records a [`Store`] holds.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Owner {
    /// The product.
    pub image: ImageId,
    /// The version of the product's stored layout ([`Table::LAYOUT`](crate::param::Table::LAYOUT)), below 80h.
    pub layout: u8,
    /// The serial number of the unit.
    pub serial: u32,
}

/// A record could not be written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StoreError;

/// What the memory held when the unit started.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Boot<'a> {
    /// The newest stored parameters, as [`Parameters::decode`](crate::param::Parameters::decode) takes them; None: use the factory
    /// values.
    pub parameters: Option<&'a [u8]>,
    /// The calibration of the unit; [`Calibration::IDENTITY`] when it has none.
    pub calibration: Calibration,
    /// Something newer than the parameters is damaged, or the calibration is lost, or nothing is whole although the memory is not
    /// blank.
    pub damaged: bool,
    /// The serial number of the unit.
    pub serial: u32,
}

impl Default for Boot<'_> {
    /// A blank memory, serial number 0.
    fn default() -> Self {
        Self {
            parameters: None,
            calibration: Calibration::IDENTITY,
            damaged: false,
            serial: 0,
        }
    }
}
