//! `watch`, `record` and `log`.

use crate::adapter::{Adapter, Mode};
use crate::client::Link;
use crate::connect;
use crate::failure::Failure;
use crate::output::Terminal;
use crate::sample::{Sample, Sampler};
use crate::session::Session;
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant, after, millis};
use serde_json::json;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

/// The longest wait without a look at Ctrl-C.
const SLICE: Duration = millis(50);

/// The name of the interface in a log.
const INTERFACE: &str = "can0";

/// When to end.
fn end(now: Instant, seconds: Option<f64>) -> Result<Option<Instant>, Failure> {
    match seconds {
        None => Ok(None),
        Some(seconds) if (0.0..=1e9).contains(&seconds) => {
            let ticks = (seconds * 1e6) as u64;
            Ok(Some(after(now, Duration::from_ticks(ticks))))
        }
        Some(_) => Err(Failure::usage(
            "bad-value",
            "--seconds is a time of 0 to 1000000000 s",
        )),
    }
}

/// A function that takes each sample.
type Take<'a> =
    &'a mut dyn FnMut(&mut Terminal, &Session, &Sampler, &Sample) -> Result<(), Failure>;

/// Polls the angles and hands each sample to `take`, until the time is over or Ctrl-C.
fn samples(
    session: &mut Session,
    every: u32,
    seconds: Option<f64>,
    terminal: &mut Terminal,
    take: Take,
) -> Result<Sampler, Failure> {
    let mut sampler = Sampler::new(session)?;
    let end = end(session.link.now(), seconds)?;
    loop {
        if let Some(sample) = sampler.poll(session)? {
            take(terminal, session, &sampler, &sample)?;
        }
        let is_over = |session: &Session| end.is_some_and(|end| session.link.now() >= end);
        if is_over(session)
            || !sampler.wait(session, millis(every), terminal.stopped)?
            || is_over(session)
        {
            break;
        }
    }
    if sampler.lost == sampler.polls {
        return Err(Failure::silent(
            "no-answer",
            "the sensor has not answered once: check power and wiring",
        ));
    }
    Ok(sampler)
}

/// Shows the angles, one line for each sample.
pub(super) fn watch(
    session: &mut Session,
    every: u32,
    seconds: Option<f64>,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let sampler = samples(
        session,
        every,
        seconds,
        terminal,
        &mut |terminal, session, sampler, sample| {
            terminal.line(sampler.line(session, sample))?;
            terminal.document(&sampler.json(session, sample))
        },
    )?;
    terminal.note(sampler.summary());
    Ok(())
}

/// Records the angles as CSV.
pub(super) fn record(
    session: &mut Session,
    path: &Path,
    every: u32,
    seconds: Option<f64>,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let mut file = BufWriter::new(File::create(path).map_err(|error| unwritten(path, &error))?);
    let mut has_heading = false;
    let sampler = samples(
        session,
        every,
        seconds,
        terminal,
        &mut |terminal, session, sampler, sample| {
            if !has_heading {
                writeln!(file, "{}", sampler.heading(session))
                    .map_err(|error| unwritten(path, &error))?;
                has_heading = true;
            }
            terminal.document(&sampler.json(session, sample))?;
            writeln!(file, "{}", sampler.row(sample)).map_err(|error| unwritten(path, &error))
        },
    )?;
    file.flush().map_err(|error| unwritten(path, &error))?;
    let recorded = sampler.polls - sampler.lost;
    terminal.line(format!("{recorded} samples are in {}", path.display()))?;
    terminal.note(sampler.summary());
    Ok(())
}

fn unwritten(path: &Path, error: &io::Error) -> Failure {
    Failure::bus(
        "no-file",
        format!("cannot write {} ({error})", path.display()),
    )
}

/// Writes all frames on the bus; only listens.
pub(super) fn log(
    adapter: Box<dyn Adapter>,
    rate: Option<BitRate>,
    path: &Path,
    seconds: Option<f64>,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let mut link = Link::new(adapter);
    let rate = match rate {
        None if link.adapter().capabilities().needs_rate => {
            Some(connect::talking(&mut link)?.ok_or_else(|| {
                Failure::silent(
                    "no-answer",
                    "nobody talks, so the bit rate is unknown: give it with --rate",
                )
            })?)
        }
        rate => rate,
    };
    link.open(rate, Mode::Listen)?;
    let start = link.now();
    let epoch = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default()
        .as_micros() as u64;
    let is_output = path == Path::new("-");
    let mut file = match is_output {
        true => None,
        false => Some(BufWriter::new(
            File::create(path).map_err(|error| unwritten(path, &error))?,
        )),
    };
    let end = end(start, seconds)?;
    let mut count = 0_u64;
    while !(terminal.stopped)() {
        let until = after(link.now(), SLICE);
        let until = end.map_or(until, |end| until.min(end));
        if let Some((at, frame)) = link.receive(until)? {
            let text = line(epoch + at.ticks().saturating_sub(start.ticks()), &frame);
            count += 1;
            let written = match &mut file {
                Some(file) => writeln!(file, "{text}"),
                None => writeln!(terminal.out, "{text}"),
            };
            written.map_err(|error| unwritten(path, &error))?;
        }
        if end.is_some_and(|end| link.now() >= end) {
            break;
        }
    }
    link.adapter().close();
    if let Some(mut file) = file {
        file.flush().map_err(|error| unwritten(path, &error))?;
        terminal.line(format!("{count} frames are in {}", path.display()))?;
        terminal.document(&json!({"file": path.display().to_string(), "frames": count}))?;
    }
    Ok(())
}

/// A frame as `candump -L` writes it; `time` in us since 1970.
fn line(time: u64, frame: &Frame) -> String {
    format!(
        "({}.{:06}) {INTERFACE} {frame:?}",
        time / 1_000_000,
        time % 1_000_000
    )
}
