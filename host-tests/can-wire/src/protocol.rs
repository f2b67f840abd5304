//! The CAN protocol of ISO 11898-1, bit by bit: the part that is common to all CAN controllers, independent of their registers.
//!
//! The bus simulation goes from one [`next_event`](Protocol::next_event) to the next. It steps all state machines that are due,
//! with the level of the wire before that time. Then it combines the levels that they drive, and reports to all of them when the
//! wire has become dominant. An idle controller begins a frame at once, not at the next bit start of its own clock; this is the
//! only simplification of the standard.

mod coding;
mod confinement;
mod flags;
mod machine;
mod repetition;
mod timing;

use coding::{Incoming, Outgoing};
use confinement::Confinement;
use machine::Phase;
use plumbline::can::{BitRate, Frame};
use plumbline::node::BusState;
pub use repetition::Period;
use timing::BitClock;

/// A point in time or a duration in picoseconds: a bit of each of the ten rates and a clock cycle of 64 MHz are integer values.
/// 64 bits hold 213 days.
pub type Picoseconds = u64;

/// The bit timing of a controller.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct BitTiming {
    /// The length of a bit.
    pub bit: Picoseconds,
    /// From the start of a bit to its sample point.
    pub sample: Picoseconds,
    /// Maximum shift of the sample point by one resynchronization (SJW).
    pub jump: Picoseconds,
}

impl BitTiming {
    /// A bit rate with the sample point that CiA recommends, at 7/8 of the bit, and a jump width of an eighth of the bit.
    pub fn of(rate: BitRate) -> Self {
        let bit = bit_time(rate);
        Self {
            bit,
            sample: bit / 8 * 7,
            jump: bit / 8,
        }
    }
}

/// The length of a bit.
pub fn bit_time(rate: BitRate) -> Picoseconds {
    1_000_000_000_000 / Picoseconds::from(rate.bits_per_second())
}

/// The type of an error; the numbers are those of bxCAN's last error code (RM0008, CAN_ESR.LEC).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum ErrorCode {
    /// More than five equal bits in a stuffed field.
    Stuff = 1,
    /// A bit of fixed value was wrong.
    Form = 2,
    /// No other node acknowledged the frame.
    Acknowledgment = 3,
    /// Recessive was sent, dominant was on the wire.
    BitRecessive = 4,
    /// Dominant was sent, recessive was on the wire.
    BitDominant = 5,
    /// The checksum does not match.
    Crc = 6,
}

/// The result of a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Event {
    /// 11 recessive bits have been seen: the controller takes part in the bus (after a join).
    Joined,
    /// The transmission of the offered frame has started: start of frame.
    Started,
    /// The frame has lost arbitration and can be offered again.
    LostArbitration,
    /// The frame has been sent successfully.
    Transmitted,
    /// A frame of another controller has been received.
    Received(Frame),
    /// An error; `transmitting` when it destroyed its own frame, which can be offered again.
    Error {
        /// The type of the error.
        code: ErrorCode,
        /// The controller was the transmitter.
        transmitting: bool,
    },
    /// The recovery from bus-off has ended.
    Recovered,
}

/// The protocol state machine of one controller.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Protocol {
    clock: BitClock,
    silent: bool,
    phase: Phase,
    confinement: Confinement,
    /// The level that it drives now; true is dominant.
    drives: bool,
    /// The level that it drives from the start of the next bit.
    drives_next: bool,
    /// The frame on the wire, also its own.
    incoming: Incoming,
    /// Its own frame, until its end or an error.
    outgoing: Option<Outgoing>,
    /// The current frame, or the last one until the end of the intermission, is its own.
    transmitter: bool,
    error_flags: u64,
    /// The start of the current or the last frame.
    frame_start: Picoseconds,
}

impl Protocol {
    /// Starts to take part with this timing; [`Event::Joined`] follows after 11 recessive bits. Silent: it sees its own dominant
    /// bits, but does not drive them, and sends no frames. The error counters stay. A bus-off controller stays bus-off, and
    /// counts from zero when it recovers.
    pub fn join(&mut self, now: Picoseconds, timing: BitTiming, silent: bool) {
        self.leave();
        self.clock = BitClock::new(now, timing);
        self.silent = silent;
        self.phase = if self.confinement.is_bus_off() {
            Phase::BusOff {
                sequences: None,
                recessive: 0,
            }
        } else {
            Phase::Integrating { recessive: 0 }
        };
    }

    /// Changes timing and mode without leaving the bus, from the next bit on: a fault of the controller.
    pub fn retime(&mut self, timing: BitTiming, silent: bool) {
        self.clock.retime(timing);
        self.silent = silent;
    }

    /// Stops taking part at once; a current frame is aborted. The error counters stay.
    pub fn leave(&mut self) {
        self.phase = Phase::Off;
        self.drives = false;
        self.drives_next = false;
        self.outgoing = None;
        self.transmitter = false;
    }

    /// True after a join, until it leaves.
    pub fn is_on(&self) -> bool {
        self.phase != Phase::Off
    }

    /// True during any frame, including error frame and intermission: bxCAN waits for its end before it acknowledges
    /// initialization mode.
    pub fn is_busy(&self) -> bool {
        !matches!(
            self.phase,
            Phase::Off
                | Phase::Integrating { .. }
                | Phase::BusOff { .. }
                | Phase::Idle { .. }
                | Phase::Suspend(_)
        )
    }

    /// True while its own frame is being sent.
    pub fn is_transmitting(&self) -> bool {
        self.outgoing.is_some()
    }

    /// Error active, error passive or bus-off, from the error counters.
    pub fn state(&self) -> BusState {
        self.confinement.state()
    }

    /// The transmit error counter, 0 to 255 (bus-off: 255).
    pub fn transmit_errors(&self) -> u16 {
        self.confinement.transmit()
    }

    /// The receive error counter, 0 to 255.
    pub fn receive_errors(&self) -> u16 {
        self.confinement.receive()
    }

    /// The number of error flags that it has begun to send, active and passive, since it was created.
    pub fn error_flags(&self) -> u64 {
        self.error_flags
    }

    /// The bit timing since the last join.
    pub fn timing(&self) -> BitTiming {
        self.clock.timing()
    }

    /// Whether it is in listen-only mode: it sends neither frames nor acknowledges.
    pub fn is_silent(&self) -> bool {
        self.silent
    }

    /// True between a join and the 11 recessive bits after it.
    pub fn is_joining(&self) -> bool {
        matches!(self.phase, Phase::Integrating { .. })
    }

    /// True when it takes part and there is no frame on the wire.
    pub fn is_idle(&self) -> bool {
        matches!(self.phase, Phase::Idle { .. })
    }

    /// True when it does not take a dominant bit for a start of frame: in an error or overload frame, and in the first two bits of
    /// the intermission. There it sees an error or an overload.
    pub fn refuses_start_of_frame(&self) -> bool {
        matches!(
            self.phase,
            Phase::ActiveFlag { .. }
                | Phase::PassiveFlag { .. }
                | Phase::OthersFlags { .. }
                | Phase::Delimiter(_)
                | Phase::Intermission(0..=1)
        )
    }

    /// The start of the current or the last frame: the beginning of its start of frame bit.
    pub fn frame_start(&self) -> Picoseconds {
        self.frame_start
    }

    /// The start of the bit that is sampled next; after a step that sampled one, the end of that bit.
    pub fn bit_start(&self) -> Picoseconds {
        self.clock.start()
    }

    /// True when the bit that is sampled next is the CRC delimiter.
    pub fn is_at_crc_delimiter(&self) -> bool {
        self.phase == Phase::CrcDelimiter
    }

    /// True when the bit that is sampled next is the ACK slot.
    pub fn is_at_ack_slot(&self) -> bool {
        self.phase == Phase::AckSlot
    }

    /// True in the end of frame.
    pub fn is_at_end_of_frame(&self) -> bool {
        matches!(self.phase, Phase::EndOfFrame(_))
    }

    /// True when it takes part and acknowledges the frames that it receives: it is not silent, joining or bus-off.
    pub fn can_acknowledge(&self) -> bool {
        let is_out = matches!(
            self.phase,
            Phase::Off | Phase::Integrating { .. } | Phase::BusOff { .. }
        );
        !self.silent && !is_out
    }

    /// True while it acknowledges, internally when it is silent: up to the end of the ACK slot. Its sample point is earlier.
    pub fn is_acknowledging(&self) -> bool {
        self.drives && matches!(self.phase, Phase::AckSlot | Phase::AckDelimiter)
    }

    /// In bus-off: starts to count 128 times 11 recessive bits. No effect in another state, or when it already counts.
    pub fn recover(&mut self, now: Picoseconds) {
        if let Phase::BusOff { sequences, .. } = &mut self.phase
            && sequences.is_none()
        {
            *sequences = Some(0);
            self.clock.catch_up(now);
        }
    }

    /// Sets the counters to zero and the state to error active, as a reset of the controller does; then it is off the bus.
    pub fn reset(&mut self) {
        self.leave();
        self.confinement = Confinement::default();
    }

    /// When the controller has to be stepped next; None while the wire is idle and no frame is offered. A time in the past means
    /// now.
    pub fn next_event(&self, offered: bool) -> Option<Picoseconds> {
        match self.phase {
            Phase::Off
            | Phase::BusOff {
                sequences: None, ..
            } => None,
            Phase::Idle { edge: false } => (offered && !self.silent).then(|| self.clock.start()),
            _ if self.drives != self.drives_next => Some(self.clock.start()),
            _ => Some(self.clock.sample()),
        }
    }

    /// The level that it drives now: true is dominant.
    pub fn is_dominant(&self) -> bool {
        self.drives && !self.silent
    }

    /// Reports a recessive to dominant edge of the wire; synchronizes.
    pub fn edge(&mut self, now: Picoseconds) {
        if !self.clock.takes_edge() {
            return;
        }
        match &mut self.phase {
            Phase::Off
            | Phase::BusOff {
                sequences: None, ..
            } => {}
            Phase::Idle { edge } => {
                *edge = true;
                self.clock.synchronize(now);
            }
            Phase::Integrating { .. } | Phase::Intermission(1..) | Phase::Suspend(_) => {
                self.clock.synchronize(now);
            }
            _ => self.clock.resynchronize(now, self.drives),
        }
    }

    /// Begins or samples the bit that is due at `now`. `dominant` is the level just before `now`; `offered` is the frame to be
    /// sent next, used only when a start of frame is possible ([`Self::takes_offer`]).
    pub fn step(
        &mut self,
        now: Picoseconds,
        dominant: bool,
        offered: Option<Frame>,
    ) -> Option<Event> {
        if let (Phase::Idle { edge: false }, Some(frame)) = (self.phase, offered)
            && !self.silent
            && self.clock.start() <= now
        {
            self.clock.restart(now);
            self.frame_start = now;
            let event = self.start(&frame);
            self.drives = true;
            self.drives_next = true;
            return Some(event);
        }
        if !self.is_on() || matches!(self.phase, Phase::Idle { edge: false }) {
            return None;
        }
        if self.clock.start() <= now {
            self.drives = self.drives_next;
        }
        if now < self.clock.sample() {
            return None;
        }
        // The level of a silent controller is looped back internally.
        let dominant = dominant || (self.silent && self.drives);
        let event = self.take(dominant, offered);
        self.drives_next = self.driven();
        self.clock.sampled(dominant);
        event
    }

    /// True when it would send a frame offered now, after the current frame, if any, and its intermission.
    pub fn can_send(&self) -> bool {
        !self.silent
            && !matches!(
                self.phase,
                Phase::Off | Phase::Integrating { .. } | Phase::BusOff { .. } | Phase::Suspend(_)
            )
    }

    /// True when a step may begin a frame and reads the offered frame.
    pub fn takes_offer(&self) -> bool {
        matches!(self.phase, Phase::Idle { .. } | Phase::Intermission(2))
    }
}

#[cfg(test)]
mod tests;
