//! What comes from the threads of the clients, and the connections to the clients.

use super::outbox::Outbox;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// Events that may wait for the main loop before their senders block.
const EVENTS_MAX: usize = 256;

/// Events from outside the bus.
pub(super) enum Event {
    /// A client has connected, which speaks this.
    Joined(ClientId, Client, Language),
    /// A client has sent these bytes.
    Input(ClientId, Vec<u8>),
    /// A client has closed its connection.
    Left(ClientId),
    /// The program must end.
    Stop,
}

/// What the clients of a port speak.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Language {
    /// slcan.
    Slcan,
    /// The JSON lines of clients that control the sensors.
    Control,
}

/// Identifies a client; never reused.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) struct ClientId(u64);

impl ClientId {
    pub(super) fn next() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

impl fmt::Display for ClientId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// The connection to a client. Dropping it ends the connection after the content of the outbox has been written.
pub(super) struct Client {
    outbox: Arc<Outbox>,
    hang_up: Box<dyn Fn() + Send>,
}

impl Client {
    pub(super) fn new(outbox: Arc<Outbox>, hang_up: impl Fn() + Send + 'static) -> Self {
        Self {
            outbox,
            hang_up: Box::new(hang_up),
        }
    }

    /// Sends bytes to the client; false when it had to be dropped because it does not read.
    pub(super) fn push(&self, bytes: &[u8]) -> bool {
        let taken = bytes.is_empty() || self.outbox.push(bytes);
        if !taken {
            (self.hang_up)();
        }
        taken
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        self.outbox.close();
    }
}

/// The server accepts no more events.
pub(super) struct Ended;

/// The channel by which client threads report events.
#[derive(Clone)]
pub struct Events(SyncSender<Event>);

impl Events {
    /// The channel, and what comes from it.
    pub(super) fn channel() -> (Self, Receiver<Event>) {
        let (sender, events) = sync_channel(EVENTS_MAX);
        (Self(sender), events)
    }

    pub(super) fn send(&self, event: Event) -> Result<(), Ended> {
        self.0.send(event).map_err(|_| Ended)
    }

    /// Ends the server after the event that it handles.
    pub fn stop(&self) {
        // If the receiver is gone, the server has already ended.
        let _ = self.send(Event::Stop);
    }
}
