//! The virtual sensor of a demonstration, which the user moves and breaks, also while an action runs.

use super::Worker;
use crate::demo::StandIn;
use crate::error::{Error, PageError};
use crate::serve::events::{Hub, Kind};
use crate::serve::job::{Job, Task};
use crate::serve::lease::Moves;
use serde_json::{Value, json};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::time::Duration;
use virtual_sensor::server::Request;

/// The jobs. Those of the virtual sensor do not wait for an action that runs.
pub(super) struct Jobs {
    receiver: Receiver<Job>,
    /// They came during an action.
    waiting: VecDeque<Job>,
}

impl Jobs {
    pub(super) fn new(receiver: Receiver<Job>) -> Self {
        Self {
            receiver,
            waiting: VecDeque::new(),
        }
    }

    /// The next job, without a wait.
    ///
    /// # Errors
    /// There is none, or nobody can send one.
    pub(super) fn try_next(&mut self) -> Result<Job, TryRecvError> {
        let waiting = self.waiting.pop_front();
        waiting.map_or_else(|| self.receiver.try_recv(), Ok)
    }

    /// The next job within this time.
    ///
    /// # Errors
    /// There is none, or nobody can send one.
    pub(super) fn next(&mut self, time: Duration) -> Result<Job, RecvTimeoutError> {
        let waiting = self.waiting.pop_front();
        waiting.map_or_else(|| self.receiver.recv_timeout(time), Ok)
    }

    /// The next job of the virtual sensor. The others wait.
    fn next_move(&mut self) -> Option<Job> {
        let is_move = |job: &Job| matches!(job.task, Task::StandIn(_));
        self.waiting.extend(self.receiver.try_iter());
        let place = self.waiting.iter().position(is_move)?;
        self.waiting.remove(place)
    }
}

impl Worker {
    /// Does the jobs of the virtual sensor while somebody waits for a frame.
    pub(super) fn moves(&self) -> Moves {
        let (jobs, hub): (Rc<RefCell<Jobs>>, Arc<Hub>) = (self.jobs.clone(), self.hub.clone());
        Box::new(move |own| {
            loop {
                let job = jobs.borrow_mut().next_move();
                let Some(Job {
                    task: Task::StandIn(request),
                    reply,
                }) = job
                else {
                    return;
                };
                let done = own.perform(request).map(|()| json!({}));
                hub.publish(Kind::StandIn, &own.state());
                let _ = reply.send(done);
            }
        })
    }

    /// Moves or breaks the virtual sensor.
    pub(super) fn stand_in(&mut self, request: Request) -> Result<Value, Error> {
        let port = self.port.as_ref();
        let done = port.and_then(|(_, lease)| lease.with_stand_in(|own| own.perform(request)));
        done.ok_or(PageError::NoStandIn)??;
        self.show_stand_in();
        Ok(json!({}))
    }

    /// Shows the virtual sensor; or that there is none.
    pub(super) fn show_stand_in(&self) {
        let port = self.port.as_ref();
        let state = port.and_then(|(_, lease)| lease.with_stand_in(|own| StandIn::state(own)));
        self.hub.publish(Kind::StandIn, &json!(state));
    }
}
