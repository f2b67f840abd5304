//! The CRC calculation unit (RM0008, chapter 4): CRC-32 with the polynomial 04C11DB7h, word by word, most significant bit first.
//!
//! | offset | register | |
//! |---|---|---|
//! | 00h | CRC_DR | a write calculates, a read returns the result |
//! | 04h | CRC_IDR | 8 bits of general purpose |
//! | 08h | CRC_CR | RESET |

use super::io::AccessError;
use crc::{CRC_32_MPEG_2, Crc};

const UNIT: Crc<u32> = Crc::<u32>::new(&CRC_32_MPEG_2);

/// CRC_CR.RESET.
const RESET: u32 = 1;

/// The unit.
#[derive(Clone, Copy, Debug)]
pub struct CrcUnit {
    value: u32,
    purpose: u8,
}

impl Default for CrcUnit {
    /// The unit after a reset.
    fn default() -> Self {
        Self {
            value: UNIT.algorithm.init,
            purpose: 0,
        }
    }
}

impl CrcUnit {
    /// Reads the register at `offset`.
    pub fn read(&self, offset: u32) -> Result<u32, AccessError> {
        match offset {
            0x00 => Ok(self.value),
            0x04 => Ok(self.purpose.into()),
            // RESET is cleared by hardware.
            0x08 => Ok(0),
            _ => Err(AccessError::Unmapped),
        }
    }

    /// Writes the register at `offset`.
    pub fn write(&mut self, offset: u32, value: u32) -> Result<(), AccessError> {
        match offset {
            0x00 => {
                let mut digest = UNIT.digest_with_initial(self.value);
                digest.update(&value.to_be_bytes());
                self.value = digest.finalize();
            }
            0x04 => self.purpose = value as u8,
            0x08 if value & RESET != 0 => self.value = UNIT.algorithm.init,
            0x08 => {}
            _ => return Err(AccessError::Unmapped),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_calculates_the_crc_of_words() {
        let mut unit = CrcUnit::default();
        assert_eq!(unit.read(0x00).unwrap(), 0xFFFF_FFFF);
        unit.write(0x00, 0x3132_3334).unwrap();
        unit.write(0x00, 0x3536_3738).unwrap();
        assert_eq!(unit.read(0x00).unwrap(), UNIT.checksum(b"12345678"));
        unit.write(0x08, RESET).unwrap();
        assert_eq!(unit.read(0x00).unwrap(), 0xFFFF_FFFF);
    }
}
