//! Server-sent events to the tabs: one stream for each tab, at most five.
//!
//! ```text
//! event: samples
//! data: {"first":0,"rows":[[0.0,1.25,-0.5]]}
//! ```
//!
//! A tab gets the newest event of each kind first, except samples, and the log. The stream of a tab that does not read ends: the tab
//! opens another one and knows the present state again. The numbers of the samples show what is missing.

use crate::error::Error;
use serde_json::Value;
use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::mpsc::{Receiver, Sender, channel};

/// The maximum number of tabs.
pub const TABS: usize = 5;

/// The maximum number of events that wait for a tab: 12 s of samples.
const WAITING: usize = 256;

/// The maximum number of actions that are kept for new tabs.
const ACTIONS: usize = 100;

/// An event as bytes of the stream.
pub type Event = Arc<str>;

/// The kinds of events that a tab can receive.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Kind {
    /// The connection: port, rate, mode, frames per second, errors.
    Status,
    /// The sensor of the session, or null.
    Device,
    /// The values of all parameters, or null.
    Values,
    /// Rows of samples, which follow each other.
    Samples,
    /// The other sensors in the chart.
    Others,
    /// Rows of samples of one of them.
    OtherSamples,
    /// The names of the active bits of the status.
    Condition,
    /// The newest frame of each identifier.
    Frames,
    /// What the last scan has found.
    Found,
    /// The data sheets that the user has opened.
    Sheets,
    /// The calibration of a unit.
    Calibration,
    /// An action, at its start and at its end.
    Action,
    /// A line of text of a running action.
    Note,
    /// The progress of a running action.
    Progress,
}

impl Kind {
    /// The name in the stream.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Status => "status",
            Self::Device => "device",
            Self::Values => "values",
            Self::Samples => "samples",
            Self::Others => "others",
            Self::OtherSamples => "other-samples",
            Self::Condition => "condition",
            Self::Frames => "frames",
            Self::Found => "found",
            Self::Sheets => "sheets",
            Self::Calibration => "calibration",
            Self::Action => "action",
            Self::Note => "note",
            Self::Progress => "progress",
        }
    }
}

/// The tabs, and what a new tab must know.
#[derive(Default)]
pub struct Hub {
    inner: Mutex<Inner>,
    /// The last number of an action or a question.
    numbers: AtomicU64,
}

#[derive(Default)]
struct Inner {
    tabs: Vec<Sender<Event>>,
    newest: BTreeMap<Kind, Event>,
    actions: VecDeque<(u64, Event)>,
}

impl Hub {
    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The events for a new tab.
    ///
    /// # Errors
    /// There are five tabs already.
    pub fn subscribe(&self) -> Result<Receiver<Event>, Error> {
        let mut inner = self.inner();
        inner.tabs.retain(|tab| !tab.is_closed());
        if inner.tabs.len() >= TABS {
            let message = format!(
                "{TABS} tabs are already open: close one of them, then this page connects automatically"
            );
            return Err(Error::bus("too-many-tabs", message));
        }
        let (tab, events) = channel(WAITING);
        let actions = inner.actions.iter().map(|(_, event)| event);
        for event in inner.newest.values().chain(actions) {
            let _ = tab.try_send(event.clone());
        }
        inner.tabs.push(tab);
        Ok(events)
    }

    /// The number of a new action or question, from 1.
    pub fn number(&self) -> u64 {
        self.numbers.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// Whether a tab is open.
    pub fn is_watched(&self) -> bool {
        self.inner().tabs.iter().any(|tab| !tab.is_closed())
    }

    /// Sends an event to all tabs.
    pub fn publish(&self, kind: Kind, data: &Value) {
        let event: Event = format!("event: {}\ndata: {data}\n\n", kind.name()).into();
        let mut inner = self.inner();
        match kind {
            Kind::Samples | Kind::OtherSamples | Kind::Note | Kind::Progress => {}
            Kind::Action => inner.keep(data["n"].as_u64().unwrap_or(0), event.clone()),
            _ => {
                inner.newest.insert(kind, event.clone());
            }
        }
        // A tab that is full does not read. Without this event it would show an old state.
        inner.tabs.retain(|tab| tab.try_send(event.clone()).is_ok());
    }
}

impl Inner {
    /// Keeps an action; its end replaces its start.
    fn keep(&mut self, number: u64, event: Event) {
        match self.actions.iter_mut().find(|(own, _)| *own == number) {
            Some((_, own)) => *own = event,
            None => self.actions.push_back((number, event)),
        }
        if self.actions.len() > ACTIONS {
            self.actions.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use tokio::sync::mpsc::error::TryRecvError;

    #[test]
    fn sixth_tab_is_refused_until_one_is_closed() {
        let hub = Hub::default();
        let mut tabs: Vec<_> = (0..TABS)
            .map(|_| hub.subscribe().expect("a place"))
            .collect();
        assert_eq!(hub.subscribe().unwrap_err().code, "too-many-tabs");
        tabs.pop();
        assert!(hub.subscribe().is_ok());
    }

    #[test]
    fn new_tab_gets_newest_state_and_actions_but_no_old_samples() {
        let hub = Hub::default();
        hub.publish(Kind::Status, &json!(1));
        hub.publish(Kind::Status, &json!(2));
        hub.publish(Kind::Samples, &json!(3));
        hub.publish(Kind::Action, &json!({"n": 7, "state": "running"}));
        hub.publish(Kind::Action, &json!({"n": 7, "state": "done"}));
        let mut tab = hub.subscribe().expect("a place");
        assert_eq!(
            &*tab.try_recv().expect("the status"),
            "event: status\ndata: 2\n\n"
        );
        let action = tab.try_recv().expect("the action");
        assert_eq!(
            &*action,
            "event: action\ndata: {\"n\":7,\"state\":\"done\"}\n\n"
        );
        assert!(tab.try_recv().is_err());
    }

    #[test]
    fn stream_of_a_tab_that_does_not_read_ends_and_the_next_one_has_the_present_state() {
        let hub = Hub::default();
        let mut tab = hub.subscribe().expect("a place");
        for number in 0..10_000 {
            hub.publish(Kind::Samples, &json!(number));
            hub.publish(Kind::Action, &json!({"n": number}));
        }
        hub.publish(Kind::Device, &json!("the second sensor"));
        assert_eq!(tab.len(), WAITING);
        assert_eq!(hub.inner().actions.len(), ACTIONS);
        while tab.try_recv().is_ok() {}
        assert_eq!(tab.try_recv(), Err(TryRecvError::Disconnected));
        assert!(!hub.is_watched());
        let mut again = hub.subscribe().expect("a place");
        let device = again.try_recv().expect("the device");
        assert!(device.contains("the second sensor"), "{device}");
    }
}
