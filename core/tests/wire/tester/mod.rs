//! A test driver for a node: drives it like a board, with frames and times.

pub mod canopen;
pub mod devicenet;
pub mod dictionary;
pub mod fsc;
pub mod gauge;
pub mod gemac;
pub mod ims360;
pub mod j1939;
pub mod mapped;
pub mod sweep;
pub mod tiltix;

use plumbline::can::Frame;
use plumbline::diagnosis::ResetCauses;
use plumbline::measure::self_test::Working;
use plumbline::measure::{Calibration, I32x3, ONE_G, Reading};
use plumbline::node::{Action, Boot, BusEvent, Leds, Node};
use plumbline::store::{StoreError, Unit, Usage};
use plumbline::time::{Duration, Instant, millis};
use plumbline::update::Installed;

/// The serial number of the node under test.
pub const SERIAL: u32 = 0x0403_0201;

/// The run and the error LED; the others are off.
pub const fn leds(run: bool, error: bool) -> Leds {
    Leds {
        run,
        error,
        module_green: false,
        module_red: false,
    }
}

/// A frame with its time in ms.
pub type Timed = (u64, Frame);

/// A node with its simulated environment.
pub struct Tester<N> {
    pub node: N,
    pub now: Instant,
    pub actions: Vec<Action>,
    pub leds: Leds,
    /// The contents of the nonvolatile memory.
    pub memory: Option<Vec<u8>>,
    /// The calibration of the device.
    pub calibration: Calibration,
    /// The identity of the unit.
    pub unit: Unit,
    /// The usage of the device, and the causes of the next start.
    pub usage: Usage,
    pub causes: ResetCauses,
    /// The program behind a bootloader, from the next power-up on.
    pub program: Option<Installed>,
    /// The result of the next saves; None: a save runs until `finish_save`.
    pub memory_works: Option<bool>,
    /// The present specific force, 1 g = [`ONE_G`].
    pub force: [i32; 3],
    /// The present angular rate, 1 deg/s = 2^16.
    pub rate: [i32; 3],
    /// The temperature of the accelerometer in 0.01 degC.
    pub temperature: i16,
    pub clipped: bool,
    /// Whether the accelerometer delivers samples.
    pub sampled: bool,
    pub sample_period: Duration,
    /// Another node acknowledges the frames of the node.
    pub acknowledged: bool,
    /// The node-ID of a CANopen node for SDO requests.
    pub node_id: u8,
    next_sample: Instant,
    boot: Box<PowerUp<N>>,
}

/// Starts a node with the contents of its memory.
type PowerUp<N> = dyn Fn(Instant, &Boot) -> N;

impl<N: Node> Tester<N> {
    /// Powers a node up and hands in its first sample.
    pub fn power_up(loaded: Boot, boot: impl Fn(Instant, &Boot) -> N + 'static) -> Self {
        let mut tester = Self::switch_on(loaded, boot);
        tester.begin();
        tester
    }

    /// Powers a node up, without a sample. It is not on the bus until [`begin`](Self::begin).
    pub fn switch_on(loaded: Boot, boot: impl Fn(Instant, &Boot) -> N + 'static) -> Self {
        let now = Instant::from_ticks(0);
        let memory = loaded.parameters.map(<[u8]>::to_vec);
        let unit = loaded.unit;
        let node = boot(
            now,
            &Boot {
                serial: SERIAL,
                ..loaded
            },
        );
        let mut tester = Self {
            node,
            now,
            actions: Vec::new(),
            leds: Leds::default(),
            memory,
            calibration: Calibration::IDENTITY,
            unit,
            usage: Usage::NONE,
            causes: ResetCauses::NONE,
            program: None,
            memory_works: Some(true),
            force: [0, 0, ONE_G],
            rate: [0; 3],
            temperature: 25_00,
            clipped: false,
            sampled: false,
            sample_period: millis(5),
            acknowledged: true,
            node_id: 10,
            next_sample: now,
            boot: Box::new(boot),
        };
        tester.settle();
        tester
    }

    /// Hands in the first sample. From now on the accelerometer delivers samples.
    pub fn begin(&mut self) {
        self.sampled = true;
        self.sample();
    }

    /// Power off and on again, and the first sample.
    pub fn power_cycle(&mut self) {
        self.switch_on_again();
        self.begin();
    }

    /// The restart that the node has requested, and the first sample.
    pub fn restart(&mut self) {
        self.start(self.node.kept());
        self.begin();
    }

    /// Power off and on again, without a sample.
    pub fn switch_on_again(&mut self) {
        self.start(0);
    }

    fn start(&mut self, kept: u32) {
        self.sampled = false;
        let loaded = Boot {
            parameters: self.memory.as_deref(),
            calibration: self.calibration,
            damaged: false,
            serial: SERIAL,
            kept,
            unit: self.unit,
            usage: self.usage,
            causes: self.causes,
            program: self.program,
        };
        self.actions.clear();
        self.node = (self.boot)(self.now, &loaded);
        self.settle();
    }

    fn settle(&mut self) {
        for _ in 0..100 {
            let Some(action) = self.node.poll(self.now) else {
                let deadline = self.node.deadline();
                assert!(deadline.is_none_or(|at| at > self.now), "{deadline:?}");
                return;
            };
            self.actions.push(action);
            match action {
                Action::Leds(leds) => self.leds = leds,
                Action::Save => {
                    let mut image = vec![0; 1000];
                    let size = self.node.image(&mut image).unwrap();
                    image.truncate(size);
                    match self.memory_works {
                        Some(true) => {
                            self.memory = Some(image);
                            self.node.stored(self.now, Ok(()));
                        }
                        Some(false) => self.node.stored(self.now, Err(StoreError)),
                        None => {}
                    }
                }
                _ => {}
            }
        }
        panic!("the node requests actions without end: {:?}", self.actions);
    }

    /// Ends the running save with this result.
    pub fn finish_save(&mut self, result: Result<(), StoreError>) {
        self.node.stored(self.now, result);
        self.settle();
    }

    /// Ends the self-test of the accelerometer.
    pub fn tested(&mut self, x: bool, y: bool) {
        self.node.tested(self.now, Working { x, y, z: true });
        self.settle();
    }

    /// Hands in one sample of the present force.
    pub fn sample(&mut self) {
        let [x, y, z] = self.force;
        let reading = Reading {
            acceleration: I32x3 { x, y, z },
            angular_rate: I32x3 {
                x: self.rate[0],
                y: self.rate[1],
                z: self.rate[2],
            },
            temperature: self.temperature,
            clipped: self.clipped,
        };
        self.node.sample(self.now, &reading);
        self.next_sample = self.now + self.sample_period;
        self.settle();
    }

    /// Hands in a measurement of the supply voltage in mV, 400 times: until its filter has settled.
    pub fn supply(&mut self, millivolts: u16) {
        for _ in 0..400 {
            self.node.supply(self.now, millivolts);
            self.settle();
        }
    }

    /// Hands in `samples` samples of this specific force without passing time.
    pub fn hold(&mut self, force: [i32; 3], samples: usize) {
        self.force = force;
        (0..samples).for_each(|_| self.sample());
    }

    /// Hands in `samples` samples of the present force at the limit of the range, without passing time.
    pub fn clip(&mut self, samples: usize) {
        self.clipped = true;
        (0..samples).for_each(|_| self.sample());
        self.clipped = false;
    }

    /// Whether a frame with this identifier passes the acceptance filters.
    pub fn accepts(&self, id: embedded_can::Id) -> bool {
        let mut accepted = false;
        self.node
            .filters(&mut |filter| accepted |= filter.accepts(id));
        accepted
    }

    /// The node receives this frame.
    pub fn receive(&mut self, frame: Frame) {
        assert!(self.node.ready(), "not ready for {frame:?}");
        self.node.receive(self.now, &frame);
        self.settle();
    }

    /// Hands an event of the CAN controller in.
    pub fn bus(&mut self, event: BusEvent) {
        self.node.bus(self.now, event);
        self.settle();
    }

    /// All frames that the node sends now.
    pub fn sent(&mut self) -> Vec<Frame> {
        let mut frames = Vec::new();
        while let Some(frame) = self.node.transmit(self.now) {
            frames.push(frame);
            self.settle();
            if self.acknowledged {
                self.node.sent(self.now);
                self.settle();
            }
        }
        frames
    }

    /// Lets time pass and polls at each deadline. Returns the sent frames with the time since power-up in ms.
    pub fn wait(&mut self, ms: u64) -> Vec<Timed> {
        let end = Instant::from_ticks(self.now.ticks() + ms * 1000);
        let mut frames = Vec::new();
        loop {
            if self.sampled && self.now >= self.next_sample {
                self.sample();
            }
            let time = self.now.ticks() / 1000;
            frames.extend(self.sent().into_iter().map(|frame| (time, frame)));
            if self.now >= end {
                return frames;
            }
            let deadline = self.node.deadline().unwrap_or(end).min(end);
            let sample = if self.sampled { self.next_sample } else { end };
            self.now = deadline.min(sample).max(self.now);
            self.settle();
        }
    }

    /// Lets time pass without samples.
    pub fn wait_without_samples(&mut self, ms: u64) -> Vec<Timed> {
        self.sampled = false;
        let frames = self.wait(ms);
        self.sampled = true;
        frames
    }

    /// Advances to the next deadline without a sample. Returns the frames sent then.
    pub fn next(&mut self) -> Vec<Frame> {
        self.now = self.node.deadline().unwrap();
        self.settle();
        self.sent()
    }
}
