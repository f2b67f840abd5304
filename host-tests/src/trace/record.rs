//! Writes the frames of a simulated sensor into a trace.

use super::replay::{Replay, Scenes};
use super::{Trace, TraceError, What};
use bench::{Device, Flash, NodeType, Sensor};
use plumbline::can::Frame;
use plumbline::time::{Duration, Instant, after, millis};

/// A frame and its time.
type Timed = (Instant, Frame);

/// The bus is silent if the sensor sends nothing for this long.
const SILENCE: Duration = millis(20);

/// The longest time after the last frame of the tester until the bus is silent.
const PATIENCE: Duration = millis(1000);

impl Trace {
    /// The text of a trace with the frames that a sensor of this type sends, in place of those that it has.
    ///
    /// Lines that are right stay. The `R` lines that the text has are marks in time: an action after such a line acts at its time, and the
    /// trace ends at its last line.
    /// Without any `R` line, the bus is silent before each action and at the end; only a new tolerance directly after a frame of the tester
    /// is in force for the reply.
    ///
    /// # Errors
    /// An invalid line, or an action that is not possible.
    pub fn record(text: &str, node_type: &NodeType, scenes: &Scenes) -> Result<String, TraceError> {
        let placed = with_frames(text, node_type, scenes)?;
        // Now each action has its place, as in a replay.
        with_frames(&placed, node_type, scenes)
    }
}

/// The text with the frames of one run.
fn with_frames(text: &str, node_type: &NodeType, scenes: &Scenes) -> Result<String, TraceError> {
    let trace: Trace = text.parse()?;
    let run = Run::of(&trace, node_type, scenes)?;
    let marks = trace
        .steps
        .iter()
        .filter(|step| is_mark(&step.what))
        .count();
    let same = marks == run.received.len();
    let mut received = run.received;
    if same {
        keep_times(&trace, &mut received);
    }
    let mut frames = received.into_iter().enumerate().peekable();
    let mut before_actions = run.before_actions.into_iter();
    let mut steps = trace.steps.iter().peekable();
    let mut mark = 0;
    let mut out = String::new();
    let mut after_description = false;
    // Comments and empty lines belong to the line after them.
    let mut comments = String::new();
    for (line, source) in (1..).zip(text.lines()) {
        let Some(step) = steps.next_if(|step| step.line == line) else {
            comments += &format!("{source}\n");
            // The description of the trace, and the empty line after it, are before all frames.
            let is_description = source.starts_with('#') && !source.starts_with("# --");
            if is_description || after_description && source.is_empty() {
                out += &std::mem::take(&mut comments);
            }
            after_description = is_description;
            continue;
        };
        let count = match step.what {
            What::Send(..) | What::Expect(..) => 0,
            _ => before_actions.next().unwrap_or(0),
        };
        while let Some((_, timed)) = frames.next_if(|(index, (at, _))| match step.what {
            What::Send(start, _) => *at <= start,
            What::Expect(..) if same => *index < mark,
            What::Expect(end, _) => *at < end,
            _ => *index < count,
        }) {
            out += &line_of(timed);
        }
        out += &std::mem::take(&mut comments);
        if is_mark(&step.what) {
            mark += 1;
        } else {
            out += &format!("{source}\n");
        }
    }
    out.extend(frames.map(|(_, timed)| line_of(timed)));
    Ok(out + &comments)
}

/// Frames that the trace has, within its tolerance, keep their times.
fn keep_times(trace: &Trace, received: &mut [Timed]) {
    let mut tolerance = trace.tolerance.ticks();
    let mut frames = received.iter_mut();
    for step in &trace.steps {
        match step.what {
            What::Tolerance(new) => tolerance = new.ticks(),
            What::Expect(time, expected) => {
                if let Some((at, frame)) = frames.next()
                    && *frame == expected
                    && at.ticks().abs_diff(time.ticks()) <= tolerance
                {
                    *at = time;
                }
            }
            _ => {}
        }
    }
}

/// True for a frame of the sensor.
fn is_mark(what: &What) -> bool {
    matches!(what, What::Expect(..))
}

/// What a sensor has sent.
struct Run {
    /// All frames that the tester received.
    received: Vec<Timed>,
    /// The number of frames before each action.
    before_actions: Vec<usize>,
}

impl Run {
    fn of(trace: &Trace, node_type: &NodeType, scenes: &Scenes) -> Result<Self, TraceError> {
        let make = |node_type: &NodeType, serial, motion| -> Box<dyn Sensor> {
            Box::new(Device::new(node_type, serial, Flash::default(), motion))
        };
        let begin = Duration::from_ticks(0);
        let mut replay = Replay::new(trace, node_type, scenes, begin, &make)?;
        let is_marked = trace.steps.iter().any(|step| is_mark(&step.what));
        let mut before_actions = Vec::new();
        let mut last = Instant::from_ticks(0);
        let mut sent = false;
        for (index, step) in trace.steps.iter().enumerate() {
            let is_frame = matches!(step.what, What::Send(..) | What::Expect(..));
            if !is_frame {
                let for_reply = sent && matches!(step.what, What::Tolerance(_));
                if !is_marked && !for_reply {
                    let next = trace.steps[index..]
                        .iter()
                        .find_map(|step| match step.what {
                            What::Send(at, _) => Some(at),
                            _ => None,
                        });
                    let limit = next.unwrap_or(after(last, PATIENCE));
                    replay.run_until_silent(SILENCE, limit);
                }
                replay.catch_up();
                before_actions.push(replay.received.len());
            }
            if let What::Send(at, _) = step.what {
                last = at;
            }
            sent = matches!(step.what, What::Send(..));
            replay.step(step, node_type, scenes)?;
        }
        if !is_marked {
            replay.run_until_silent(SILENCE, after(last, PATIENCE));
        }
        replay.finish();
        Ok(Self {
            received: replay.received,
            before_actions,
        })
    }
}

/// A frame of the sensor, in the format of `candump`.
fn line_of((at, frame): Timed) -> String {
    let us = at.ticks();
    let (seconds, us) = (us / 1_000_000, us % 1_000_000);
    format!("({seconds}.{us:06}) can0 {frame:?} R\n")
}
