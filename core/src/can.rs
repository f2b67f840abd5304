//! A classic CAN frame, its identifier, the ten bit rates and the acceptance filters.
//!
//! Identifiers are those of the crate `embedded-can` 0.4, and [`Frame`] implements [`embedded_can::Frame`], so that frames of other
//! drivers can be converted.

use crate::walk::copy;
pub use embedded_can::Id;
use embedded_can::{ExtendedId, StandardId};

/// A CAN 2.0 A or B frame: identifier, remote flag and 0 to 8 data bytes.
///
/// It consists of four words and is copied word by word. The length is a word, because padding would be copied byte by byte. With an [`Id`] and
/// a bool, an `Option` of a frame would also be copied byte by byte, which would be half of the time from a request to its reply.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// A [`CanId`] and [`REMOTE`].
    head: u32,
    length: u32,
    data: [u8; 8],
}

/// Bit of `head`: remote frame.
const REMOTE: u32 = 1 << 30;

/// An identifier and its format in one word, so that a comparison needs one instruction.
///
/// Bit 31 is the format (1 = 29 bit), bits 30 and 29 are 0, and the identifier is right-aligned.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct CanId(u32);

/// Bit of a [`CanId`] and of `head`: the identifier has 29 bits.
const EXTENDED: u32 = 1 << 31;

impl CanId {
    /// An 11-bit identifier; the upper bits of `id` are ignored.
    pub const fn standard(id: u16) -> Self {
        Self((id & 0x7FF) as u32)
    }

    /// A 29-bit identifier; the upper bits of `id` are ignored.
    pub const fn extended(id: u32) -> Self {
        Self(id & 0x1FFF_FFFF | EXTENDED)
    }

    /// The identifier with these bits; bits that are always 0 are ignored.
    pub const fn from_bits(bits: u32) -> Self {
        if bits & EXTENDED != 0 {
            Self::extended(bits)
        } else {
            Self::standard(bits as u16)
        }
    }

    /// The bits of the identifier and its format.
    pub const fn bits(self) -> u32 {
        self.0
    }
}

impl From<Id> for CanId {
    fn from(id: Id) -> Self {
        match id {
            Id::Standard(id) => Self(id.as_raw().into()),
            Id::Extended(id) => Self(id.as_raw() | EXTENDED),
        }
    }
}

impl From<CanId> for Id {
    fn from(id: CanId) -> Self {
        if id.0 & EXTENDED != 0 {
            extended(id.0)
        } else {
            standard(id.0 as u16)
        }
    }
}

impl Frame {
    /// A frame without data, with the identifier 0.
    pub(crate) const EMPTY: Self = Self {
        head: 0,
        length: 0,
        data: [0; 8],
    };

    /// A data frame; None if `data` is longer than 8 bytes.
    pub fn data(id: Id, data: &[u8]) -> Option<Self> {
        let mut bytes = [0; 8];
        copy(bytes.get_mut(..data.len())?, data);
        Some(Self {
            head: CanId::from(id).0,
            length: data.len() as u32,
            data: bytes,
        })
    }

    /// A data frame with the first `length` of these bytes, 8 at most.
    pub fn of(id: impl Into<CanId>, bytes: [u8; 8], length: u8) -> Self {
        // Masks two 32-bit words. A copy of variable length takes about 50 instructions, and a 64-bit shift is a function call.
        let data = u64::from_le_bytes(bytes);
        let (low, high) = (data as u32, (data >> 32) as u32);
        let (low, high, length) = match length {
            0..4 => (low & !(u32::MAX << (8 * length)), 0, length),
            4..8 => (low, high & !(u32::MAX << (8 * (length - 4))), length),
            _ => (low, high, 8),
        };
        Self::word(id, u64::from(high) << 32 | u64::from(low), length)
    }

    /// A data frame with the first `length` bytes (at most 8) of a little-endian number. Its other bytes must be 0.
    pub(crate) fn word(id: impl Into<CanId>, data: u64, length: u8) -> Self {
        Self {
            head: id.into().0,
            length: length.into(),
            data: data.to_le_bytes(),
        }
    }

    /// A remote frame with the data length code `length`; None if `length` is above 8.
    pub fn remote(id: Id, length: usize) -> Option<Self> {
        (length <= 8).then_some(Self {
            head: CanId::from(id).0 | REMOTE,
            length: length as u32,
            data: [0; 8],
        })
    }

    /// The identifier with its format (11 or 29 bit).
    pub fn id(&self) -> Id {
        self.can_id().into()
    }

    /// The identifier and its format in one word.
    pub const fn can_id(&self) -> CanId {
        CanId(self.head & !REMOTE)
    }

    /// True for a remote frame.
    pub const fn is_remote(&self) -> bool {
        self.head & REMOTE != 0
    }

    /// The data length code, 0 to 8.
    pub const fn dlc(&self) -> usize {
        self.length as usize
    }

    /// The data bytes; none in a remote frame.
    #[inline]
    pub fn bytes(&self) -> &[u8] {
        if self.is_remote() {
            &[]
        } else {
            self.data.get(..self.dlc()).unwrap_or(&[])
        }
    }

    /// The data bytes of a data frame with eight of them; None for any other frame.
    pub(crate) fn eight_bytes(&self) -> Option<[u8; 8]> {
        (!self.is_remote() && self.length == 8).then_some(self.data)
    }

    /// The eight data bytes as two little-endian words, as in the registers of CAN controllers. Bytes beyond the data are 0.
    pub const fn data_words(&self) -> [u32; 2] {
        let data = u64::from_le_bytes(self.data);
        [data as u32, (data >> 32) as u32]
    }
}

impl embedded_can::Frame for Frame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        Self::data(id.into(), data)
    }
    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        Self::remote(id.into(), dlc)
    }
    fn is_extended(&self) -> bool {
        self.head & EXTENDED != 0
    }
    fn is_remote_frame(&self) -> bool {
        self.is_remote()
    }
    fn id(&self) -> Id {
        self.id()
    }
    fn dlc(&self) -> usize {
        self.dlc()
    }
    fn data(&self) -> &[u8] {
        self.bytes()
    }
}

impl core::fmt::Debug for Frame {
    /// In the format of candump: `301#FF02`, `1FFFFFFF#R4`.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.id() {
            Id::Standard(id) => write!(f, "{:03X}#", id.as_raw())?,
            Id::Extended(id) => write!(f, "{:08X}#", id.as_raw())?,
        }
        if self.is_remote() {
            return if self.length == 0 {
                f.write_str("R")
            } else {
                write!(f, "R{}", self.length)
            };
        }
        self.bytes()
            .iter()
            .try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

/// An 11-bit identifier. The upper bits of `id` are ignored, so that constants need no error handling.
pub const fn standard(id: u16) -> Id {
    match StandardId::new(id & 0x7FF) {
        Some(id) => Id::Standard(id),
        None => Id::Standard(StandardId::ZERO),
    }
}

/// A 29-bit identifier; the upper bits of `id` are ignored.
pub const fn extended(id: u32) -> Id {
    match ExtendedId::new(id & 0x1FFF_FFFF) {
        Some(id) => Id::Extended(id),
        None => Id::Extended(ExtendedId::ZERO),
    }
}

/// The ten bit rates of the original sensors.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BitRate {
    /// 10 kbit/s: a bit takes 100 us.
    K10,
    /// 20 kbit/s: a bit takes 50 us.
    K20,
    /// 50 kbit/s: a bit takes 20 us.
    K50,
    /// 62.5 kbit/s: a bit takes 16 us.
    K62_5,
    /// 100 kbit/s: a bit takes 10 us.
    K100,
    /// 125 kbit/s: a bit takes 8 us.
    K125,
    /// 250 kbit/s: a bit takes 4 us.
    K250,
    /// 500 kbit/s: a bit takes 2 us.
    K500,
    /// 800 kbit/s: a bit takes 1.25 us.
    K800,
    /// 1 Mbit/s: a bit takes 1 us.
    M1,
}

impl BitRate {
    /// All ten bit rates, from the slowest to the fastest.
    pub const ALL: [Self; 10] = [
        Self::K10,
        Self::K20,
        Self::K50,
        Self::K62_5,
        Self::K100,
        Self::K125,
        Self::K250,
        Self::K500,
        Self::K800,
        Self::M1,
    ];

    /// The bit rate with its unit.
    pub const fn name(self) -> &'static str {
        match self {
            Self::K10 => "10 kbit/s",
            Self::K20 => "20 kbit/s",
            Self::K50 => "50 kbit/s",
            Self::K62_5 => "62.5 kbit/s",
            Self::K100 => "100 kbit/s",
            Self::K125 => "125 kbit/s",
            Self::K250 => "250 kbit/s",
            Self::K500 => "500 kbit/s",
            Self::K800 => "800 kbit/s",
            Self::M1 => "1 Mbit/s",
        }
    }

    /// The number of bits in a second.
    pub const fn bits_per_second(self) -> u32 {
        match self {
            Self::K10 => 10_000,
            Self::K20 => 20_000,
            Self::K50 => 50_000,
            Self::K62_5 => 62_500,
            Self::K100 => 100_000,
            Self::K125 => 125_000,
            Self::K250 => 250_000,
            Self::K500 => 500_000,
            Self::K800 => 800_000,
            Self::M1 => 1_000_000,
        }
    }
}

/// An acceptance filter. It accepts frames with the same identifier format whose identifier is equal in the bits set in `mask`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Filter {
    /// The identifier to compare with. Its format (11 or 29 bit) is always compared.
    pub id: Id,
    /// The identifier bits to compare, right-aligned (11 or 29 bits).
    pub mask: u32,
}

impl Filter {
    /// Accepts data and remote frames with exactly this identifier.
    pub fn exact(id: impl Into<CanId>) -> Self {
        Self {
            id: id.into().into(),
            mask: 0x1FFF_FFFF,
        }
    }

    /// Whether a frame with this identifier passes.
    pub fn accepts(&self, id: Id) -> bool {
        match (self.id, id) {
            (Id::Standard(a), Id::Standard(b)) => {
                u32::from(a.as_raw() ^ b.as_raw()) & self.mask == 0
            }
            (Id::Extended(a), Id::Extended(b)) => (a.as_raw() ^ b.as_raw()) & self.mask == 0,
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_has_at_most_eight_bytes() {
        assert!(Frame::data(standard(1), &[0; 9]).is_none());
        assert!(Frame::remote(standard(1), 9).is_none());
        assert_eq!(Frame::data(standard(1), &[0; 8]).map(|f| f.dlc()), Some(8));
    }

    #[test]
    fn frame_ignores_bytes_beyond_dlc() {
        let data = [1, 2, 3, 4, 5, 6, 7, 8];
        for length in 0..=9 {
            let frame = Frame::of(standard(5), data, length);
            let bytes = &data[..usize::from(length).min(8)];
            assert_eq!(Some(frame), Frame::data(standard(5), bytes));
        }
    }

    #[test]
    fn data_words_have_the_data_from_the_lowest_byte_on() {
        let frame = Frame::data(standard(5), &[1, 2, 3, 4, 5, 6]).unwrap();
        assert_eq!(frame.data_words(), [0x0403_0201, 0x0605]);
        assert_eq!(Frame::EMPTY.data_words(), [0, 0]);
    }

    #[test]
    fn frame_of_embedded_can_has_the_same_parts() {
        use embedded_can::Frame as _;
        let data = <Frame as embedded_can::Frame>::new(extended(0x361), &[1, 2]).unwrap();
        assert!(data.is_extended() && !data.is_remote_frame());
        assert_eq!(embedded_can::Frame::dlc(&data), 2);
        assert_eq!(data.data(), [1, 2]);
        let remote = Frame::new_remote(standard(0x361), 5).unwrap();
        assert!(!remote.is_extended() && remote.is_remote_frame());
        assert_eq!(embedded_can::Frame::dlc(&remote), 5);
        assert_eq!(embedded_can::Frame::id(&remote), standard(0x361));
        assert_eq!(
            <Frame as embedded_can::Frame>::new(standard(1), &[0; 9]),
            None
        );
        assert_eq!(Frame::new_remote(standard(1), 9), None);
    }

    #[test]
    fn only_a_data_frame_with_eight_bytes_has_eight_bytes() {
        let data = [1, 2, 3, 4, 5, 6, 7, 8];
        let bytes = |frame: Option<Frame>| frame.and_then(|frame| frame.eight_bytes());
        assert_eq!(bytes(Frame::data(standard(5), &data)), Some(data));
        assert_eq!(bytes(Frame::data(standard(5), &data[..7])), None);
        assert_eq!(bytes(Frame::remote(standard(5), 8)), None);
    }

    #[test]
    fn bit_rate_has_its_name_and_number() {
        let of = |rate: BitRate| (rate.name(), rate.bits_per_second());
        assert_eq!(of(BitRate::K10), ("10 kbit/s", 10_000));
        assert_eq!(of(BitRate::K62_5), ("62.5 kbit/s", 62_500));
        assert_eq!(of(BitRate::M1), ("1 Mbit/s", 1_000_000));
        let rates = BitRate::ALL.map(BitRate::bits_per_second);
        assert!(rates.is_sorted_by(|a, b| a < b));
    }

    #[test]
    fn can_id_keeps_format_and_bits() {
        assert_eq!(CanId::from(standard(0x7FF)).bits(), 0x7FF);
        assert_eq!(CanId::from(extended(0x361)).bits(), 0x8000_0361);
        assert_eq!(Id::from(CanId::from_bits(0x8000_0361)), extended(0x361));
        assert_eq!(CanId::from_bits(0xFFFF_FFFF).bits(), 0x9FFF_FFFF);
        assert_eq!(CanId::from_bits(0x7FFF_FFFF).bits(), 0x7FF);
    }

    #[test]
    fn frame_keeps_format_and_bits_of_identifier() {
        let ids = [0, 1, 0x400, 0x7FF].map(standard).into_iter();
        for id in ids.chain([0, 1, 0x7FF, 0x1000_0000, 0x1FFF_FFFF].map(extended)) {
            for frame in [Frame::data(id, &[1]), Frame::remote(id, 1)] {
                assert_eq!(frame.map(|frame| frame.id()), Some(id));
            }
            let remote = |frame: Option<Frame>| frame.map(|frame| frame.is_remote());
            assert_eq!(remote(Frame::data(id, &[1])), Some(false));
            assert_eq!(remote(Frame::remote(id, 1)), Some(true));
        }
    }

    #[test]
    fn frame_is_printed_in_candump_format() {
        let text = |frame: Option<Frame>| std::format!("{:?}", frame.unwrap());
        assert_eq!(text(Frame::data(standard(0x301), &[0xFF, 2])), "301#FF02");
        assert_eq!(text(Frame::data(extended(0x361), &[])), "00000361#");
        assert_eq!(text(Frame::remote(standard(0x7FF), 4)), "7FF#R4");
        assert_eq!(text(Frame::remote(standard(0x7FF), 0)), "7FF#R");
    }

    #[test]
    fn filter_compares_format_and_masked_bits() {
        let filter = Filter::exact(standard(0x300));
        assert!(filter.accepts(standard(0x300)));
        assert!(!filter.accepts(standard(0x301)));
        assert!(!filter.accepts(extended(0x300)));
        let group = Filter {
            id: extended(0x18EA_0000),
            mask: 0x00FF_0000,
        };
        assert!(group.accepts(extended(0x0CEA_FF12)));
        assert!(!group.accepts(extended(0x0CEB_FF12)));
    }
}
