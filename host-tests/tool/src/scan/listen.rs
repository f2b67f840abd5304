//! The first part of a scan, and of every other command that does not know where the sensor is: listens and sends nothing.

use super::passive;
use super::schedule::{self, Lone, Schedule};
use crate::counted::Errors;
use crate::error::{Error, RequestError};
use crate::link::{Link, stopped};
use crate::note::{Note, Step};
use crate::output::{Progress, Terminal};
use crate::question::{Question, Rate};
use adapter::Mode;
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant, after, millis};

/// How long a bus with traffic is listened to: heartbeats and cyclic values come once a second.
pub const LONG: Duration = millis(1100);

/// The maximum number of frames that are kept: a message that nobody acknowledges is repeated all the time.
const FRAMES: usize = 20_000;

/// Frames with the times of their reception.
pub type Frames = [(Instant, Frame)];

/// What was heard at a rate.
#[derive(Clone, Debug)]
pub struct Traffic {
    /// The rate; None: the rate of the interface.
    pub rate: Option<BitRate>,
    /// The frames in their order.
    pub frames: Vec<(Instant, Frame)>,
}

/// Listens at all rates of a schedule; None: there is no traffic at any of them. A scan reports each rate also without a progress bar.
///
/// # Errors
/// The adapter has no listen-only mode, refuses all rates, or has failed.
pub fn all(
    link: &mut Link,
    schedule: &Schedule,
    terminal: &mut Terminal,
) -> Result<Option<Traffic>, Error> {
    let total = schedule.steps.len();
    // An adapter does not have every rate.
    let mut refused: Vec<(Option<BitRate>, Error)> = Vec::new();
    if schedule.is_shown {
        terminal.note(&Step::Switch);
    }
    // The rate at which the adapter is open.
    let mut open: Option<Option<BitRate>> = None;
    let mut heard = None;
    for (done, step) in (1..).zip(&schedule.steps) {
        if (terminal.stopped)() {
            if open.is_some() {
                link.close();
            }
            return Err(stopped());
        }
        if refused.iter().any(|(rate, _)| *rate == step.rate) {
            continue;
        }
        let start = link.now();
        // The adapter stays open for the next step at the same rate: it receives all frames that come between the steps.
        if open != Some(step.rate) {
            if open.take().is_some() {
                link.close();
            }
            match quiet(link, step.rate, terminal) {
                Err(failure) if failure.is_rate_refused() => {
                    terminal.note(&failure);
                    refused.push((step.rate, failure));
                    continue;
                }
                opened => opened?,
            }
            open = Some(step.rate);
        }
        let opened = link.now();
        let until = step.until(start, opened);
        let frames = hear(link, until, End::Traffic)?;
        let is_shown = schedule.is_shown && (step.is_line || !frames.is_empty());
        // Some adapters have to be asked, which takes a part of a short step.
        let counts = link.adapter().capabilities().reports_errors
            || (is_shown && (step.is_long() || !frames.is_empty()));
        let errors = counts.then(|| link.adapter().errors()).flatten();
        let dwell = Duration::from_ticks(until.ticks().saturating_sub(opened.ticks())).to_millis();
        let mut told = Step::Listened(link.rate().into(), dwell, frames.len().into());
        if let Some(errors) = errors {
            told = Step::Counted(Box::new(told), Errors(errors));
        }
        let line = is_shown.then(|| Step::Numbered(done, total, Box::new(told.clone())));
        let step = match schedule.is_shown && frames.is_empty() {
            true => &Step::Waits(Box::new(told)),
            false => &told,
        };
        terminal.progress(Progress { done, total, step }, line.as_ref());
        if !frames.is_empty() {
            let rate = link.rate();
            let mut own = Traffic { rate, frames };
            wait_for_sensor(link, &mut own, schedule, terminal)?;
            heard = Some(own);
            break;
        }
    }
    if open.is_some() {
        link.close();
    }
    terminal.hide();
    let is_refused = |step: &schedule::Step| refused.iter().any(|(rate, _)| *rate == step.rate);
    match schedule.steps.iter().all(is_refused) {
        true => Err(all_refused(refused)),
        false => Ok(heard),
    }
}

/// Listens to a bus whose traffic shows no sensor for sure, until one is switched on and tells its address. The frames are then those
/// of its message: older ones of the same sensor would not fit them.
fn wait_for_sensor(
    link: &mut Link,
    heard: &mut Traffic,
    schedule: &Schedule,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let is_sure = |frames: &Frames| {
        let mut sightings = passive::sightings(frames).into_iter();
        sightings.any(|sighting| sighting.is_sure)
    };
    // A node with a likely address is asked after a yes.
    let sightings = passive::sightings(&heard.frames);
    if sightings
        .iter()
        .any(|own| own.is_sure || own.target.is_some())
    {
        return Ok(());
    }
    let mut before = Vec::new();
    for done in 1..=schedule.more {
        if (terminal.stopped)() {
            link.close();
            return Err(stopped());
        }
        let latest = collect(link, LONG)?;
        let told = Step::Listened(link.rate().into(), LONG.to_millis(), latest.len().into());
        let step = Step::Waits(Box::new(told));
        let progress = Progress {
            done,
            total: schedule.more,
            step: &step,
        };
        let line = Step::Numbered(done, schedule.more, Box::new(step.clone()));
        terminal.progress(progress, schedule.is_shown.then_some(&line));
        // A message can begin in one of the steps and end in the next one.
        let both = [before, latest.clone()].concat();
        for frames in [&latest, &both] {
            if is_sure(frames) {
                heard.frames.clone_from(frames);
                return Ok(());
            }
        }
        before = latest;
    }
    Ok(())
}

/// The adapter refuses all bit rates at which the tool must listen.
fn all_refused(mut refused: Vec<(Option<BitRate>, Error)>) -> Error {
    match (refused.pop(), refused.is_empty()) {
        (Some((_, only)), true) => only,
        _ => RequestError::AllRefused.into(),
    }
}

/// When the tool stops to listen.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum End {
    /// At the end of the time, with or without frames.
    Time,
    /// [`LONG`] after the first frame: long enough for every node that sends once a second. A node that is alone on the bus is
    /// recognised earlier.
    Traffic,
}

/// The frames until then. The first one counts also if it is late: the computer can have been busy with something else.
fn hear(link: &mut Link, mut until: Instant, end: End) -> Result<Vec<(Instant, Frame)>, Error> {
    let (mut frames, mut lone) = (Vec::new(), Lone::default());
    let mut is_last_look = false;
    loop {
        let Some((at, frame)) = link.receive(until)? else {
            // A frame can have arrived while the program did not read.
            if !frames.is_empty() || is_last_look {
                break;
            }
            is_last_look = true;
            continue;
        };
        // A late frame ends it: a sensor that nobody acknowledges sends all the time.
        if at >= until && !frames.is_empty() {
            break;
        }
        if frames.is_empty() && end == End::Traffic {
            until = after(at, LONG);
        }
        if frames.len() < FRAMES {
            frames.push((at, frame));
        }
        if end == End::Traffic && lone.take(at, &frame, link.rate()) {
            break;
        }
    }
    Ok(frames)
}

/// Opens the adapter to listen at the rate that the user has said. An adapter without listen-only mode takes part in the bus only after a
/// yes, which is asked for once.
///
/// # Errors
/// The question was answered with no, or the adapter fails.
pub fn open(link: &mut Link, rate: Option<BitRate>, terminal: &mut Terminal) -> Result<(), Error> {
    match quiet(link, rate, terminal) {
        Err(failure) if failure.lacks_listen_only() => {
            if !link.takes_part() {
                confirmed(rate, terminal)?;
                link.take_part();
            }
            link.open(rate, Mode::Active)
        }
        opened => opened,
    }
}

/// Asks whether an adapter without listen-only mode may take part in the bus.
fn confirmed(rate: Option<BitRate>, terminal: &mut Terminal) -> Result<(), Error> {
    let rate = rate.map_or(Rate::Interface, |rate| Rate::Named(rate.name().to_owned()));
    if terminal.ask(&Question::TakePart { rate })? {
        terminal.note(&Note::AdapterTakesPart);
        return Ok(());
    }
    Err(RequestError::MayNotTakePart.into())
}

/// Opens the adapter in listen-only mode. This program does not change the mode of an interface: if it takes part in the bus, its frames
/// are read, and a note says so once.
fn quiet(link: &mut Link, rate: Option<BitRate>, terminal: &mut Terminal) -> Result<(), Error> {
    let sets_rate = link.adapter().capabilities().sets_rate;
    match link.open(rate, Mode::Listen) {
        Err(failure) if failure.lacks_listen_only() && !sets_rate => {
            link.open(rate, Mode::Active)?;
            if link.take_part() {
                terminal.note(&Note::InterfaceTakesPart(failure));
            }
            Ok(())
        }
        opened => opened,
    }
}

/// Listens at one rate, long enough for nodes that send once a second; None: there is no traffic.
///
/// # Errors
/// The errors of [`open()`].
pub fn once(
    link: &mut Link,
    rate: Option<BitRate>,
    terminal: &mut Terminal,
) -> Result<Option<Traffic>, Error> {
    open(link, rate, terminal)?;
    let (rate, frames) = (link.rate(), collect(link, LONG)?);
    link.close();
    Ok((!frames.is_empty()).then_some(Traffic { rate, frames }))
}

/// The frames of this time.
///
/// # Errors
/// The adapter fails.
pub fn collect(link: &mut Link, time: Duration) -> Result<Vec<(Instant, Frame)>, Error> {
    let until = after(link.now(), time);
    hear(link, until, End::Time)
}

#[cfg(test)]
mod tests;
