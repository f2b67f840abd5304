//! `replay`: the frames of a log, with their spacing.

use super::log::{View, each};
use super::sender::Sender;
use crate::cli::Options;
use crate::cli::frames::{Replay, Shown};
use crate::error::{Error, RequestError};
use crate::note::Note;
use crate::output::Terminal;
use plumbline::can::Frame;
use plumbline::time::{Duration, Instant, after};
use std::collections::BTreeSet;

/// The time between the last frame and the next first one of a log with one frame, in us.
const ALONE: u64 = 100_000;

/// The shortest one of other logs, in us.
const SHORTEST: u64 = 1000;

/// The frames, with their times after the first one in us.
pub(super) struct Round(Vec<(u64, Frame)>);

impl Round {
    fn length(&self) -> u64 {
        self.0.last().map_or(0, |(at, _)| *at)
    }

    /// The time from the first frame to the next first one: one mean gap longer than the frames.
    fn period(&self) -> u64 {
        let gaps = self.0.len() as u64 - 1;
        let gap = self.length().checked_div(gaps);
        self.length() + gap.map_or(ALONE, |gap| gap.max(SHORTEST))
    }
}

/// Reads the frames that are sent.
///
/// # Errors
/// The file cannot be read, has no such frame, or has frames of several buses.
pub(super) fn read(
    options: &Options,
    replay: &Replay,
    terminal: &mut Terminal,
) -> Result<Round, Error> {
    let shown = Shown {
        which: replay.which.clone(),
        by_id: false,
    };
    let mut view = View::new(options, &shown, false)?;
    view.learn(&replay.file, terminal)?;
    let (mut frames, mut interfaces) = (Vec::new(), BTreeSet::new());
    let (mut first, mut newest) = (None, 0);
    let others = each(&replay.file, terminal, &mut |_, line| {
        let wanted = replay.interface.as_ref();
        let is_wanted = wanted.is_none_or(|name| *name == line.interface);
        if is_wanted && view.take(&line.frame).is_some() {
            let micros = line.micros();
            // The time of a log can go back: then the frame follows at once.
            newest = micros
                .saturating_sub(*first.get_or_insert(micros))
                .max(newest);
            frames.push((newest, line.frame));
            interfaces.insert(line.interface);
        }
        Ok(())
    })?;
    if others > 0 {
        terminal.note(&Note::OtherLines(others));
    }
    let path = replay.file.display().to_string();
    if frames.is_empty() {
        return Err(RequestError::NoFrame(path).into());
    }
    if interfaces.len() > 1 {
        let names = interfaces.into_iter().collect::<Vec<_>>().join(", ");
        return Err(RequestError::Interfaces(path, names).into());
    }
    Ok(Round(frames))
}

/// Sends the frames, once or again and again, until the user or the time ends it.
///
/// # Errors
/// The adapter fails, or the output is closed.
pub(super) fn replay(
    mut sender: Sender,
    replay: &Replay,
    round: &Round,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let path = replay.file.display().to_string();
    let (count, time) = (round.0.len(), round.length() as f64 / replay.speed / 1e6);
    terminal.note(&match replay.repeats {
        true => Note::ReplaysAgain(count, path, time),
        false => Note::Replays(count, path, time),
    });
    let result = send_all(&mut sender, replay, round);
    sender.finish(result, terminal)
}

fn send_all(sender: &mut Sender, replay: &Replay, round: &Round) -> Result<(), Error> {
    let later = |start: Instant, micros: u64| {
        let ticks = (micros as f64 / replay.speed).round() as u64;
        after(start, Duration::from_ticks(ticks))
    };
    let mut start = sender.now();
    loop {
        for (at, frame) in &round.0 {
            if !sender.send(later(start, *at), frame)? {
                return Ok(());
            }
        }
        if !replay.repeats {
            return Ok(());
        }
        start = later(start, round.period());
    }
}
