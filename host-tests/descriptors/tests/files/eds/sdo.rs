//! An SDO client on the bench, and the comparison of a data sheet with the sensor.

use super::sheet::{DataType, Sheet, Variable};
use bench::script::LEVEL;
use bench::{AdapterId, Bus, BusRate, Device, Flash, NodeType};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::time::{after, millis};

/// Abort codes (CiA 301, table 22).
pub const WRITE_ONLY: u32 = 0x0601_0001;
pub const READ_ONLY: u32 = 0x0601_0002;
pub const NO_OBJECT: u32 = 0x0602_0000;
const NOT_MAPPABLE: u32 = 0x0604_0041;
pub const TOO_LONG: u32 = 0x0607_0012;
pub const TOO_SHORT: u32 = 0x0607_0013;
pub const NO_SUB_INDEX: u32 = 0x0609_0011;
const VALUE: u32 = 0x0609_0030;
const TOO_HIGH: u32 = 0x0609_0031;
const TOO_LOW: u32 = 0x0609_0032;
const NO_DATA: u32 = 0x0800_0024;
const SIGNATURE: u32 = 0x0800_0020;

/// The factory bit rate of both sensors.
const RATE: BitRate = BitRate::K125;

/// A sensor under test: the product, its factory node-ID, and whether it is made one with one axis first.
#[derive(Clone, Copy, Debug)]
pub struct Subject {
    pub product: &'static str,
    pub node_id: u8,
    pub has_one_axis: bool,
}

/// ifm's JN2101 as delivered (manual 8.1).
pub const JN2101: Subject = Subject {
    product: "jn2101",
    node_id: 10,
    has_one_axis: false,
};

/// SIKO's IMS360 (manual 7.2.23), as delivered.
pub const IMS360: Subject = Subject {
    product: "ims360",
    node_id: 50,
    has_one_axis: false,
};

/// SIKO's IMS360 with one axis (manual 7.2.40).
pub const IMS360_ONE_AXIS: Subject = Subject {
    has_one_axis: true,
    ..IMS360
};

/// Maximum time of a reply, which may wait for a save.
const PATIENCE_MS: u32 = 1000;

/// A bus with a sensor with factory values, in level position, and a client.
pub struct Client {
    bus: Bus,
    adapter: AdapterId,
    pub node_id: u8,
}

impl Client {
    pub fn new(subject: Subject) -> Self {
        let node_type = NodeType::find(subject.product).expect("a product");
        let mut bus = Bus::new(BusRate::Fixed(RATE));
        bus.attach(Device::new(
            &node_type,
            1,
            Flash::default(),
            Box::new(LEVEL),
        ));
        let adapter = bus.adapter();
        bus.open(adapter, None, false);
        let mut client = Self {
            bus,
            adapter,
            node_id: subject.node_id,
        };
        client.wait(100);
        if subject.has_one_axis {
            client.take_one_axis();
        }
        client
    }

    /// Makes an IMS360 a sensor with one axis: 3120h:01 = 0, "save", reset.
    fn take_one_axis(&mut self) {
        for (address, data) in [
            ((0x3120, 1), &[0][..]),
            ((0x1010, 1), b"save"),
            ((0x2010, 1), &[1]),
        ] {
            assert_eq!(self.write(address, data), Ok(()), "{address:X?}");
        }
        self.wait(100);
    }

    pub fn wait(&mut self, ms: u32) {
        let until = after(self.bus.now(), millis(ms));
        self.bus.run_until(until);
        self.bus.take_received(self.adapter);
    }

    /// Sends a frame without a reply.
    pub fn send(&mut self, id: u16, data: &[u8]) {
        let frame = Frame::data(standard(id), data).expect("eight bytes at most");
        self.bus.send(self.adapter, frame);
    }

    fn exchange(&mut self, request: [u8; 8]) -> [u8; 8] {
        self.send(0x600 + u16::from(self.node_id), &request);
        let reply = standard(0x580 + u16::from(self.node_id));
        for _ in 0..PATIENCE_MS {
            self.bus.run_until(after(self.bus.now(), millis(1)));
            for (_, frame) in self.bus.take_received(self.adapter) {
                if frame.id() == reply {
                    return frame.bytes().try_into().expect("eight bytes");
                }
            }
        }
        panic!("no reply to {request:02X?}");
    }

    /// Reads an object; returns the abort code on failure.
    pub fn read(&mut self, (index, sub): (u16, u8)) -> Result<Vec<u8>, u32> {
        let [low, high] = index.to_le_bytes();
        let first = self.exchange([0x40, low, high, sub, 0, 0, 0, 0]);
        if first[0] & 0xE2 == 0x42 {
            let unused = usize::from(first[0] >> 2 & 3);
            return Ok(first[4..8 - unused].to_vec());
        }
        let announced = accepted(first)?;
        let mut data = Vec::new();
        for number in 0_u8.. {
            let segment = self.exchange([0x60 | (number & 1) << 4, 0, 0, 0, 0, 0, 0, 0]);
            accepted(segment)?;
            let unused = usize::from(segment[0] >> 1 & 7);
            data.extend(&segment[1..8 - unused]);
            if segment[0] & 1 != 0 {
                break;
            }
        }
        assert_eq!(data.len() as u32, announced);
        Ok(data)
    }

    /// Writes an object; returns the abort code on failure.
    pub fn write(&mut self, (index, sub): (u16, u8), data: &[u8]) -> Result<(), u32> {
        let [low, high] = index.to_le_bytes();
        let mut request = [0x21, low, high, sub, 0, 0, 0, 0];
        if data.len() <= 4 {
            request[0] = 0x23 | (4 - data.len() as u8) << 2;
            request[4..4 + data.len()].copy_from_slice(data);
            return accepted(self.exchange(request)).map(drop);
        }
        request[4] = data.len() as u8;
        accepted(self.exchange(request))?;
        let segments = data.chunks(7);
        let last = segments.len() - 1;
        for (number, part) in segments.enumerate() {
            let mut segment = [0; 8];
            let toggle = (number as u8 & 1) << 4;
            segment[0] = toggle | (7 - part.len() as u8) << 1 | u8::from(number == last);
            segment[1..=part.len()].copy_from_slice(part);
            accepted(self.exchange(segment))?;
        }
        Ok(())
    }
}

/// The number in a reply, or the abort code.
fn accepted(reply: [u8; 8]) -> Result<u32, u32> {
    let [command, _, _, _, number @ ..] = reply;
    let number = u32::from_le_bytes(number);
    if command == 0x80 {
        Err(number)
    } else {
        Ok(number)
    }
}

/// The differences between a new sensor and a data sheet, one line each.
pub fn differences(subject: Subject, sheet: &Sheet) -> Vec<String> {
    let mut client = Client::new(subject);
    let mut found = Vec::new();
    for variable in sheet.variables() {
        let mut note = |what: &str, got: String| {
            found.push(format!("[{}] {what}: {got}", variable.section));
        };
        let Some(data) = reading(&mut client, &variable, &mut note) else {
            continue;
        };
        writing(&mut client, &variable, &data, &mut note);
        beyond(&mut client, &variable, &mut note);
    }
    found
}

/// Reads a variable and compares type and factory value; returns data that can be written to it.
fn reading(
    client: &mut Client,
    variable: &Variable,
    note: &mut impl FnMut(&str, String),
) -> Option<Vec<u8>> {
    let read = client.read(variable.address);
    if variable.access == "wo" {
        if read != Err(WRITE_ONLY) {
            note("can be read", format!("{read:X?}"));
        }
        return Some(variable.data_type.bytes(1));
    }
    // There is no error yet, and the IMS360 has no entries above their number.
    if variable.address.0 == 0x1003 && read == Err(NO_DATA) {
        return None;
    }
    let Ok(data) = read else {
        note("cannot be read", format!("{read:X?}"));
        return None;
    };
    if variable.data_type == DataType::Text {
        let expected = variable.default.as_deref().map(str::as_bytes);
        if expected.is_some_and(|expected| expected != data) {
            note("text", String::from_utf8_lossy(&data).into_owned());
        }
        return Some(data);
    }
    if data.len() * 8 != variable.data_type.bits() as usize {
        note("size", data.len().to_string());
    }
    let expected = variable.default_at(client.node_id.into());
    if expected.is_some_and(|expected| variable.data_type.bytes(expected) != data) {
        note("factory value", format!("{data:02X?}"));
    }
    Some(data)
}

/// Writes its current value to a variable, also with wrong sizes.
fn writing(
    client: &mut Client,
    variable: &Variable,
    data: &[u8],
    note: &mut impl FnMut(&str, String),
) {
    let address = variable.address;
    let written = client.write(address, data);
    if address == (0x2010, 1) {
        // It restarts.
        client.wait(100);
    }
    let is_read_only = variable.access != "rw" && variable.access != "wo";
    let expected = match (variable.access.as_str(), address.0) {
        // A fixed mapping and the fixed COB-ID of the EMCY accept their present value.
        ("ro", 0x1A00..0x1C00 | 0x1014) => Ok(()),
        ("ro" | "const", _) => Err(READ_ONLY),
        // Their value is not the required signature.
        (_, 0x1010 | 0x1011) => Err(SIGNATURE),
        // It reads as 0 and accepts only 1.
        (_, 0x207F) => Err(VALUE),
        _ => Ok(()),
    };
    if written != expected {
        note("writing", format!("{written:X?}"));
    }
    if expected == Err(READ_ONLY) || variable.data_type == DataType::Text {
        return;
    }
    let [too_long, too_short] = match (is_read_only, address.0) {
        // A fixed mapping.
        (true, 0x1A00..0x1C00) => [NOT_MAPPABLE; 2],
        _ => [TOO_LONG, TOO_SHORT],
    };
    let longer = client.write(address, &[data, &[0]].concat());
    if longer != Err(too_long) {
        note("writing a byte more", format!("{longer:X?}"));
    }
    if data.len() > 1 {
        let shorter = client.write(address, &data[1..]);
        if shorter != Err(too_short) {
            note("writing a byte less", format!("{shorter:X?}"));
        }
    }
}

/// Writes values beyond the limits.
fn beyond(client: &mut Client, variable: &Variable, note: &mut impl FnMut(&str, String)) {
    let [lowest, highest] = variable.data_type.limits();
    let below = variable.low.map(|low| (low - 1, TOO_LOW));
    let above = variable.high.map(|high| (high + 1, TOO_HIGH));
    for (number, code) in [below, above].into_iter().flatten() {
        if number < lowest || number > highest {
            continue;
        }
        let written = client.write(variable.address, &variable.data_type.bytes(number));
        if written != Err(code) && written != Err(VALUE) {
            note(&format!("writing {number}"), format!("{written:X?}"));
        }
    }
}
