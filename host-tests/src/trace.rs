//! Bus traces, recorded or written, and their replay against a simulated sensor.
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
//! # -- A comment.
//! (0.100000) can0 300#00 T
//! (0.100672) can0 301#FF03000300004403 R
//! # power-cycle
//! ```
//!
//! Time is in seconds since power-up. `T` lines are frames of the tester; their time is the start of the frame. `R` lines are
//! frames of the sensor; their time is the end of the frame. The sensor must send exactly these frames, in this order, byte for
//! byte, at these times within the tolerance, and nothing else until the last time plus the tolerance.
//!
//! Lines with `#` describe the trace or, between frames, act on the sensor. `# -- text` and a bare `#` are comments. Every other
//! line with `#` is an error.
//!
//! | line | meaning |
//! |---|---|
//! | `# origin: text` | source of the trace; mandatory |
//! | `# model: name` | the product; mandatory |
//! | `# scene: text` | the scene; between frames: a new scene |
//! | `# bitrate: N` | bit rate of the bus in bit/s. A sensor that detects the bit rate is set to it before each frame of the tester. Without this line the bus has the bit rate of the sensor ([`BusRate::Follow`](bench::BusRate::Follow)) |
//! | `# tolerance-us: N` | maximum time error of a frame in us; 1000 without this line; between frames: that of the frames after it |
//! | `# serial: N` | the serial number; 1 without this line |
//! | `# power-cycle` | switches the power off and on again |
//! | `# corrupt newest-image` | flips a bit in the newest record in nonvolatile memory |
//! | `# fail-writes on`, `off` | programming and erasing of nonvolatile memory fails; works again |
//!
//! A line between frames acts after the end of the frame in the line before it.
//!
//! A new trace has only `T` lines and lines with `#`. `UPDATE=1 cargo test -p host-tests --test sensor traces::` adds the `R` lines
//! ([`Trace::record`]); compare them with the manual.

mod difference;
mod parse;
mod record;
pub mod recorded;
mod replay;

pub use difference::Difference;
pub use replay::{Failure, MakeSensor, Scenes};

use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant, millis};
use std::fmt;

/// A trace that was read from its file.
#[derive(Clone, PartialEq, Debug)]
pub struct Trace {
    /// The source of the trace.
    pub origin: String,
    /// The name of the product.
    pub model: String,
    /// The scene at the start.
    pub scene: Option<String>,
    /// The bit rate of the bus; None: that of the sensor.
    pub bit_rate: Option<BitRate>,
    /// The maximum time error of a frame.
    pub tolerance: Duration,
    /// The maximum error of an angular rate, in its digits.
    pub noise: u16,
    /// The serial number of the sensor.
    pub serial: u32,
    /// Frames, and actions between them.
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
            noise: 0,
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
    /// The frame or the action.
    pub what: What,
}

/// A frame or an action.
#[derive(Clone, PartialEq, Debug)]
pub enum What {
    /// A frame of the tester, and the time of its start.
    Send(Instant, Frame),
    /// A frame of the sensor, and the time of its end.
    Expect(Instant, Frame),
    /// Switches the power off and on again.
    PowerCycle,
    /// Flips a bit in the newest record.
    CorruptNewest,
    /// Programming and erasing of nonvolatile memory fails, or works again.
    FailWrites(bool),
    /// The sensor moves as in this scene from now on.
    Scene(String),
    /// The maximum time error of the frames after this line.
    Tolerance(Duration),
}

impl Trace {
    /// Increases the maximum time error of all frames, and the maximum error of the angular rates.
    pub fn loosen(&mut self, by: Duration, noise: u16) {
        self.noise += noise;
        self.tolerance += by;
        for step in &mut self.steps {
            if let What::Tolerance(tolerance) = &mut step.what {
                *tolerance += by;
            }
        }
    }
}

/// An invalid line of a trace.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct TraceError {
    /// The number of the line, from 1; 0 when a line is missing.
    pub line: usize,
    /// What is wrong in the line.
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
