//! Errors: the emergency producer with its inhibit time, the error register and the history (CiA 301, 7.2.7; objects 1001h,
//! 1003h, 1015h).
//!
//! ```text
//!  byte 0      2                3                        4         8
//!       +------+----------------+------------------------+---------+
//!       | code | error register | manufacturer's status  | 0       |
//!       | u16  | (1001h)        | (active faults)        |         |
//!       +------+----------------+------------------------+---------+
//! ```
//!
//! When a fault begins, an emergency message with its error code is sent. When it ends, a message with code 0000h (error reset)
//! is sent. Only the beginning is stored in the history.

use crate::application::Faults;
use crate::mistake::Origin;
use crate::time::{Deadline, Duration, Instant};
use crate::walk::{each, put};
use heapless::Deque;

/// The cause of a fault.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Cause {
    /// No cause: the bit is reserved.
    Never,
    /// At least one of these faults of the application is active.
    Application(Faults),
    /// An access to the nonvolatile memory failed.
    Memory,
    /// Received frames were lost.
    Overrun,
    /// The CAN controller is error passive.
    Passive,
    /// Life guarding timed out, or the heartbeat of a monitored node is lost.
    Guarding,
    /// The CAN controller has recovered from bus-off.
    BusOff,
}

/// A bit of the manufacturer's status byte, with the emergency message of its fault.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct FaultBit {
    /// The name of the fault.
    pub name: &'static str,
    /// What sets and clears the fault.
    pub cause: Cause,
    /// The emergency error code in the first two bytes of the message.
    pub code: u16,
    /// Its bits in the error register, besides bit 0 (generic error).
    pub register: u8,
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

impl FaultBit {
    /// A bit that no fault sets.
    pub const RESERVED: Self = Self {
        name: "",
        cause: Cause::Never,
        code: 0,
        register: 0,
        origin: Origin::here(),
    };
}

/// Bit 2 of the error register: voltage.
pub const VOLTAGE: u8 = 1 << 2;
/// Bit 3 of the error register: temperature.
pub const TEMPERATURE: u8 = 1 << 3;
/// Bit 4 of the error register: communication.
pub const COMMUNICATION: u8 = 1 << 4;

/// Received frames were lost (CiA 301: CAN overrun).
pub const OVERRUN: FaultBit = fault("CAN overrun", Cause::Overrun, 0x8110, COMMUNICATION);
/// The CAN controller is error passive.
pub const PASSIVE: FaultBit = fault("CAN error passive", Cause::Passive, 0x8120, COMMUNICATION);
/// Life guarding timed out, or the heartbeat of a monitored node is lost.
pub const GUARDING: FaultBit = fault("life guarding", Cause::Guarding, 0x8130, COMMUNICATION);
/// The CAN controller has recovered from bus-off.
pub const BUS_OFF: FaultBit = fault(
    "recovered from bus-off",
    Cause::BusOff,
    0x8140,
    COMMUNICATION,
);

/// The faults of a sensor with the emergency error codes of CiA 301, table 26.
pub const CIA_301: [FaultBit; 8] = [
    fault("sensor", Cause::Application(Faults::SENSOR), 0x5000, 0),
    fault("range", Cause::Application(Faults::RANGE), 0x9000, 0),
    fault("memory", Cause::Memory, 0x6300, 0),
    OVERRUN,
    PASSIVE,
    GUARDING,
    BUS_OFF,
    FaultBit::RESERVED,
];

/// A fault that is announced with this code.
#[track_caller]
pub const fn fault(name: &'static str, cause: Cause, code: u16, register: u8) -> FaultBit {
    FaultBit {
        name,
        cause,
        code,
        register,
        origin: Origin::here(),
    }
}

/// A [`FaultBit`] in the form that the device uses.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Fault {
    code: u16,
    register: u8,
}

/// Projects the description of the faults.
pub(super) const fn faults(bits: &[FaultBit; 8]) -> [Fault; 8] {
    let mut faults = [Fault {
        code: 0,
        register: 0,
    }; 8];
    each!(place, FaultBit { code, register, .. } in bits => {
        put(&mut faults, place, Fault { code: *code, register: *register });
    });
    faults
}

/// The faults of the application that cause each bit of the status byte, from bit 0 on.
pub(super) type Causes = [Faults; 8];

/// Projects the causes of the faults.
pub(super) const fn causes(bits: &[FaultBit; 8]) -> Causes {
    let mut causes = [Faults::NONE; 8];
    each!(place, bit in bits => {
        if let Cause::Application(faults) = bit.cause {
            put(&mut causes, place, faults);
        }
    });
    causes
}

/// The bits of the status byte that these faults of the application cause. No loop, because a frame can wait: with constant causes, a
/// bit without cause needs no instruction.
pub(super) const fn caused([a, b, c, d, e, f, g, h]: Causes, faults: Faults) -> u8 {
    const fn bit(number: u8, cause: Faults, faults: Faults) -> u8 {
        (cause.intersects(faults) as u8) << number
    }
    let low = bit(0, a, faults) | bit(1, b, faults) | bit(2, c, faults) | bit(3, d, faults);
    let high = bit(4, e, faults) | bit(5, f, faults) | bit(6, g, faults) | bit(7, h, faults);
    low | high
}

/// The bits with this cause, which must not be [`Cause::Application`].
pub(super) const fn bits_of(bits: &[FaultBit; 8], cause: Cause) -> u8 {
    let mut mask = 0;
    each!(place, bit in bits => { mask |= (is_same(bit.cause, cause) as u8) << place });
    mask
}

/// The event with this cause.
pub(super) const fn event_of(events: &[FaultBit], cause: Cause) -> Option<Fault> {
    each!(FaultBit { cause: own, code, register, .. } in events => {
        if is_same(*own, cause) {
            return Some(Fault { code: *code, register: *register });
        }
    });
    None
}

/// Whether both are the same cause, which is not [`Cause::Application`].
pub(super) const fn is_same(one: Cause, other: Cause) -> bool {
    matches!(
        (one, other),
        (Cause::Memory, Cause::Memory)
            | (Cause::Overrun, Cause::Overrun)
            | (Cause::Passive, Cause::Passive)
            | (Cause::Guarding, Cause::Guarding)
            | (Cause::BusOff, Cause::BusOff)
    )
}

/// Bit 0 of the error register: generic error.
const GENERIC: u8 = 1 << 0;

/// The maximum number of queued emergency messages. When the queue is full, the oldest is dropped; the history keeps its error.
const WAITING: usize = 8;

/// The history of errors (1003h). An error is the first four bytes of its emergency message: code, error register, status byte.
pub trait History: Send + 'static {
    /// The history before the first error.
    const EMPTY: Self;
    /// The maximum number of errors. When the history is full, the oldest error is removed.
    const CAPACITY: usize;

    /// Adds an error as the newest one. The oldest one goes if there is no room.
    fn push(&mut self, error: u32);

    /// The number of errors in it (1003h:00).
    fn count(&self) -> usize;

    /// The error at an index; 0 is the newest.
    fn get(&self, place: usize) -> Option<u32>;

    /// Removes all errors, as a write of 0 to 1003h:00 does.
    fn clear(&mut self);
}

impl<const N: usize> History for Deque<u32, N> {
    const EMPTY: Self = Self::new();
    const CAPACITY: usize = N;

    fn push(&mut self, error: u32) {
        if self.is_full() {
            self.pop_back();
        }
        let _ = self.push_front(error);
    }

    fn count(&self) -> usize {
        self.len()
    }

    fn get(&self, place: usize) -> Option<u32> {
        self.iter().nth(place).copied()
    }

    fn clear(&mut self) {
        Deque::clear(self);
    }
}

/// The faults of one node, with a history `H`.
#[derive(Debug)]
pub(super) struct Emergency<H> {
    /// The fault of each bit of the status byte, from bit 0 on; None before the start.
    faults: Option<&'static [Fault; 8]>,
    /// Active faults for which a message was queued: the manufacturer's status byte.
    active: u8,
    /// Active faults, including the changes of the application for which no message was queued yet.
    wanted: u8,
    /// The active faults of the last message that was sent.
    told: u8,
    waiting: Deque<[u8; 4], WAITING>,
    /// No messages are queued: the node is in NMT stopped.
    silent: bool,
    history: H,
    inhibit: Duration,
    inhibited: Deadline,
}

impl<H: History> Emergency<H> {
    /// The state before the start: no fault is active, and no message is sent.
    pub const INITIAL: Self = Self {
        faults: None,
        active: 0,
        wanted: 0,
        told: 0,
        waiting: Deque::new(),
        silent: false,
        history: H::EMPTY,
        inhibit: Duration::from_ticks(0),
        inhibited: Deadline::NEVER,
    };

    /// Starts without active faults. `faults` has the fault of each bit of the status byte, from bit 0 on.
    pub fn start(&mut self, faults: &'static [Fault; 8]) {
        self.faults = Some(faults);
    }

    /// The fault of each bit of the status byte.
    fn faults(&self) -> &'static [Fault] {
        self.faults.map_or(&[], |faults| faults)
    }

    /// Resets the active faults, the messages, the history and the inhibit time.
    pub fn reset(&mut self) {
        // Not a copy of `INITIAL`: it would be 280 bytes of flash.
        self.active = 0;
        self.wanted = 0;
        self.waiting.clear();
        self.silent = false;
        self.history.clear();
        self.inhibit = Duration::from_ticks(0);
        self.inhibited = Deadline::NEVER;
    }

    /// Sets the inhibit time, in 100 us. A running one counts from the same message.
    pub fn configure(&mut self, inhibit: u32) {
        let before = self.inhibit;
        self.inhibit = Duration::from_ticks(u64::from(inhibit) * 100);
        self.inhibited = self.inhibited.with_delay(before, self.inhibit);
    }

    /// Sets the faults in `mask` to `bits`. [`announce_next`](Self::announce_next) queues the messages.
    pub fn want(&mut self, mask: u8, bits: u8) {
        self.wanted = self.wanted & !mask | bits & mask;
    }

    /// Queues the message for one fault of the application that has begun or ended. Returns true if there is another one. A call handles
    /// one fault, because received frames can wait until it returns.
    pub fn announce_next(&mut self) -> bool {
        let changed = self.active ^ self.wanted;
        if changed == 0 {
            return false;
        }
        let rest = changed & changed.wrapping_sub(1);
        self.announce(changed ^ rest, true);
        rest != 0
    }

    /// Sets the faults in `mask` to `bits`. Queues a message for each fault that begins or ends.
    pub fn update(&mut self, mask: u8, bits: u8) {
        self.want(mask, bits);
        let changed = (self.active ^ bits) & mask;
        if changed != 0 {
            self.announce(changed, true);
        }
    }

    /// Changes these faults. Queues a message for each. `is_new`: a fault that begins is stored in the history.
    #[cold]
    fn announce(&mut self, changed: u8, is_new: bool) {
        let mut rest = changed;
        // Visits only the changed faults, because received frames wait until this loop ends.
        while let Some(fault) = self.faults().get(rest.trailing_zeros() as usize) {
            let bit = rest & rest.wrapping_neg();
            rest ^= bit;
            self.active ^= bit;
            let begins = self.active & bit != 0;
            let code = if begins { fault.code } else { 0 };
            let message = self.message(code, 0);
            self.queue(message);
            if begins && is_new {
                self.history.push(u32::from_le_bytes(message));
            }
        }
    }

    /// A message with these bits besides those of the active faults in its error register.
    fn message(&self, code: u16, register: u8) -> [u8; 4] {
        let [low, high] = code.to_le_bytes();
        [low, high, self.register() | register, self.active]
    }

    fn queue(&mut self, message: [u8; 4]) {
        if self.silent {
            return;
        }
        if self.waiting.is_full() {
            self.waiting.pop_front();
        }
        let _ = self.waiting.push_back(message);
    }

    /// Discards the queued messages and queues no more. Active faults and the history continue.
    pub fn silence(&mut self) {
        self.silent = true;
        self.waiting.clear();
    }

    /// A reset of the communication: replaces the queued messages by one for each active fault, and queues messages again.
    pub fn restart(&mut self) {
        self.told = 0;
        self.resume();
    }

    /// Leaves NMT stopped: queues a message for each active fault, and one error reset if a fault has ended of which the master was told.
    pub fn resume(&mut self) {
        self.silent = false;
        self.waiting.clear();
        let has_ended = self.told & !self.active != 0;
        let active = core::mem::take(&mut self.active);
        self.announce(active, false);
        if has_ended {
            self.queue(self.message(0, 0));
        }
    }

    /// Notes that this message was sent: the master knows these faults.
    pub fn told(&mut self, message: &[u8; 8]) {
        let [_, _, _, active, ..] = *message;
        self.told = active;
    }

    /// A momentary fault: queues the error, then the error reset.
    pub fn event(&mut self, bits: u8) {
        self.update(bits, bits);
        self.update(bits, 0);
    }

    /// A momentary fault without a bit in the status byte: queues the error, then the error reset. If the queue has no room for both
    /// messages, only the history has the fault, so that it does not displace the message of a lasting fault.
    pub fn momentary(&mut self, event: Fault) {
        let message = self.message(event.code, GENERIC | event.register);
        self.history.push(u32::from_le_bytes(message));
        if self.waiting.len() + 2 <= WAITING {
            self.queue(message);
            self.queue(self.message(0, 0));
        }
    }

    /// The history.
    pub fn history_mut(&mut self) -> &mut H {
        &mut self.history
    }

    /// The active faults, as bits of the status byte.
    pub fn active(&self) -> u8 {
        self.active
    }

    /// The error register (1001h): the bits of all active faults.
    pub fn register(&self) -> u8 {
        let (mut register, mut rest) = (0, self.active);
        while let Some(fault) = self.faults().get(rest.trailing_zeros() as usize) {
            register |= GENERIC | fault.register;
            rest &= rest.wrapping_sub(1);
        }
        register
    }

    /// The number of errors in the history.
    pub fn count(&self) -> u32 {
        self.history.count() as u32
    }

    /// The error at `sub` (1 is the newest); 0 if there is none.
    #[inline(never)] // measured: inlined, it delays the answer to each read
    pub fn entry(&self, sub: u8) -> u32 {
        let place = usize::from(sub).checked_sub(1);
        place.and_then(|place| self.history.get(place)).unwrap_or(0)
    }

    pub fn clear_history(&mut self) {
        self.history.clear();
    }

    /// Whether a message is queued and the inhibit time has ended.
    pub fn is_due(&mut self, now: Instant) -> bool {
        if self.inhibited.is_reached(now) {
            self.inhibited = Deadline::NEVER;
        }
        self.is_waiting() && !self.inhibited.is_set()
    }

    /// Removes the next message from the queue and starts the inhibit time.
    pub fn take(&mut self, now: Instant) -> Option<[u8; 8]> {
        let [low, high, register, status] = self.waiting.pop_front()?;
        if self.inhibit.ticks() > 0 {
            self.inhibited = Deadline::after(now, self.inhibit);
        }
        Some([low, high, register, status, 0, 0, 0, 0])
    }

    /// True while messages are queued.
    pub fn is_waiting(&self) -> bool {
        !self.waiting.is_empty()
    }

    /// The end of the inhibit time, if a message waits for it.
    pub fn deadline(&self) -> Deadline {
        if self.is_waiting() {
            self.inhibited
        } else {
            Deadline::NEVER
        }
    }
}

#[cfg(test)]
mod tests;
