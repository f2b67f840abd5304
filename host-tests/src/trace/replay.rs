//! Runs a trace against a simulated sensor.

use super::{Difference, Step, Trace, TraceError, What};
use bench::motion::Motion;
use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, NodeType, Sensor};
use plumbline::can::Frame;
use plumbline::time::{Duration, Instant, after, millis};
use std::fmt;

/// A sensor that detects the bit rate is set to that of the trace this long before a frame of the tester: it needs some
/// milliseconds for each rate that it tries.
const LEAD: Duration = millis(60);

/// The precision of a trace.
const STEP: Duration = Duration::from_ticks(1);

/// Parses the text of a `# scene:` line into a motion for this node type, or returns the error.
pub type Scenes = dyn Fn(&NodeType, &str) -> Result<Box<dyn Motion>, String>;

/// Creates a sensor with a blank memory from the node type, the serial number and the motion.
pub type MakeSensor<'a> = dyn Fn(&NodeType, u32, Box<dyn Motion>) -> Box<dyn Sensor> + 'a;

/// Why a sensor does not agree with a trace.
#[derive(Clone, PartialEq, Debug)]
pub enum Failure {
    /// The trace requires something that is not possible.
    Trace(TraceError),
    /// The frames of the sensor differ from the trace.
    Differs(Difference),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Trace(error) => error.fmt(f),
            Self::Differs(difference) => difference.fmt(f),
        }
    }
}

impl std::error::Error for Failure {}

impl Trace {
    /// Replays the trace against a sensor of this type with a blank memory.
    ///
    /// # Errors
    /// The frames of the sensor differ from the trace, or a scene is invalid.
    pub fn replay(&self, node_type: &NodeType, scenes: &Scenes) -> Result<(), Failure> {
        let none = Duration::from_ticks(0);
        self.replay_on(node_type, scenes, none, &|node_type, serial, motion| {
            Box::new(Device::new(node_type, serial, Flash::default(), motion))
        })
    }

    /// Replays the trace against the sensor that `make` creates. All times are later by `boot` after each power-up: an image starts its
    /// clocks before it takes part in the bus.
    ///
    /// # Errors
    /// The frames of the sensor differ from the trace, or a scene is invalid.
    pub fn replay_on(
        &self,
        node_type: &NodeType,
        scenes: &Scenes,
        boot: Duration,
        make: &MakeSensor,
    ) -> Result<(), Failure> {
        let mut replay =
            Replay::new(self, node_type, scenes, boot, make).map_err(Failure::Trace)?;
        for step in &self.steps {
            replay
                .step(step, node_type, scenes)
                .map_err(Failure::Trace)?;
        }
        replay.finish();
        match Difference::between(self, &replay.received) {
            Some(difference) => Err(Failure::Differs(difference)),
            None => Ok(()),
        }
    }
}

/// A replay in progress: a bus with a sensor and a tester.
pub(super) struct Replay {
    bus: Bus,
    device: DeviceId,
    tester: AdapterId,
    tolerance: Duration,
    /// The longer time of the sensor from power-up to its first frame.
    boot: Duration,
    /// The difference between the time of the bus and that of the trace.
    begin: Duration,
    /// The time of the last frame line.
    last: Instant,
    /// The number of frames expected up to `last`.
    expected: usize,
    /// The frames of the sensor so far.
    pub(super) received: Vec<(Instant, Frame)>,
}

impl Replay {
    /// Attaches the sensor that `make` creates and a tester.
    pub(super) fn new(
        trace: &Trace,
        node_type: &NodeType,
        scenes: &Scenes,
        boot: Duration,
        make: &MakeSensor,
    ) -> Result<Self, TraceError> {
        let scene = trace.scene.as_deref().unwrap_or("tilt=0,0");
        let motion = scenes(node_type, scene).map_err(|message| TraceError { line: 0, message })?;
        let device = make(node_type, trace.serial, motion);
        let mut bus = Bus::new(trace.bit_rate.map_or(BusRate::Follow, BusRate::Fixed));
        let device = bus.attach_boxed(device);
        let tester = bus.adapter();
        bus.open(tester, None, false);
        Ok(Self {
            bus,
            device,
            tester,
            tolerance: trace.tolerance,
            boot,
            begin: boot,
            last: Instant::from_ticks(0),
            expected: 0,
            received: Vec::new(),
        })
    }

    pub(super) fn step(
        &mut self,
        step: &Step,
        node_type: &NodeType,
        scenes: &Scenes,
    ) -> Result<(), TraceError> {
        let Step { line, what } = step;
        let invalid = |message| TraceError {
            line: *line,
            message,
        };
        match what {
            What::Send(at, frame) => {
                let lead = Instant::from_ticks(at.ticks().saturating_sub(LEAD.ticks()));
                self.run_until(lead);
                self.bus.lead_detection();
                self.run_until(*at);
                self.bus.send(self.tester, *frame);
                self.last = *at;
                return Ok(());
            }
            What::Expect(at, _) => {
                self.expected += 1;
                self.last = *at;
                return Ok(());
            }
            _ => self.catch_up(),
        }
        if let What::Tolerance(tolerance) = what {
            self.tolerance = *tolerance;
        }
        let now = self.bus.now();
        let device = self.bus.device_mut(self.device);
        match what {
            What::PowerCycle => {
                device.power_cycle(now);
                self.begin += self.boot;
            }
            What::CorruptNewest if !device.flash().corrupt_newest() => {
                return Err(invalid("no record has been written yet".to_owned()));
            }
            What::FailWrites(fail) => {
                device.flash().fail_writes(*fail);
                device.flash().fail_erases(*fail);
            }
            What::Scene(text) => device.set_motion(scenes(node_type, text).map_err(invalid)?),
            What::CorruptNewest | What::Tolerance(_) | What::Send(..) | What::Expect(..) => {}
        }
        Ok(())
    }

    /// Runs the bus up to this time of the trace.
    fn run_until(&mut self, at: Instant) {
        self.bus.run_until(after(at, self.begin));
    }

    /// Runs the bus until the end of the frame in the line before, at most up to the tolerance.
    pub(super) fn catch_up(&mut self) {
        self.run_until(self.last);
        self.collect();
        let patience = after(after(self.last, self.tolerance), self.begin);
        while self.bus.queued(self.tester) > 0 || self.received.len() < self.expected {
            let Some(next) = self.bus.next_event().filter(|at| *at <= patience) else {
                return;
            };
            // A simulated microcontroller may act at any time, so the time must advance in any case.
            self.bus.run_until(next.max(after(self.bus.now(), STEP)));
            self.collect();
        }
    }

    /// Runs the bus until the last line could be late, at the end of the trace.
    pub(super) fn finish(&mut self) {
        self.run_until(after(self.last, self.tolerance));
        self.collect();
    }

    /// Runs the bus until the sensor sends no frame for this time, at most up to `limit` in the time of the trace.
    pub(super) fn run_until_silent(&mut self, silence: Duration, limit: Instant) {
        self.catch_up();
        loop {
            let count = self.received.len();
            let end = after(self.bus.now(), silence);
            self.bus.run_until(end.min(after(limit, self.begin)));
            self.collect();
            if self.received.len() == count {
                return;
            }
        }
    }

    fn collect(&mut self) {
        let begin = self.begin.ticks();
        let received = self.bus.take_received(self.tester).into_iter();
        let in_trace = |at: Instant| Instant::from_ticks(at.ticks().saturating_sub(begin));
        self.received
            .extend(received.map(|(at, frame)| (in_trace(at), frame)));
    }
}
