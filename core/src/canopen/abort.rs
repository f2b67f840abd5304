//! The SDO abort codes (CiA 301, 7.2.4.3.17).

use crate::param::Refused;

/// The reason for the abort of an SDO transfer. The discriminant is the abort code.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)]
pub enum Abort {
    /// The toggle bit did not alternate.
    Toggle = 0x0503_0000,
    /// SDO protocol timed out: the next segment did not come in time.
    TimeOut = 0x0504_0000,
    /// The command specifier is unknown, or not valid without a transfer.
    Command = 0x0504_0001,
    /// The block size is not 1 to 127.
    BlockSize = 0x0504_0002,
    /// Block transfer: the sequence number is not valid.
    SequenceNumber = 0x0504_0003,
    /// Block transfer: the CRC is wrong.
    Crc = 0x0504_0004,
    /// The access is not supported now: the TPDO is valid, or its number of mapped objects is not 0.
    Access = 0x0601_0000,
    /// Read of a write-only object.
    WriteOnly = 0x0601_0001,
    /// Write to a read-only object.
    ReadOnly = 0x0601_0002,
    /// The object does not exist in the object dictionary.
    NoObject = 0x0602_0000,
    /// The object cannot be mapped, or not with this length.
    NotMappable = 0x0604_0041,
    /// The mapped objects are too many or too long for the PDO.
    TooManyMapped = 0x0604_0042,
    /// The value is incompatible with another object: two entries monitor the same node.
    Incompatible = 0x0604_0043,
    /// Access failed because the nonvolatile memory failed.
    Hardware = 0x0606_0000,
    /// The length of the data does not match the announced size.
    Length = 0x0607_0010,
    /// The data is longer than the object.
    TooLong = 0x0607_0012,
    /// The data is shorter than the object.
    TooShort = 0x0607_0013,
    /// The sub-index does not exist.
    NoSubIndex = 0x0609_0011,
    /// The value is not permitted.
    Value = 0x0609_0030,
    /// The value is above the permitted range.
    TooHigh = 0x0609_0031,
    /// The value is below the permitted range.
    TooLow = 0x0609_0032,
    /// The signature is wrong. Nothing is stored or restored.
    Signature = 0x0800_0020,
    /// Not possible in the present state of the device.
    DeviceState = 0x0800_0022,
    /// There is nothing to read, as for an error in the history that did not occur.
    NoData = 0x0800_0024,
}

impl From<Refused> for Abort {
    fn from(refused: Refused) -> Self {
        match refused {
            Refused::TooLow => Self::TooLow,
            Refused::TooHigh => Self::TooHigh,
            Refused::NotPermitted => Self::Value,
            Refused::State => Self::DeviceState,
        }
    }
}
