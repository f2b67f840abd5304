//! A record in a file: its length and its CRC-32 (both 32 bits, little endian), and its bytes.

use crc::{CRC_32_ISO_HDLC, Crc};
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

/// The longest record.
const LONGEST: usize = 1 << 16;

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// The record with these bytes.
pub fn encoded(bytes: &[u8]) -> Vec<u8> {
    debug_assert!((1..=LONGEST).contains(&bytes.len()));
    let length = (bytes.len() as u32).to_le_bytes();
    let crc = CRC.checksum(bytes).to_le_bytes();
    [&length[..], &crc, bytes].concat()
}

/// The next record of a file; None: the end, or damaged bytes.
pub fn record(file: &mut impl Read) -> io::Result<Option<Vec<u8>>> {
    let mut head = [0; 8];
    let mut read = |bytes: &mut [u8]| match file.read_exact(bytes) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
        read => read.map(|()| true),
    };
    if !read(&mut head)? {
        return Ok(None);
    }
    let [length, crc] =
        [0, 4].map(|at| u32::from_le_bytes([0, 1, 2, 3].map(|byte| head[at + byte])));
    // A power cut can leave zeros at the end of a file.
    if !(1..=LONGEST).contains(&(length as usize)) {
        return Ok(None);
    }
    let mut bytes = vec![0; length as usize];
    let is_valid = read(&mut bytes)? && CRC.checksum(&bytes) == crc;
    Ok(is_valid.then_some(bytes))
}

/// The number of valid records at the start of a file, and their length.
pub fn valid(path: &Path) -> io::Result<(u64, u64)> {
    let mut file = BufReader::new(File::open(path)?);
    let (mut count, mut length) = (0, 0);
    while let Some(bytes) = record(&mut file)? {
        count += 1;
        length += 8 + bytes.len() as u64;
    }
    Ok((count, length))
}
