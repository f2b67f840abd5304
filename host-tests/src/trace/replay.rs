//! Runs a trace against a simulated sensor.

use super::{Difference, Trace, TraceError, What};
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

/// Why a replay failed.
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

    /// Replays the trace against the sensor that `make` creates. The trace begins `boot` after power-up: an image waits for its
    /// accelerometer before it takes part in the bus.
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
        let mut replay = Replay::new(self, node_type, scenes, boot, make)?;
        for step in &self.steps {
            replay
                .step(&step.what, node_type, scenes)
                .map_err(|message| trace_error(step.line, message))?;
        }
        let end = after(replay.last, replay.tolerance);
        replay.run_until(end);
        replay.collect();
        match Difference::between(self, &replay.received) {
            Some(difference) => Err(Failure::Differs(difference)),
            None => Ok(()),
        }
    }
}

fn trace_error(line: usize, message: String) -> Failure {
    Failure::Trace(TraceError { line, message })
}

struct Replay {
    bus: Bus,
    device: DeviceId,
    tester: AdapterId,
    tolerance: Duration,
    /// The time of the bus at the begin of the trace.
    begin: Duration,
    /// The time of the last frame line.
    last: Instant,
    /// The number of frames expected up to `last`.
    expected: usize,
    received: Vec<(Instant, Frame)>,
}

impl Replay {
    fn new(
        trace: &Trace,
        node_type: &NodeType,
        scenes: &Scenes,
        begin: Duration,
        make: &MakeSensor,
    ) -> Result<Self, Failure> {
        let scene = trace.scene.as_deref().unwrap_or("tilt=0,0");
        let motion = scenes(node_type, scene).map_err(|message| trace_error(0, message))?;
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
            begin,
            last: Instant::from_ticks(0),
            expected: 0,
            received: Vec::new(),
        })
    }

    fn step(&mut self, what: &What, node_type: &NodeType, scenes: &Scenes) -> Result<(), String> {
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
            What::PowerCycle => device.power_cycle(now),
            What::CorruptNewest if !device.flash().corrupt_newest() => {
                return Err("no record has been written yet".to_owned());
            }
            What::FailWrites(fail) => {
                device.flash().fail_writes(*fail);
                device.flash().fail_erases(*fail);
            }
            What::Scene(text) => device.set_motion(scenes(node_type, text)?),
            What::CorruptNewest | What::Tolerance(_) | What::Send(..) | What::Expect(..) => {}
        }
        Ok(())
    }

    /// Runs the bus up to this time of the trace.
    fn run_until(&mut self, at: Instant) {
        self.bus.run_until(after(at, self.begin));
    }

    /// Runs the bus until the end of the frame in the line before, at most up to the tolerance.
    fn catch_up(&mut self) {
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

    fn collect(&mut self) {
        let begin = self.begin.ticks();
        let received = self.bus.take_received(self.tester).into_iter();
        let in_trace = |at: Instant| Instant::from_ticks(at.ticks().saturating_sub(begin));
        self.received
            .extend(received.map(|(at, frame)| (in_trace(at), frame)));
    }
}
