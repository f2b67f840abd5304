//! What an adapter says that this tool cannot read.

use std::cell::RefCell;
use std::rc::Rc;
use texts::shown;

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
}
