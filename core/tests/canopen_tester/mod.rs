//! A JN2101 on the desk: bytes in at a time, bytes out, as the driver of a board would do it. Frames are written as candump does.
#![allow(dead_code, reason = "not every test uses everything")]

use plumbline::can::{Frame, extended, standard};
use plumbline::measure::self_test::Working;
use plumbline::measure::{I32x3, ONE_G, Reading, SAMPLE_PERIOD};
use plumbline::model::jn2101::Jn2101;
use plumbline::node::{Action, Boot, BusEvent, Leds, Node};
use plumbline::store::{Loaded, Payload, StoreError};
use plumbline::time::Instant;

/// The serial number of the sensor under test.
pub const SERIAL: u32 = 0x0403_0201;

/// A frame with a time in ms since the wait began.
pub type Timed = (u64, String);

/// The frame that a text like `60A#4000100000000000` or `70A#R` stands for.
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

/// A sensor and what the world around it has seen.
pub struct Tester {
    pub sensor: Jn2101,
    pub now: Instant,
    pub actions: Vec<Action>,
    pub leds: Leds,
    pub node_id: u8,
    /// What the nonvolatile memory holds.
    pub memory: Option<Payload>,
    /// The result of the next saves; None: the memory does not answer before `finish_save`.
    pub memory_works: Option<bool>,
    /// The specific force at present; the sensor gets a sample of it every 5 ms.
    pub force: [f64; 3],
    pub temperature: i16,
    pub clipped: bool,
    /// The accelerometer delivers.
    pub sampled: bool,
    next_sample: Instant,
}

impl Tester {
    /// A sensor as delivered, level, powered up; its boot-up message still to be sent.
    pub fn power_up() -> Self {
        Self::with_memory(Loaded::default())
    }

    pub fn with_memory(loaded: Loaded) -> Self {
        let now = Instant::from_ticks(0);
        let memory = loaded.payload.clone();
        let mut tester = Self {
            sensor: boot(now, loaded),
            now,
            actions: Vec::new(),
            leds: Leds::default(),
            node_id: 10,
            memory,
            memory_works: Some(true),
            force: [0.0, 0.0, 1.0],
            temperature: 2500,
            clipped: false,
            sampled: true,
            next_sample: now,
        };
        tester.sample();
        tester
    }

    /// A sensor as delivered that has booted.
    pub fn booted() -> Self {
        let mut tester = Self::power_up();
        assert_eq!(tester.sent(), ["70A#00"]);
        tester
    }

    /// A sensor as delivered in operational, its TPDOs silent without a SYNC or a request.
    pub fn operational() -> Self {
        let mut tester = Self::booted();
        tester.send("000#010A");
        assert_eq!(tester.sent(), [""; 0]);
        tester
    }

    /// Power off and on again.
    pub fn power_cycle(&mut self) {
        let loaded = Loaded {
            payload: self.memory.clone(),
            damaged: false,
        };
        self.actions.clear();
        self.sensor = boot(self.now, loaded);
        self.sample();
    }

    fn settle(&mut self) {
        for _ in 0..100 {
            let Some(action) = self.sensor.poll(self.now) else {
                let deadline = self.sensor.deadline();
                assert!(deadline.is_none_or(|at| at > self.now), "{deadline:?}");
                return;
            };
            self.actions.push(action);
            match action {
                Action::Leds(leds) => self.leds = leds,
                Action::Save => {
                    let image = self.sensor.image();
                    match self.memory_works {
                        Some(true) => {
                            self.memory = Some(image);
                            self.sensor.stored(self.now, Ok(()));
                        }
                        Some(false) => self.sensor.stored(self.now, Err(StoreError)),
                        None => {}
                    }
                }
                _ => {}
            }
        }
        panic!("the sensor never rests: {:?}", self.actions);
    }

    /// The save that was left open ends.
    pub fn finish_save(&mut self, result: Result<(), StoreError>) {
        self.sensor.stored(self.now, result);
        self.settle();
    }

    /// The test of the accelerometer ends.
    pub fn tested(&mut self, x: bool, y: bool) {
        self.sensor.tested(self.now, Working { x, y, z: true });
        self.settle();
    }

    fn sample(&mut self) {
        let [x, y, z] = self
            .force
            .map(|component| (component * f64::from(ONE_G)).round() as i32);
        let reading = Reading {
            acceleration: I32x3 { x, y, z },
            angular_rate: I32x3 { x: 0, y: 0, z: 0 },
            temperature: self.temperature,
            clipped: self.clipped,
        };
        self.sensor.sample(self.now, &reading);
        self.next_sample = self.now + SAMPLE_PERIOD;
        self.settle();
    }

    /// Rests with this specific force until every filter has settled; no time passes.
    pub fn rest(&mut self, force: [f64; 3]) {
        self.force = force;
        for _ in 0..400 {
            self.sample();
        }
    }

    /// Rests in the position with these perpendicular angles in deg.
    pub fn tilt(&mut self, longitudinal: f64, lateral: f64) {
        let (x, y) = (-longitudinal.to_radians().sin(), lateral.to_radians().sin());
        self.rest([x, y, (1.0 - x * x - y * y).sqrt()]);
    }

    /// Hands in a frame.
    pub fn send(&mut self, text: &str) {
        assert!(self.sensor.ready(), "not ready for {text}");
        self.sensor.receive(self.now, &frame(text));
        self.settle();
    }

    pub fn bus(&mut self, event: BusEvent) {
        self.sensor.bus(self.now, event);
        self.settle();
    }

    /// Everything that the sensor has to send.
    pub fn sent(&mut self) -> Vec<String> {
        let mut frames = Vec::new();
        while let Some(frame) = self.sensor.transmit(self.now) {
            frames.push(format!("{frame:?}"));
            self.settle();
        }
        frames
    }

    /// Hands in a frame and returns what is sent at once.
    pub fn exchange(&mut self, text: &str) -> Vec<String> {
        self.send(text);
        self.sent()
    }

    /// Lets time pass, polling at every deadline; returns what is sent.
    pub fn wait(&mut self, ms: u64) -> Vec<Timed> {
        let start = self.now;
        let end = Instant::from_ticks(start.ticks() + ms * 1000);
        let mut frames = Vec::new();
        loop {
            if self.sampled && self.now >= self.next_sample {
                self.sample();
            }
            let time = (self.now.ticks() - start.ticks()) / 1000;
            frames.extend(self.sent().into_iter().map(|frame| (time, frame)));
            if self.now >= end {
                return frames;
            }
            let deadline = self.sensor.deadline().unwrap_or(end).min(end);
            let sample = if self.sampled { self.next_sample } else { end };
            self.now = deadline.min(sample).max(self.now);
            self.settle();
        }
    }

    /// Goes on to the next deadline without a sample; returns what is sent then.
    pub fn next(&mut self) -> Vec<String> {
        self.now = self.sensor.deadline().unwrap();
        self.settle();
        self.sent()
    }

    /// An SDO request and the data of its one reply, both as hexadecimal text.
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

    /// Reads a number of at most four bytes; the abort code when that is refused.
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

    /// Writes a number of `size` bytes; the abort code when that is refused.
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
        let [low, high] = index.to_le_bytes();
        let reply = self.sdo(&hex(&[0x40, low, high, 0, 0, 0, 0, 0]));
        assert_eq!(reply[..8], hex(&[0x41, low, high, 0]), "{reply}");
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

    /// Writes a text with a segmented transfer; the last reply.
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

fn boot(now: Instant, loaded: Loaded) -> Jn2101 {
    Jn2101::new(
        now,
        Boot {
            loaded,
            serial: SERIAL,
        },
    )
}
