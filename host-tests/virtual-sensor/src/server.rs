//! The bench's bus, with clients that speak slcan on TCP and on a pseudoterminal.
//!
//! ```text
//!  client -- reading thread --\                           /-- outbox -- writing thread -- client
//!  client -- reading thread ---+-- events -- main loop --+--- outbox -- writing thread -- client
//!  client -- reading thread --/                           \-- outbox -- writing thread -- client
//! ```
//!
//! Only the main loop owns the bus. It sleeps until a client sends data or the bus has an event, whichever comes first, so there
//! is no tick delay. It never waits for a client: unread data stays in the outbox of the client, and a client with a full outbox
//! is dropped. A client that sends faster than the server processes its lines is blocked by the bounded event queue, as by the
//! full buffer of an adapter.

mod clock;
mod control;
mod event;
mod log;
mod outbox;
mod outside;
mod pace;
mod passage;
mod pattern;
mod port;
#[cfg(unix)]
pub mod pty;
mod session;
mod status;
pub mod tcp;

pub use clock::Clock;
pub use control::{MemoryFault, Refused, Request, Side, Topic, Unit};
pub use event::{Events, Language};
pub use log::Log;
pub use outside::Outside;
pub use passage::{Passage, Rule};
pub use status::StatusLine;

use crate::slcan::Channel;
use adapter::AdapterError;
use bench::{Bus, DeviceId, Source};
use clock::{Line, write_time};
use control::Control;
use event::{ClientId, Event};
use port::{AdapterPort, Leaving};
use session::Session;
use std::collections::BTreeMap;
use std::io;
use std::sync::mpsc::Receiver;
use std::time::Duration;
use stm32_sim::Microcontroller;

/// Events that are processed before the bus runs again.
const BURST: usize = 64;

/// The main loop: one bus and all its clients.
pub struct Server {
    bus: Bus,
    sensor: DeviceId,
    clock: Clock,
    start: std::time::Instant,
    events: Receiver<Event>,
    sessions: BTreeMap<ClientId, Session>,
    /// The clients that control the sensors, and these sensors.
    controls: BTreeMap<ClientId, Control>,
    units: Vec<Unit>,
    leaving: Leaving,
    /// The bus of an adapter.
    outside: Option<Outside>,
    log: Option<Log>,
    status: Option<StatusLine>,
    traffic: Traffic,
}

/// Number of frames on the bus.
#[derive(Clone, Copy, Default, Debug)]
struct Traffic {
    /// The number of frames to the sensor.
    received: u64,
    /// The number of frames from the sensor.
    sent: u64,
}

/// The reason why the server has ended.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The log cannot be written.
    #[error("cannot write the log: {0}")]
    Log(#[from] io::Error),
    /// The adapter has failed.
    #[error("{0}")]
    Adapter(#[from] AdapterError),
    /// The simulated program has stopped, for this reason.
    #[error("the firmware {0}")]
    Firmware(String),
}

impl Server {
    /// A server for `bus`, whose current time is now, and the channel for its events.
    ///
    /// `sensor` is the device that the status line describes, if there are no others ([`control`](Self::control)); `clock` tells the time
    /// from now on.
    pub fn new(
        bus: Bus,
        sensor: DeviceId,
        clock: Clock,
        mut log: Option<Log>,
        status: Option<StatusLine>,
    ) -> (Self, Events) {
        let (sender, events) = Events::channel();
        let past = Duration::from_micros(bus.now().ticks());
        let start = std::time::Instant::now();
        if let Some(log) = &mut log {
            log.begin(past);
        }
        let server = Self {
            bus,
            sensor,
            clock,
            start: start.checked_sub(past).unwrap_or(start),
            events,
            sessions: BTreeMap::new(),
            controls: BTreeMap::new(),
            units: Vec::new(),
            leaving: Leaving::default(),
            outside: None,
            log,
            status,
            traffic: Traffic::default(),
        };
        (server, sender)
    }

    /// Connects the bus to that of an adapter.
    pub fn connect(&mut self, mut outside: Outside) {
        outside.join(&mut self.bus);
        self.outside = Some(outside);
    }

    /// Runs until [`Events::stop`].
    ///
    /// # Errors
    /// The log cannot be written, the adapter fails, or the firmware cannot continue.
    pub fn run(mut self) -> Result<(), RunError> {
        loop {
            self.advance()?;
            let mut next = self.wait()?;
            self.run_bus();
            if let Some(outside) = &mut self.outside {
                outside.enter(&mut self.bus);
            }
            let mut burst = 0;
            while let Some(event) = next.take() {
                if matches!(event, Event::Stop) {
                    return self.end();
                }
                self.handle(event)?;
                burst += 1;
                if burst < BURST {
                    next = self.events.try_recv().ok();
                }
            }
        }
    }

    /// Advances the bus to the current time and passes on its traffic.
    fn advance(&mut self) -> Result<(), RunError> {
        self.run_bus();
        let mut lines = Vec::new();
        let (bus, leaving) = (&mut self.bus, &mut self.leaving);
        self.sessions.retain(|_, session| {
            lines.clear();
            for (_, frame) in session.to_bus.arrived(bus.now()) {
                bus.send(session.adapter, frame);
            }
            for (at, frame) in session.receive(bus) {
                if self.clock == Clock::Client && session.channel.is_open() {
                    session.received = true;
                    write_time(at, &mut lines);
                }
                session.channel.received(at, &frame, &mut lines);
            }
            session.push(&lines) || {
                leaving.add(bus, session.adapter);
                false
            }
        });
        leaving.remove_done(bus);
        if let Some(outside) = &mut self.outside {
            outside.leave(bus, self.sensor)?;
        }
        for adapter in self.controls.values().filter_map(|one| one.adapter) {
            // The events have the frames of all senders.
            bus.take_received(adapter);
        }
        let logged = self.bus.take_log();
        for entry in &logged {
            match entry.source {
                Source::Device(_) => self.traffic.sent += 1,
                Source::Adapter(_) => self.traffic.received += 1,
            }
        }
        if let Some(log) = &mut self.log {
            log.write(&logged)?;
        }
        self.report(&logged);
        let devices = self.devices();
        // Before the status line, which is then written again.
        for unit in &mut self.units {
            if let Some(why) = unit.newly_unwritten(&mut self.bus) {
                eprintln!("virtual-sensor: {why}");
            }
        }
        for device in &devices {
            let Some(sensor) = Microcontroller::of_mut(self.bus.device_mut(*device)) else {
                continue;
            };
            for violation in sensor.take_new_violations() {
                eprintln!(
                    "virtual-sensor: the firmware violates the reference manual: {violation}"
                );
            }
            if let Some(reason) = sensor.stopped() {
                return Err(RunError::Firmware(reason.to_owned()));
            }
        }
        if let Some(status) = &mut self.status {
            let sensors = devices.iter().map(|device| self.bus.device(*device));
            status.show(self.bus.now(), sensors, self.traffic, self.sessions.len());
        }
        Ok(())
    }

    /// The sensors that the server watches.
    fn devices(&self) -> Vec<DeviceId> {
        match self.units.is_empty() {
            true => vec![self.sensor],
            false => self.units.iter().map(|unit| unit.device).collect(),
        }
    }

    /// Handles one event at the current bus time.
    fn handle(&mut self, event: Event) -> Result<(), RunError> {
        match event {
            Event::Joined(id, client, Language::Control) => {
                self.controls.insert(id, Control::new(client));
                // The events of earlier times are not for it.
                self.report(&[]);
            }
            Event::Joined(id, client, Language::Slcan) => {
                let session = Session {
                    client,
                    channel: Channel::new(),
                    adapter: self.bus.adapter(),
                    line: Line::default(),
                    received: false,
                    to_client: Passage::default(),
                    to_bus: Passage::default(),
                };
                self.sessions.insert(id, session);
            }
            Event::Input(id, bytes) if self.controls.contains_key(&id) => {
                self.input_of_control(id, &bytes)?;
            }
            Event::Input(id, bytes) => match self.clock {
                Clock::Computer => self.input(id, &bytes),
                Clock::Client => self.input_with_clock(id, &bytes)?,
            },
            Event::Left(id) => {
                self.leave(id);
                self.leave_control(id);
            }
            Event::Stop => {}
        }
        Ok(())
    }

    /// Passes input of a client to its adapter.
    fn input(&mut self, id: ClientId, bytes: &[u8]) {
        // Events of a dropped client may still arrive.
        let Some(session) = self.sessions.get_mut(&id) else {
            return;
        };
        let mut answers = Vec::new();
        let mut port = AdapterPort {
            bus: &mut self.bus,
            adapter: &mut session.adapter,
            leaving: &mut self.leaving,
            to_bus: &mut session.to_bus,
        };
        session.channel.input(bytes, &mut port, &mut answers);
        if !session.push(&answers) {
            self.leave(id);
        }
    }

    fn leave(&mut self, id: ClientId) {
        if let Some(session) = self.sessions.remove(&id) {
            self.leaving.add(&mut self.bus, session.adapter);
        }
    }

    /// The faults of the frames from this side, to and from each client and the adapter.
    fn passages(&mut self, from: Side) -> impl Iterator<Item = &mut Passage> {
        let sessions = self.sessions.values_mut();
        let sessions = sessions.map(move |one| one.passage(from));
        let outside = self.outside.iter_mut();
        sessions.chain(outside.map(move |one| one.passage(from)))
    }

    fn end(mut self) -> Result<(), RunError> {
        if let Some(status) = &mut self.status {
            status.end();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
