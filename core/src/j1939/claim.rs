//! Address claim (SAE J1939-81, 4.4): the address of the node and its defence.
//!
//! ```text
//!  18EEFFSA  8 bytes: the NAME. SA is the claimed address, or 254: cannot claim.
//!
//!             +-----------+  250 ms  +----------+
//!   start --> | claiming  | -------> | claimed  |
//!             +-----------+          +----------+
//!               |   ^  lower NAME at      |
//!               |   |  our address: next  |
//!               v   |  address            |
//!             +--------------+            |
//!             | cannot claim | <----------+   no other address
//!             +--------------+
//! ```
//!
//! A node that is arbitrary address capable takes the next free address above its own in 128..247, after 247 from 128 on. An
//! address is free if no claim of another node for it was received.

use super::identifier::{ADDRESS_CLAIMED, GLOBAL, Identifier, NO_ADDRESS};
use super::name::Name;
use crate::can::Frame;
use crate::time::{Deadline, Duration, Instant, millis};

/// The time without contention after which the address is ours.
pub const SILENCE: Duration = millis(250);

/// The addresses that a node takes by itself.
const FIRST: u8 = 128;
const COUNT: u8 = 120;

/// The number of random delays, in steps of 1 ms: 0..153 ms.
const DELAYS: u32 = 154;

/// The state of the address.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)] // off is 0, so that it needs no flash in static memory
pub enum State {
    /// The node has not started, or it has stopped: it neither sends nor contends.
    Off,
    /// The address is claimed, and others can contend for it.
    Claiming,
    /// The node has its address: it sends and receives messages.
    Claimed,
    /// There is no address that the node may take: it sends "cannot claim" from [`NO_ADDRESS`], and nothing else.
    CannotClaim,
}

/// The result of a claim of another node.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Outcome {
    /// The other claim does not contend for our address.
    None,
    /// The claim must be sent again at once.
    Defended,
    /// The address was left. Nothing more may be sent from it. A claim for another address must be sent, unless there is none.
    Left,
}

/// The address of a node.
#[derive(Clone, Debug)]
pub struct Claim {
    name: Name,
    state: State,
    /// The address in the last claim. It is ours in [`State::Claimed`].
    address: u8,
    /// The claim is queued, and not sent yet: the silence has not begun. Cannot claim: the same for its message, and after bus-off.
    queued: bool,
    /// Claiming: the end of the silence. Cannot claim, or after a failed claim: the end of the delay before it is sent.
    due: Deadline,
    /// Claiming: the claim has failed and is sent again after the delay.
    failed: bool,
    /// The addresses from 128 on that other nodes were heard to claim, a bit for each.
    heard: [u32; 4],
    random: u32,
}

impl Claim {
    /// Not started. All bits are 0.
    pub const OFF: Self = Self {
        name: Name(0),
        state: State::Off,
        address: 0,
        queued: false,
        due: Deadline::NEVER,
        failed: false,
        heard: [0; 4],
        random: 0,
    };

    /// Begins to claim the preferred address. The [claim](Self::frame) must be sent. The seed is different in each device.
    pub fn start(&mut self, name: Name, preferred: u8, seed: u32) {
        *self = Self {
            name,
            random: seed,
            ..Self::OFF
        };
        self.take(preferred);
    }

    /// Leaves the address without a message, as at a stop of the node.
    pub fn stop(&mut self) {
        *self = Self::OFF;
    }

    /// Whether the node has an address, or is on the way to it.
    pub fn state(&self) -> State {
        self.state
    }

    /// The NAME of this node, which decides who keeps an address.
    pub fn name(&self) -> Name {
        self.name
    }

    /// The address that is ours; None before.
    pub fn address(&self) -> Option<u8> {
        (self.state == State::Claimed).then_some(self.address)
    }

    /// The source address of a claim: our address, or 254.
    pub fn source(&self) -> u8 {
        match self.state {
            State::Claiming | State::Claimed => self.address,
            State::Off | State::CannotClaim => NO_ADDRESS,
        }
    }

    /// The frame Address Claimed or Cannot Claim.
    pub fn frame(&self) -> Frame {
        let id = Identifier::new(ADDRESS_CLAIMED, GLOBAL, self.source());
        id.frame(self.name.to_bytes())
    }

    /// Begins to claim an address. The [claim](Self::frame) must be sent.
    pub fn take(&mut self, address: u8) {
        self.state = State::Claiming;
        self.address = address;
        self.begin();
    }

    /// Bus-off: the frame that is not sent yet is discarded.
    pub fn suspend(&mut self) {
        let waits = self.queued || self.due.is_set();
        self.queued = waits && self.state == State::CannotClaim;
        self.due = Deadline::NEVER;
    }

    /// After bus-off: begins to claim the same address again. Without an address, "cannot claim" follows if it was not sent before, and
    /// the result is false.
    pub fn resume(&mut self, now: Instant) -> bool {
        if self.has_address() {
            self.take(self.address);
            return true;
        }
        if core::mem::take(&mut self.queued) {
            self.delay(now);
        }
        false
    }

    /// Whether the node has an address or is claiming one.
    fn has_address(&self) -> bool {
        matches!(self.state, State::Claiming | State::Claimed)
    }

    /// The silence begins when the claim is sent.
    fn begin(&mut self) {
        self.queued = true;
        self.failed = false;
        self.due = Deadline::NEVER;
    }

    /// Whether a claim or "cannot claim" is queued: [`sent`](Self::sent) must follow.
    pub fn is_queued(&self) -> bool {
        self.queued
    }

    /// The frame is sent: begins the silence after a claim.
    pub fn sent(&mut self, now: Instant) {
        if core::mem::take(&mut self.queued) && self.state == State::Claiming {
            self.due = Deadline::after(now, SILENCE);
        }
    }

    /// The frame ended in a bit error: another node claims the same address at the same time. Both follow after random delays, so that
    /// one of them hears the other (J1939-81).
    pub fn failed(&mut self, now: Instant) {
        if core::mem::take(&mut self.queued) {
            self.failed = true;
            self.delay(now);
        }
    }

    /// Handles the claim of another node.
    pub fn hear(&mut self, now: Instant, source: u8, name: Name) -> Outcome {
        if !self.has_address() || source != self.address {
            self.note(source);
            return Outcome::None;
        }
        // Two nodes with the same NAME would answer each other without end.
        if name == self.name {
            return Outcome::None;
        }
        if name > self.name {
            // A claim that is already queued is the answer.
            if self.queued {
                return Outcome::None;
            }
            if self.state == State::Claiming {
                self.begin();
            }
            return Outcome::Defended;
        }
        self.note(source);
        match self.next() {
            Some(address) if self.name.is_arbitrary() => self.take(address),
            _ => {
                self.state = State::CannotClaim;
                self.queued = false;
                self.delay(now);
            }
        }
        Outcome::Left
    }

    /// Handles a request for Address Claimed. Returns true if the [claim](Self::frame) must be sent at once. A frame that is not sent yet
    /// is the answer.
    pub fn requested(&mut self, now: Instant) -> bool {
        if self.queued {
            return false;
        }
        if self.state == State::CannotClaim && !self.due.is_set() {
            self.delay(now);
        }
        self.has_address()
    }

    /// Returns true if a time has ended: the address is ours now, or the [frame](Self::frame) must be sent.
    pub fn poll(&mut self, now: Instant) -> bool {
        let ended = self.due.is_reached(now);
        if ended {
            self.due = Deadline::NEVER;
            match self.state {
                State::Claiming if !self.failed => self.state = State::Claimed,
                _ => self.begin(),
            }
        }
        ended
    }

    /// The time of the next [`poll`](Self::poll).
    pub fn deadline(&self) -> Deadline {
        self.due
    }

    /// Begins the random delay before "cannot claim", or before a failed claim is sent again.
    fn delay(&mut self, now: Instant) {
        // The linear congruential generator of Numerical Recipes. Its upper bits are more random than its lower bits. With the time, two
        // starts have different delays.
        let random = (self.random ^ now.ticks() as u32).wrapping_mul(1_664_525);
        self.random = random.wrapping_add(1_013_904_223);
        self.due = Deadline::after(now, millis((self.random >> 16) % DELAYS));
    }

    /// Marks an address as that of another node.
    fn note(&mut self, address: u8) {
        let place = address.wrapping_sub(FIRST);
        if let Some(word) = self.heard.get_mut(usize::from(place / 32)) {
            *word |= 1 << (place % 32);
        }
    }

    /// The next address after ours that no other node has claimed.
    fn next(&self) -> Option<u8> {
        let own = self.address.wrapping_sub(FIRST);
        let first = if own < COUNT { own + 1 } else { 0 };
        let places = (first..COUNT).chain(0..first);
        let mut free = places.filter(|place| {
            let word = self.heard.get(usize::from(place / 32));
            word.is_none_or(|word| word >> (place % 32) & 1 == 0)
        });
        free.next().map(|place| place + FIRST)
    }
}

#[cfg(test)]
mod tests;
