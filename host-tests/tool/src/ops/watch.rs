//! The samples of a sensor: polled, or as it sends them.

use super::set;
use crate::cyclic::Cyclic;
use crate::error::{Error, RequestError, Silence};
use crate::note::Note;
use crate::output::Terminal;
use crate::resolve;
use crate::sample::{Sample, Sampler};
use crate::session::Session;
use plumbline::param::DataType;
use plumbline::time::{Duration, after, millis};
use serde::Serialize;

/// The time without an answer after which the user is told.
const SILENT: Duration = millis(1000);

/// Which samples, and how many.
#[derive(Clone, Debug)]
pub struct Request {
    /// The names of the values; none: the angles.
    pub names: Vec<String>,
    /// The period of the samples in ms.
    pub every: u32,
    /// The sensor sends them by itself.
    pub is_cyclic: bool,
    /// The time after which it ends.
    pub time: Option<Duration>,
}

/// What became of the samples.
#[derive(Clone, Debug, Serialize)]
pub struct Watched {
    /// The samples.
    pub samples: u64,
    /// Those that are missing.
    pub lost: u64,
    /// What the user must know of them.
    #[serde(skip)]
    pub notes: Vec<Note>,
    /// The time since the last answer.
    #[serde(skip)]
    silence: Duration,
}

impl Watched {
    /// Refuses samples of a sensor that does not answer any more.
    ///
    /// # Errors
    /// That.
    pub fn check(&self) -> Result<(), Error> {
        match self.silence < SILENT {
            true => Ok(()),
            false => Err(Silence::Seconds(self.silence.to_secs()).into()),
        }
    }
}

/// A sampler of the values with these names; without names, of the angles.
///
/// # Errors
/// A name is wrong, or a request of the session fails.
fn sampler(session: &mut Session, names: &[String]) -> Result<Sampler, Error> {
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
pub type Take<'a> =
    &'a mut dyn FnMut(&mut Terminal, &Session, &Sampler, &Sample) -> Result<(), Error>;

/// Hands each sample to `take`, until the time is over or Ctrl-C.
///
/// # Errors
/// A name is wrong, nobody has answered, the sensor refuses, or the adapter or `take` fails.
pub fn watch(
    session: &mut Session,
    wanted: &Request,
    terminal: &mut Terminal,
    take: Take,
) -> Result<Watched, Error> {
    let mut sampler = sampler(session, &wanted.names)?;
    match wanted.is_cyclic {
        false => polled(session, &mut sampler, wanted, terminal, take)?,
        true => {
            let mut cyclic = Cyclic::start(session, &mut sampler, wanted.every, terminal)?;
            let sent = sent(session, &mut sampler, &mut cyclic, wanted, terminal, take);
            let put_back = cyclic.stop(session);
            sent?;
            put_back?;
        }
    }
    if sampler.printed == 0 && sampler.lost > 0 {
        return Err(Silence::AnyRequest.into());
    }
    Ok(Watched {
        samples: sampler.printed,
        lost: sampler.lost,
        notes: sampler.summary(),
        silence: sampler.silence(session.link.now()),
    })
}

fn polled(
    session: &mut Session,
    sampler: &mut Sampler,
    wanted: &Request,
    terminal: &mut Terminal,
    take: Take,
) -> Result<(), Error> {
    let every = millis(wanted.every);
    let end = wanted.time.map(|seconds| sampler.end_after(seconds));
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
    wanted: &Request,
    terminal: &mut Terminal,
    take: Take,
) -> Result<(), Error> {
    let end = wanted
        .time
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
