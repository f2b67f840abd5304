//! A classic CAN frame, its identifier, the ten bit rates and the acceptance filters.
//!
//! Identifiers are embedded-can's, and [`Frame`] implements embedded-can's trait, so that any driver's frames convert.

use embedded_can::{ExtendedId, Id, StandardId};

/// A CAN 2.0 A or B frame: identifier, remote flag and 0 to 8 data bytes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    id: Id,
    remote: bool,
    length: u8,
    data: [u8; 8],
}

impl Frame {
    /// A data frame; None when `data` is longer than 8 bytes.
    pub fn data(id: Id, data: &[u8]) -> Option<Self> {
        let mut bytes = [0; 8];
        bytes.get_mut(..data.len())?.copy_from_slice(data);
        Some(Self {
            id,
            remote: false,
            length: data.len() as u8,
            data: bytes,
        })
    }

    /// A data frame of the first `length` of these bytes, of all eight when that is more; nothing is copied byte by byte.
    pub const fn of(id: Id, bytes: [u8; 8], length: u8) -> Self {
        Self {
            id,
            remote: false,
            length: if length > 8 { 8 } else { length },
            data: bytes,
        }
    }

    /// A remote frame asking for `length` bytes; None when that is more than 8.
    pub fn remote(id: Id, length: usize) -> Option<Self> {
        (length <= 8).then_some(Self {
            id,
            remote: true,
            length: length as u8,
            data: [0; 8],
        })
    }

    /// The identifier with its format (11 or 29 bit).
    pub const fn id(&self) -> Id {
        self.id
    }

    /// True for a remote transmission request.
    pub const fn is_remote(&self) -> bool {
        self.remote
    }

    /// The data length code, 0 to 8.
    pub const fn dlc(&self) -> usize {
        self.length as usize
    }

    /// The data bytes; none in a remote frame.
    pub fn bytes(&self) -> &[u8] {
        if self.remote {
            &[]
        } else {
            self.data.get(..self.dlc()).unwrap_or(&[])
        }
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
        matches!(self.id, Id::Extended(_))
    }
    fn is_remote_frame(&self) -> bool {
        self.remote
    }
    fn id(&self) -> Id {
        self.id
    }
    fn dlc(&self) -> usize {
        self.dlc()
    }
    fn data(&self) -> &[u8] {
        self.bytes()
    }
}

impl core::fmt::Debug for Frame {
    /// As candump prints it: `301#FF02`, `1FFFFFFF#R4`.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.id {
            Id::Standard(id) => write!(f, "{:03X}#", id.as_raw())?,
            Id::Extended(id) => write!(f, "{:08X}#", id.as_raw())?,
        }
        if self.remote {
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

/// An 11-bit identifier; the upper bits of `id` are dropped, so that constants need no error path.
pub const fn standard(id: u16) -> Id {
    match StandardId::new(id & 0x7FF) {
        Some(id) => Id::Standard(id),
        None => Id::Standard(StandardId::ZERO),
    }
}

/// A 29-bit identifier; the upper bits of `id` are dropped.
pub const fn extended(id: u32) -> Id {
    match ExtendedId::new(id & 0x1FFF_FFFF) {
        Some(id) => Id::Extended(id),
        None => Id::Extended(ExtendedId::ZERO),
    }
}

/// The ten bit rates of the sensors that are replaced.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BitRate {
    /// 10 kbit/s
    K10,
    /// 20 kbit/s
    K20,
    /// 50 kbit/s
    K50,
    /// 62.5 kbit/s
    K62_5,
    /// 100 kbit/s
    K100,
    /// 125 kbit/s
    K125,
    /// 250 kbit/s
    K250,
    /// 500 kbit/s
    K500,
    /// 800 kbit/s
    K800,
    /// 1 Mbit/s
    M1,
}

impl BitRate {
    /// All ten, slowest first.
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

    /// Bits per second.
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

/// One acceptance filter: frames of this identifier's format that agree with it in the bits set in `mask`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Filter {
    /// The identifier to compare with; its format (11 or 29 bit) always counts.
    pub id: Id,
    /// The identifier bits that count, right-aligned (11 or 29 bits).
    pub mask: u32,
}

impl Filter {
    /// Accepts exactly `id`, data and remote frames.
    pub const fn exact(id: Id) -> Self {
        Self {
            id,
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

/// The acceptance filters of a node: a frame that none of them accepts is not passed to it.
pub type Filters = heapless::Vec<Filter, 8>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_eight_bytes_make_no_frame() {
        assert!(Frame::data(standard(1), &[0; 9]).is_none());
        assert!(Frame::remote(standard(1), 9).is_none());
        assert_eq!(Frame::data(standard(1), &[0; 8]).map(|f| f.dlc()), Some(8));
    }

    #[test]
    fn frames_print_as_candump_does() {
        let text = |frame: Option<Frame>| std::format!("{:?}", frame.unwrap());
        assert_eq!(text(Frame::data(standard(0x301), &[0xFF, 2])), "301#FF02");
        assert_eq!(text(Frame::data(extended(0x361), &[])), "00000361#");
        assert_eq!(text(Frame::remote(standard(0x7FF), 4)), "7FF#R4");
        assert_eq!(text(Frame::remote(standard(0x7FF), 0)), "7FF#R");
    }

    #[test]
    fn a_filter_tells_the_formats_apart() {
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
