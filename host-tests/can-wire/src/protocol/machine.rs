//! The meaning of a sampled bit: the states of a controller and their transitions (ISO 11898-1, medium access control).

use super::coding::{Incoming, Outgoing};
use super::confinement::Role;
use super::flags::Cost;
use super::{ErrorCode, Event, Protocol};
use plumbline::can::Frame;

/// Recessive bits after which a controller treats the bus as idle.
const INTEGRATION: u8 = 11;

/// Number of these sequences needed to leave bus-off.
const RECOVERY: u8 = 128;

/// The bits of an error or overload flag.
pub(super) const FLAG: u8 = 6;

/// The bits of an error or overload delimiter.
const DELIMITER: u8 = 8;

/// The bits of the end of frame.
const END_OF_FRAME: u8 = 7;

/// The bits of the intermission.
const INTERMISSION: u8 = 3;

/// The bits of suspend transmission: an error passive transmitter waits after the intermission.
const SUSPEND: u8 = 8;

/// The meaning of the next bit for a controller. Numbers count the bits that have ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) enum Phase {
    #[default]
    Off,
    Integrating {
        recessive: u8,
    },
    /// `sequences` of 11 recessive bits have been seen; None: recovery has not been requested.
    BusOff {
        sequences: Option<u8>,
        recessive: u8,
    },
    /// The bit clock stops until there is an edge, or a frame to be sent.
    Idle {
        edge: bool,
    },
    /// From start of frame to CRC sequence.
    Stuffed,
    CrcDelimiter,
    AckSlot,
    AckDelimiter,
    EndOfFrame(u8),
    ActiveFlag {
        kind: Flag,
        sent: u8,
    },
    /// Ends after six equal bits. `unacknowledged`: the error counts only if a bit is dominant.
    PassiveFlag {
        equal: u8,
        dominant: bool,
        unacknowledged: bool,
    },
    /// The flags of others, which may end later than its own.
    OthersFlags {
        kind: Flag,
        dominant: u8,
    },
    Delimiter(u8),
    Intermission(u8),
    Suspend(u8),
}

/// The meaning of a flag.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Flag {
    Error,
    Overload,
}

impl Protocol {
    /// The level that it drives in the next bit; true is dominant.
    pub(super) fn driven(&self) -> bool {
        match self.phase {
            Phase::Stuffed => self.outgoing.is_some_and(|out| !out.next(&self.incoming)),
            Phase::AckSlot => !self.transmitter && self.incoming.is_intact(),
            Phase::ActiveFlag { .. } => true,
            _ => false,
        }
    }

    /// Begins its own frame with the start of frame.
    pub(super) fn start(&mut self, frame: &Frame) -> Event {
        self.incoming = Incoming::default();
        self.outgoing = Some(Outgoing::new(frame));
        self.transmitter = true;
        self.phase = Phase::Stuffed;
        Event::Started
    }

    /// Processes a bit. `offered` is a frame that may be sent.
    pub(super) fn take(&mut self, dominant: bool, offered: Option<Frame>) -> Option<Event> {
        match self.phase {
            Phase::Off => None,
            Phase::Integrating { recessive } => self.integrate(dominant, recessive),
            Phase::BusOff {
                sequences,
                recessive,
            } => self.count_for_recovery(dominant, sequences, recessive),
            Phase::Idle { .. } if dominant => self.see_start_of_frame(offered),
            Phase::Idle { .. } => self.go(Phase::Idle { edge: false }),
            Phase::Stuffed => self.take_stuffed(dominant),
            Phase::CrcDelimiter if dominant => self.wrong_delimiter(),
            Phase::CrcDelimiter => self.go(Phase::AckSlot),
            Phase::AckSlot => self.acknowledge(dominant),
            Phase::AckDelimiter if dominant => self.wrong_delimiter(),
            Phase::AckDelimiter if !self.transmitter && !self.incoming.is_intact() => {
                self.fail(ErrorCode::Crc)
            }
            Phase::AckDelimiter => self.go(Phase::EndOfFrame(0)),
            Phase::EndOfFrame(over) => self.end_frame(dominant, over),
            Phase::ActiveFlag { .. } if !dominant => {
                self.raise_flag(ErrorCode::BitDominant, Cost::Serious)
            }
            Phase::ActiveFlag { kind, sent } if sent + 1 == FLAG => {
                self.go(Phase::OthersFlags { kind, dominant: 0 })
            }
            Phase::ActiveFlag { kind, sent } => {
                let sent = sent + 1;
                self.go(Phase::ActiveFlag { kind, sent })
            }
            Phase::PassiveFlag {
                equal,
                dominant: last,
                unacknowledged,
            } => {
                let equal = if dominant == last { equal + 1 } else { 1 };
                self.wait_for_six(dominant, equal, unacknowledged)
            }
            Phase::OthersFlags { .. } if !dominant => self.go(Phase::Delimiter(1)),
            Phase::OthersFlags { kind, dominant } => self.outlast(kind, dominant),
            Phase::Delimiter(over) if dominant => {
                if over + 1 == DELIMITER {
                    self.overload()
                } else {
                    self.fail(ErrorCode::Form)
                }
            }
            Phase::Delimiter(over) if over + 1 == DELIMITER => self.go(Phase::Intermission(0)),
            Phase::Delimiter(over) => self.go(Phase::Delimiter(over + 1)),
            Phase::Intermission(over) => self.pause(dominant, over, offered),
            Phase::Suspend(_) if dominant => self.see_start_of_frame(None),
            Phase::Suspend(over) if over + 1 == SUSPEND => self.go(Phase::Idle { edge: false }),
            Phase::Suspend(over) => self.go(Phase::Suspend(over + 1)),
        }
    }

    pub(super) fn go(&mut self, phase: Phase) -> Option<Event> {
        self.phase = phase;
        None
    }

    pub(super) fn role(&self) -> Role {
        if self.transmitter {
            Role::Transmitter
        } else {
            Role::Receiver
        }
    }

    fn integrate(&mut self, dominant: bool, recessive: u8) -> Option<Event> {
        let recessive = if dominant { 0 } else { recessive + 1 };
        if recessive < INTEGRATION {
            return self.go(Phase::Integrating { recessive });
        }
        self.phase = Phase::Idle { edge: false };
        Some(Event::Joined)
    }

    fn count_for_recovery(
        &mut self,
        dominant: bool,
        sequences: Option<u8>,
        recessive: u8,
    ) -> Option<Event> {
        let recessive = if dominant { 0 } else { recessive + 1 };
        let full = recessive == INTEGRATION;
        let sequences = sequences.map(|seen| seen + u8::from(full));
        if sequences == Some(RECOVERY) {
            self.confinement = Default::default();
            self.phase = Phase::Idle { edge: false };
            return Some(Event::Recovered);
        }
        self.go(Phase::BusOff {
            sequences,
            recessive: if full { 0 } else { recessive },
        })
    }

    /// Another controller's start of frame has been sampled. A controller with a frame to send continues with its identifier.
    fn see_start_of_frame(&mut self, offered: Option<Frame>) -> Option<Event> {
        let offered = offered.filter(|_| !self.silent);
        self.frame_start = self.clock.start();
        self.outgoing = None;
        self.transmitter = false;
        self.incoming = Incoming::default();
        let event = offered.map(|frame| self.start(&frame));
        self.phase = Phase::Stuffed;
        // The first bit cannot be a stuff error.
        let _ = self.incoming.push(false);
        event
    }

    fn take_stuffed(&mut self, dominant: bool) -> Option<Event> {
        let mut event = None;
        if let Some(outgoing) = self.outgoing {
            let recessive = outgoing.next(&self.incoming);
            if !recessive && !dominant {
                return self.fail(ErrorCode::BitDominant);
            }
            if recessive && dominant {
                if !self.incoming.in_arbitration() {
                    return self.fail(ErrorCode::BitRecessive);
                }
                if self.incoming.stuff_is_due() {
                    // Another controller has sent one dominant bit too many: not an error of the transmitter.
                    return self.raise_flag(ErrorCode::Stuff, Cost::Nothing);
                }
                self.outgoing = None;
                self.transmitter = false;
                event = Some(Event::LostArbitration);
            }
        }
        if self.incoming.push(!dominant).is_err() {
            return self.fail(ErrorCode::Stuff);
        }
        if self.incoming.is_complete() {
            self.phase = Phase::CrcDelimiter;
        }
        event
    }

    fn wrong_delimiter(&mut self) -> Option<Event> {
        self.fail(if self.transmitter {
            ErrorCode::BitRecessive
        } else {
            ErrorCode::Form
        })
    }

    fn acknowledge(&mut self, dominant: bool) -> Option<Event> {
        if self.transmitter && !dominant {
            return self.fail(ErrorCode::Acknowledgment);
        }
        if self.driven() {
            if !dominant {
                return self.fail(ErrorCode::BitDominant);
            }
            self.confinement.success(Role::Receiver);
        }
        self.go(Phase::AckDelimiter)
    }

    /// The frame is valid for a receiver at the last bit but one of EOF, for the transmitter at the last bit.
    fn end_frame(&mut self, dominant: bool, over: u8) -> Option<Event> {
        let last = over + 1 == END_OF_FRAME;
        if dominant {
            return if last && !self.transmitter {
                self.overload()
            } else {
                self.wrong_delimiter()
            };
        }
        self.phase = if last {
            Phase::Intermission(0)
        } else {
            Phase::EndOfFrame(over + 1)
        };
        if last && self.transmitter {
            self.confinement.success(Role::Transmitter);
            self.outgoing = None;
            return Some(Event::Transmitted);
        }
        if over + 2 == END_OF_FRAME && !self.transmitter {
            return self.incoming.frame().map(Event::Received);
        }
        None
    }

    fn pause(&mut self, dominant: bool, over: u8, offered: Option<Frame>) -> Option<Event> {
        let last = over + 1 == INTERMISSION;
        let suspended = self.transmitter && self.confinement.is_passive();
        if dominant && !last {
            return self.overload();
        }
        if dominant {
            return self.see_start_of_frame(offered.filter(|_| !suspended));
        }
        if last {
            self.transmitter = false;
        }
        self.go(match (last, suspended) {
            (false, _) => Phase::Intermission(over + 1),
            (true, true) => Phase::Suspend(0),
            (true, false) => Phase::Idle { edge: false },
        })
    }
}
