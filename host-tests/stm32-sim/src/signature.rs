//! The electronic signature in system memory: flash size and unique device identifier (RM0008, chapter 30: at 1FFF_F7E0h and
//! 1FFF_F7E8h; RM0390, chapter 34: at 1FFF_7A22h and 1FFF_7A10h).

use super::board::Board;
use super::io::{AccessError, Width};
use crc::{CRC_32_ISO_HDLC, Crc};

/// The unique device identifier for which the firmware calculates this serial number: the CRC-32 of its bytes.
pub fn unique_id(serial: u32) -> [u32; 3] {
    /// The polynomial of the CRC, reflected.
    const POLYNOMIAL: u32 = 0xEDB8_8320;
    let [low, middle] = [0x0034_0021_u32, 0x3438_510D];
    let before = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    let mut before = before.digest();
    before.update(&u64::to_le_bytes(u64::from(middle) << 32 | u64::from(low)));
    // The checksum register, 32 bits before the end.
    let wanted = (0..32).fold(!serial, |register, _| match register >> 31 {
        0 => register << 1,
        _ => (register ^ POLYNOMIAL) << 1 | 1,
    });
    [low, middle, wanted ^ !before.finalize()]
}

/// The signature of one part.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Signature {
    board: Board,
    unique_id: [u32; 3],
}

impl Signature {
    /// A part with this unique device identifier, bits 31:0 first.
    pub fn new(board: Board, unique_id: [u32; 3]) -> Self {
        Self { board, unique_id }
    }

    /// The unique identifier of the chip, 96 bits.
    pub fn unique_id(&self) -> [u32; 3] {
        self.unique_id
    }

    /// Reads system memory. The identifier can be read by byte, half-word and word.
    pub fn read(&self, address: u32, width: Width) -> Result<u32, AccessError> {
        let facts = self.board.chip().facts();
        let [low, high] = ((self.board.facts().flash / 1024) as u16).to_le_bytes();
        let byte = |address: u32| match address.checked_sub(facts.unique_id_at) {
            Some(offset @ 0..12) => {
                let word = self.unique_id[offset as usize / 4];
                Ok(word.to_le_bytes()[offset as usize % 4])
            }
            _ if address == facts.flash_size_at => Ok(low),
            _ if address == facts.flash_size_at + 1 => Ok(high),
            _ => Err(AccessError::Unmapped),
        };
        (0..width.bytes() as u32).try_fold(0, |value, at| {
            Ok(value | u32::from(byte(address + at)?) << (8 * at))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_serial_number_has_identifier() {
        for serial in [0, 1, 0x1234_5678, u32::MAX] {
            let bytes: Vec<u8> = unique_id(serial)
                .into_iter()
                .flat_map(u32::to_le_bytes)
                .collect();
            assert_eq!(Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&bytes), serial);
        }
    }

    #[test]
    fn signature_has_size_and_identifier() {
        let part = Signature::new(Board::BluePill, [0x4433_2211, 0x8877_6655, 0xCCBB_AA99]);
        assert_eq!(part.read(0x1FFF_F7E0, Width::HalfWord), Ok(64));
        assert_eq!(part.read(0x1FFF_F7E8, Width::Word), Ok(0x4433_2211));
        assert_eq!(part.read(0x1FFF_F7F0, Width::Word), Ok(0xCCBB_AA99));
        assert_eq!(part.read(0x1FFF_F7EA, Width::HalfWord), Ok(0x4433));
        assert_eq!(part.read(0x1FFF_F7F3, Width::Byte), Ok(0xCC));
        assert_eq!(
            part.read(0x1FFF_F7F4, Width::Byte),
            Err(AccessError::Unmapped)
        );
        let part = Signature::new(Board::NucleoF446, [1, 2, 3]);
        assert_eq!(part.read(0x1FFF_7A22, Width::HalfWord), Ok(512));
        assert_eq!(part.read(0x1FFF_7A18, Width::Word), Ok(3));
    }
}
