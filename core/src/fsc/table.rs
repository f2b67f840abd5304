//! How a model is described: one table is the truth.
//!
//! The rich description ([`Model::PARAMETERS`], [`Model::FUNCTIONS`]) carries names, units and meanings; descriptors (DBC) and
//! documents on a PC come from it. The device itself only keeps the [`Rule`]s, which [`rules`] projects from it at compile
//! time: size, permitted values and factory value. Dispatch, range checks, factory reset and the EEPROM image work on those.

use super::key::{KEYS, Key};
use super::measured::Measured;
use crate::heater::Settings;
use crate::measure::I32x3;
use crate::node::Pattern;
use crate::store::ImageId;

/// A number in the data bytes of a request or reply.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Field {
    /// The manual's symbol, for example `CYT`.
    pub symbol: &'static str,
    /// What it is.
    pub name: &'static str,
    /// Size in bytes, 1 to 4, little-endian.
    pub size: u8,
    /// Two's complement.
    pub signed: bool,
    /// Digits behind the decimal point: the value is the number divided by 10 to this power.
    pub decimals: u8,
    /// The unit of the value, empty when it has none.
    pub unit: &'static str,
    /// The smallest permitted number.
    pub min: i64,
    /// The largest permitted number.
    pub max: i64,
    /// Names of particular numbers.
    pub meanings: &'static [(u32, &'static str)],
}

/// What a written parameter is checked for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Check {
    /// Its one field lies between its limits.
    Range,
    /// It is an identifier of the 11- or 29-bit format that no other frame type uses (section 9.10.2).
    Identifier,
    /// Cut-off frequency and filter type fit each other (section 9.10.5).
    CutOff,
}

/// A device parameter: a row of table 19, with its codes and values from tables 17, 18 and section 9.10.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Parameter {
    /// Where it lives; its read and write codes follow from that.
    pub key: Key,
    /// The manual's name.
    pub name: &'static str,
    /// Its fields, in the order of the bytes; at most four bytes together.
    pub fields: &'static [Field],
    /// What a written value is checked for.
    pub check: Check,
    /// The factory value: the bytes of all fields as one little-endian number.
    pub factory: u32,
}

impl Parameter {
    /// The code that reads it.
    pub const fn read_code(&self) -> u8 {
        super::code::READ + self.key as u8
    }

    /// The code that writes it.
    pub const fn write_code(&self) -> u8 {
        super::code::WRITE + self.key as u8
    }
}

/// A function that is not a parameter: a row of tables 17 and 18.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Function {
    /// Its function select code.
    pub fsc: u8,
    /// What it does.
    pub name: &'static str,
    /// The signature that the request must carry; empty when there is none.
    pub signature: &'static [u8],
    /// The fields of the reply behind the status byte.
    pub reply: &'static [Field],
}

/// Run and error LED patterns of table 12.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LedTable {
    /// Run LED while the bit rate is being detected.
    pub detecting: Pattern,
    /// Run LED in normal operation.
    pub normal: Pattern,
    /// Error LED while neither of the following holds.
    pub working: Pattern,
    /// Error LED when the CAN warning limit has been reached.
    pub warning: Pattern,
    /// Error LED in bus-off.
    pub bus_off: Pattern,
}

/// A model that speaks FSC: its tables and its measurement.
pub trait Model {
    /// The device parameters, in the order of [`Key`].
    const PARAMETERS: &'static [Parameter];
    /// The other functions, in the order of their codes.
    const FUNCTIONS: &'static [Function];
    /// The names of the status bits from bit 0 on; an empty name is a reserved bit.
    const STATUS_BITS: [&'static str; 8];
    /// What the LEDs show.
    const LEDS: LedTable;
    /// What the device keeps of [`PARAMETERS`](Self::PARAMETERS): their projection by [`rules`].
    const RULES: &'static [Rule];
    /// The number of angles: 1 or 2.
    const AXES: u8;
    /// The status bits that stand for sensor errors.
    const SENSOR_ERRORS: u8;
    /// The heater of the measuring cell, for active temperature compensation (section 9.3); None without it.
    const HEATER: Option<&'static Settings> = None;

    /// The angles and sensor errors for a filtered up vector.
    fn measure(up: I32x3, product: &Product) -> Measured;
    /// A measured angle with the zero offset applied, as it is transmitted; in 0.01 deg.
    fn with_offset(measured: i32, offset: u32) -> i32;
    /// The zero offset that makes the present angle 0.
    fn zero_for(measured: i32) -> u32;
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

/// A product of a model: what differs between lines and housings.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Product {
    /// The type name, for example `IS2BP090-C-CL`.
    pub name: &'static str,
    /// The digits of the article number: PR-23054-30 is 2305430.
    pub article: u32,
    /// The revision.
    pub revision: u16,
    /// The software version it reports.
    pub version: Version,
    /// 1-axis: the largest cross slope; 2-axis: the largest inclination without a sensor error. In 0.01 deg.
    pub limit: u16,
    /// Marks its images in nonvolatile memory.
    pub image: ImageId,
}

/// What the device keeps of a parameter.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Rule {
    /// Size in bytes, 1 to 4.
    pub size: u8,
    /// Permitted values.
    pub permitted: Permitted,
    /// The factory value.
    pub factory: u32,
}

/// The values that a parameter takes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Permitted {
    /// From the first to the second, both included.
    Unsigned(u16, u16),
    /// In two's complement, from the first to the second, both included.
    Signed(i16, i16),
    /// A free CAN identifier.
    Identifier,
    /// A cut-off frequency (two bytes) and a filter type that fit each other.
    CutOff,
}

/// Projects the description of a model's parameters onto what the device keeps.
///
/// A row in the wrong place (missing, duplicate, unsorted) or one that cannot be is a compile error, because this runs while a
/// `static` is evaluated.
#[allow(clippy::indexing_slicing, clippy::panic)] // evaluated at compile time only
pub const fn rules<const N: usize>(parameters: &[Parameter]) -> [Rule; N] {
    assert!(
        parameters.len() == N && N <= KEYS,
        "one rule for each parameter"
    );
    let mut rules = [Rule {
        size: 0,
        permitted: Permitted::Identifier,
        factory: 0,
    }; N];
    let mut row = 0;
    while row < N {
        let parameter = &parameters[row];
        assert!(
            parameter.key as usize == row,
            "the rows must be in the order of their keys"
        );
        let mut size = 0;
        let mut field = 0;
        while field < parameter.fields.len() {
            size += parameter.fields[field].size;
            field += 1;
        }
        assert!(1 <= size && size <= 4, "a parameter has one to four bytes");
        let first = &parameter.fields[0];
        let permitted = match parameter.check {
            Check::Identifier => Permitted::Identifier,
            Check::CutOff => Permitted::CutOff,
            Check::Range if first.signed => {
                assert!(parameter.fields.len() == 1 && size == 2);
                assert!(first.min >= i16::MIN as i64 && first.max <= i16::MAX as i64);
                Permitted::Signed(first.min as i16, first.max as i16)
            }
            Check::Range => {
                assert!(parameter.fields.len() == 1);
                assert!(first.min >= 0 && first.max <= u16::MAX as i64);
                Permitted::Unsigned(first.min as u16, first.max as u16)
            }
        };
        rules[row] = Rule {
            size,
            permitted,
            factory: parameter.factory,
        };
        row += 1;
    }
    rules
}

/// Checks that the functions are in the order of their codes, each once; called while a constant is evaluated.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn sorted(functions: &'static [Function]) -> &'static [Function] {
    let mut row = 1;
    while row < functions.len() {
        assert!(
            functions[row - 1].fsc < functions[row].fsc,
            "functions must be sorted by their code"
        );
        row += 1;
    }
    functions
}

/// The bytes that the values of these parameters take in an image.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn values_size(rules: &[Rule]) -> usize {
    let mut size = 0;
    let mut row = 0;
    while row < rules.len() {
        size += rules[row].size as usize;
        row += 1;
    }
    size
}
