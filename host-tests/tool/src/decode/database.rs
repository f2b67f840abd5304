//! A CAN database (DBC) of the user, for the frames of other devices.

use super::{Decoded, Named};
use crate::error::{Error, FileError};
use bench::file::{Unread, decoded, read};
use can_dbc::{
    ByteOrder, Dbc, Message, MessageId, MultiplexIndicator, Signal, SignalExtendedValueType,
    ValueType,
};
use plumbline::can::Frame;
use serde_json::json;
use std::path::Path;

/// The longest file, in bytes.
const LONGEST: u64 = 16 << 20;

/// The highest identifier of 11 bits.
const STANDARD: u32 = 0x7FF;

/// The name of a message of a database where others have that of their protocol.
const NAME: &str = "dbc";

/// A database.
#[derive(Clone, Debug)]
pub struct Database(Dbc);

impl Database {
    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read, or is not a database.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let shown = || path.display().to_string();
        let bytes = read(path, LONGEST).map_err(|unread| match unread {
            Unread::Failed(error) => FileError::DatabaseUnread(shown(), error.to_string()),
            Unread::Unfit(why) => FileError::DatabaseUnread(shown(), why.to_string()),
        })?;
        Self::parse(&decoded(&bytes).text).map_err(|line| FileError::Database(shown(), line).into())
    }

    /// The database of a text. The error is the number of the line that is not valid.
    fn parse(text: &str) -> Result<Self, usize> {
        let line = |rest: &str| {
            let read = text.len().saturating_sub(rest.trim_start().len());
            text.as_bytes()[..read]
                .iter()
                .filter(|byte| **byte == b'\n')
                .count()
                + 1
        };
        match Dbc::try_from(text) {
            Ok(dbc) if dbc.messages().is_empty() => Err(1),
            Ok(dbc) => Ok(Self(dbc)),
            Err(can_dbc::Error::Incomplete(_, rest)) => Err(line(rest)),
            Err(_) => Err(1),
        }
    }

    /// The meaning of a frame; None: the database does not have it.
    pub fn decode(&self, frame: &Frame) -> Option<Decoded> {
        if frame.is_remote() {
            return None;
        }
        let bits = frame.can_id().bits();
        let mut messages = self.0.messages().iter();
        let message = messages.find(|message| match *message.id() {
            MessageId::Standard(id) => bits <= STANDARD && u32::from(id) == bits,
            MessageId::Extended(id) => bits > STANDARD && id == bits & 0x1FFF_FFFF,
        })?;
        let signals = message.signals().iter();
        let signals = signals.filter(|signal| self.is_sent(message, signal, frame.bytes()));
        let values = signals.filter_map(|signal| self.value(message, signal, frame.bytes()));
        Some(Decoded {
            protocol: NAME,
            is_sure: true,
            node: None,
            product: None,
            message: message.name().clone(),
            values: values.collect(),
            needs_product: false,
        })
    }

    /// Whether a multiplexed signal is in the frame.
    fn is_sent(&self, message: &Message, signal: &Signal, data: &[u8]) -> bool {
        let mut extended = self.0.extended_multiplex().iter();
        let extended = extended
            .find(|row| row.message_id() == message.id() && row.signal_name() == signal.name());
        let mut signals = message.signals().iter();
        if let Some(row) = extended {
            let switch = signals.find(|own| own.name() == row.multiplexor_signal_name());
            let Some(number) = switch.and_then(|switch| raw(switch, data)) else {
                return false;
            };
            let mut ranges = row.mappings().iter();
            return ranges.any(|range| (*range.min_value()..=*range.max_value()).contains(&number));
        }
        let (MultiplexIndicator::MultiplexedSignal(wanted)
        | MultiplexIndicator::MultiplexorAndMultiplexedSignal(wanted)) =
            *signal.multiplexer_indicator()
        else {
            return true;
        };
        let switch =
            signals.find(|own| *own.multiplexer_indicator() == MultiplexIndicator::Multiplexor);
        switch.and_then(|switch| raw(switch, data)) == Some(wanted)
    }

    /// The value of a signal; None: the frame is too short for it.
    fn value(&self, message: &Message, signal: &Signal, data: &[u8]) -> Option<Named> {
        let bits = raw(signal, data)?;
        let name = signal.name().clone();
        let unit = signal.unit().as_str();
        let kind = self
            .0
            .extended_value_type_for_signal(*message.id(), signal.name());
        let number = match (kind, signal.size) {
            (Some(SignalExtendedValueType::IEEEfloat32Bit), 32) => {
                f64::from(f32::from_bits(bits as u32))
            }
            (Some(SignalExtendedValueType::IEEEdouble64bit), 64) => f64::from_bits(bits),
            _ => {
                let integer = integer(signal, bits);
                let meanings = self
                    .0
                    .value_descriptions_for_signal(*message.id(), signal.name());
                let mut meanings = meanings.unwrap_or_default().iter();
                let own = meanings.find(|meaning| *meaning.id() == integer as f64);
                if let Some(own) = own {
                    let text = own.description().clone();
                    let json = json!({"value": text, "unit": "", "raw": integer as i64});
                    return Some(Named { name, text, json });
                }
                integer as f64
            }
        };
        let number = number * signal.factor + signal.offset;
        // The digits of the factor and the offset; a binary fraction has others behind them.
        let digits = digits(signal.factor).max(digits(signal.offset));
        let text = match kind {
            None | Some(SignalExtendedValueType::SignedOrUnsignedInteger) => {
                format!("{number:.digits$}")
            }
            Some(_) => number.to_string(),
        };
        let rounded = text.parse().unwrap_or(number);
        Some(Named {
            name,
            text: format!("{text} {unit}").trim_end().to_owned(),
            json: json!({"value": rounded, "unit": unit}),
        })
    }
}

/// The bits of a signal as a number without a sign; None: they are not in the data.
fn raw(signal: &Signal, data: &[u8]) -> Option<u64> {
    let (start, size) = (signal.start_bit, signal.size);
    if !(1..=64).contains(&size) || start >= 64 {
        return None;
    }
    let bit = |place: u64| {
        let byte = data.get(usize::try_from(place / 8).ok()?)?;
        Some(u64::from(byte >> (place % 8) & 1))
    };
    match signal.byte_order() {
        ByteOrder::LittleEndian => (0..size).try_fold(0, |number, place| {
            Some(number | bit(start + place)? << place)
        }),
        // The start is the highest bit; bit 0 of a byte is followed by bit 7 of the next one.
        ByteOrder::BigEndian => {
            let first = start / 8 * 8 + 7 - start % 8;
            (first..first + size).try_fold(0, |number, place| {
                Some(number << 1 | bit(place / 8 * 8 + 7 - place % 8)?)
            })
        }
    }
}

/// The bits as a number with its sign.
fn integer(signal: &Signal, bits: u64) -> i128 {
    let is_negative =
        *signal.value_type() == ValueType::Signed && bits >> (signal.size - 1) & 1 == 1;
    match is_negative {
        true => i128::from(bits) - (1 << signal.size),
        false => bits.into(),
    }
}

/// The number of digits behind the point that a number needs, up to 9.
fn digits(number: f64) -> usize {
    let text = format!("{number:.9}");
    let digits = text.trim_end_matches('0').split_once('.');
    digits.map_or(0, |(_, digits)| digits.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use can_wire::text::frame;
    use plumbline::model::catalog::find;

    /// Both orders of bytes, signs, meanings, floats, and two levels of multiplexing.
    const TEXT: &str = r#"VERSION ""

NS_ :

BS_:

BU_: Crane

BO_ 385 Boom: 8 Crane
 SG_ Length : 0|16@1+ (0.01,0) [0|655.35] "m" Vector__XXX
 SG_ Angle : 23|12@0- (0.1,-5) [-210|200] "deg" Vector__XXX
 SG_ State : 28|4@1+ (1,0) [0|15] "" Vector__XXX
 SG_ Load : 32|32@1- (1,0) [0|0] "t" Vector__XXX

BO_ 2566844672 Parts: 8 Crane
 SG_ Kind M : 0|8@1+ (1,0) [0|0] "" Vector__XXX
 SG_ First m1 : 8|8@1+ (1,0) [0|0] "" Vector__XXX
 SG_ Second m2M : 8|8@1+ (1,0) [0|0] "" Vector__XXX
 SG_ Third m3 : 16|8@1- (1,0) [0|0] "" Vector__XXX

VAL_ 385 State 0 "stopped" 1 "moves" ;
SIG_VALTYPE_ 385 Load : 1;
SG_MUL_VAL_ 2566844672 Second Kind 2-2;
SG_MUL_VAL_ 2566844672 Third Second 3-4, 7-7;
"#;

    fn shown(frame: &str) -> String {
        let database = Database::parse(TEXT).expect("a database");
        let decoded = database.decode(&can_wire::text::frame(frame));
        decoded.map_or("-".to_owned(), |decoded| decoded.to_string())
    }

    #[test]
    fn values_have_sign_scale_unit_and_meaning() {
        for (frame, text) in [
            (
                "181#D204FF610000C03F",
                "dbc: Boom, Length = 12.34 m, Angle = -6.0 deg, State = 6, Load = 1.5 t",
            ),
            (
                "181#D204001F00002041",
                "dbc: Boom, Length = 12.34 m, Angle = -4.9 deg, State = moves, Load = 10 t",
            ),
            ("181#D204", "dbc: Boom, Length = 12.34 m"),
            ("18FEF100#0105", "dbc: Parts, Kind = 1, First = 5"),
            (
                "18FEF100#0203FF",
                "dbc: Parts, Kind = 2, Second = 3, Third = -1",
            ),
            ("18FEF100#0205FF", "dbc: Parts, Kind = 2, Second = 5"),
            ("00000181#D204", "-"),
            ("182#D204", "-"),
            ("181#R2", "-"),
        ] {
            assert_eq!(shown(frame), text, "{frame}");
        }
    }

    #[test]
    fn database_of_a_product_decodes_its_frames() {
        let text = descriptors::dbc;
        let product = find("is2").expect("a product");
        let plumbline::model::catalog::Protocol::Fsc(tables) = &product.protocol else {
            panic!("{} has function select codes", product.name);
        };
        let database = Database::parse(&text(product, tables)).expect("a database");
        let decoded = database.decode(&frame("301#0001D204C9FD"));
        let text = decoded.expect("a message").to_string();
        for part in [
            "FSC = Inclination",
            "AngleX = 12.34 deg",
            "AngleY = -5.67 deg",
            "DefaultParam = 1",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
    }

    #[test]
    fn wrong_line_is_told() {
        for (text, line) in [
            ("", 1),
            ("no database", 1),
            (
                &*TEXT.replace("SG_ Angle : 23|12@0-", "SG_ Angle : 23|x@0-"),
                11,
            ),
            (&*TEXT.replace("VAL_ 385", "VAL 385"), 21),
        ] {
            assert_eq!(Database::parse(text).err(), Some(line), "{text}");
        }
        // Signals that no frame has, and numbers that do not fit.
        for (part, other) in [
            ("23|12@0-", "63|64@0-"),
            ("0|16@1+", "0|0@1+"),
            ("0|16@1+", "4294967295|16@1+"),
            ("0|16@1+", "60|64@1-"),
        ] {
            let database = Database::parse(&TEXT.replace(part, other)).expect("a database");
            let decoded = database.decode(&frame("181#FFFFFFFFFFFFFFFF"));
            assert!(decoded.is_some(), "{other}");
        }
    }
}
