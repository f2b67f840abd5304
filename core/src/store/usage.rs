//! The usage of a device: operating time, starts, saves, erases and extremes. It is stored beside the calibration.
//!
//! # Byte map
//!
//! ```text
//!  byte 0     1         5          9        13       17        21         23        25
//!       +-----+---------+----------+--------+--------+---------+----------+---------+---------+
//!       | 02h | serial  | minutes  | starts | saves  | erases  | coldest  | warmest | shock   |
//!       |     | u32     | u32      | u32    | u32    | u32     | i16      | i16     | u16     |
//!       +-----+---------+----------+--------+--------+---------+----------+---------+---------+
//! ```
//!
//! Numbers are little-endian. The record belongs to the chip with its serial number, as a calibration does.
//!
//! # Wear
//!
//! A record has 44 bytes. It is written ten seconds after a start, then at most once an hour. Each slot of the Blue Pill, a page of 1 KiB,
//! holds 13 to 20 of them beside the calibration and the parameters. A page is erased once for each two fillings. With 24 records a day,
//! which is an operation without a pause, that is at most once in 26 hours. The flash permits 10,000 erases of a page: 28 years. A device
//! that runs 10 hours a day with three starts writes 12 records a day, and lasts twice as long.

/// The payload of the record in bytes.
pub(super) const SIZE: usize = OWNER + 22;
/// The size of mark and serial number.
pub(super) const OWNER: usize = 5;
/// The first byte.
pub(super) const MARK: u8 = 2;

/// The usage of a device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Usage {
    /// The time in operation in minutes.
    pub minutes: u32,
    /// The number of starts.
    pub starts: u32,
    /// The number of saves of parameters.
    pub saves: u32,
    /// The number of erased slots.
    pub erases: u32,
    /// The lowest temperature of the measuring element in 0.01 degC; `i16::MAX` without a reading.
    pub coldest: i16,
    /// The highest temperature of the measuring element in 0.01 degC; `i16::MIN` without a reading.
    pub warmest: i16,
    /// The highest acceleration in mg, gravity included.
    pub shock: u16,
}

impl Usage {
    /// Of a new device.
    pub const NONE: Self = Self {
        minutes: 0,
        starts: 0,
        saves: 0,
        erases: 0,
        coldest: i16::MAX,
        warmest: i16::MIN,
        shock: 0,
    };

    /// The payload of the record, see the byte map.
    pub(super) fn encode(&self, serial: u32) -> [u8; SIZE] {
        let [s0, s1, s2, s3] = serial.to_le_bytes();
        let [a0, a1, a2, a3] = self.minutes.to_le_bytes();
        let [b0, b1, b2, b3] = self.starts.to_le_bytes();
        let [c0, c1, c2, c3] = self.saves.to_le_bytes();
        let [d0, d1, d2, d3] = self.erases.to_le_bytes();
        let [e0, e1] = self.coldest.to_le_bytes();
        let [f0, f1] = self.warmest.to_le_bytes();
        let [g0, g1] = self.shock.to_le_bytes();
        [
            MARK, s0, s1, s2, s3, a0, a1, a2, a3, b0, b1, b2, b3, c0, c1, c2, c3, d0, d1, d2, d3,
            e0, e1, f0, f1, g0, g1,
        ]
    }

    /// Decodes the payload of a record.
    pub(super) fn decode(bytes: &[u8; SIZE]) -> Self {
        let [
            _,
            _,
            _,
            _,
            _,
            a0,
            a1,
            a2,
            a3,
            b0,
            b1,
            b2,
            b3,
            c0,
            c1,
            c2,
            c3,
            d0,
            d1,
            d2,
            d3,
            e0,
            e1,
            f0,
            f1,
            g0,
            g1,
        ] = *bytes;
        Self {
            minutes: u32::from_le_bytes([a0, a1, a2, a3]),
            starts: u32::from_le_bytes([b0, b1, b2, b3]),
            saves: u32::from_le_bytes([c0, c1, c2, c3]),
            erases: u32::from_le_bytes([d0, d1, d2, d3]),
            coldest: i16::from_le_bytes([e0, e1]),
            warmest: i16::from_le_bytes([f0, f1]),
            shock: u16::from_le_bytes([g0, g1]),
        }
    }
}

impl Default for Usage {
    fn default() -> Self {
        Self::NONE
    }
}
