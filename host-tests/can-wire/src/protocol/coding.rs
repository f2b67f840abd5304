//! Frames to bits and back: fields, stuffing and checksum (ISO 11898-1, formats of data and remote frames).
//!
//! ```text
//!  bit       0     1..12    12    13    14   15..19   19..             (11 bit)
//!           SOF | ID 28-18 | RTR | IDE | r0 |  DLC  | data | CRC 15
//!           SOF | ID 28-18 | SRR | IDE | ID 17-0 | RTR | r1 | r0 |  DLC  | data | CRC 15
//!  bit       0     1..12    12    13    14..32    32    33   34   35..39   39..   (29 bit)
//! ```
//!
//! The positions count without stuff bits. A bit is true when it is recessive, which the standard writes as 1.

use embedded_can::Id;
use plumbline::can::{Frame, extended, standard};

/// The position of the identifier extension flag.
const IDE: u8 = 13;

/// The position of the remote transmission request, which ends the arbitration field: 11 bit, 29 bit.
const RTR: [u8; 2] = [12, 32];

/// The position of the data length code: 11 bit, 29 bit.
const DLC: [u8; 2] = [15, 35];

/// The bits of the data length code and of the checksum.
const DLC_BITS: u8 = 4;
const CRC_BITS: u8 = 15;

/// Equal bits after which a stuff bit follows.
const STUFF: u8 = 5;

/// A frame to be sent: its bits from start of frame to CRC sequence without stuff bits, 118 at most.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Outgoing {
    bits: u128,
    count: u8,
}

impl Outgoing {
    pub(super) fn new(frame: &Frame) -> Self {
        let mut out = Self { bits: 0, count: 0 };
        let remote = u32::from(frame.is_remote());
        out.push(0, 1);
        match frame.id() {
            Id::Standard(id) => {
                out.push(id.as_raw().into(), 11);
                out.push(remote << 2, 3);
            }
            Id::Extended(id) => {
                out.push(id.as_raw() >> 18, 11);
                out.push(0b11, 2);
                out.push(id.as_raw() & 0x3_FFFF, 18);
                out.push(remote << 2, 3);
            }
        }
        out.push(frame.dlc() as u32, DLC_BITS);
        for byte in frame.bytes() {
            out.push(u32::from(*byte), 8);
        }
        let crc = (0..out.count).fold(0, |crc, position| crc15(crc, out.at(position)));
        out.push(crc.into(), CRC_BITS);
        out
    }

    /// The bit that follows the bits in `seen`, stuff bits included.
    pub(super) fn next(&self, seen: &Incoming) -> bool {
        if seen.stuff_is_due() {
            !seen.last
        } else {
            self.at(seen.count)
        }
    }

    fn push(&mut self, value: u32, count: u8) {
        self.bits = self.bits << count | u128::from(value);
        self.count += count;
    }

    fn at(&self, position: u8) -> bool {
        self.bits >> (self.count - 1 - position) & 1 == 1
    }
}

/// More than five equal bits in a row.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct StuffError;

/// A frame during reception, from start of frame to CRC sequence; the transmitter tracks its own frame in the same way.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Incoming {
    bits: u128,
    /// The number of bits without stuff bits.
    count: u8,
    /// The length of the current run of equal bits, stuff bits included, and their value.
    run: u8,
    last: bool,
    crc: u16,
    extended: bool,
    /// The position after the CRC sequence; 0 until it is known.
    end: u8,
}

impl Incoming {
    /// True when the next bit is a stuff bit.
    pub(super) fn stuff_is_due(&self) -> bool {
        self.run == STUFF
    }

    /// True when the next bit belongs to the arbitration field: the identifier, RTR, SRR, or IDE of an extended frame.
    pub(super) fn in_arbitration(&self) -> bool {
        let end = if self.count > IDE {
            RTR[usize::from(self.extended)]
        } else {
            IDE
        };
        (1..=end).contains(&self.count)
    }

    /// True when the checksum, and the stuff bit that may follow it, have been received.
    pub(super) fn is_complete(&self) -> bool {
        self.count == self.end && self.count != 0 && !self.stuff_is_due()
    }

    /// True when the checksum is correct: the remainder including the checksum is zero.
    pub(super) fn is_intact(&self) -> bool {
        self.crc == 0
    }

    /// Processes the next bit of a frame. Six equal bits are an error.
    pub(super) fn push(&mut self, bit: bool) -> Result<(), StuffError> {
        if self.stuff_is_due() {
            if bit == self.last {
                return Err(StuffError);
            }
            self.last = bit;
            self.run = 1;
            return Ok(());
        }
        let goes_on = bit == self.last && self.count != 0;
        self.run = if goes_on { self.run + 1 } else { 1 };
        self.last = bit;
        self.crc = crc15(self.crc, bit);
        self.bits = self.bits << 1 | u128::from(bit);
        if self.count == IDE {
            self.extended = bit;
        }
        self.count += 1;
        if self.count == DLC[usize::from(self.extended)] + DLC_BITS {
            self.end = self.count + 8 * self.data_bytes() + CRC_BITS;
        }
        Ok(())
    }

    /// The frame, if it is complete.
    pub(super) fn frame(&self) -> Option<Frame> {
        let id = if self.extended {
            extended(self.field(1, 11) << 18 | self.field(14, 18))
        } else {
            standard(self.field(1, 11) as u16)
        };
        if self.is_remote() {
            return Frame::remote(id, self.length().into());
        }
        let start = self.dlc_position() + DLC_BITS;
        let bytes: [u8; 8] = std::array::from_fn(|index| {
            let position = start + 8 * index as u8;
            if index < usize::from(self.length()) {
                self.field(position, 8) as u8
            } else {
                0
            }
        });
        Frame::data(id, &bytes[..usize::from(self.length())])
    }

    fn dlc_position(&self) -> u8 {
        DLC[usize::from(self.extended)]
    }

    fn is_remote(&self) -> bool {
        self.field(RTR[usize::from(self.extended)], 1) == 1
    }

    /// The data length code; 9 to 15 mean 8 as well.
    fn length(&self) -> u8 {
        (self.field(self.dlc_position(), DLC_BITS) as u8).min(8)
    }

    fn data_bytes(&self) -> u8 {
        if self.is_remote() { 0 } else { self.length() }
    }

    fn field(&self, position: u8, bits: u8) -> u32 {
        let value = self.bits >> (self.count - position - bits);
        value as u32 & ((1 << bits) - 1)
    }
}

/// Extends a CRC-15/CAN by one bit: x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1.
fn crc15(crc: u16, bit: bool) -> u16 {
    let feedback = bit ^ (crc >> 14 & 1 == 1);
    (crc << 1 & 0x7FFF) ^ if feedback { 0x4599 } else { 0 }
}
