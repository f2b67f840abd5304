//! What was heard before a question: after the yes, the same command goes on there.

use super::listen::{self, Traffic};
use super::schedule::Schedule;
use crate::error::Error;
use crate::link::Link;
use crate::output::Terminal;
use std::cell::RefCell;
use std::rc::Rc;

/// What was heard; empty at first.
#[derive(Clone, Debug, Default)]
pub struct Memory(Rc<RefCell<Option<Option<Traffic>>>>);

impl Memory {
    /// Listens at all rates of a schedule. Traffic that was heard before counts; after silence one short look at each rate shows whether
    /// a machine was switched on meanwhile.
    ///
    /// # Errors
    /// The errors of [`listen::all`].
    pub fn listen(
        &self,
        link: &mut Link,
        schedule: &Schedule,
        terminal: &mut Terminal,
    ) -> Result<Option<Traffic>, Error> {
        let kept = self.0.borrow().clone();
        let heard = match kept {
            Some(Some(traffic)) => return Ok(Some(traffic)),
            Some(None) => listen::all(link, &schedule.again(), terminal)?,
            None => listen::all(link, schedule, terminal)?,
        };
        *self.0.borrow_mut() = Some(heard.clone());
        Ok(heard)
    }
}
