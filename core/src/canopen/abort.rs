//! The SDO abort codes (CiA 301, 7.2.4.3.17).

use crate::param::Refused;

/// The reason for the abort of an SDO transfer. The discriminant is the abort code, with which the descriptions begin.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)]
pub enum Abort {
    /// 0503 0000h: the toggle bit did not alternate.
    Toggle = 0x0503_0000,
    /// 0504 0000h: SDO protocol timed out: the next segment did not come in time.
    TimeOut = 0x0504_0000,
    /// 0504 0001h: the command specifier is unknown, or not valid without a transfer.
    Command = 0x0504_0001,
    /// 0504 0002h: the block size is not 1 to 127.
    BlockSize = 0x0504_0002,
    /// 0504 0003h: block transfer: the sequence number is not valid.
    SequenceNumber = 0x0504_0003,
    /// 0504 0004h: block transfer: the CRC is wrong.
    Crc = 0x0504_0004,
    /// 0601 0000h: the access is not supported now: the TPDO is valid, or its number of mapped objects is not 0.
    Access = 0x0601_0000,
    /// 0601 0001h: read of a write-only object.
    WriteOnly = 0x0601_0001,
    /// 0601 0002h: write to a read-only object.
    ReadOnly = 0x0601_0002,
    /// 0602 0000h: the object does not exist in the object dictionary.
    NoObject = 0x0602_0000,
    /// 0604 0041h: the object cannot be mapped, or not with this length.
    NotMappable = 0x0604_0041,
    /// 0604 0042h: the mapped objects are too many or too long for the PDO.
    TooManyMapped = 0x0604_0042,
    /// 0604 0043h: the value is incompatible with another object: two entries monitor the same node.
    Incompatible = 0x0604_0043,
    /// 0606 0000h: access failed because the nonvolatile memory failed.
    Hardware = 0x0606_0000,
    /// 0607 0010h: the length of the data does not match the announced size.
    Length = 0x0607_0010,
    /// 0607 0012h: the data is longer than the object.
    TooLong = 0x0607_0012,
    /// 0607 0013h: the data is shorter than the object.
    TooShort = 0x0607_0013,
    /// 0609 0011h: the sub-index does not exist.
    NoSubIndex = 0x0609_0011,
    /// 0609 0030h: the value is not permitted.
    Value = 0x0609_0030,
    /// 0609 0031h: the value is above the permitted range.
    TooHigh = 0x0609_0031,
    /// 0609 0032h: the value is below the permitted range.
    TooLow = 0x0609_0032,
    /// 0800 0020h: the signature is wrong. Nothing is stored or restored.
    Signature = 0x0800_0020,
    /// 0800 0021h: the device itself does not permit it: a program without the signature of its key.
    LocalControl = 0x0800_0021,
    /// 0800 0022h: not possible in the present state of the device.
    DeviceState = 0x0800_0022,
    /// 0800 0024h: there is nothing to read, as for an error in the history that did not occur.
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
