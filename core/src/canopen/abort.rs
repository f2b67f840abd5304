//! The SDO abort codes (CiA 301, 7.2.4.3.17).

use crate::param::Refused;

/// Why an SDO transfer was aborted.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)]
pub enum Abort {
    /// The toggle bit did not alternate.
    Toggle = 0x0503_0000,
    /// The next segment did not come in time.
    TimeOut = 0x0504_0000,
    /// The command is unknown, or there is no transfer that it could belong to.
    Command = 0x0504_0001,
    /// The object can be written only.
    WriteOnly = 0x0601_0001,
    /// The object can be read only.
    ReadOnly = 0x0601_0002,
    /// There is no such object.
    NoObject = 0x0602_0000,
    /// The nonvolatile memory failed.
    Hardware = 0x0606_0000,
    /// The data are not as long as was said.
    Length = 0x0607_0010,
    /// The data are longer than the object.
    TooLong = 0x0607_0012,
    /// The data are shorter than the object.
    TooShort = 0x0607_0013,
    /// There is no such sub-index.
    NoSubIndex = 0x0609_0011,
    /// The value is none of those that are permitted.
    Value = 0x0609_0030,
    /// The value is larger than permitted.
    TooHigh = 0x0609_0031,
    /// The value is smaller than permitted.
    TooLow = 0x0609_0032,
    /// The signature is wrong: nothing is stored or restored.
    Signature = 0x0800_0020,
    /// Not in the present state of the device.
    DeviceState = 0x0800_0022,
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
