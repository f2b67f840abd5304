//! A DeviceNet master with a sensor on a virtual bus.

use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, NodeType};
use plumbline::can::{Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::model::catalog::Product;
use plumbline::time::{after, millis};

/// A sensor with factory values and a master with an explicit connection.
pub struct Master {
    bus: Bus,
    device: DeviceId,
    adapter: AdapterId,
}

impl Master {
    pub fn new(product: &'static Product) -> Self {
        let mut bus = Bus::new(BusRate::Follow);
        // At rest with Z up: all angles are 0.
        let motion = Box::new(Reading {
            acceleration: I32x3 {
                x: 0,
                y: 0,
                z: ONE_G,
            },
            ..Reading::default()
        });
        let device = bus.attach(Device::new(
            &NodeType::from(product),
            1,
            Flash::default(),
            motion,
        ));
        let adapter = bus.adapter();
        bus.open(adapter, None, false);
        let mut master = Self {
            bus,
            device,
            adapter,
        };
        master.connect();
        master
    }

    /// Waits until the sensor is on-line and allocates the explicit connection.
    fn connect(&mut self) {
        self.run(2300);
        assert_eq!(self.send(6, &[0x4B, 3, 1, 1, 0x0A]), [0xCB, 0]);
        assert_eq!(self.ask(&[0x10, 5, 1, 9, 0, 0]), [0x90, 0, 0]);
    }

    /// Switches the power of the sensor off and on.
    pub fn power_cycle(&mut self) {
        self.run(1000);
        self.bus.power_cycle(self.device);
        self.connect();
    }

    /// Allocates these I/O connections and establishes them without a watchdog.
    pub fn establish(&mut self, choice: u8, instances: &[u8]) {
        assert_eq!(self.ask(&[0x4B, 3, 1, choice, 0x0A]), [0xCB, 0]);
        for instance in instances {
            self.ask(&[0x10, 5, *instance, 9, 0, 0]);
        }
    }

    /// The number of bytes of a poll response.
    pub fn poll(&mut self) -> Option<usize> {
        self.bus.take_received(self.adapter);
        let poll = Frame::data(standard(0x5FD), &[]).expect("no data");
        self.bus.send(self.adapter, poll);
        self.run(5);
        let received = self.bus.take_received(self.adapter);
        let mut responses = received
            .iter()
            .filter(|(_, frame)| frame.id() == standard(0x3FF));
        responses.next().map(|(_, frame)| frame.bytes().len())
    }

    pub fn run(&mut self, ms: u32) {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
    }

    /// The answer to a request, without its header. Fragments are joined.
    pub fn send(&mut self, message: u16, request: &[u8]) -> Vec<u8> {
        let mut bytes = [&[0x0A], request].concat();
        let mut answer = Vec::new();
        loop {
            self.bus.take_received(self.adapter);
            let frame = Frame::data(standard(0x5F8 | message), &bytes);
            self.bus
                .send(self.adapter, frame.expect("at most eight bytes"));
            self.run(5);
            let received = self.bus.take_received(self.adapter);
            // Beside messages of I/O connections.
            let mut responses = received
                .iter()
                .filter(|(_, frame)| frame.id() == standard(0x5FB));
            let Some((_, frame)) = responses.next() else {
                return answer;
            };
            let (header, body) = frame.bytes().split_first().expect("a header");
            if header & 0x80 == 0 {
                return body.to_vec();
            }
            answer.extend(&body[1..]);
            bytes = vec![0x8A, 0xC0 | body[0] & 0x3F, 0];
        }
    }

    pub fn ask(&mut self, request: &[u8]) -> Vec<u8> {
        self.send(4, request)
    }

    /// The value of an attribute.
    pub fn get(&mut self, class: u8, instance: u8, attribute: u8) -> Vec<u8> {
        let answer = self.ask(&[0x0E, class, instance, attribute]);
        assert_eq!(
            answer[0], 0x8E,
            "{class:02X} {attribute:02X}: {answer:02X?}"
        );
        answer[1..].to_vec()
    }

    /// Sets an attribute of the instance 1; the error is the general code.
    pub fn set(&mut self, class: u8, attribute: u8, value: i64, size: usize) -> Result<(), u8> {
        let bytes = value.to_le_bytes();
        let request = [&[0x10, class, 1, attribute], &bytes[..size]].concat();
        match *self.ask(&request) {
            [0x90] => Ok(()),
            [0x94, code, 0xFF] => Err(code),
            ref answer => panic!("{answer:02X?}"),
        }
    }
}

/// A number from bytes, low byte first.
pub fn value(bytes: &[u8], signed: bool) -> i64 {
    let raw = bytes
        .iter()
        .rev()
        .fold(0_i64, |sum, byte| sum << 8 | i64::from(*byte));
    let unused = 64 - 8 * bytes.len();
    if signed { raw << unused >> unused } else { raw }
}
