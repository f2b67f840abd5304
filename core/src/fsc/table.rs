//! How a product that speaks FSC is described: its function select codes, what each reply carries, the status byte, the LEDs.
//!
//! The description is for people and tools: descriptors (DBC) and documents on a PC come from it. The device works on
//! [`Codes`], which [`project_functions!`](crate::project_functions) derives from it.

use super::projection::Codes;
use super::status::StatusBit;
use crate::application::Application;
use crate::can::BitRate;
use crate::node::{ErrorPatterns, Pattern};
use crate::param::{DataType, Parameter, ParameterId, ParameterSet, Quantity, ValueId};
use crate::store::ImageId;

/// Where a number in the data bytes of a reply comes from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Source {
    /// A parameter.
    Parameter(ParameterId),
    /// A value that the application has published.
    Value(ValueId),
    /// The counter of cyclic mode; it and what follows is left out while that is off.
    Counter,
    /// The digits of the article number.
    ProductNumber,
    /// The revision.
    Revision,
    /// The serial number of the unit.
    SerialNumber,
    /// The software version.
    SoftwareVersion,
    /// The Set-Parameter-ID in force.
    ActiveSetId,
}

impl Source {
    /// The type of the number.
    #[allow(clippy::indexing_slicing)] // evaluated at compile time only
    pub const fn data_type(self, parameters: &[Parameter], quantities: &[Quantity]) -> DataType {
        match self {
            Self::Parameter(id) => parameters[id.0 as usize].data_type,
            Self::Value(id) => quantities[id.0 as usize].data_type,
            Self::ProductNumber | Self::SerialNumber | Self::ActiveSetId => DataType::U32,
            Self::Counter | Self::Revision | Self::SoftwareVersion => DataType::U16,
        }
    }
}

/// A number in the data bytes of a reply.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Field {
    /// Where it comes from.
    pub source: Source,
    /// What it is; empty for a parameter or a value, which have a name of their own.
    pub name: &'static str,
}

impl Field {
    /// A parameter or a value.
    pub const fn described(source: Source) -> Self {
        Self { source, name: "" }
    }
}

/// What a function does.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Operation {
    /// Replies.
    Read,
    /// Replies with the inclination; its reply is also sent on a sync frame and in cyclic mode.
    Inclination,
    /// Replies, then clears the sticky bits of the status byte.
    ReadStatus,
    /// Writes parameters.
    Write,
    /// Loads the factory values, with the signature as data.
    Load,
    /// Saves the parameters, with the signature as data.
    Save,
    /// Restarts the sensor with the signature as data; replies without data. Its reply is also the boot-up message.
    Alive,
}

/// Parameters that are read and written together: rows of tables 17 and 18.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Access {
    /// The function select code that reads them.
    pub read: u8,
    /// The function select code that writes them.
    pub write: u8,
    /// The manual's name.
    pub name: &'static str,
    /// The parameters in the order of their bytes; at most six bytes together.
    pub parameters: &'static [ParameterId],
}

/// A function that is not access to parameters: a row of tables 17 and 18.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Function {
    /// Its function select code.
    pub code: u8,
    /// The manual's name.
    pub name: &'static str,
    /// What it does.
    pub operation: Operation,
    /// The signature that the request carries; empty when there is none.
    pub signature: &'static [u8],
    /// The fields of the reply behind the status byte.
    pub reply: &'static [Field],
}

/// Run and error LED patterns (table 12).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LedTable {
    /// Run LED while the bit rate is being detected.
    pub detecting: Pattern,
    /// Run LED in normal operation.
    pub normal: Pattern,
    /// Error LED.
    pub error: ErrorPatterns,
}

/// The parameters by which the protocol itself works.
#[derive(Clone, Copy, Debug)]
pub struct Roles {
    /// The identifier of requests.
    pub set_id: ParameterId,
    /// The identifier of replies.
    pub reply_id: ParameterId,
    /// The identifier of sync frames.
    pub sync_id: ParameterId,
    /// The code of the bit rate.
    pub bit_rate: ParameterId,
    /// What its codes stand for, from 0 on; None: automatic detection.
    pub bit_rates: &'static [Option<BitRate>],
    /// Automatic bus-off recovery: 0 is off.
    pub bus_off_recovery: ParameterId,
    /// The cyclic time in ms.
    pub cyclic_time: ParameterId,
    /// Cyclic mode: 0 is off.
    pub cyclic_mode: ParameterId,
}

impl Roles {
    /// The code of the bit rate that stands for automatic detection; None without it.
    #[allow(clippy::indexing_slicing)] // evaluated at compile time only
    pub(super) const fn automatic(&self) -> Option<u32> {
        let mut row = 0;
        while row < self.bit_rates.len() {
            if self.bit_rates[row].is_none() {
                return Some(row as u32);
            }
            row += 1;
        }
        None
    }

    /// The parameters that only the protocol uses.
    pub(super) const fn own(&self) -> ParameterSet {
        ParameterSet::of(&[
            self.set_id,
            self.reply_id,
            self.sync_id,
            self.bit_rate,
            self.bus_off_recovery,
            self.cyclic_time,
            self.cyclic_mode,
        ])
    }
}

/// How a software version is written as two bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Version {
    /// v3.44 is 44h 03h: the digits in hexadecimal (types of 2021).
    Digits {
        /// Digits before the point, as decimal digits in hexadecimal.
        major: u8,
        /// Digits behind the point, likewise.
        minor: u8,
    },
    /// v01.03 is 103 (older types).
    Number(u16),
}

impl Version {
    /// SWV0 and SWV1 as one little-endian number.
    pub const fn code(self) -> u16 {
        match self {
            Self::Digits { major, minor } => u16::from_le_bytes([minor, major]),
            Self::Number(number) => number,
        }
    }
}

/// An article number, for example PR-23054-30. On the wire it is a number of its digits: 2305430.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ArticleNumber {
    text: &'static str,
    digits: u32,
}

impl ArticleNumber {
    /// The number with this text: capital letters, dashes, and up to nine digits.
    ///
    /// # Panics
    /// The text has another form; in a constant this does not compile.
    #[allow(clippy::indexing_slicing)] // evaluated at compile time only
    pub const fn new(text: &'static str) -> Self {
        let bytes = text.as_bytes();
        let (mut digits, mut count, mut place) = (0, 0, 0);
        while place < bytes.len() {
            if bytes[place].is_ascii_digit() {
                digits = 10 * digits + (bytes[place] - b'0') as u32;
                count += 1;
                assert!(count <= 9, "an article number has at most nine digits");
            } else {
                assert!(
                    bytes[place] == b'-' || bytes[place].is_ascii_uppercase(),
                    "an article number has capital letters, dashes and digits"
                );
            }
            place += 1;
        }
        Self { text, digits }
    }

    /// The text, as the maker prints it.
    pub const fn text(self) -> &'static str {
        self.text
    }

    /// Its digits as a number.
    pub const fn digits(self) -> u32 {
        self.digits
    }
}

/// An article of a product: what differs between lines and housings.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Article {
    /// The type name, for example `IS2BP090-C-CL`.
    pub name: &'static str,
    /// The article number.
    pub number: ArticleNumber,
    /// The revision.
    pub revision: u16,
    /// The software version that it reports.
    pub version: Version,
    /// 1-axis: the largest cross slope; 2-axis: the largest inclination without a sensor error. In 0.01 deg.
    pub limit: u16,
    /// Marks its images in nonvolatile memory.
    pub image: ImageId,
}

/// A product that speaks FSC.
///
/// [`project_functions!`](crate::project_functions) derives [`CODES`](Self::CODES) from the description.
pub trait Product: 'static {
    /// What it measures and does.
    type Application: Application;

    /// The parameters by which the protocol works.
    const ROLES: Roles;
    /// The codes that read and write parameters, in the order of the reading codes.
    const ACCESS: &'static [Access];
    /// The other functions, in the order of their codes.
    const FUNCTIONS: &'static [Function];
    /// The status byte, from bit 0 on.
    const STATUS: [StatusBit; 8];
    /// What the LEDs show.
    const LEDS: LedTable;

    /// What the device keeps of the codes.
    const CODES: Codes;

    /// Makes the application that of an article.
    fn set_article(application: &mut Self::Application, article: &Article);
}
