//! Server-sent events to the tabs: one stream for each tab, at most five.
//!
//! ```text
//! event: samples
//! data: {"first":0,"rows":[[0.0,1.25,-0.5]]}
//! ```
//!
//! A tab gets the newest event of each kind first, except samples, and the log. The stream of a tab that does not read ends: the tab
//! opens another one and knows the present state again. The numbers of the samples show what is missing.

use crate::error::{Asks, Error, PageError};
use serde_json::{Value, json};
use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use texts::Text;
use tokio::sync::mpsc::{Receiver, Sender, channel};

/// The maximum number of tabs.
pub const TABS: usize = 5;

/// The maximum number of events that wait for a tab: 12 s of samples.
const WAITING: usize = 256;

/// The maximum number of actions that are kept for new tabs.
const ACTIONS: usize = 100;

/// An event as bytes of the stream.
pub type Event = Arc<str>;

/// An open tab.
struct Tab {
    /// The name that it has given itself; None: a program.
    name: Option<String>,
    events: Sender<Event>,
}

/// The kinds of events that a tab can receive.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Kind {
    /// The name of the tab that is in charge, or null.
    Owner,
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
    /// The transmit list, and the log that is sent.
    Transmission,
    /// The virtual sensor of the demonstration, or null.
    StandIn,
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
            Self::Owner => "owner",
            Self::Status => "status",
            Self::Device => "device",
            Self::Values => "values",
            Self::Samples => "samples",
            Self::Others => "others",
            Self::OtherSamples => "other-samples",
            Self::Condition => "condition",
            Self::Frames => "frames",
            Self::Transmission => "transmission",
            Self::StandIn => "stand-in",
            Self::Found => "found",
            Self::Sheets => "sheets",
            Self::Calibration => "calibration",
            Self::Action => "action",
            Self::Note => "note",
            Self::Progress => "progress",
        }
    }
}

/// Adds a failure to an answer or an event: the document of `--json`, and the texts of the page.
pub fn tell(to: &mut Value, failure: &Error) {
    to["error"] = failure.json()["error"].clone();
    to["texts"] = failure.texts();
    if let Error::Asks(Asks(questions)) = failure {
        let asks = questions.iter();
        let asks = asks.map(|own| json!({"question": own, "texts": own.texts()}));
        to["asks"] = asks.collect();
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
    tabs: Vec<Tab>,
    /// The tab that is in charge: the others only look.
    owner: Option<String>,
    newest: BTreeMap<Kind, Event>,
    actions: VecDeque<(u64, Event)>,
}

impl Hub {
    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The events for a new tab of this name. It is in charge if no other one is.
    ///
    /// # Errors
    /// There are five tabs already.
    pub fn subscribe(&self, name: Option<String>) -> Result<Receiver<Event>, Error> {
        let mut inner = self.inner();
        inner.tabs.retain(|tab| !tab.events.is_closed());
        inner.resign();
        if inner.tabs.len() >= TABS {
            return Err(PageError::TooManyTabs(TABS).into());
        }
        let (tab, events) = channel(WAITING);
        let actions = inner.actions.iter().map(|(_, event)| event);
        for event in inner.newest.values().chain(actions) {
            let _ = tab.try_send(event.clone());
        }
        let is_first = inner.owner.is_none();
        inner.tabs.push(Tab {
            name: name.clone(),
            events: tab,
        });
        if is_first && name.is_some() {
            inner.charge(name);
        }
        Ok(events)
    }

    /// Lets a tab be in charge, also if another one is.
    pub fn take_over(&self, name: &str) {
        self.inner().charge(Some(name.to_owned()));
    }

    /// Whether a tab may act: it is in charge, or nobody is. Then it is from now on.
    pub fn may_act(&self, name: &str) -> bool {
        let mut inner = self.inner();
        inner.tabs.retain(|tab| !tab.events.is_closed());
        inner.resign();
        if inner.owner.is_none() {
            inner.charge(Some(name.to_owned()));
        }
        inner.owner.as_deref() == Some(name)
    }

    /// The number of a new action or question, from 1.
    pub fn number(&self) -> u64 {
        self.numbers.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// Whether a tab is open.
    pub fn is_watched(&self) -> bool {
        self.inner().tabs.iter().any(|tab| !tab.events.is_closed())
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
        inner.send(&event);
        inner.resign();
    }
}

impl Inner {
    /// Sends an event to all tabs. A tab that is full does not read: without this event it would show an old state, so its stream ends.
    fn send(&mut self, event: &Event) {
        self.tabs
            .retain(|tab| tab.events.try_send(event.clone()).is_ok());
    }

    /// Another tab is in charge.
    fn charge(&mut self, name: Option<String>) {
        let event: Event = format!("event: owner\ndata: {}\n\n", json!(name)).into();
        self.owner = name;
        self.newest.insert(Kind::Owner, event.clone());
        self.send(&event);
    }

    /// Nobody is in charge if the tab that was is closed.
    fn resign(&mut self) {
        let is_open = |tab: &Tab| tab.name == self.owner;
        if self.owner.is_some() && !self.tabs.iter().any(is_open) {
            self.charge(None);
        }
    }

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
            .map(|_| hub.subscribe(None).expect("a place"))
            .collect();
        assert_eq!(hub.subscribe(None).unwrap_err().code(), "too-many-tabs");
        tabs.pop();
        assert!(hub.subscribe(None).is_ok());
    }

    #[test]
    fn one_tab_is_in_charge_until_it_is_closed_or_another_one_takes_over() {
        let hub = Hub::default();
        let open = |name: &str| hub.subscribe(Some(name.to_owned())).expect("a place");
        let (one, mut two) = (open("one"), open("two"));
        assert!(hub.may_act("one") && !hub.may_act("two"));
        let owner = |tab: &mut Receiver<Event>| tab.try_recv().expect("an event");
        assert_eq!(&*owner(&mut two), "event: owner\ndata: \"one\"\n\n");
        hub.take_over("two");
        assert_eq!(&*owner(&mut two), "event: owner\ndata: \"two\"\n\n");
        assert!(hub.may_act("two") && !hub.may_act("one"));
        drop(two);
        hub.publish(Kind::Status, &json!(1));
        assert!(hub.may_act("one"), "nobody was in charge");
        drop(one);
    }

    #[test]
    fn new_tab_gets_newest_state_and_actions_but_no_old_samples() {
        let hub = Hub::default();
        hub.publish(Kind::Status, &json!(1));
        hub.publish(Kind::Status, &json!(2));
        hub.publish(Kind::Samples, &json!(3));
        hub.publish(Kind::Action, &json!({"n": 7, "state": "running"}));
        hub.publish(Kind::Action, &json!({"n": 7, "state": "done"}));
        let mut tab = hub.subscribe(None).expect("a place");
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
        let mut tab = hub.subscribe(None).expect("a place");
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
        let mut again = hub.subscribe(None).expect("a place");
        let device = again.try_recv().expect("the device");
        assert!(device.contains("the second sensor"), "{device}");
    }
}
