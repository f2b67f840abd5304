//! A node on the desk: frames in at a time, frames out, driven as a board drives it.

pub mod canopen;
pub mod fsc;

use plumbline::can::Frame;
use plumbline::measure::self_test::Working;
use plumbline::measure::{Calibration, I32x3, ONE_G, Reading};
use plumbline::node::{Action, Boot, BusEvent, Leds, Node};
use plumbline::store::StoreError;
use plumbline::time::{Duration, Instant, millis};

/// The serial number of the node under test.
pub const SERIAL: u32 = 0x0403_0201;

/// The run and the error LED; the others are dark.
pub const fn leds(run: bool, error: bool) -> Leds {
    Leds {
        run,
        error,
        module_green: false,
        module_red: false,
    }
}

/// A frame with a time in ms.
pub type Timed = (u64, Frame);

/// A node and what the world around it has seen.
pub struct Tester<N> {
    pub node: N,
    pub now: Instant,
    pub actions: Vec<Action>,
    pub leds: Leds,
    /// What the nonvolatile memory holds.
    pub memory: Option<Vec<u8>>,
    /// The calibration of the unit.
    pub calibration: Calibration,
    /// The result of the next saves; None: the memory does not answer before `finish_save`.
    pub memory_works: Option<bool>,
    /// The specific force at present.
    pub force: [i32; 3],
    /// The temperature of the accelerometer in 0.01 degC.
    pub temperature: i16,
    pub clipped: bool,
    /// The accelerometer delivers.
    pub sampled: bool,
    pub sample_period: Duration,
    /// The node-ID of a CANopen node, to which SDO requests go.
    pub node_id: u8,
    next_sample: Instant,
    boot: Box<PowerUp<N>>,
}

/// Starts a node with what its memory holds.
type PowerUp<N> = dyn Fn(Instant, &Boot) -> N;

impl<N: Node> Tester<N> {
    /// Powers a node up; it gets its first sample before its first actions are carried out, as on a board.
    pub fn power_up(loaded: Boot, boot: impl Fn(Instant, &Boot) -> N + 'static) -> Self {
        let now = Instant::from_ticks(0);
        let memory = loaded.parameters.map(<[u8]>::to_vec);
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
            memory_works: Some(true),
            force: [0, 0, ONE_G],
            temperature: 25_00,
            clipped: false,
            sampled: true,
            sample_period: millis(5),
            node_id: 10,
            next_sample: now,
            boot: Box::new(boot),
        };
        tester.sample();
        tester
    }

    /// Power off and on again.
    pub fn power_cycle(&mut self) {
        let loaded = Boot {
            parameters: self.memory.as_deref(),
            calibration: self.calibration,
            damaged: false,
            serial: SERIAL,
        };
        self.actions.clear();
        self.node = (self.boot)(self.now, &loaded);
        self.sample();
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
        panic!("the node never rests: {:?}", self.actions);
    }

    /// The save that was left open ends.
    pub fn finish_save(&mut self, result: Result<(), StoreError>) {
        self.node.stored(self.now, result);
        self.settle();
    }

    /// The self-test of the accelerometer ends.
    pub fn tested(&mut self, x: bool, y: bool) {
        self.node.tested(self.now, Working { x, y, z: true });
        self.settle();
    }

    /// One sample of the present force.
    pub fn sample(&mut self) {
        let [x, y, z] = self.force;
        let reading = Reading {
            acceleration: I32x3 { x, y, z },
            angular_rate: I32x3 { x: 0, y: 0, z: 0 },
            temperature: self.temperature,
            clipped: self.clipped,
        };
        self.node.sample(self.now, &reading);
        self.next_sample = self.now + self.sample_period;
        self.settle();
    }

    /// Rests with this specific force for `samples` samples; no time passes.
    pub fn hold(&mut self, force: [i32; 3], samples: usize) {
        self.force = force;
        (0..samples).for_each(|_| self.sample());
    }

    /// Whether a frame with this identifier passes the acceptance filters.
    pub fn accepts(&self, id: embedded_can::Id) -> bool {
        let mut accepted = false;
        self.node
            .filters(&mut |filter| accepted |= filter.accepts(id));
        accepted
    }

    /// Hands a frame in.
    pub fn receive(&mut self, frame: Frame) {
        assert!(self.node.ready(), "not ready for {frame:?}");
        self.node.receive(self.now, &frame);
        self.settle();
    }

    /// The CAN controller tells something.
    pub fn bus(&mut self, event: BusEvent) {
        self.node.bus(self.now, event);
        self.settle();
    }

    /// Everything that the node has to send.
    pub fn sent(&mut self) -> Vec<Frame> {
        let mut frames = Vec::new();
        while let Some(frame) = self.node.transmit(self.now) {
            frames.push(frame);
            self.settle();
        }
        frames
    }

    /// Lets time pass, polling at every deadline; returns what is sent, with the time since power-up in ms.
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

    /// Goes on to the next deadline without a sample; returns what is sent then.
    pub fn next(&mut self) -> Vec<Frame> {
        self.now = self.node.deadline().unwrap();
        self.settle();
        self.sent()
    }
}
