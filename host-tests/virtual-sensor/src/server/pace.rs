//! When the main loop runs the bus, and how long it sleeps.

use super::clock::Clock;
use super::event::Event;
use super::{Outside, RunError, Server, StatusLine};
use plumbline::time::{Instant, after, millis};
use std::sync::mpsc::{RecvTimeoutError, TryRecvError};
use std::time::Duration;

/// The minimum pause: running the bus for every bit would cost too much computing time.
const PAUSE_MIN: Duration = Duration::from_micros(100);

/// The minimum pause while no client is on the bus: nobody sees when the bus runs.
const PAUSE_UNSEEN: Duration = Duration::from_millis(20);

/// The time of the bus that is simulated at once.
const SLICE: plumbline::time::Duration = millis(20);

/// The longest time of the computer for it. A computer that is too slow for the sensor makes the time of the bus slower, so that clients are
/// still served.
const PATIENCE: Duration = Duration::from_millis(100);

impl Server {
    /// Waits for an event, for a frame of the adapter, or until the bus must run.
    pub(super) fn wait(&mut self) -> Result<Option<Event>, RunError> {
        let pause = self.pause();
        if let Some(outside) = &mut self.outside {
            outside.receive(pause)?;
            return Ok(match self.events.try_recv() {
                Ok(event) => Some(event),
                Err(TryRecvError::Empty) => None,
                Err(TryRecvError::Disconnected) => Some(Event::Stop),
            });
        }
        let event = match pause {
            Some(pause) => self.events.recv_timeout(pause),
            None => self.events.recv().map_err(RecvTimeoutError::from),
        };
        Ok(match event {
            Ok(event) => Some(event),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => Some(Event::Stop),
        })
    }

    /// The time on the bus: that of the computer, or that of a client (`--clock client`).
    fn now(&self) -> Instant {
        match self.clock {
            Clock::Computer => Instant::from_ticks(self.start.elapsed().as_micros() as u64),
            Clock::Client => self.bus.now(),
        }
    }

    /// The time until the next event of the bus; None: there is none.
    pub(super) fn pause(&self) -> Option<Duration> {
        let until = |at: Instant| {
            let at = Duration::from_micros(at.ticks());
            at.saturating_sub(self.start.elapsed())
        };
        let minimum = if self.is_seen() {
            PAUSE_MIN
        } else {
            PAUSE_UNSEEN
        };
        let bus = match self.clock {
            Clock::Computer => {
                let sessions = self.sessions.values();
                let late = sessions.flat_map(|one| [one.to_client.next(), one.to_bus.next()]);
                let outside = self.outside.iter().flat_map(Outside::late);
                let next = late
                    .chain(outside)
                    .chain([self.bus.next_event()])
                    .flatten()
                    .min();
                next.map(until).map(|at| at.max(minimum))
            }
            Clock::Client => None,
        };
        let status = self.status.as_ref().map(StatusLine::pause);
        match (bus, status) {
            (Some(bus), Some(status)) => Some(bus.min(status)),
            (bus, status) => bus.or(status),
        }
    }

    /// True while a client is on the bus, or frames of one that has left wait for it.
    fn is_seen(&self) -> bool {
        let sessions = self.sessions.values().map(|session| session.adapter);
        let controls = self.controls.values().filter_map(|control| control.adapter);
        let mut adapters = sessions.chain(controls);
        let is_client = adapters.any(|adapter| self.bus.takes_part(adapter));
        is_client || self.outside.is_some() || !self.leaving.is_empty()
    }

    /// Advances the bus to the current time, or by what the computer has simulated in [`PATIENCE`].
    pub(super) fn run_bus(&mut self) {
        let begin = std::time::Instant::now();
        let now = self.now();
        loop {
            self.bus.run_until(now.min(after(self.bus.now(), SLICE)));
            if self.bus.now() >= now {
                return;
            }
            if begin.elapsed() > PATIENCE {
                let behind = (now - self.bus.now()).ticks();
                self.start += Duration::from_micros(behind);
                return;
            }
        }
    }
}
