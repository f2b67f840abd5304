//! Tests of the bootloader through its SDO server.

use super::super::element::Element;
use super::super::header::crc;
use super::super::record::Contact;
use super::super::server::UpdateServer;
use super::super::simulated::{DEVICE, Flash, file, sign};
use super::*;
use crate::can::{BitRate, CanId};
use crate::store::ImageId;
use crate::time::{Instant, after, millis};

const CONTACT: Contact = Contact {
    rate: BitRate::K250,
    request: CanId::standard(0x601),
    reply: CanId::standard(0x581),
    boot_up: CanId::standard(0x701),
    vendor: 0x12,
    product_code: 0x34,
    serial: 0x56,
};

/// A bootloader and its client.
struct Bus {
    update: Update<Flash>,
    server: UpdateServer,
    now: Instant,
}

impl Bus {
    fn new(mut flash: Flash) -> Self {
        let program = Program::of(&flash).committed(&mut flash);
        let record = Record::new(ImageId::new(3), Element::Ism330dhcx, &CONTACT, crc);
        Self {
            update: Update::new(flash, program, DEVICE, Some(record)),
            server: UpdateServer::new(),
            now: Instant::from_ticks(0),
        }
    }

    fn send(&mut self, request: [u8; 8]) -> Option<[u8; 8]> {
        self.server.serve(&mut self.update, self.now, request)
    }

    /// Reads an object.
    fn read(&mut self, index: u16, sub: u8) -> [u8; 8] {
        let [low, high] = index.to_le_bytes();
        self.send([0x40, low, high, sub, 0, 0, 0, 0]).unwrap()
    }

    /// Reads a number of 32 bits.
    fn number(&mut self, index: u16, sub: u8) -> u32 {
        let [command, _, _, _, data @ ..] = self.read(index, sub);
        assert_eq!(command, 0x43, "{index:04X}h:{sub:02X}");
        u32::from_le_bytes(data)
    }

    /// Writes 1F51h:01.
    fn control(&mut self, value: u8) -> [u8; 8] {
        self.send([0x2F, 0x51, 0x1F, 1, value, 0, 0, 0]).unwrap()
    }

    /// A segmented download of 1F50h:01. The first reply that is an abort, otherwise the last one.
    fn segmented(&mut self, file: &[u8]) -> [u8; 8] {
        let [a, b, c, d] = (file.len() as u32).to_le_bytes();
        let mut reply = self.send([0x21, 0x50, 0x1F, 1, a, b, c, d]).unwrap();
        let count = file.chunks(7).count();
        for (number, piece) in file.chunks(7).enumerate() {
            if reply[0] == 0x80 {
                break;
            }
            let mut request = [0; 8];
            request[1..=piece.len()].copy_from_slice(piece);
            let is_last = number + 1 == count;
            request[0] = (number as u8 & 1) << 4 | (7 - piece.len() as u8) << 1 | u8::from(is_last);
            reply = self.send(request).unwrap();
        }
        reply
    }

    /// A block download of 1F50h:01. The first reply that is an abort, otherwise the last one.
    fn block(&mut self, file: &[u8]) -> [u8; 8] {
        let [a, b, c, d] = (file.len() as u32).to_le_bytes();
        let reply = self.send([0xC6, 0x50, 0x1F, 1, a, b, c, d]).unwrap();
        if reply[0] == 0x80 {
            return reply;
        }
        assert_eq!(reply, [0xA0, 0x50, 0x1F, 1, 31, 0, 0, 0]);
        let blocks = file.chunks(31 * 7).count();
        for (block, data) in file.chunks(31 * 7).enumerate() {
            let segments = data.chunks(7).count();
            for (number, piece) in data.chunks(7).enumerate() {
                let mut request = [0; 8];
                request[1..=piece.len()].copy_from_slice(piece);
                let is_end = number + 1 == segments;
                let is_last = is_end && block + 1 == blocks;
                request[0] = (number as u8 + 1) | u8::from(is_last) << 7;
                let reply = self.send(request);
                if is_end {
                    let reply = reply.unwrap();
                    if reply[0] == 0x80 {
                        return reply;
                    }
                    assert_eq!(reply, [0xA2, segments as u8, 31, 0, 0, 0, 0, 0]);
                } else {
                    // A client listens at the end of a block only.
                    assert_eq!(reply, None);
                }
            }
        }
        let unused = (file.len().next_multiple_of(7) - file.len()) as u8;
        self.send([0xC1 | unused << 2, 0, 0, 0, 0, 0, 0, 0])
            .unwrap()
    }

    /// The state that a client sees: 1F57h and 1F56h.
    fn state(&mut self) -> (u32, bool) {
        (self.number(0x1F57, 1), self.number(0x1F56, 1) != 0)
    }
}

/// A client downloads: with or without blocks.
type Download = fn(&mut Bus, &[u8]) -> [u8; 8];
const KINDS: [Download; 2] = [Bus::block, Bus::segmented];

fn abort(index: u16, sub: u8, code: u32) -> [u8; 8] {
    let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), code.to_le_bytes());
    [0x80, low, high, sub, a, b, c, d]
}

/// 1F51h:01 is confirmed.
const CONFIRMED: [u8; 8] = [0x60, 0x51, 0x1F, 1, 0, 0, 0, 0];

#[test]
fn blank_sensor_takes_a_program_in_blocks_and_in_segments_and_starts_it() {
    let file = file(0x0001_0203, 3000, 0);
    for download in KINDS {
        let mut bus = Bus::new(Flash::blank());
        assert_eq!(bus.state(), (2, false));
        assert_eq!(bus.control(1), abort(0x1F51, 1, 0x0800_0022));
        assert_eq!(bus.control(3), CONFIRMED);
        // Clients wait for 0 after the clear command.
        assert_eq!(bus.state(), (0, false));
        let reply = download(&mut bus, &file);
        assert!(matches!(reply[0], 0xA1 | 0x20 | 0x30));
        assert_eq!(bus.state(), (0, true));
        assert_eq!(bus.number(0x1018, 3), 0x0001_0203);
        let [.., a, b, c, d] = *file[..24].last_chunk::<4>().unwrap();
        assert_eq!(bus.number(0x1F56, 1), u32::from_le_bytes([a, b, c, d]));
        assert!(!bus.update.take_restart());
        assert_eq!(bus.control(1), CONFIRMED);
        assert!(bus.update.take_restart());
        assert!(!bus.update.take_restart());
    }
}

#[test]
fn refused_image_keeps_the_program() {
    let old = file(0x0001_0000, 2048, 0);
    let new = file(0x0001_0001, 3000, 1);
    let with = |place: usize, value: u8| {
        let mut body = new[SIZE_OF_HEADER..].to_vec();
        let mut header = *new.first_chunk::<SIZE_OF_HEADER>().unwrap();
        header[place] = value;
        body[header::PLACE..][..SIZE_OF_HEADER].copy_from_slice(&header);
        let page = crate::update::header::crc(&header::first_page_parts(&body));
        header[56..60].copy_from_slice(&page.to_le_bytes());
        body[header::PLACE..][..SIZE_OF_HEADER].fill(0xFF);
        [&header[..], &body].concat()
    };
    let mut damaged = new.clone();
    damaged[100] ^= 1;
    let cases: [(_, _, u32, u32); 7] = [
        ("magic", with(0, b'X'), 0x0609_0030, 4),
        ("layout", with(5, 2), 0x0609_0030, 4),
        ("product", with(6, 4), 0x0609_0030, 4),
        ("board", with(8, 2), 0x0609_0030, 4),
        ("older", with(14, 0), 0x0800_0022, 14),
        ("longer than the slot", with(18, 1), 0x0609_0030, 4),
        ("damaged", damaged, 0x0800_0020, 6),
    ];
    for (name, file, code, status) in cases {
        for download in KINDS {
            let mut bus = Bus::new(Flash::blank());
            bus.control(3);
            download(&mut bus, &old);
            let before = bus.update.slot.bytes.clone();
            bus.control(3);
            assert_eq!(download(&mut bus, &file), abort(0x1F50, 1, code), "{name}");
            assert_eq!(bus.state(), (status, true), "{name}");
            assert_eq!(bus.update.slot.bytes, before, "{name}");
        }
    }
}

const SIZE_OF_HEADER: usize = header::SIZE;

#[test]
fn each_wrong_request_has_its_abort_code() {
    let mut bus = Bus::new(Flash::blank());
    let mut write = |request: [u8; 8]| bus.send(request).unwrap();
    assert_eq!(
        write([0x2F, 0x51, 0x1F, 1, 7, 0, 0, 0]),
        abort(0x1F51, 1, 0x0609_0030)
    );
    assert_eq!(
        write([0x2B, 0x51, 0x1F, 1, 1, 0, 0, 0]),
        abort(0x1F51, 1, 0x0607_0012)
    );
    assert_eq!(
        write([0x23, 0x57, 0x1F, 1, 0, 0, 0, 0]),
        abort(0x1F57, 1, 0x0601_0002)
    );
    assert_eq!(
        write([0x23, 0x50, 0x1F, 1, 0, 0, 0, 0]),
        abort(0x1F50, 1, 0x0607_0013)
    );
    assert_eq!(
        write([0x21, 0x50, 0x1F, 1, 0, 0, 16, 0]),
        abort(0x1F50, 1, 0x0607_0012)
    );
    assert_eq!(bus.read(0x1F50, 1), abort(0x1F50, 1, 0x0601_0001));
    assert_eq!(bus.read(0x1F50, 2), abort(0x1F50, 2, 0x0609_0011));
    assert_eq!(bus.read(0x2000, 0), abort(0x2000, 0, 0x0602_0000));
}

#[test]
fn identity_is_that_of_the_sensor_and_the_device_type_is_not() {
    let mut bus = Bus::new(Flash::blank());
    assert_eq!(bus.number(0x1000, 0), 0);
    assert_eq!(bus.read(0x1001, 0), [0x4F, 0x01, 0x10, 0, 1, 0, 0, 0]);
    assert_eq!(bus.read(0x1018, 0), [0x4F, 0x18, 0x10, 0, 4, 0, 0, 0]);
    let identity = [1, 2, 3, 4].map(|sub| bus.number(0x1018, sub));
    assert_eq!(identity, [0x12, 0x34, 0, 0x56]);
}

#[test]
fn client_that_leaves_in_the_middle_leaves_no_program_and_another_one_completes_it() {
    let file = file(0x0001_0000, 3000, 0);
    let mut bus = Bus::new(Flash::blank());
    bus.control(3);
    bus.segmented(&file);
    bus.control(3);
    // 250 segments, then nothing.
    bus.send([0x21, 0x50, 0x1F, 1, 0, 0, 0, 0]).unwrap();
    for (number, piece) in file.chunks(7).take(250).enumerate() {
        let mut request = [(number as u8 & 1) << 4, 0, 0, 0, 0, 0, 0, 0];
        request[1..].copy_from_slice(piece);
        bus.send(request).unwrap();
    }
    bus.now = after(bus.now, millis(1000));
    let aborted = bus.server.poll(bus.now);
    assert_eq!(aborted, Some(abort(0x1F50, 1, 0x0504_0000)));
    assert!(!bus.state().1);
    assert_eq!(bus.control(1), abort(0x1F51, 1, 0x0800_0022));
    let refused = abort(0x1F50, 1, 0x0800_0022);
    for download in KINDS {
        assert_eq!(download(&mut bus, &file), refused);
    }
    bus.control(3);
    bus.block(&file);
    assert_eq!(bus.state(), (0, true));
}

#[test]
fn interrupted_commit_is_completed_at_the_next_start() {
    let file = file(0x0001_0000, 2048, 0);
    let mut bus = Bus::new(Flash::blank());
    bus.control(3);
    bus.block(&file);
    let mut flash = bus.update.slot;
    flash.bytes[header::COMMIT] = 0x55;
    let bus = Bus::new(flash);
    assert!(matches!(bus.update.program(), Program::Complete(_)));
    assert_eq!(bus.update.slot.bytes[header::COMMIT..][..2], [0, 0]);
}

#[test]
fn file_without_the_signature_of_the_key_is_refused_and_a_signed_one_is_taken() {
    let unsigned = file(0x0001_0000, 8192, 0);
    let (signed, key) = sign(&unsigned);
    for download in KINDS {
        let mut flash = Flash::blank();
        flash.key = Some(key);
        let mut bus = Bus::new(flash);
        bus.control(3);
        let refused = download(&mut bus, &unsigned);
        assert_eq!(refused, abort(0x1F50, 1, 0x0800_0021));
        assert_eq!(bus.state(), (14, false));
        bus.control(3);
        download(&mut bus, &signed);
        assert_eq!(bus.state(), (0, true));
    }
}
