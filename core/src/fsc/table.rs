//! The description of a product with the FSC protocol: function select codes, contents of the replies, status byte and LEDs.
//!
//! The description is the source of the descriptors (DBC) and documents on a PC. The device uses [`Codes`], which
//! [`project!(functions)`](crate::project) derives from it.

use super::projection::Codes;
use super::status::StatusBit;
use crate::application::Application;
use crate::can::BitRate;
use crate::mistake::{Mistake, Origin};
use crate::node::{Context, ErrorPatterns, Pattern};
use crate::param::{DataType, Parameter, ParameterId, ParameterSet, Quantity, ValueId};
use crate::store::ImageId;
use crate::text::Text;
use crate::walk::each;

/// The source of a number in the data bytes of a reply.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Source {
    /// The value in force of this parameter.
    Parameter(ParameterId),
    /// A value that the application has published.
    Value(ValueId),
    /// The counter of cyclic mode. While cyclic mode is off, the reply ends before it.
    Counter,
    /// The digits of the article number.
    ProductNumber,
    /// The revision of the article, or of the unit record if that has one.
    Revision,
    /// The serial number of the device.
    SerialNumber,
    /// The software version of the article, which also is in the boot-up message.
    SoftwareVersion,
    /// The identifier of requests that is in force until the next restart.
    ActiveSetId,
}

impl Source {
    /// The type of the number.
    pub const fn data_type(self, parameters: &[Parameter], quantities: &[Quantity]) -> DataType {
        match self {
            Self::Parameter(id) => id.data_type(parameters),
            Self::Value(id) => id.data_type(quantities),
            Self::ProductNumber | Self::SerialNumber | Self::ActiveSetId => DataType::U32,
            Self::Counter | Self::Revision | Self::SoftwareVersion => DataType::U16,
        }
    }
}

/// A number in the data bytes of a reply.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Field {
    /// What the reply contains at this place.
    pub source: Source,
    /// Its name; empty for a parameter or a value, which has its own name.
    pub name: &'static str,
}

impl Field {
    /// A parameter or a value.
    pub const fn described(source: Source) -> Self {
        Self { source, name: "" }
    }
}

/// The operation of a function.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Operation {
    /// Replies with the fields of the row.
    Read,
    /// Replies with the inclination. The same reply is sent after a sync frame and in cyclic mode.
    Inclination,
    /// Replies, then clears the sticky bits of the status byte.
    ReadStatus,
    /// Writes the parameters of its [`Access`] from the data.
    Write,
    /// Loads the factory values, if the data is the signature.
    Load,
    /// Saves the parameters, if the data is the signature.
    Save,
    /// Restarts the sensor if the data is the signature; without data it replies. The same reply is the boot-up message.
    Alive,
    /// A function of the product, in [`Product::OWN`].
    Own,
}

/// The function of a code with [`Operation::Own`].
pub struct Own<A: Application> {
    /// The function select code, which has a [`Function`] with [`Operation::Own`].
    pub code: u8,
    /// Handles the data of a request. Returns the data of the reply, or None: the request is refused and has changed nothing. The
    /// function may write parameters ([`Context::write`], [`Context::apply`]), but begins no save: a master saves with
    /// [`Operation::Save`].
    pub serve: fn(&mut Context<A>, &[u8]) -> Option<Text<6>>,
}

/// Parameters that are read and written together: rows of tables 17 and 18.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Access {
    /// The function select code that reads them.
    pub read: u8,
    /// The function select code that writes them.
    pub write: u8,
    /// The name of the function in the manual.
    pub name: &'static str,
    /// The parameters in the order of their bytes; at most six bytes in total.
    pub parameters: &'static [ParameterId],
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

impl Access {
    /// The code that reads and the one that writes these parameters.
    #[track_caller]
    pub const fn new(
        read: u8,
        write: u8,
        name: &'static str,
        parameters: &'static [ParameterId],
    ) -> Self {
        Self {
            read,
            write,
            name,
            parameters,
            origin: Origin::here(),
        }
    }

    /// A mistake in this row.
    pub(super) const fn mistake(&self) -> Mistake<'_> {
        Mistake::code(self.read, self.name).at(self.origin)
    }
}

/// A function that does not access parameters: a row of tables 17 and 18.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Function {
    /// The function select code: byte 0 of request and reply.
    pub code: u8,
    /// The name of the function in the manual.
    pub name: &'static str,
    /// What a request with this code does.
    pub operation: Operation,
    /// The signature in the data of the request; empty if there is none.
    pub signature: &'static [u8],
    /// The fields of the reply after the status byte.
    pub reply: &'static [Field],
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

impl Function {
    /// A function without signature whose reply has only the status byte.
    #[track_caller]
    pub const fn new(code: u8, name: &'static str, operation: Operation) -> Self {
        Self {
            code,
            name,
            operation,
            signature: b"",
            reply: &[],
            origin: Origin::here(),
        }
    }

    /// The same with a signature.
    pub const fn signed(self, signature: &'static [u8]) -> Self {
        Self { signature, ..self }
    }

    /// The same with these fields in the reply.
    pub const fn replying(self, reply: &'static [Field]) -> Self {
        Self { reply, ..self }
    }

    /// A mistake in this row.
    pub(super) const fn mistake(&self) -> Mistake<'_> {
        Mistake::code(self.code, self.name).at(self.origin)
    }
}

/// Run and error LED patterns (table 12).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LedTable {
    /// Run LED while the bit rate is being detected.
    pub detecting: Pattern,
    /// Run LED in normal operation.
    pub normal: Pattern,
    /// Error LED in each state of the bus.
    pub error: ErrorPatterns,
}

/// The parameters that the protocol itself uses.
#[derive(Clone, Copy, Debug)]
pub struct Roles {
    /// The identifier of the requests that the sensor receives.
    pub set_id: ParameterId,
    /// The identifier of the replies that the sensor sends.
    pub reply_id: ParameterId,
    /// The identifier of sync frames.
    pub sync_id: ParameterId,
    /// The code of the bit rate.
    pub bit_rate: ParameterId,
    /// The bit rates of its codes, from code 0; None: automatic detection.
    pub bit_rates: &'static [Option<BitRate>],
    /// Automatic bus-off recovery: 0 is off.
    pub bus_off_recovery: ParameterId,
    /// The cyclic time in ms.
    pub cyclic_time: ParameterId,
    /// Cyclic mode: 0 is off.
    pub cyclic_mode: ParameterId,
}

impl Roles {
    /// The bit rate code for automatic detection; None if there is none.
    pub(super) const fn automatic(&self) -> Option<u32> {
        each!(code, rate in self.bit_rates => {
            if rate.is_none() {
                return Some(code as u32);
            }
        });
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

/// A software version and its coding in two bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Version {
    /// v3.44 is 44h 03h: binary-coded decimal (types of 2021).
    Digits {
        /// The digits before the point, binary-coded decimal.
        major: u8,
        /// The digits after the point, binary-coded decimal.
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

/// An article number, for example PR-23054-30. On the bus it is the number of its digits: 2305430.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ArticleNumber {
    text: &'static str,
    digits: u32,
}

impl ArticleNumber {
    /// An article number of capital letters, dashes and up to nine digits.
    ///
    /// # Panics
    /// The text has another form; in a constant this does not compile.
    pub const fn new(text: &'static str) -> Self {
        let (mut digits, mut count) = (0, 0);
        each!(letter in text.as_bytes() => {
            if letter.is_ascii_digit() {
                digits = 10 * digits + (*letter - b'0') as u32;
                count += 1;
                assert!(count <= 9, "an article number has at most nine digits");
            } else {
                assert!(
                    *letter == b'-' || letter.is_ascii_uppercase(),
                    "an article number has capital letters, dashes and digits"
                );
            }
        });
        Self { text, digits }
    }

    /// The text, for example `PR-23054-30`.
    pub const fn text(self) -> &'static str {
        self.text
    }

    /// Its digits as a number.
    pub const fn digits(self) -> u32 {
        self.digits
    }
}

/// An article of a product: the data that differ between lines and housings.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Article {
    /// The type name, for example `IS2BP090-C-CL`.
    pub name: &'static str,
    /// The number under which the maker sells it. Its digits are in a reply.
    pub number: ArticleNumber,
    /// The revision that the sensor reports, unless its unit record has another one.
    pub revision: u16,
    /// The software version that the sensor reports.
    pub version: Version,
    /// 1-axis: the largest cross slope; 2-axis: the largest inclination without a sensor error; in 0.01 deg.
    pub limit: u16,
    /// The identification of its stored images.
    pub image: ImageId,
}

/// A product with the FSC protocol.
///
/// [`project!(functions)`](crate::project) derives [`CODES`](Self::CODES) from the description.
pub trait Product: Sized + Send + 'static {
    /// What the product measures, and what it does with the numbers that masters write.
    type Application: Application;

    /// The parameters that the protocol uses.
    const ROLES: Roles;
    /// The codes that read and write parameters, in the order of the read codes.
    const ACCESS: &'static [Access];
    /// The other functions, in the order of their codes.
    const FUNCTIONS: &'static [Function];
    /// The functions of the codes with [`Operation::Own`], in the order of their codes.
    const OWN: &'static [Own<Self::Application>] = &[];
    /// The status byte, from bit 0 on.
    const STATUS: [StatusBit; 8];
    /// The LED patterns while the bit rate is being detected and in operation.
    const LEDS: LedTable;

    /// The codes in the form that the device uses.
    const CODES: Codes;

    /// Configures the application for an article.
    fn set_article(application: &mut Self::Application, article: &Article);
}
