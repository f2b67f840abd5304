//! A bus outside of the program, connected through a CAN adapter.
//!
//! The adapter and a participant of the simulated bus pass each frame on, so a frame takes its time on both. The acknowledge of the
//! simulated bus does not wait for that of the other: a frame that nobody there acknowledges is lost for the sensor.

use super::control::Side;
use super::passage::Passage;
use super::port::QUEUE_MAX;
use adapter::{Adapter, AdapterError, Mode};
use bench::{AdapterId, Bus, DeviceId};
use plumbline::can::{BitRate, Frame};
use plumbline::node::BusMode;
use plumbline::time::{Instant, after};
use std::time::{Duration, Instant as Time};

/// The longest wait for a frame: clients have no other turn.
const WAIT: Duration = Duration::from_millis(2);

/// The interval of the questions for errors of the bus, until the first frame.
const CHECK: Duration = Duration::from_secs(1);

/// The bus of an adapter.
pub struct Outside {
    adapter: Box<dyn Adapter>,
    name: String,
    /// The participant of the simulated bus; None: it is not connected yet.
    port: Option<AdapterId>,
    rate: BitRate,
    received: Vec<Frame>,
    to_client: Passage,
    to_bus: Passage,
    /// The time of the next question for errors; None: a frame was received, or the user was warned.
    check: Option<Time>,
    /// The user knows that frames are refused.
    is_refused: bool,
}

impl Outside {
    /// Opens the adapter of a port at this bit rate.
    ///
    /// # Errors
    /// There is no such port, or the adapter cannot be used at this bit rate.
    pub fn open(name: &str, rate: BitRate) -> Result<Self, AdapterError> {
        let mut adapter = adapter::connect(name)?;
        adapter.open(Some(rate), Mode::Active)?;
        Ok(Self {
            adapter,
            name: name.to_owned(),
            port: None,
            rate,
            received: Vec::new(),
            to_client: Passage::default(),
            to_bus: Passage::default(),
            check: Some(Time::now() + CHECK),
            is_refused: false,
        })
    }

    /// Connects the adapter to the simulated bus.
    pub(super) fn join(&mut self, bus: &mut Bus) {
        let port = bus.adapter();
        bus.open(port, None, false);
        self.port = Some(port);
    }

    /// Waits for a frame of the adapter, at most for this time.
    pub(super) fn receive(&mut self, pause: Option<Duration>) -> Result<(), AdapterError> {
        let pause = pause.map_or(WAIT, |pause| pause.min(WAIT));
        let span = plumbline::time::Duration::from_ticks(pause.as_micros() as u64);
        let mut until = after(self.adapter.now(), span);
        loop {
            match self.adapter.receive(until) {
                Ok(Some((_, frame))) => {
                    (self.check, self.is_refused) = (None, false);
                    self.received.push(frame);
                    // Those that have arrived meanwhile.
                    until = self.adapter.now();
                    if self.received.len() >= QUEUE_MAX {
                        return Ok(());
                    }
                }
                Ok(None) => break,
                Err(refusal) => self.refused(refusal)?,
            }
        }
        if self.check.is_some_and(|at| Time::now() >= at) {
            self.check = Some(Time::now() + CHECK);
            self.check_rate();
        }
        Ok(())
    }

    /// Warns if the bus has errors and no frame.
    fn check_rate(&mut self) {
        if self.adapter.errors().is_some_and(|count| count > 0) {
            let (name, rate) = (&self.name, self.rate.name());
            eprintln!(
                "virtual-sensor: {name} reports errors of the bus and has received no frame: check the wiring, and whether the bus has {rate} \
                 (--bus-rate selects another bit rate)"
            );
            self.check = None;
        }
    }

    /// Sends the received frames on the simulated bus.
    pub(super) fn enter(&mut self, bus: &mut Bus) {
        let Some(port) = self.port else {
            return;
        };
        let now = bus.now();
        for (_, frame) in self.to_bus.arrived(now) {
            bus.send(port, frame);
        }
        for frame in self.received.drain(..) {
            if bus.queued(port) + self.to_bus.late() < QUEUE_MAX
                && let Some(frame) = self.to_bus.pass(now, frame)
            {
                bus.send(port, frame);
            }
        }
    }

    /// Takes over the bit rate of the first sensor, and sends the frames of the simulated bus.
    pub(super) fn leave(&mut self, bus: &mut Bus, first: DeviceId) -> Result<(), AdapterError> {
        let Some(port) = self.port else {
            return Ok(());
        };
        // Before the frames: on a late computer they contain the boot-up message at the new bit rate.
        let sensor = bus.device(first);
        let takes_part = sensor.mode() == Some(BusMode::Normal) && sensor.rate().is_some();
        if takes_part && bus.rate() != self.rate {
            self.adapter.open(Some(bus.rate()), Mode::Active)?;
            self.rate = bus.rate();
            self.check = Some(Time::now() + CHECK);
        }
        let mut frames: Vec<Frame> = Vec::new();
        for (at, frame) in bus.take_received(port) {
            frames.extend(self.to_client.pass(at, frame));
        }
        let late = self.to_client.arrived(bus.now());
        frames.extend(late.into_iter().map(|(_, frame)| frame));
        for frame in frames {
            if let Err(refusal) = self.adapter.send(&frame) {
                self.refused(refusal)?;
            }
        }
        Ok(())
    }

    /// A refused frame is lost, and the first one is told. Another error ends the program.
    fn refused(&mut self, refusal: AdapterError) -> Result<(), AdapterError> {
        match refusal {
            AdapterError::FrameRefused(_) | AdapterError::QueueFull => {
                if !std::mem::replace(&mut self.is_refused, true) {
                    eprintln!("virtual-sensor: {refusal}");
                }
                Ok(())
            }
            other => Err(other),
        }
    }

    /// The arrivals of the late frames.
    pub(super) fn late(&self) -> [Option<Instant>; 2] {
        [self.to_client.next(), self.to_bus.next()]
    }

    /// The faults of the frames from this side.
    pub(super) fn passage(&mut self, from: Side) -> &mut Passage {
        match from {
            Side::Sensors => &mut self.to_client,
            Side::Clients => &mut self.to_bus,
        }
    }
}
