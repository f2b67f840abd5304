//! The connection to a broker, in a thread of its own: it delivers the records of the queue, and documents that the broker keeps.
//!
//! Each connection is a new session. It begins with the first record that is not acknowledged, so nothing depends on what the broker
//! remembers. A record whose acknowledgement was lost is sent again with the same number.

use super::address::{Address, Credentials};
use super::failure;
use super::queue::{Cursor, Lost, Queue};
use super::topics::HERE;
use super::window::{Entry, Window};
use crate::error::{BrokerError, Error};
use rumqttc::{
    AsyncClient, ConnectionError, Event, EventLoop, LastWill, MqttOptions, Outgoing, Packet, QoS,
    Transport,
};
use serde_json::Value;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use tokio::select;
use tokio::sync::Notify;
use tokio::time::sleep;

/// The messages on their way that wait for an acknowledgement.
const WINDOW: usize = 100;

/// The packet identifiers of the client: more than are on their way.
const IDENTIFIERS: u16 = 1000;

/// The pause after the first failure, and the longest pause.
const PAUSE: (Duration, Duration) = (Duration::from_secs(1), Duration::from_secs(60));

/// The pauses begin again after a connection of this time: a broker can accept each connection and close it at once.
const LASTING: Duration = Duration::from_secs(10);

/// The time for a connection.
const CONNECT: u64 = 10;

/// The broker says that the bridge is away after one and a half times this time without a message.
const KEEP_ALIVE: Duration = Duration::from_secs(15);

/// The time for the last messages.
const END: Duration = Duration::from_secs(5);

/// The pause between two writes of the queue to the disk.
const SYNC: Duration = Duration::from_secs(5);

/// What happens in the thread.
pub enum BrokerEvent {
    /// The queue cannot be written to the disk, for this reason.
    NotSynchronised(String),
    /// There is a connection.
    Connected,
    /// There is none, for this reason. The next try follows after this number of seconds.
    Away(String, u64),
    /// No try can succeed.
    Failed(Error),
}

/// A connection.
pub struct Wanted {
    /// Where the broker is.
    pub address: Address,
    /// User and password.
    pub credentials: Option<Credentials>,
    /// TCP or TLS.
    pub transport: Transport,
    /// The name of the client.
    pub client: String,
    /// The topic that says whether the bridge is there.
    pub availability: String,
}

/// The documents that the broker keeps.
#[derive(Default)]
struct Documents {
    /// The number of the newest one.
    number: u64,
    /// The newest one of each topic, with its number.
    topics: BTreeMap<String, (u64, String)>,
}

/// What both threads know.
struct Shared {
    queue: Mutex<Queue>,
    kept: Mutex<Documents>,
    /// There is something new.
    wake: Notify,
    /// The bridge ends.
    ends: tokio::sync::watch::Sender<bool>,
}

impl Shared {
    fn queue(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The documents with other numbers than these, which become the same.
    fn news(&self, sent: &mut BTreeMap<String, u64>) -> Vec<(String, String)> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let is_new =
            |(topic, (number, _)): &(&String, &(u64, String))| sent.get(*topic) != Some(number);
        let news: Vec<_> = kept.topics.iter().filter(is_new).collect();
        let news = news.into_iter().map(|(topic, (number, text))| {
            sent.insert(topic.clone(), *number);
            (topic.clone(), text.clone())
        });
        news.collect()
    }
}

/// The connection to a broker.
pub struct Broker {
    shared: Arc<Shared>,
    events: Receiver<BrokerEvent>,
    thread: JoinHandle<()>,
    availability: String,
}

impl Broker {
    /// Connects, and delivers what is in the queue.
    ///
    /// # Errors
    /// There is no thread.
    pub fn start(wanted: Wanted, queue: Queue) -> Result<Self, Error> {
        let shared = Arc::new(Shared {
            queue: Mutex::new(queue),
            kept: Mutex::default(),
            wake: Notify::new(),
            ends: tokio::sync::watch::Sender::new(false),
        });
        let (sender, events) = channel();
        let availability = wanted.availability.clone();
        let failed = |error: std::io::Error| {
            BrokerError::Socket(wanted.address.to_string(), error.to_string())
        };
        let mut builder = tokio::runtime::Builder::new_current_thread();
        let runtime = builder.enable_all().build().map_err(failed)?;
        let own = shared.clone();
        let name = wanted.address.to_string();
        let thread = thread::Builder::new().name("broker".to_owned());
        let thread = thread.spawn(move || {
            runtime.block_on(run(&wanted, &own, &sender));
            // The search for the address of the broker can last longer.
            runtime.shutdown_background();
        });
        let thread = thread.map_err(|error| BrokerError::Socket(name, error.to_string()))?;
        let broker = Self {
            shared,
            events,
            thread,
            availability,
        };
        broker.keep(broker.availability.clone(), HERE[1].to_owned());
        Ok(broker)
    }

    /// Delivers a document with the next number.
    ///
    /// # Errors
    /// The queue cannot be written.
    pub fn publish(&self, topic: &str, document: &Value) -> Result<(), Error> {
        let mut queue = self.shared.queue();
        let mut record = format!("{topic}\n{{\"seq\":{},", queue.next());
        record.push_str(document.to_string().trim_start_matches('{'));
        queue.push(record.as_bytes())?;
        drop(queue);
        self.shared.wake.notify_one();
        Ok(())
    }

    /// The broker keeps this text as the newest one of a topic.
    pub fn keep(&self, topic: String, text: String) {
        let mut kept = self
            .shared
            .kept
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        kept.number += 1;
        let number = kept.number;
        kept.topics.insert(topic, (number, text));
        drop(kept);
        self.shared.wake.notify_one();
    }

    /// What has happened in the thread since the last call.
    pub fn events(&self) -> Vec<BrokerEvent> {
        self.events.try_iter().collect()
    }

    /// What was lost since the last call.
    pub fn take_lost(&self) -> Lost {
        self.shared.queue().take_lost()
    }

    /// Says that the bridge ends, and delivers what can be delivered in some seconds. Returns the number of records that stay in the queue,
    /// or the reason why it cannot be written; and what has happened in the thread since the last call.
    pub fn end(self) -> (std::io::Result<u64>, Vec<BrokerEvent>) {
        self.keep(self.availability.clone(), HERE[0].to_owned());
        self.shared.ends.send_replace(true);
        self.shared.wake.notify_one();
        // The thread that has panicked has written it to standard error.
        let _ = self.thread.join();
        let mut queue = self.shared.queue();
        let left = queue.end().map(|()| queue.waiting());
        (left, self.events.try_iter().collect())
    }
}

async fn run(wanted: &Wanted, shared: &Shared, sender: &Sender<BrokerEvent>) {
    let mut ends = shared.ends.subscribe();
    select! {
        () = connections(wanted, shared, sender) => {}
        () = synchronised(shared, sender) => {}
        () = async {
            // The sender lives as long as this thread.
            let _ = ends.wait_for(|ends| *ends).await;
            sleep(END).await;
        } => {}
    }
}

/// Brings the queue to the disk again and again. The disk can be slow, so the queue takes records meanwhile.
async fn synchronised(shared: &Shared, sender: &Sender<BrokerEvent>) {
    let mut known = None;
    loop {
        sleep(SYNC).await;
        let unsynced = shared.queue().unsynced();
        let written = unsynced.and_then(|unsynced| {
            unsynced.write()?;
            shared.queue().synced(&unsynced);
            Ok(())
        });
        let failed = written.err().map(|error| error.to_string());
        if let Some(reason) = failed.clone().filter(|_| failed != known) {
            let _ = sender.send(BrokerEvent::NotSynchronised(reason));
        }
        known = failed;
    }
}

/// Connects again and again, with a growing pause.
async fn connections(wanted: &Wanted, shared: &Shared, sender: &Sender<BrokerEvent>) {
    let (first, longest) = PAUSE;
    let mut pause = first;
    let mut ends = shared.ends.subscribe();
    loop {
        let window = RefCell::new(Window::default());
        let error = connection(wanted, shared, sender, &window).await;
        if let Some(failure) = failure::lasting(&error, &wanted.address) {
            let _ = sender.send(BrokerEvent::Failed(failure));
            return;
        }
        let connected = window.borrow().connected;
        if connected.is_some_and(|since| since.elapsed() >= LASTING) {
            pause = first;
        }
        let _ = sender.send(BrokerEvent::Away(failure::reason(&error), pause.as_secs()));
        select! {
            () = sleep(pause) => {}
            _ = ends.wait_for(|ends| *ends) => return,
        }
        pause = longest.min(2 * pause);
    }
}

/// One connection, and why it has ended.
async fn connection(
    wanted: &Wanted,
    shared: &Shared,
    sender: &Sender<BrokerEvent>,
    window: &RefCell<Window>,
) -> ConnectionError {
    let mut options = MqttOptions::new(&wanted.client, &wanted.address.host, wanted.address.port);
    options.set_keep_alive(KEEP_ALIVE);
    options.set_clean_session(true);
    options.set_inflight(IDENTIFIERS);
    options.set_transport(wanted.transport.clone());
    let will = LastWill::new(&wanted.availability, HERE[0], QoS::AtLeastOnce, true);
    options.set_last_will(will);
    if let Some(own) = &wanted.credentials {
        options.set_credentials(&own.username, &own.password);
    }
    let (client, mut events) = AsyncClient::new(options, WINDOW);
    events.network_options.set_connection_timeout(CONNECT);
    let changed = Notify::new();
    select! {
        error = received(&mut events, shared, sender, window, &changed) => error,
        error = delivered(&client, shared, window, &changed) => error,
    }
}

/// Takes what the broker sends.
async fn received(
    events: &mut EventLoop,
    shared: &Shared,
    sender: &Sender<BrokerEvent>,
    window: &RefCell<Window>,
    changed: &Notify,
) -> ConnectionError {
    loop {
        match events.poll().await {
            Err(error) => return error,
            Ok(Event::Incoming(Packet::ConnAck(_))) => {
                window.borrow_mut().connected = Some(Instant::now());
                let _ = sender.send(BrokerEvent::Connected);
                changed.notify_one();
            }
            Ok(Event::Outgoing(Outgoing::Publish(packet))) => window.borrow_mut().sent(packet),
            Ok(Event::Incoming(Packet::PubAck(packet))) => {
                let before = window.borrow_mut().acknowledged(packet.pkid);
                if let Some(before) = before {
                    shared.queue().acknowledge(before);
                }
                changed.notify_one();
            }
            Ok(_) => {}
        }
    }
}

/// Sends what is new, as long as few messages are on their way. At the end of the bridge it disconnects as soon as everything is
/// acknowledged.
async fn delivered(
    client: &AsyncClient,
    shared: &Shared,
    window: &RefCell<Window>,
    changed: &Notify,
) -> ConnectionError {
    // It begins with the first record that is not acknowledged.
    let mut cursor = Cursor::default();
    let mut sent = BTreeMap::new();
    loop {
        let (is_connected, under_way) = {
            let window = window.borrow();
            (window.connected.is_some(), window.under_way())
        };
        let mut is_idle = true;
        if is_connected && under_way < WINDOW {
            for (topic, text) in shared.news(&mut sent) {
                is_idle = false;
                window.borrow_mut().submit(Entry::Kept);
                let published = client.publish(topic, QoS::AtLeastOnce, true, text);
                // The other half knows why the connection has ended.
                let _ = published.await;
            }
            let records = match shared.queue().read(&mut cursor, WINDOW - under_way) {
                Err(error) => return ConnectionError::Io(error),
                Ok(records) => records,
            };
            for (number, bytes) in records {
                is_idle = false;
                window.borrow_mut().submit(Entry::Record(number));
                let end = bytes.iter().position(|byte| *byte == b'\n');
                let (topic, text) = bytes.split_at(end.unwrap_or(bytes.len()));
                let topic = String::from_utf8_lossy(topic);
                let text = text.get(1..).unwrap_or_default();
                let published = client.publish(topic, QoS::AtLeastOnce, false, text);
                let _ = published.await;
            }
        }
        if is_idle && is_connected && under_way == 0 && *shared.ends.borrow() {
            // The connection ends with this message, without the last will.
            let _ = client.disconnect().await;
            std::future::pending::<()>().await;
        }
        select! {
            () = shared.wake.notified() => {}
            () = changed.notified() => {}
        }
    }
}
