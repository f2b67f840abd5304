//! Explicit messages: requests, responses and their errors.
//!
//! ```text
//!              byte 0                     1               2          3           4 ...
//!  request     80h fragment, 40h XID,     service         class      instance    attribute or data
//!              MAC ID of the master
//!  response    XID and MAC ID             80h + service   data ...
//!  error       of the request             94h             general    additional
//! ```
//!
//! An unfragmented message has at most 8 bytes. A longer one is sent in [fragments](super::fragment).

use super::fragment::SHORTEST;
use crate::param::number;
use crate::store::Name;

/// Bit of the header: fragmented message.
pub(super) const FRAGMENT: u8 = 0x80;
/// Bits of the header of a response that are those of its request: XID and MAC ID.
pub(super) const ECHO: u8 = 0x7F;
/// Bits of the header: the MAC ID of the master.
pub(super) const MAC: u8 = super::identifiers::MAC_MAX;
/// Bit of the service: response.
const RESPONSE: u8 = 0x80;
/// The service codes of requests and responses.
pub mod service {
    /// The response to a request that is refused.
    pub const ERROR: u8 = 0x14;
    /// Reset of the identity object.
    pub const RESET: u8 = 0x05;
    /// Get_Attribute_Single: reads an attribute.
    pub const GET: u8 = 0x0E;
    /// Set_Attribute_Single: writes an attribute.
    pub const SET: u8 = 0x10;
    /// The update of the program, a service of the identity object. Services from 32h to 4Ah are those of the vendor.
    pub const UPDATE: u8 = 0x32;
    /// Allocate_Master/Slave_Connection_Set.
    pub const ALLOCATE: u8 = 0x4B;
    /// Release_Group_2_Identifier_Set.
    pub const RELEASE: u8 = 0x4C;
}

/// The general codes of an error response.
pub mod general {
    /// The resource is not available.
    pub const RESOURCE: u8 = 0x02;
    /// There is no such service.
    pub const SERVICE: u8 = 0x08;
    /// The value is not permitted.
    pub const VALUE: u8 = 0x09;
    /// Already in the requested state.
    pub const ALREADY: u8 = 0x0B;
    /// Not possible in the present state of the object.
    pub const STATE: u8 = 0x0C;
    /// The attribute can only be read.
    pub const NOT_SETTABLE: u8 = 0x0E;
    /// There is not enough data.
    pub const TOO_LITTLE: u8 = 0x13;
    /// There is no such attribute.
    pub const ATTRIBUTE: u8 = 0x14;
    /// There is too much data.
    pub const TOO_MUCH: u8 = 0x15;
    /// There is no such object.
    pub const OBJECT: u8 = 0x16;
    /// A parameter of the service is not permitted.
    pub const PARAMETER: u8 = 0x20;
}

/// The general and the additional code of an error response.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Failure {
    pub general: u8,
    pub additional: u8,
}

impl Failure {
    /// A failure whose additional code is FFh: there is none.
    const fn new(general: u8) -> Self {
        Self {
            general,
            additional: 0xFF,
        }
    }

    /// The same with an additional code.
    pub const fn with(self, additional: u8) -> Self {
        Self { additional, ..self }
    }

    pub const RESOURCE: Self = Self::new(general::RESOURCE);
    pub const SERVICE: Self = Self::new(general::SERVICE);
    pub const VALUE: Self = Self::new(general::VALUE);
    pub const ALREADY: Self = Self::new(general::ALREADY);
    pub const STATE: Self = Self::new(general::STATE);
    pub const NOT_SETTABLE: Self = Self::new(general::NOT_SETTABLE);
    pub const TOO_LITTLE: Self = Self::new(general::TOO_LITTLE);
    pub const ATTRIBUTE: Self = Self::new(general::ATTRIBUTE);
    pub const TOO_MUCH: Self = Self::new(general::TOO_MUCH);
    pub const OBJECT: Self = Self::new(general::OBJECT);
    pub const PARAMETER: Self = Self::new(general::PARAMETER);
}

/// The data of a successful response.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Data {
    /// The first `length` bytes, at most 6, of a little-endian number. The other bytes are 0.
    Bytes { bytes: u64, length: u8 },
    /// A text of [`SHORTEST`] characters at least, with its length in the first byte.
    Text(Name),
}

impl Data {
    /// A response that contains its header and the service only.
    pub const NONE: Self = Self::Bytes {
        bytes: 0,
        length: 0,
    };

    /// The low `size` bytes of a number: 1, 2 or 4.
    pub const fn number(value: u32, size: u8) -> Self {
        let mask = match size {
            1 => 0xFF,
            2 => 0xFFFF,
            _ => u32::MAX,
        };
        Self::Bytes {
            bytes: (value & mask) as u64,
            length: size,
        }
    }

    /// A text with its length in the first byte.
    pub fn text(text: &Name) -> Self {
        let characters = text.bytes();
        if characters.len() >= SHORTEST {
            return Self::Text(*text);
        }
        let mut bytes = characters.len() as u64;
        for (place, character) in (1..).zip(characters) {
            bytes |= u64::from(*character) << (8 * place);
        }
        Self::Bytes {
            bytes,
            length: characters.len() as u8 + 1,
        }
    }

    /// A number of one byte.
    pub const fn byte(value: u8) -> Self {
        Self::number(value as u32, 1)
    }

    /// A number of two bytes.
    pub const fn word(value: u16) -> Self {
        Self::number(value as u32, 2)
    }
}

/// A request without its header.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request<'a> {
    pub service: u8,
    pub class: u8,
    pub instance: u8,
    /// The attribute and its data, or the data of the service.
    pub data: &'a [u8],
}

impl<'a> Request<'a> {
    /// The request in the body of a message: the bytes after the header.
    pub fn parse(body: &'a [u8]) -> Result<Self, Failure> {
        let [service, class, instance, data @ ..] = body else {
            return Err(Failure::TOO_LITTLE);
        };
        Ok(Self {
            service: *service,
            class: *class,
            instance: *instance,
            data,
        })
    }

    /// The attribute, and the data after it.
    pub fn attribute(&self) -> Result<(u8, &'a [u8]), Failure> {
        let [attribute, data @ ..] = self.data else {
            return Err(Failure::TOO_LITTLE);
        };
        Ok((*attribute, data))
    }

    /// Answers a request to a class (instance 0): its revision is readable.
    pub fn class_attribute(&self, revision: u8) -> Result<Data, Failure> {
        if self.service != service::GET {
            return Err(Failure::SERVICE);
        }
        let (attribute, data) = self.attribute()?;
        if attribute != 1 {
            return Err(Failure::ATTRIBUTE);
        }
        nothing(data)?;
        Ok(Data::word(revision.into()))
    }
}

/// Checks that there is no data.
pub(super) fn nothing(data: &[u8]) -> Result<(), Failure> {
    if data.is_empty() {
        return Ok(());
    }
    Err(Failure::TOO_MUCH)
}

/// The number in exactly `size` bytes, at most 4.
pub(super) fn exactly(data: &[u8], size: u8) -> Result<u32, Failure> {
    let size = usize::from(size);
    if data.len() < size {
        return Err(Failure::TOO_LITTLE);
    }
    if data.len() > size {
        return Err(Failure::TOO_MUCH);
    }
    Ok(number(data))
}

/// Whether the first byte of a body is the service of a response.
pub(super) const fn is_response(service: u8) -> bool {
    service & RESPONSE != 0
}

/// The service of a successful response.
pub(super) const fn response_to(service: u8) -> u8 {
    service | RESPONSE
}

/// The data of an unfragmented response, and its length. `header` is that of the request, without the fragment bit.
pub(super) fn unfragmented(header: u8, service: u8, bytes: u64, length: u8) -> (u64, u8) {
    let head = u64::from(header) | u64::from(response_to(service)) << 8;
    (head | bytes << 16, length + 2)
}

/// The data of an error response, and its length.
pub(super) fn error(header: u8, failure: Failure) -> (u64, u8) {
    let codes = u64::from(failure.general) | u64::from(failure.additional) << 8;
    unfragmented(header, service::ERROR, codes, 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn responses_are_those_of_the_examples() {
        let (data, length) = unfragmented(0x4A, service::GET, 1634, 2);
        assert_eq!(data.to_le_bytes()[..4], [0x4A, 0x8E, 0x62, 0x06]);
        assert_eq!(length, 4);
        let (data, length) = error(0x0A, Failure::ALREADY.with(2));
        assert_eq!(data.to_le_bytes()[..4], [0x0A, 0x94, 0x0B, 0x02]);
        assert_eq!(length, 4);
        assert_eq!(Failure::VALUE.additional, 0xFF);
    }

    #[test]
    fn number_has_low_bytes_of_value() {
        let minus_one = u32::MAX;
        for (size, bytes) in [(1, 0xFF), (2, 0xFFFF), (4, 0xFFFF_FFFF)] {
            let length = size;
            assert_eq!(Data::number(minus_one, size), Data::Bytes { bytes, length });
        }
    }

    #[test]
    fn text_that_fits_into_a_frame_is_not_fragmented() {
        let text = |text| Data::text(&Name::constant(text));
        let (bytes, length) = (u64::from_le_bytes(*b"\x04abcd\0\0\0"), 5);
        assert_eq!(text("abcd"), Data::Bytes { bytes, length });
        assert_eq!(text("abcde"), Data::Text(Name::constant("abcde")));
    }

    #[test]
    fn data_of_another_length_is_too_little_or_too_much() {
        assert_eq!(exactly(&[0x2C, 0x01], 2), Ok(300));
        assert_eq!(exactly(&[0x2C], 2), Err(Failure::TOO_LITTLE));
        assert_eq!(exactly(&[0x2C, 1, 0], 2), Err(Failure::TOO_MUCH));
        assert_eq!(Request::parse(&[1, 2]).err(), Some(Failure::TOO_LITTLE));
        let request = Request::parse(&[0x0E, 1, 1]).unwrap();
        assert_eq!(request.attribute(), Err(Failure::TOO_LITTLE));
    }

    #[test]
    fn class_has_only_its_revision_and_only_get() {
        let class = |body: &[u8]| Request::parse(body).unwrap().class_attribute(2);
        assert_eq!(class(&[0x0E, 3, 0, 1]), Ok(Data::word(2)));
        assert_eq!(class(&[0x0E, 3, 0, 2]), Err(Failure::ATTRIBUTE));
        assert_eq!(class(&[0x0E, 3, 0, 1, 0]), Err(Failure::TOO_MUCH));
        assert_eq!(class(&[0x0E, 3, 0]), Err(Failure::TOO_LITTLE));
        assert_eq!(class(&[0x10, 3, 0, 1, 2]), Err(Failure::SERVICE));
    }
}
