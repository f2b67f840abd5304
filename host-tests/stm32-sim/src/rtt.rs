//! The log of a program with the feature `defmt`, as a probe reads it from RAM (RTT).
//!
//! A message is a frame of bytes, encoded in rzCOBS and followed by 0: two bytes are the number of its text, which is a symbol of the ELF
//! file, then follow the values.

use super::Microcontroller;
use object::read::elf::ElfFile32;
use object::{Object, ObjectSection, ObjectSymbol};

/// A message: its text, and the bytes of its values.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Message {
    /// The text, with the places of the values.
    pub text: String,
    /// The bytes of the time and of the values, as encoded by defmt.
    pub values: Vec<u8>,
}

/// The messages since the start of the program with this ELF file. None if the probe does not reach the RAM, or if there is no log.
pub fn read(microcontroller: &Microcontroller, elf: &[u8]) -> Option<Vec<Message>> {
    let block = microcontroller.image().address_of("_SEGGER_RTT")?;
    let word = |address: u32| {
        let bytes = microcontroller.probe_read(address, 4)?;
        Some(u32::from_le_bytes(*bytes.first_chunk()?))
    };
    // The identifier and the numbers of the channels; the first channel: name, buffer, size, write position.
    if microcontroller.probe_read(block, 10)? != b"SEGGER RTT" {
        return None;
    }
    let [buffer, written] = [word(block + 28)?, word(block + 36)?];
    let bytes = microcontroller.probe_read(buffer, written as usize)?;
    let texts = texts(elf)?;
    let frames = bytes.split(|byte| *byte == 0).filter(|it| !it.is_empty());
    frames
        .map(|frame| {
            let frame = decode(frame)?;
            let (number, values) = frame.split_first_chunk()?;
            let number = u16::from_le_bytes(*number);
            let (_, text) = texts.iter().find(|(known, _)| *known == number)?;
            Some(Message {
                text: text.clone(),
                values: values.to_vec(),
            })
        })
        .collect()
}

/// The texts with their numbers: the symbols of the section .defmt, whose names are JSON.
fn texts(elf: &[u8]) -> Option<Vec<(u16, String)>> {
    let file: ElfFile32 = ElfFile32::parse(elf).ok()?;
    let section = file.section_by_name(".defmt")?.index();
    let symbols = file.symbols();
    let texts = symbols.filter(|symbol| symbol.section_index() == Some(section));
    let texts = texts.filter_map(|symbol| {
        let (_, rest) = symbol.name().ok()?.split_once("\"data\":\"")?;
        let (text, _) = rest.split_once('"')?;
        Some((symbol.address() as u16, text.to_owned()))
    });
    Some(texts.collect())
}

/// Decodes rzCOBS from the end: each code follows the bytes that it describes.
fn decode(frame: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = frame.iter().rev().copied();
    let mut decoded = Vec::new();
    while let Some(code) = bytes.next() {
        match code {
            0 => return None,
            0x01..=0x7F => {
                for bit in (0..7).rev() {
                    let is_zero = code >> bit & 1 != 0;
                    decoded.push(if is_zero { 0 } else { bytes.next()? });
                }
            }
            0x80..=0xFE => {
                decoded.push(0);
                for _ in 0..(code & 0x7F) + 7 {
                    decoded.push(bytes.next()?);
                }
            }
            0xFF => {
                for _ in 0..134 {
                    decoded.push(bytes.next()?);
                }
            }
        }
    }
    decoded.reverse();
    Some(decoded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decode_inserts_zero_bytes_of_the_code() {
        // Seven bytes, of which the second is 0.
        assert_eq!(
            decode(&[1, 3, 4, 5, 6, 7, 0b000_0010]),
            Some(vec![1, 0, 3, 4, 5, 6, 7])
        );
        assert_eq!(decode(&[0x7F]), Some(vec![0; 7]));
        assert_eq!(decode(&[0x01]), None, "bytes are missing");
    }
}
