//! `send`: frames of the command line or of a list, once or periodically.

use super::sender::Sender;
use crate::cli::frames::{self, Sending, Sent};
use crate::error::{Error, Fault, FileError};
use crate::note::Note;
use crate::output::Terminal;
use bench::file::{LONGEST_TEXT, Unread, decoded, read};
use plumbline::can::Frame;
use plumbline::time::{Duration, after, millis};
use serde::{Deserialize, Deserializer};
use std::path::Path;

/// A frame, and the time between two of them in ms; None: it is sent once.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Item {
    #[serde(deserialize_with = "frame")]
    frame: Frame,
    #[serde(default, deserialize_with = "every")]
    every: Option<u32>,
}

/// The longest period in ms.
const LONGEST: u32 = 3_600_000;

/// A list of frames.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    send: Vec<Item>,
}

fn frame<'de, D: Deserializer<'de>>(from: D) -> Result<Frame, D::Error> {
    let text = String::deserialize(from)?;
    frames::frame(&text).map_err(serde::de::Error::custom)
}

fn every<'de, D: Deserializer<'de>>(from: D) -> Result<Option<u32>, D::Error> {
    let every = u32::deserialize(from)?;
    match (1..=LONGEST).contains(&every) {
        true => Ok(Some(every)),
        false => Err(serde::de::Error::custom(format!(
            "every is 1 to {LONGEST} ms"
        ))),
    }
}

/// The frames of the command line and of its lists, in their order.
///
/// # Errors
/// A list cannot be read, or is not valid.
pub(super) fn items(sending: &Sending) -> Result<Vec<Item>, Error> {
    let mut items = Vec::new();
    for sent in &sending.what {
        match sent {
            Sent::Frame(frame) => items.push(Item {
                frame: *frame,
                every: sending.every,
            }),
            Sent::List(path) => items.extend(list(path)?),
        }
    }
    Ok(items)
}

fn list(path: &Path) -> Result<Vec<Item>, Error> {
    let name = || path.display().to_string();
    let wrong = |why: Fault| FileError::List(name(), why);
    let bytes = read(path, LONGEST_TEXT).map_err(|unread| match unread {
        Unread::Failed(error) => FileError::ListUnread(name(), error.to_string()),
        Unread::Unfit(why) => wrong(why.into()),
    })?;
    let list: Result<List, _> = toml::from_str(&decoded(&bytes).text);
    let list = list.map_err(|error| wrong(error.message().to_owned().into()))?;
    Ok(list.send)
}

/// Sends each frame once or with its period, until the user or the time ends it.
///
/// # Errors
/// The adapter fails, or the output is closed.
pub(super) fn send(
    mut sender: Sender,
    items: Vec<Item>,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    for Item { frame, every } in &items {
        let frame = format!("{frame:?}");
        terminal.note(&match every {
            Some(every) => Note::SendsEvery(frame, *every),
            None => Note::SendsOnce(frame),
        });
    }
    let mut left_out = 0;
    let result = send_all(&mut sender, items, &mut left_out);
    if left_out > 0 {
        terminal.note(&Note::NotSentInTime(left_out));
    }
    sender.finish(result, terminal)
}

fn send_all(sender: &mut Sender, items: Vec<Item>, left_out: &mut u64) -> Result<(), Error> {
    let start = sender.now();
    let mut next: Vec<_> = items.into_iter().map(|item| (start, item)).collect();
    // Of frames with the same time the first one of the list is sent first.
    while let Some(place) = (0..next.len()).min_by_key(|place| next[*place].0) {
        let (at, item) = next[place];
        if !sender.send(at, &item.frame)? {
            break;
        }
        let Some(every) = item.every.map(millis) else {
            next.remove(place);
            continue;
        };
        // A frame that is too late is left out: a burst of late frames would have another period.
        let late = sender.now().ticks().saturating_sub(at.ticks()) / every.ticks();
        *left_out += late;
        next[place].0 = after(at, Duration::from_ticks(every.ticks() * (late + 1)));
    }
    Ok(())
}
