//! The CAN protocol of ISO 11898-1, bit by bit: what is common to every CAN controller, whatever its registers look like.

use plumbline::can::Frame;
use plumbline::node::BusState;

/// A point in time, or a length of time, in picoseconds: a bit of each of the ten rates and a clock cycle of 64 MHz are whole
/// numbers of them. 64 bits hold 213 days.
pub type Picoseconds = u64;

/// How a controller divides a bit.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct BitTiming {
    /// The length of a bit.
    pub bit: Picoseconds,
    /// From the start of a bit to its sample point.
    pub sample: Picoseconds,
    /// How far one resynchronization may move the sample point (SJW).
    pub jump: Picoseconds,
}

/// What a controller found wrong; the numbers are those of bxCAN's last error code (RM0008, CAN_ESR.LEC).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum ErrorCode {
    /// More than five equal bits in a stuffed field.
    Stuff = 1,
    /// A bit of fixed value was wrong.
    Form = 2,
    /// Nobody acknowledged.
    Acknowledgment = 3,
    /// Recessive was sent, dominant was on the wire.
    BitRecessive = 4,
    /// Dominant was sent, recessive was on the wire.
    BitDominant = 5,
    /// The checksum does not match.
    Crc = 6,
}

/// What a step brought.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Event {
    /// 11 recessive bits have been seen: the controller takes part in the bus (after a join).
    Joined,
    /// The frame that was offered is on its way: its start of frame has begun.
    Started,
    /// The frame on its way has lost arbitration; it stays to be offered again.
    LostArbitration,
    /// The frame on its way has ended well.
    Transmitted,
    /// Another's frame has ended well.
    Received(Frame),
    /// An error was seen; `transmitting` when it destroyed the own frame, which stays to be offered again.
    Error {
        /// What was wrong.
        code: ErrorCode,
        /// The controller was the transmitter.
        transmitting: bool,
    },
    /// The recovery from bus-off has ended.
    Recovered,
}

/// The protocol state machine of one controller.
#[derive(Debug, Default)]
pub struct Protocol {}

impl Protocol {
    /// Begins to take part with this timing: after 11 recessive bits comes [`Event::Joined`]. Silent: sees its own dominant bits,
    /// but does not drive them. The error counters stay.
    pub fn join(&mut self, _now: Picoseconds, _timing: BitTiming, _silent: bool) {}

    /// Takes no part any more, at once; a frame on its way is torn off. The error counters stay.
    pub fn leave(&mut self) {}

    /// True from join to leave.
    pub fn is_on(&self) -> bool {
        false
    }

    /// True while a frame is under way, one's own or another's, error frame and intermission included: what bxCAN waits for
    /// before it acknowledges initialization mode.
    pub fn is_busy(&self) -> bool {
        false
    }

    /// True while the own frame is under way.
    pub fn is_transmitting(&self) -> bool {
        false
    }

    /// The fault confinement state.
    pub fn state(&self) -> BusState {
        BusState::Active
    }

    /// The transmit error counter, 0 to 255 (bus-off: 255).
    pub fn transmit_errors(&self) -> u16 {
        0
    }

    /// The receive error counter.
    pub fn receive_errors(&self) -> u16 {
        0
    }

    /// From bus-off: begin to count 128 times 11 recessive bits.
    pub fn recover(&mut self, _now: Picoseconds) {}

    /// Sets the counters to zero and the state to active, as a reset of the controller does.
    pub fn reset(&mut self) {}

    /// When the controller has to be stepped next; None while the wire is quiet and nothing is offered.
    pub fn next_event(&self, _offered: bool) -> Option<Picoseconds> {
        None
    }

    /// The level that it drives now: true is dominant.
    pub fn is_dominant(&self) -> bool {
        false
    }

    /// The wire has gone from recessive to dominant: synchronizes.
    pub fn edge(&mut self, _now: Picoseconds) {}

    /// Does what is due at `now`: begins a bit or samples one. `offered` is the frame to be sent next, asked for at the moment at
    /// which a start of frame is possible.
    pub fn step(
        &mut self,
        _now: Picoseconds,
        _dominant: bool,
        _offered: Option<Frame>,
    ) -> Option<Event> {
        None
    }
}
