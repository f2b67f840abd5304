//! The first part of a scan: listens at all rates and sends nothing.

use crate::adapter::Mode;
use crate::client::Link;
use crate::failure::Failure;
use crate::output::Terminal;
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, after, millis};

/// The first round: a lone CANopen node repeats its boot-up message all the time.
const SHORT: Duration = millis(120);

/// The second round: heartbeats and cyclic values come once a second.
const LONG: Duration = millis(1100);

/// The most frames that are kept: a message that nobody acknowledges is repeated all the time.
const FRAMES: usize = 20_000;

/// What was heard at a rate.
#[derive(Clone, Debug)]
pub struct Heard {
    /// The rate; None: that of the interface.
    pub rate: Option<BitRate>,
    /// The frames in their order.
    pub frames: Vec<Frame>,
}

/// Listens at all rates, in two rounds; None: nobody talks.
///
/// # Errors
/// The adapter has no listen-only mode, or has failed.
pub fn all(
    link: &mut Link,
    rates: &[Option<BitRate>],
    terminal: &mut Terminal,
) -> Result<Option<Heard>, Failure> {
    let rounds = [(1, SHORT), (2, LONG)];
    for (round, time) in rounds {
        for (place, rate) in (1..).zip(rates) {
            if (terminal.stopped)() {
                return Err(Failure::bus(
                    "stopped",
                    "the scan was stopped: start it again to finish",
                ));
            }
            match link.open(*rate, Mode::Listen) {
                Err(failure) if failure.code == "rate-refused" => {
                    terminal.note(failure.message);
                    continue;
                }
                opened => opened?,
            }
            let mut frames = collect(link, time)?;
            let errors = link.adapter().errors();
            let name = rate.map_or("the bit rate of the interface", BitRate::name);
            let progress = (round - 1) * rates.len() + place;
            let errors = errors.map_or(String::new(), |errors| format!(", {errors} errors"));
            let (total, dwell, count) = (2 * rates.len(), time.to_millis(), frames.len());
            terminal.note(format!(
                "[{progress:2}/{total}] listened at {name} for {dwell} ms: {count} frames{errors}"
            ));
            if !frames.is_empty() {
                // Long enough to hear every node that talks once a second.
                if time < LONG {
                    frames.extend(collect(link, LONG)?);
                }
                link.adapter().close();
                return Ok(Some(Heard {
                    rate: *rate,
                    frames,
                }));
            }
            link.adapter().close();
        }
    }
    Ok(None)
}

fn collect(link: &mut Link, time: Duration) -> Result<Vec<Frame>, Failure> {
    let until = after(link.now(), time);
    let mut frames = Vec::new();
    while let Some((_, frame)) = link.receive(until)? {
        if frames.len() < FRAMES {
            frames.push(frame);
        }
    }
    Ok(frames)
}
