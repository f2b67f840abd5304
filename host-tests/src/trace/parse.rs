//! Parses a trace; the frames are parsed by socketcan.

use super::{Step, Trace, TraceError, What};
use embedded_can::Frame as _;
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant};
use socketcan::CanAnyFrame;
use socketcan::dump::{Direction, Reader};
use std::str::FromStr;

impl FromStr for Trace {
    type Err = TraceError;

    fn from_str(text: &str) -> Result<Self, TraceError> {
        let mut trace = Self::default();
        let mut last = Instant::from_ticks(0);
        for (index, text) in text.lines().enumerate() {
            let line = index + 1;
            let step = read_line(text.trim(), &mut trace).map_err(|message| TraceError {
                line,
                message: format!("{message}: {text}"),
            })?;
            if let Some(What::Send(at, _) | What::Expect(at, _)) = step {
                if at < last {
                    let message = format!("the time is less than in the line before: {text}");
                    return Err(TraceError { line, message });
                }
                last = at;
            }
            trace.steps.extend(step.map(|what| Step { line, what }));
        }
        for (key, value) in [("origin", &trace.origin), ("model", &trace.model)] {
            if value.is_empty() {
                return Err(TraceError {
                    line: 0,
                    message: format!("the line \"# {key}: ...\" is missing"),
                });
            }
        }
        Ok(trace)
    }
}

/// Parses one line: a step, a property of the trace, or nothing.
fn read_line(text: &str, trace: &mut Trace) -> Result<Option<What>, String> {
    let Some(text) = text.strip_prefix('#') else {
        return if text.is_empty() {
            Ok(None)
        } else {
            frame(text).map(Some)
        };
    };
    let text = text.trim();
    if text.is_empty() || text.starts_with("--") {
        return Ok(None);
    }
    match text {
        "power-cycle" => return Ok(Some(What::PowerCycle)),
        "corrupt newest-image" => return Ok(Some(What::CorruptNewest)),
        "fail-writes on" => return Ok(Some(What::FailWrites(true))),
        "fail-writes off" => return Ok(Some(What::FailWrites(false))),
        _ => {}
    }
    let (key, value) = text
        .split_once(':')
        .ok_or("neither a comment nor an action nor a property")?;
    let value = value.trim();
    if key == "scene" && !trace.steps.is_empty() {
        return Ok(Some(What::Scene(value.to_owned())));
    }
    if key == "tolerance-us" && !trace.steps.is_empty() {
        let tolerance = Duration::from_ticks(number(value)?.into());
        return Ok(Some(What::Tolerance(tolerance)));
    }
    if !trace.steps.is_empty() {
        return Err("this must be before the first frame".to_owned());
    }
    match key {
        "origin" => trace.origin = value.to_owned(),
        "model" => trace.model = value.to_owned(),
        "scene" => trace.scene = Some(value.to_owned()),
        "bitrate" => trace.bit_rate = Some(bit_rate(number(value)?)?),
        "tolerance-us" => trace.tolerance = Duration::from_ticks(number(value)?.into()),
        "serial" => trace.serial = number(value)?,
        _ => return Err("unknown property".to_owned()),
    }
    Ok(None)
}

fn number(text: &str) -> Result<u32, String> {
    text.parse().map_err(|_| "not a number".to_owned())
}

fn bit_rate(bits_per_second: u32) -> Result<BitRate, String> {
    BitRate::ALL
        .into_iter()
        .find(|rate| rate.bits_per_second() == bits_per_second)
        .ok_or_else(|| "not one of the ten bit rates".to_owned())
}

fn frame(text: &str) -> Result<What, String> {
    let record = Reader::from_reader(text.as_bytes())
        .next_record()
        .map_err(|error| error.to_string())?
        .ok_or("an empty line")?;
    let frame = match &record.frame {
        CanAnyFrame::Normal(frame) => Frame::data(frame.id(), frame.data()),
        CanAnyFrame::Remote(frame) => Frame::remote(frame.id(), frame.dlc()),
        CanAnyFrame::Error(_) | CanAnyFrame::Fd(_) => None,
    };
    let frame = frame.ok_or("not a classic data or remote frame")?;
    let at = Instant::from_ticks(record.t_us);
    match record.direction {
        Some(Direction::Transmitted) => Ok(What::Send(at, frame)),
        Some(Direction::Received) => Ok(What::Expect(at, frame)),
        None => Err("the direction T or R is missing at the end".to_owned()),
    }
}
