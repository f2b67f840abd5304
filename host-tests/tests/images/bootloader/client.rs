//! A client of the bootloader: SDO on two identifiers.

use crate::rig::{Rig, chip};
use plumbline::can::{CanId, Frame};
use plumbline::update::Contact;
use stm32_sim::flash::Times;

/// The longest time of an answer in ms: a block of 217 bytes erases a page and programs 128 half-words; at 10 kbit/s the frames of the
/// block take 400 ms.
fn patience() -> u64 {
    560 + Times::longest(chip()).erase_of_slot[2] / 1_000_000_000
}

/// Segments in a block.
const BLOCK: usize = 31;

/// The client.
pub struct Client<'a> {
    pub rig: &'a mut Rig,
    pub request: CanId,
    pub reply: CanId,
    /// The longest time until an answer in us.
    pub slowest: u64,
}

impl<'a> Client<'a> {
    /// A client of a bootloader that does not know its identifiers.
    pub fn of_unknown(rig: &'a mut Rig) -> Self {
        Self {
            rig,
            request: CanId::standard(0x67F),
            reply: CanId::standard(0x5FF),
            slowest: 0,
        }
    }

    /// A client of a bootloader with a boot record of this contact.
    pub fn of_known(rig: &'a mut Rig, contact: &Contact) -> Self {
        Self {
            rig,
            request: contact.request,
            reply: contact.reply,
            slowest: 0,
        }
    }

    fn send(&mut self, bytes: [u8; 8]) {
        let frame = Frame::of(self.request, bytes, 8);
        self.rig.bus.send(self.rig.tester, frame);
    }

    /// Reads an object until the bootloader has found the bit rate and answers, at most twice as long as it listens at all bit rates.
    #[track_caller]
    pub fn wake(&mut self) {
        for _ in 0..60 {
            self.send([0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
            self.rig.run(50);
            if !self.rig.frames().is_empty() {
                return;
            }
        }
        panic!("the bootloader does not answer");
    }

    /// Sends a request and returns the reply.
    #[track_caller]
    pub fn ask(&mut self, bytes: [u8; 8]) -> [u8; 8] {
        self.send(bytes);
        self.answer()
    }

    /// The next frame of the sensor; None: the power was cut, or none comes in time.
    fn next(&mut self) -> Option<[u8; 8]> {
        for step in 1..=patience() * 10 {
            self.rig.run_us(100);
            self.slowest = self.slowest.max(step * 100);
            if let Some(frame) = self.rig.frames().first() {
                assert_eq!(frame.can_id(), self.reply, "{frame:?}");
                return Some(frame.bytes().try_into().expect("8 bytes"));
            }
            if !self.rig.device().is_on() {
                return None;
            }
        }
        None
    }

    #[track_caller]
    fn answer(&mut self) -> [u8; 8] {
        self.next().expect("an answer")
    }

    /// Reads a number of 32 bits.
    #[track_caller]
    pub fn number(&mut self, index: u16, sub: u8) -> u32 {
        let [low, high] = index.to_le_bytes();
        let reply = self.ask([0x40, low, high, sub, 0, 0, 0, 0]);
        assert_eq!(reply[..4], [0x43, low, high, sub], "{reply:02X?}");
        u32::from_le_bytes([reply[4], reply[5], reply[6], reply[7]])
    }

    /// Writes 1F51h:01.
    #[track_caller]
    pub fn control(&mut self, value: u8) {
        let reply = self.ask([0x2F, 0x51, 0x1F, 1, value, 0, 0, 0]);
        assert_eq!(reply, [0x60, 0x51, 0x1F, 1, 0, 0, 0, 0]);
    }

    /// Begins a download of a file to 1F50h:01 by blocks, after a clear command.
    #[track_caller]
    fn begin(&mut self, file: &[u8]) {
        self.control(3);
        let [a, b, c, d] = (file.len() as u32).to_le_bytes();
        let reply = self.ask([0xC2, 0x50, 0x1F, 1, a, b, c, d]);
        assert_eq!(reply, [0xA0, 0x50, 0x1F, 1, BLOCK as u8, 0, 0, 0]);
    }

    /// Begins a download and sends nine segments of its first block.
    #[track_caller]
    pub fn leave_in_block(&mut self, file: &[u8]) {
        self.begin(file);
        for (number, segment) in (1..10).zip(file.as_chunks().0) {
            let [a, b, c, d, e, f, g] = *segment;
            self.send([number, a, b, c, d, e, f, g]);
        }
    }

    /// Downloads a file to 1F50h:01 by blocks, after a clear command. Err has the reply that refuses it; None: the power was cut.
    #[track_caller]
    pub fn download(&mut self, file: &[u8]) -> Result<(), Option<[u8; 8]>> {
        self.begin(file);
        let segments: Vec<_> = file.chunks(7).collect();
        let mut left = segments.len();
        for block in segments.chunks(BLOCK) {
            for (number, segment) in (1..).zip(block) {
                left -= 1;
                let mut bytes = [0; 8];
                bytes[0] = number | if left == 0 { 0x80 } else { 0 };
                bytes[1..=segment.len()].copy_from_slice(segment);
                self.send(bytes);
            }
            let reply = self.next().ok_or(None)?;
            if reply[..3] != [0xA2, block.len() as u8, BLOCK as u8] {
                return Err(Some(reply));
            }
        }
        let unused = (7 - file.len() % 7) % 7;
        self.send([0xC1 | (unused as u8) << 2, 0, 0, 0, 0, 0, 0, 0]);
        match self.next().ok_or(None)? {
            [0xA1, 0, 0, 0, 0, 0, 0, 0] => Ok(()),
            reply => Err(Some(reply)),
        }
    }
}
