//! `send`: frames of the command line or of a list, once or periodically.

use super::sender::Sender;
use crate::cli::frames::{Sending, Sent};
use crate::counted::Frames;
use crate::error::{Error, Fault, FileError};
use crate::note::Note;
use crate::ops::transmit::{self, Item, List};
use crate::output::Terminal;
use bench::file::{LONGEST_TEXT, Unread, decoded, read};
use std::path::Path;

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
    let items = transmit::items(&decoded(&bytes).text);
    Ok(items.map_err(|error| wrong(error.into()))?)
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
    let mut list = List::default();
    for item in items {
        let frame = format!("{:?}", item.frame);
        terminal.note(&match item.every {
            Some(every) => Note::SendsEvery(frame, every),
            None => Note::SendsOnce(frame),
        });
        list.add(item);
    }
    list.start(sender.now());
    let result = sender.send_all(&mut list);
    let left_out = list.lines().iter().map(|line| line.left_out).sum();
    if left_out > 0 {
        terminal.note(&Note::NotSentInTime(Frames(left_out)));
    }
    sender.finish(result, terminal)
}
