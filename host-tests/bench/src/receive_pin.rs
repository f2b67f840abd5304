//! The receive pin of a sensor with the timer that measures its pulses, as on the boards.

use can_wire::protocol::Picoseconds;
use plumbline::node::{BitTime, PulseMeter};
use plumbline::time::{Duration, Instant, after};

/// The duration of a tick of the timer.
const TICK: Picoseconds = 1_000_000 / BitTime::PER_US as Picoseconds;

/// The period of the polls while a result is pending.
const POLL_PERIOD: Duration = Duration::from_ticks(1000);

/// The timer at the receive pin.
#[derive(Clone, Copy, Debug)]
pub struct ReceivePin {
    meter: PulseMeter,
    /// The start of the present pulse.
    start: Option<u16>,
    polled: Instant,
}

impl Default for ReceivePin {
    fn default() -> Self {
        Self {
            meter: PulseMeter::EMPTY,
            start: None,
            polled: Instant::from_ticks(0),
        }
    }
}

impl ReceivePin {
    /// Handles a new level; true is dominant.
    pub fn edge(&mut self, now: Picoseconds, dominant: bool) {
        // The counter has 16 bits.
        let counter = (now / TICK) as u16;
        if dominant {
            self.start = Some(counter);
        } else if let Some(start) = self.start.take() {
            self.meter.pulse(start, counter);
        }
    }

    /// The bit time of the last frame, once.
    pub fn poll(&mut self, now: Instant) -> Option<BitTime> {
        self.polled = now;
        self.meter.poll(now)
    }

    /// The time of the next poll; None on a silent wire.
    pub fn deadline(&self) -> Option<Instant> {
        let pending = self.meter.is_pending();
        pending.then(|| after(self.polled, POLL_PERIOD))
    }
}
