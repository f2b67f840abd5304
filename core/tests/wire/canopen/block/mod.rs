//! SDO block transfer (CiA 301, 7.2.4.3.8 to 7.2.4.3.16): both directions with exact bytes, lost and repeated frames, errors and
//! the order of the frames of other services.

mod download;
mod errors;
mod upload;

use crate::tester::Tester;
use crate::tester::canopen::{abort, frame, write_request};
use crate::tester::gauge::{Gauge, TEXT, booted, text};
use crc::{CRC_16_XMODEM, Crc};
use plumbline::node::{BusEvent, BusState, Node};
use proptest::prelude::*;

const NOTHING: [&str; 0] = [];
/// Initiates the upload of 2100h with CRC in blocks of 127 segments.
const UPLOAD: &str = "632#A40021007F000000";
const START: &str = "632#A300000000000000";
const END: &str = "632#A100000000000000";
/// Index and sub-index of 2100h in an abort.
const OBJECT: &str = "002100";
const TIME_OUT: u32 = 0x0504_0000;
const COMMAND: u32 = 0x0504_0001;
const BLOCK_SIZE: u32 = 0x0504_0002;
const SEQUENCE_NUMBER: u32 = 0x0504_0003;
const CRC: u32 = 0x0504_0004;

fn crc(data: &[u8]) -> u16 {
    Crc::<u16>::new(&CRC_16_XMODEM).checksum(data)
}

fn aborted(code: u32) -> Vec<String> {
    vec![format!("5B2#{}", abort(OBJECT, code))]
}

fn request(bytes: &[u8]) -> String {
    let data: String = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    format!("632#{data:0<16}")
}

/// The segments of data, numbered from 1 in each block.
fn segments(data: &[u8], block: usize) -> Vec<[u8; 8]> {
    let count = data.len().div_ceil(7).max(1);
    let segment = |place: usize| {
        let mut bytes = [0; 8];
        bytes[0] = (place % block + 1) as u8 | if place + 1 == count { 0x80 } else { 0 };
        let rest = &data[7 * place..];
        let used = rest.len().min(7);
        bytes[1..=used].copy_from_slice(&rest[..used]);
        bytes
    };
    (0..count).map(segment).collect()
}

fn replies(frames: &[[u8; 8]]) -> Vec<String> {
    let reply = |bytes: &[u8; 8]| request(bytes).replace("632#", "5B2#");
    frames.iter().map(reply).collect()
}

/// A gauge whose text has this length.
fn with_text(length: usize) -> Tester<Gauge> {
    let mut t = booted();
    t.write(0x2101, 0, 1, length as u32).unwrap();
    t
}

fn acknowledge(t: &mut Tester<Gauge>, number: u8, size: u8) -> Vec<String> {
    t.exchange(&request(&[0xA2, number, size]))
}

/// The message for the end of an upload of data.
fn upload_end(data: &[u8], has_crc: bool) -> Vec<String> {
    let unused = (7 - data.len() % 7) % 7;
    let unused = if data.is_empty() { 7 } else { unused };
    let [low, high] = if has_crc { crc(data) } else { 0 }.to_le_bytes();
    replies(&[[0xC1 | (unused as u8) << 2, low, high, 0, 0, 0, 0, 0]])
}

/// The message of the client for the end of a download.
fn download_end(data: &[u8], crc: u16) -> String {
    let unused = (7 - data.len() % 7) % 7;
    let unused = if data.is_empty() { 7 } else { unused };
    let [low, high] = crc.to_le_bytes();
    request(&[0xC1 | (unused as u8) << 2, low, high])
}

fn initiate_download(length: usize) -> String {
    request(&[0xC6, 0x00, 0x21, 0x00, length as u8])
}

const ACCEPTED: &str = "5B2#A40021001F000000";
const WRITTEN: &str = "5B2#A100000000000000";

/// Writes a text by block transfer; `lose` tells which frames of the client are lost. Returns the last reply.
fn download(t: &mut Tester<Gauge>, data: &[u8], mut lose: impl FnMut() -> bool) -> Vec<String> {
    assert_eq!(t.exchange(&initiate_download(data.len())), [ACCEPTED]);
    let count = data.len().div_ceil(7).max(1);
    let mut received = 0;
    let mut all_lost = false;
    while received < count {
        let block: Vec<_> = segments(&data[7 * received..], 31)
            .into_iter()
            .take(31)
            .collect();
        for (place, bytes) in block.iter().enumerate() {
            let ends = place + 1 == block.len();
            let lost = lose();
            // A client gives up if it loses all segments twice.
            if lost && !ends && !(all_lost && place == 0) {
                continue;
            }
            let sent = t.exchange(&request(bytes));
            assert_eq!(sent.len(), usize::from(ends), "{sent:?}");
            if ends {
                let reply = frame(&sent[0]);
                let &[0xA2, number, 31, 0, 0, 0, 0, 0] = reply.bytes() else {
                    panic!("{sent:?}");
                };
                received += usize::from(number);
                all_lost = number == 0;
            }
        }
    }
    t.exchange(&download_end(data, crc(data)))
}
