//! A sensor on the desk: bytes in at a time, bytes out, as the driver of a board would do it.
#![allow(dead_code, reason = "not every test uses everything")]

use plumbline::can::{Frame, standard};
use plumbline::fsc::{Model, Product, Sensor};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::model::is1::{self, OneAxis};
use plumbline::model::is2::{self, TwoAxes};
use plumbline::node::{Action, Boot, BusEvent, Leds, Node};
use plumbline::store::{Loaded, Payload, StoreError};
use plumbline::time::Instant;

/// DefaultParam and AutobaudDetection, as delivered.
pub const DELIVERED: u8 = 0x03;
pub const AUTOBAUD: u8 = 0x02;
pub const CMD_PARAM_ERROR: u8 = 0x08;
pub const EEPROM_ERROR: u8 = 0x04;

pub fn is2() -> Tester<TwoAxes> {
    Tester::online(&is2::BP_CL)
}

pub fn is1() -> Tester<OneAxis> {
    let mut tester = Tester::online(&is1::BP_CL);
    tester.rest(0, ONE_G, 0);
    tester
}

/// A sensor and what the world around it has seen.
pub struct Tester<M: Model> {
    pub sensor: Sensor<M>,
    pub now: Instant,
    pub actions: Vec<Action>,
    pub leds: Leds,
    /// What the nonvolatile memory holds.
    pub memory: Option<Payload>,
    /// The result of the next saves; None: the memory does not answer before `finish_save`.
    pub memory_works: Option<bool>,
    /// The specific force at present; the sensor gets a sample of it every 50 ms.
    force: [i32; 3],
    /// The temperature of the accelerometer in 0.01 degC.
    pub temperature: i16,
    product: &'static Product,
}

impl<M: Model> Tester<M> {
    /// Powers a blank sensor up; its bit rate is not known yet.
    pub fn power_up(product: &'static Product) -> Self {
        Self::with_memory(product, Loaded::default())
    }

    pub fn with_memory(product: &'static Product, loaded: Loaded) -> Self {
        let now = Instant::from_ticks(0);
        let memory = loaded.payload.clone();
        let sensor = Sensor::new(
            product,
            now,
            Boot {
                loaded,
                serial: 0x0403_0201,
            },
        );
        let (actions, leds) = (Vec::new(), Leds::default());
        let mut tester = Self {
            sensor,
            now,
            actions,
            leds,
            memory,
            memory_works: Some(true),
            force: [0, 0, ONE_G],
            temperature: 25_00,
            product,
        };
        tester.first_sample();
        tester
    }

    /// A sensor that has found the bit rate and sent its boot-up messages.
    pub fn online(product: &'static Product) -> Self {
        let mut tester = Self::power_up(product);
        tester.rest(0, 0, ONE_G);
        tester.receive(Frame::data(standard(0x7FF), &[]).unwrap());
        assert_eq!(tester.sent().len(), 2, "two boot-up messages");
        tester
    }

    /// Power off and on again.
    pub fn power_cycle(&mut self) {
        let loaded = Loaded {
            payload: self.memory.clone(),
            damaged: false,
        };
        self.sensor = Sensor::new(
            self.product,
            self.now,
            Boot {
                loaded,
                serial: 0x0403_0201,
            },
        );
        self.first_sample();
    }

    /// As on a board: a sample before the node's first actions are carried out.
    fn first_sample(&mut self) {
        let [x, y, z] = self.force;
        self.reading(x, y, z, false);
    }

    fn settle(&mut self) {
        for _ in 0..100 {
            let Some(action) = self.sensor.poll(self.now) else {
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

    /// Rests with this specific force until the filter has settled.
    pub fn rest(&mut self, x: i32, y: i32, z: i32) {
        for _ in 0..2000 {
            self.reading(x, y, z, false);
        }
    }

    /// One sample.
    pub fn reading(&mut self, x: i32, y: i32, z: i32, clipped: bool) {
        self.force = [x, y, z];
        let acceleration = I32x3 { x, y, z };
        let angular_rate = I32x3 { x: 0, y: 0, z: 0 };
        let reading = Reading {
            acceleration,
            angular_rate,
            temperature: self.temperature,
            clipped,
        };
        self.sensor.sample(self.now, &reading);
        self.settle();
    }

    pub fn receive(&mut self, frame: Frame) {
        assert!(self.sensor.ready());
        self.sensor.receive(self.now, &frame);
        self.settle();
    }

    pub fn bus(&mut self, event: BusEvent) {
        self.sensor.bus(self.now, event);
        self.settle();
    }

    /// Lets time pass, polling at every deadline and taking what is sent; returns the frames with their times in ms.
    pub fn wait(&mut self, ms: u64) -> Vec<(u64, Frame)> {
        self.pass(ms, true)
    }

    /// Lets time pass without a sample.
    pub fn wait_without_samples(&mut self, ms: u64) -> Vec<(u64, Frame)> {
        self.pass(ms, false)
    }

    fn pass(&mut self, ms: u64, sampled: bool) -> Vec<(u64, Frame)> {
        let end = Instant::from_ticks(self.now.ticks() + ms * 1000);
        let mut sample = self.now;
        let mut frames = Vec::new();
        loop {
            if sampled && self.now >= sample {
                let [x, y, z] = self.force;
                self.reading(x, y, z, false);
                sample = Instant::from_ticks(self.now.ticks() + 50_000);
            }
            let sent = self.sent();
            frames.extend(
                sent.into_iter()
                    .map(|frame| (self.now.ticks() / 1000, frame)),
            );
            let deadline = self.sensor.deadline().unwrap_or(end);
            let next = if sampled {
                deadline.min(sample)
            } else {
                deadline
            };
            if next >= end && self.now >= end {
                break;
            }
            self.now = self.now.max(next.min(end));
            self.settle();
        }
        frames
    }

    /// Everything that the sensor has to send.
    pub fn sent(&mut self) -> Vec<Frame> {
        let mut frames = Vec::new();
        while let Some(frame) = self.sensor.transmit(self.now) {
            frames.push(frame);
            self.settle();
        }
        frames
    }

    /// Sends a request on 300h and returns the data of the one reply on 301h.
    pub fn ask(&mut self, request: &[u8]) -> Vec<u8> {
        self.receive(Frame::data(standard(0x300), request).unwrap());
        let sent = self.sent();
        assert_eq!(sent.len(), 1, "{request:02X?} -> {sent:?}");
        assert_eq!(sent[0].id(), standard(0x301));
        sent[0].bytes().to_vec()
    }

    /// Sends a request on 300h that must not be answered.
    pub fn silent(&mut self, request: &[u8]) {
        self.receive(Frame::data(standard(0x300), request).unwrap());
        assert_eq!(self.sent(), []);
    }
}

/// The data bytes of a request.
pub fn request(code: u8, data: &[u8]) -> Vec<u8> {
    [&[code], data].concat()
}
