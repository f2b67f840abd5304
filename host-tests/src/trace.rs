//! Recorded or written traces of the bus, replayed against a simulated sensor.
//!
//! A trace is a log in the format of `candump -L -x`:
//!
//! ```text
//! # origin: written from the user manual 1.7, section 9.6
//! # model: is2
//! # scene: tilt=12.34,-5.67
//! # bitrate: 250000
//! # tolerance-us: 600
//! # serial: 1
//!
//! # -- What a comment looks like.
//! (0.100000) can0 300#00 T
//! (0.100672) can0 301#FF03000300004403 R
//! # power-cycle
//! ```
//!
//! Time is in seconds since power-up. `T` lines are frames of the tester; their time is the start of the frame. `R` lines are what
//! the sensor sends; their time is the end of the frame. The sensor must send exactly these frames, in this order, byte for byte,
//! at these times within the tolerance, and nothing else until the last time plus the tolerance.
//!
//! Lines with `#` describe the trace, or, between frames, act on the sensor. Anything else with `#` is an error, but for `# -- text`
//! and a bare `#`, which are comments.
//!
//! | line | meaning |
//! |---|---|
//! | `# origin: text` | where the trace comes from; always needed |
//! | `# model: name` | the model; always needed |
//! | `# scene: text` | what the sensor is mounted on; between frames it changes |
//! | `# bitrate: N` | bits per second on the wire. A sensor that detects the rate is led there before each of the tester's frames. Without this line the wire follows the sensor ([`BusRate::Follow`](bench::BusRate::Follow)) |
//! | `# tolerance-us: N` | how far a frame may be off its time, in microseconds; 1000 without this line |
//! | `# serial: N` | the serial number; 1 without this line |
//! | `# power-cycle` | the power goes off and on again |
//! | `# corrupt newest-image` | a bit in the newest image in nonvolatile memory flips |
//! | `# fail-writes on`, `off` | nonvolatile memory can no longer be programmed or erased; it can again |
//!
//! What acts between frames does so when the frame of the line before has ended.

mod difference;
mod parse;
mod replay;

pub use difference::Difference;
pub use replay::{Failure, MakeSensor, Scenes};

use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant, millis};
use std::fmt;

/// A trace, read and checked.
#[derive(Clone, PartialEq, Debug)]
pub struct Trace {
    /// Where it comes from.
    pub origin: String,
    /// The name of the model.
    pub model: String,
    /// What the sensor is mounted on at first.
    pub scene: Option<String>,
    /// The bit rate of the wire; None: that of the sensor.
    pub bit_rate: Option<BitRate>,
    /// How far a frame may be off its time.
    pub tolerance: Duration,
    /// The serial number.
    pub serial: u32,
    /// Frames and what happens between them.
    pub steps: Vec<Step>,
}

impl Default for Trace {
    fn default() -> Self {
        Self {
            origin: String::new(),
            model: String::new(),
            scene: None,
            bit_rate: None,
            tolerance: millis(1),
            serial: 1,
            steps: Vec::new(),
        }
    }
}

/// A line of a trace that is a frame or an action.
#[derive(Clone, PartialEq, Debug)]
pub struct Step {
    /// The number of the line, from 1.
    pub line: usize,
    /// What it says.
    pub what: What,
}

/// What a line of a trace says.
#[derive(Clone, PartialEq, Debug)]
pub enum What {
    /// The tester begins to send.
    Send(Instant, Frame),
    /// A frame of the sensor has ended.
    Expect(Instant, Frame),
    /// The power goes off and on again.
    PowerCycle,
    /// A bit in the newest image flips.
    CorruptNewest,
    /// Nonvolatile memory can no longer be written, or can again.
    FailWrites(bool),
    /// The sensor is mounted on something else.
    Scene(String),
}

/// A line of a trace that makes no sense.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct TraceError {
    /// The number of the line, from 1; 0 when a line is missing.
    pub line: usize,
    /// What is wrong with it.
    pub message: String,
}

impl fmt::Display for TraceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line > 0 {
            write!(f, "line {}: ", self.line)?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for TraceError {}
