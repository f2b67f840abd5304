//! Helpers for tests of CANopen nodes. Frames are texts in the format of candump.

use super::Tester;
use plumbline::can::{Frame, extended, standard};
use plumbline::measure::ONE_G;
use plumbline::model::jn2101::Jn2101;
use plumbline::node::{Boot, Node};

fn texts(frames: Vec<Frame>) -> Vec<String> {
    frames.iter().map(|frame| format!("{frame:?}")).collect()
}

/// The acceleration of a vector in g.
pub fn in_g(vector: [f64; 3]) -> [i32; 3] {
    vector.map(|component| (component * f64::from(ONE_G)).round() as i32)
}

/// The frame of a text like `60A#4000100000000000` or `70A#R`.
pub fn frame(text: &str) -> Frame {
    let (id, data) = text.split_once('#').unwrap();
    let number = u32::from_str_radix(id, 16).unwrap();
    let id = if id.len() == 8 {
        extended(number)
    } else {
        standard(number as u16)
    };
    if let Some(length) = data.strip_prefix('R') {
        return Frame::remote(id, length.parse().unwrap_or(0)).unwrap();
    }
    let byte = |at: usize| u8::from_str_radix(&data[at..at + 2], 16).unwrap();
    let bytes: Vec<u8> = (0..data.len()).step_by(2).map(byte).collect();
    Frame::data(id, &bytes).unwrap()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect()
}

/// A JN2101 with its bus and its memory.
pub type Jn2101Tester = Tester<Jn2101>;

/// A level sensor with factory values after power-up. Its boot-up message is not sent yet.
pub fn power_up() -> Jn2101Tester {
    with_memory(Boot::default())
}

/// A sensor after power-up with these contents of the memory.
pub fn with_memory(loaded: Boot) -> Jn2101Tester {
    Tester::power_up(loaded, Jn2101::new)
}

/// A sensor with factory values that has sent its boot-up message.
pub fn booted() -> Jn2101Tester {
    let mut tester = power_up();
    assert_eq!(tester.sent_text(), ["70A#00"]);
    tester
}

/// A sensor with factory values in operational. Its TPDOs are sent only after a SYNC or a request.
pub fn operational() -> Jn2101Tester {
    let mut tester = booted();
    tester.send("000#010A");
    assert_eq!(tester.sent_text(), [""; 0]);
    tester
}

impl<N: Node> Tester<N> {
    /// Hands in samples with these perpendicular angles in deg until all filters have settled.
    pub fn tilt(&mut self, longitudinal: f64, lateral: f64) {
        let (x, y) = (-longitudinal.to_radians().sin(), lateral.to_radians().sin());
        self.settle_at([x, y, (1.0 - x * x - y * y).sqrt()]);
    }

    /// Hands in samples of this specific force in g until all filters have settled, without passing time.
    pub fn settle_at(&mut self, force: [f64; 3]) {
        self.hold(in_g(force), 400);
    }

    /// The node receives this frame.
    pub fn send(&mut self, text: &str) {
        self.receive(frame(text));
    }

    /// All frames that the node sends now.
    pub fn sent_text(&mut self) -> Vec<String> {
        texts(self.sent())
    }

    /// Hands a frame in. Returns the frames sent at once.
    pub fn exchange(&mut self, text: &str) -> Vec<String> {
        self.send(text);
        self.sent_text()
    }

    /// Lets time pass. Returns the sent frames with the time since the start of the wait in ms.
    pub fn wait_text(&mut self, ms: u64) -> Vec<(u64, String)> {
        let start = self.now.ticks() / 1000;
        let frames = self.wait(ms).into_iter();
        frames
            .map(|(at, frame)| (at - start, format!("{frame:?}")))
            .collect()
    }

    /// Advances to the next deadline without a sample. Returns the frames sent then.
    pub fn next_text(&mut self) -> Vec<String> {
        texts(self.next())
    }

    /// Sends an SDO request and returns the data of its single reply, both as hexadecimal text.
    pub fn sdo(&mut self, request: &str) -> String {
        let request = format!("{:03X}#{request}", 0x600 + u32::from(self.node_id));
        let mut sent = self.exchange(&request);
        let reply = format!("{:03X}#", 0x580 + u32::from(self.node_id));
        assert_eq!(sent.len(), 1, "{request} -> {sent:?}");
        let sent = sent.remove(0);
        sent.strip_prefix(&reply)
            .unwrap_or_else(|| panic!("{request} -> {sent}"))
            .to_string()
    }

    /// Reads a number of at most four bytes; the error is the abort code.
    pub fn read(&mut self, index: u16, sub: u8) -> Result<u32, u32> {
        let [low, high] = index.to_le_bytes();
        let reply = self.sdo(&hex(&[0x40, low, high, sub, 0, 0, 0, 0]));
        let bytes = frame(&format!("000#{reply}"));
        let bytes: [u8; 8] = bytes.bytes().try_into().unwrap();
        assert_eq!(bytes[1..4], [low, high, sub]);
        let number = u32::from_le_bytes(bytes[4..].try_into().unwrap());
        match bytes[0] {
            0x80 => Err(number),
            0x43 | 0x47 | 0x4B | 0x4F => Ok(number),
            _ => panic!("{reply}"),
        }
    }

    /// Reads a signed number of 16 bits.
    pub fn read_i16(&mut self, index: u16) -> i16 {
        self.read(index, 0).unwrap() as i16
    }

    /// Reads a signed number of 32 bits.
    pub fn read_i32(&mut self, index: u16) -> i32 {
        self.read(index, 0).unwrap() as i32
    }

    /// Writes a number of `size` bytes; the error is the abort code.
    pub fn write(&mut self, index: u16, sub: u8, size: u8, value: u32) -> Result<(), u32> {
        let reply = self.sdo(&write_request(index, sub, size, value));
        let [low, high] = index.to_le_bytes();
        if reply == hex(&[0x60, low, high, sub, 0, 0, 0, 0]) {
            return Ok(());
        }
        assert_eq!(reply[..8], hex(&[0x80, low, high, sub]), "{reply}");
        let code = frame(&format!("000#{}", &reply[8..]));
        Err(u32::from_le_bytes(code.bytes().try_into().unwrap()))
    }

    /// Reads a text with a segmented transfer.
    pub fn read_text(&mut self, index: u16) -> String {
        self.read_text_at(index, 0)
    }

    /// Reads a text at a sub-index with a segmented transfer.
    pub fn read_text_at(&mut self, index: u16, sub: u8) -> String {
        let [low, high] = index.to_le_bytes();
        let reply = self.sdo(&hex(&[0x40, low, high, sub, 0, 0, 0, 0]));
        assert_eq!(reply[..8], hex(&[0x41, low, high, sub]), "{reply}");
        let size = usize::from_str_radix(&reply[8..10], 16).unwrap();
        let mut text = Vec::new();
        for toggle in [0, 0x10].into_iter().cycle() {
            let reply = self.sdo(&hex(&[0x60 | toggle, 0, 0, 0, 0, 0, 0, 0]));
            let reply = frame(&format!("000#{reply}"));
            let (&command, data) = reply.bytes().split_first().unwrap();
            assert_eq!(command & 0xF0, toggle);
            text.extend(&data[..7 - usize::from(command >> 1 & 7)]);
            if command & 1 != 0 {
                break;
            }
        }
        assert_eq!(text.len(), size);
        String::from_utf8(text).unwrap()
    }

    /// Writes a text with a segmented transfer. Returns the last reply.
    pub fn write_text(&mut self, index: u16, text: &str) -> String {
        let [low, high] = index.to_le_bytes();
        let mut reply = self.sdo(&hex(&[0x21, low, high, 0, text.len() as u8, 0, 0, 0]));
        let segments: Vec<_> = text.as_bytes().chunks(7).collect();
        let toggles = [0, 0x10].into_iter().cycle();
        for (number, (segment, toggle)) in segments.iter().zip(toggles).enumerate() {
            if reply.starts_with("80") {
                break;
            }
            let last = u8::from(number + 1 == segments.len());
            let unused = 7 - segment.len() as u8;
            let mut bytes = vec![toggle | unused << 1 | last];
            bytes.extend_from_slice(segment);
            bytes.resize(8, 0);
            reply = self.sdo(&hex(&bytes));
        }
        reply
    }

    /// Maps these objects into a TPDO as a master does it, and enables it with its default COB-ID.
    pub fn map(&mut self, number: u16, entries: &[u32]) {
        let (communication, mapping) = (0x1800 + number, 0x1A00 + number);
        let cob_id = 0x1B2 + 0x100 * u32::from(number);
        self.write(communication, 1, 4, 0x8000_0000 | cob_id)
            .unwrap();
        self.write(mapping, 0, 1, 0).unwrap();
        for (sub, &entry) in (1..).zip(entries) {
            self.write(mapping, sub, 4, entry).unwrap();
        }
        self.write(mapping, 0, 1, entries.len() as u32).unwrap();
        self.write(communication, 1, 4, cob_id).unwrap();
    }

    /// Stores all parameters.
    pub fn store(&mut self) {
        assert_eq!(self.write(0x1010, 1, 4, 0x6576_6173), Ok(()));
    }
}

/// The bytes of an expedited write.
pub fn write_request(index: u16, sub: u8, size: u8, value: u32) -> String {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = value.to_le_bytes();
    hex(&[0x23 | (4 - size) << 2, low, high, sub, a, b, c, d])
}

/// The bytes of an abort with this code. `object` is index and sub-index as the bytes of the message.
pub fn abort(object: &str, code: u32) -> String {
    let code: String = code
        .to_le_bytes()
        .map(|byte| format!("{byte:02X}"))
        .concat();
    format!("80{object}{code}")
}
