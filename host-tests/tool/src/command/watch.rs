//! `watch`, and the samples of `record`.

use crate::cyclic::Cyclic;
use crate::error::{Error, FileError, RequestError, Silence};
use crate::note::Note;
use crate::ops::set;
use crate::output::Terminal;
use crate::resolve;
use crate::sample::{Sample, Sampler};
use crate::session::Session;
use plumbline::param::DataType;
use plumbline::time::{Duration, after, millis};
use std::io;
use std::path::Path;

/// The time without an answer after which the user is told.
const SILENT: Duration = millis(1000);

/// The time of `--seconds`.
///
/// # Errors
/// It is out of range.
pub(super) fn checked(seconds: Option<f64>) -> Result<Option<Duration>, Error> {
    match seconds {
        None => Ok(None),
        Some(seconds) if (0.0..=1e9).contains(&seconds) => {
            let ticks = (seconds * 1e6) as u64;
            Ok(Some(Duration::from_ticks(ticks)))
        }
        Some(_) => Err(RequestError::Seconds.into()),
    }
}

/// When the samples come, and how many.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// The period of the samples in ms.
    every: u32,
    /// The sensor sends them by itself.
    is_cyclic: bool,
    /// The time after which it ends.
    seconds: Option<Duration>,
}

impl Pace {
    /// The options of `watch` and `record`.
    ///
    /// # Errors
    /// The time is out of range.
    pub(super) fn checked(
        every: u32,
        is_cyclic: bool,
        seconds: Option<f64>,
    ) -> Result<Self, Error> {
        Ok(Self {
            every,
            is_cyclic,
            seconds: checked(seconds)?,
        })
    }
}

/// A sampler of the values with these names; without names, of the angles.
///
/// # Errors
/// A name is wrong, or a request of the session fails.
pub(super) fn sampler(session: &mut Session, names: &[String]) -> Result<Sampler, Error> {
    if names.is_empty() {
        return Sampler::new(session);
    }
    let mut entries = Vec::new();
    for name in names {
        entries.extend(resolve::entries(&session.sheet, name)?.into_iter().cloned());
    }
    set::once_each(entries.iter())?;
    if let Some(entry) = entries
        .iter()
        .find(|entry| !entry.readable || entry.data_type == DataType::Text)
    {
        return Err(RequestError::NotReadable(entry.name.clone()).into());
    }
    Sampler::of(session, entries)
}

/// A function that takes each sample.
type Take<'a> = &'a mut dyn FnMut(&mut Terminal, &Session, &Sampler, &Sample) -> Result<(), Error>;

/// Hands each sample to `take`, until the time is over or Ctrl-C.
pub(super) fn samples(
    session: &mut Session,
    mut sampler: Sampler,
    pace: Pace,
    terminal: &mut Terminal,
    take: Take,
) -> Result<Sampler, Error> {
    match pace.is_cyclic {
        false => polled(session, &mut sampler, pace, terminal, take)?,
        true => {
            let mut cyclic = Cyclic::start(session, &mut sampler, pace.every, terminal)?;
            let sent = sent(session, &mut sampler, &mut cyclic, pace, terminal, take);
            let put_back = cyclic.stop(session);
            sent?;
            put_back?;
        }
    }
    if sampler.printed == 0 && sampler.lost > 0 {
        return Err(Silence::AnyRequest.into());
    }
    Ok(sampler)
}

fn polled(
    session: &mut Session,
    sampler: &mut Sampler,
    pace: Pace,
    terminal: &mut Terminal,
    take: Take,
) -> Result<(), Error> {
    let every = millis(pace.every);
    let end = pace.seconds.map(|seconds| sampler.end_after(seconds));
    let mut is_told = false;
    loop {
        match sampler.poll(session, every) {
            Ok(Some(sample)) => {
                if std::mem::take(&mut is_told) {
                    terminal.note(&Note::Answers);
                }
                take(terminal, session, sampler, &sample)?;
            }
            Ok(None) if !is_told && sampler.silence(session.link.now()) >= SILENT => {
                is_told = true;
                let unread = session.link.adapter().unread();
                let told = unread.and_then(|unread| Note::unread(&unread));
                let cause = told.unwrap_or(Note::CheckWiring);
                terminal.note(&Note::Silent(Box::new(cause)));
            }
            Ok(None) => {}
            Err(failure) if failure.is_stopped() => break,
            Err(failure) => return Err(failure),
        }
        let is_over = |session: &Session| end.is_some_and(|end| session.link.now() >= end);
        if is_over(session)
            || !sampler.wait(session, every, &*terminal.stopped)?
            || is_over(session)
        {
            break;
        }
    }
    let now = session.link.now();
    sampler.end(end.map_or(now, |end| end.min(now)), every);
    Ok(())
}

/// Takes the angles that the sensor sends.
fn sent(
    session: &mut Session,
    sampler: &mut Sampler,
    cyclic: &mut Cyclic,
    pace: Pace,
    terminal: &mut Terminal,
    take: Take,
) -> Result<(), Error> {
    let end = pace
        .seconds
        .map(|seconds| after(session.link.now(), seconds));
    while !(terminal.stopped)() {
        let now = session.link.now();
        let until = end.unwrap_or_else(|| after(now, millis(1000)));
        if now >= until {
            break;
        }
        if let Some(sample) = cyclic.next(session, sampler, until)? {
            take(terminal, session, sampler, &sample)?;
        }
    }
    cyclic.end(sampler, session.link.now());
    Ok(())
}

/// Shows the angles, one line for each sample.
pub(super) fn watch(
    session: &mut Session,
    sampler: Sampler,
    pace: Pace,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let sampler = samples(
        session,
        sampler,
        pace,
        terminal,
        &mut |terminal, session, sampler, sample| {
            terminal.line(sampler.line(session, sample))?;
            terminal.document(&sampler.json(session, sample))
        },
    )?;
    summarize(session, &sampler, terminal)
}

/// Says what the user must know of the samples.
///
/// # Errors
/// The sensor does not answer any more.
pub(super) fn summarize(
    session: &Session,
    sampler: &Sampler,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    for note in sampler.summary() {
        terminal.note(&note);
    }
    let silence = sampler.silence(session.link.now());
    if silence < SILENT {
        return Ok(());
    }
    Err(Silence::Seconds(silence.to_secs()).into())
}

pub(super) fn unwritten(path: &Path, error: &io::Error) -> Error {
    match error.kind() {
        io::ErrorKind::BrokenPipe => FileError::Closed(error.to_string()).into(),
        _ => FileError::OutputUnwritten(path.display().to_string(), error.to_string()).into(),
    }
}
