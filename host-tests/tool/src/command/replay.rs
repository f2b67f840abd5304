//! `replay`: the frames of a log, with their spacing.

use super::log::View;
use super::sender::Sender;
use crate::cli::Options;
use crate::cli::frames::{self, Shown};
use crate::counted::Lines;
use crate::decode::log::each;
use crate::error::Error;
use crate::note::Note;
use crate::ops::replay::{Recording, Replay, Round};
use crate::output::Terminal;

/// Reads the frames that are sent.
///
/// # Errors
/// The file cannot be read, has no such frame, or has frames of several buses.
pub(super) fn read(
    options: &Options,
    replay: &frames::Replay,
    terminal: &mut Terminal,
) -> Result<Round, Error> {
    let shown = Shown {
        which: replay.which.clone(),
        by_id: false,
    };
    let mut view = View::new(options, &shown, false)?;
    view.learn(&replay.file, terminal)?;
    let mut recording = Recording::default();
    let others = each(&replay.file, terminal, &mut |_, line| {
        let wanted = replay.interface.as_ref();
        let is_wanted = wanted.is_none_or(|name| *name == line.interface);
        if is_wanted && view.take(&line.frame).is_some() {
            recording.take(line);
        }
        Ok(())
    })?;
    if others > 0 {
        terminal.note(&Note::OtherLines(Lines(others)));
    }
    recording.finish(replay.file.display().to_string())
}

/// Sends the frames, once or again and again, until the user or the time ends it.
///
/// # Errors
/// The adapter fails, or the output is closed.
pub(super) fn replay(
    mut sender: Sender,
    replay: &frames::Replay,
    round: Round,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let path = replay.file.display().to_string();
    let (count, time) = (round.count(), round.length() as f64 / replay.speed / 1e6);
    terminal.note(&match replay.repeats {
        true => Note::ReplaysAgain(count.into(), path, time),
        false => Note::Replays(count.into(), path, time),
    });
    let mut frames = Replay::new(round, replay.speed, replay.repeats, sender.now());
    let result = sender.send_all(&mut frames);
    sender.finish(result, terminal)
}
