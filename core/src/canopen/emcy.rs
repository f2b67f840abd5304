//! Errors: the emergency producer with its inhibit time, the error register and the history (CiA 301, 7.2.7; objects 1001h,
//! 1003h, 1015h).
//!
//! ```text
//!  byte 0      2                3                            4         8
//!       +------+----------------+----------------------------+---------+
//!       | code | error register | manufacturer's status      | 0       |
//!       | u16  | (1001h)        | (the faults that are now)  |         |
//!       +------+----------------+----------------------------+---------+
//! ```
//!
//! A fault is announced when it begins, with its code, and when it ends, with code 0; only its beginning is history.

use crate::time::{Duration, Instant, after, is_due};
use heapless::Deque;

/// There is no valid measurement.
pub const SENSOR: u8 = 1 << 0;
/// The inclination is beyond the measuring range.
pub const LIMIT: u8 = 1 << 1;
/// The temperature is out of its range.
pub const TEMPERATURE: u8 = 1 << 2;
/// The nonvolatile memory failed.
pub const HARDWARE: u8 = 1 << 3;
/// Received frames were lost.
pub const OVERRUN: u8 = 1 << 4;
/// The CAN controller is error passive.
pub const PASSIVE: u8 = 1 << 5;
/// The guarding master is silent.
pub const GUARDING: u8 = 1 << 6;
/// The CAN controller was bus-off.
pub const BUS_OFF: u8 = 1 << 7;

/// Bit 0 of the error register: any error.
const GENERIC: u8 = 1 << 0;

/// How a fault is told.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Fault {
    /// The emergency error code.
    pub code: u16,
    /// Its bits of the error register, besides the generic one.
    pub register: u8,
}

/// Emergency messages that wait; the oldest of more is dropped, the history has it.
const WAITING: usize = 8;

/// The number of errors in the history.
pub const HISTORY: usize = 50;

/// The faults of one sensor.
#[derive(Debug)]
pub struct Emergency {
    faults: &'static [Fault; 8],
    /// The faults that are now: the manufacturer's status register.
    present: u8,
    waiting: Deque<[u8; 4], WAITING>,
    history: Deque<u32, HISTORY>,
    inhibit: Duration,
    inhibited: Option<Instant>,
}

impl Emergency {
    /// No faults; `faults` says how each bit of the status register is told, from bit 0 on.
    pub fn new(faults: &'static [Fault; 8]) -> Self {
        Self {
            faults,
            present: 0,
            waiting: Deque::new(),
            history: Deque::new(),
            inhibit: Duration::from_ticks(0),
            inhibited: None,
        }
    }

    /// Sets the inhibit time, in 100 us.
    pub fn configure(&mut self, inhibit: u32) {
        self.inhibit = Duration::from_ticks(u64::from(inhibit) * 100);
    }

    /// The faults of `mask` are now those of `bits`; announces what has begun or ended.
    pub fn update(&mut self, mask: u8, bits: u8) {
        let changed = (self.present ^ bits) & mask;
        if changed != 0 {
            self.announce(changed);
        }
    }

    #[cold]
    fn announce(&mut self, changed: u8) {
        for (bit, fault) in self.faults.iter().enumerate() {
            let bit = 1 << bit;
            if changed & bit == 0 {
                continue;
            }
            self.present ^= bit;
            if self.present & bit == 0 {
                self.queue(0);
            } else {
                self.queue(fault.code);
                if self.history.is_full() {
                    self.history.pop_back();
                }
                let entry = u32::from(self.present) << 16 | u32::from(fault.code);
                let _ = self.history.push_front(entry);
            }
        }
    }

    fn queue(&mut self, code: u16) {
        if self.waiting.is_full() {
            self.waiting.pop_front();
        }
        let [low, high] = code.to_le_bytes();
        let message = [low, high, self.register(), self.present];
        let _ = self.waiting.push_back(message);
    }

    /// A fault that is over at once.
    pub fn event(&mut self, bit: u8) {
        self.update(bit, bit);
        self.update(bit, 0);
    }

    /// The faults that are now.
    pub fn present(&self) -> u8 {
        self.present
    }

    /// The error register (1001h).
    pub fn register(&self) -> u8 {
        let register = |bit: usize| self.faults.get(bit).map_or(0, |fault| fault.register);
        (0..8)
            .filter(|bit| self.present >> bit & 1 != 0)
            .fold(0, |bits, bit| bits | GENERIC | register(bit))
    }

    /// The number of errors in the history.
    pub fn count(&self) -> u32 {
        self.history.len() as u32
    }

    /// The error at `sub` (1 is the newest): its code, and the status register above it; 0 when there are fewer.
    pub fn entry(&self, sub: u8) -> u32 {
        let place = usize::from(sub).checked_sub(1);
        place
            .and_then(|place| self.history.iter().nth(place))
            .map_or(0, |entry| *entry)
    }

    /// Forgets the history.
    pub fn clear_history(&mut self) {
        self.history.clear();
    }

    /// Whether a message waits and the inhibit time is over.
    pub fn is_due(&mut self, now: Instant) -> bool {
        if is_due(&self.inhibited, now) {
            self.inhibited = None;
        }
        self.is_waiting() && self.inhibited.is_none()
    }

    /// Takes the next message out; it goes onto the bus now.
    pub fn take(&mut self, now: Instant) -> Option<[u8; 8]> {
        let [low, high, register, status] = self.waiting.pop_front()?;
        if self.inhibit.ticks() > 0 {
            self.inhibited = Some(after(now, self.inhibit));
        }
        Some([low, high, register, status, 0, 0, 0, 0])
    }

    /// True while messages wait.
    pub fn is_waiting(&self) -> bool {
        !self.waiting.is_empty()
    }

    /// The end of the inhibit time, while it holds a message back.
    pub fn deadline(&self) -> Option<Instant> {
        self.inhibited.filter(|_| self.is_waiting())
    }
}
