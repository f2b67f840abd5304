//! What an adapter says that this tool cannot read.

use crate::eds::shown;
use crate::error::{Error, Kind, Why};
use crate::note::Note;
use std::cell::RefCell;
use std::rc::Rc;

/// The lines of an adapter that the tool cannot read. All clones are the same count.
#[derive(Clone, Debug, Default)]
pub struct Unread(Rc<RefCell<(u64, Vec<u8>)>>);

impl Unread {
    /// Counts a line.
    pub fn take(&self, line: Vec<u8>) {
        let mut own = self.0.borrow_mut();
        own.0 += 1;
        if own.0 == 1 {
            own.1 = line;
        }
    }

    /// The number of lines.
    pub fn count(&self) -> u64 {
        self.0.borrow().0
    }

    /// The first line.
    pub fn first(&self) -> String {
        shown(&String::from_utf8_lossy(&self.0.borrow().1))
    }

    /// What the user must know; None: every line was read.
    pub fn told(&self) -> Option<Note> {
        let (count, first) = (self.count(), self.first());
        (count > 0).then_some(Note::Unread(count, first))
    }

    /// The failure of a sensor that does not answer: its answers can be among the lines.
    pub fn explain(&self, failure: Error) -> Error {
        match (self.told(), failure.kind()) {
            (Some(told), Kind::Silent) => failure.explained(|_| Why::Unread(told)),
            _ => failure,
        }
    }
}
