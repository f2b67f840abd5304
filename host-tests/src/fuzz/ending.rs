//! The end of the input: a sensor in J1939 ends its connections and still answers.

use super::{Sensor, j1939};
use plumbline::can::{Frame, extended};
use plumbline::node::{BusEvent, BusState};
use plumbline::time::{Duration, after, millis};

/// The time after which all connections of J1939 have ended, and the longest time of an answer.
const QUIET: Duration = millis(6000);
const ANSWER: Duration = millis(200);

/// A request of all nodes for Address Claimed.
const CLAIMED: (u32, [u8; 3]) = (0x18EA_FF21, [0x00, 0xEE, 0x00]);

/// The longest step of the time in which nothing happens.
const STEP: Duration = millis(1);

impl Sensor {
    /// Lets time pass without another frame on the bus, and checks that the sensor in J1939 ends its connections and still answers.
    ///
    /// # Panics
    /// As [`step`](Self::step), or if it does not.
    pub fn finish(&mut self) {
        self.node.bus(self.now, BusEvent::State(BusState::Active));
        self.settle();
        if self.j1939.is_none() {
            return;
        }
        let begin = self.now;
        // A running save ends, and a pending reset.
        let sent = self.quiet(QUIET);
        // A power cut in this time can lead back to CANopen.
        let Some(known) = &self.j1939 else {
            return;
        };
        known.check_quiet(begin);
        if sent > 0 {
            self.ask(CLAIMED);
        }
        // Both connections are free again.
        for requester in [0x31, 0x32] {
            let Some(address) = self.j1939.as_ref().and_then(j1939::Known::address) else {
                return;
            };
            let packets = self.packets;
            let id = 0x18EA_0000 | u32::from(address) << 8 | requester;
            self.ask((id, [0xEB, 0xFE, 0x00]));
            assert!(self.packets > packets, "no connection is free");
        }
    }

    /// Sends a request.
    ///
    /// # Panics
    /// If there is no answer.
    fn ask(&mut self, (id, data): (u32, [u8; 3])) {
        if self.node.ready() {
            let request = Frame::data(extended(id), &data).expect("3 bytes");
            self.node.receive(self.now, &request);
            self.settle();
            assert!(self.quiet(ANSWER) > 0, "no answer");
        }
    }

    /// Lets this time pass. Returns the number of frames.
    fn quiet(&mut self, time: Duration) -> u64 {
        let (begin, end) = (self.sent, after(self.now, time));
        while self.now < end {
            let sent = self.sent;
            self.transmit();
            self.step_store();
            self.settle();
            if self.sent == sent {
                let next = after(self.now, STEP);
                let deadline = self.node.deadline().unwrap_or(end);
                self.now = deadline.clamp(self.now, next).min(end);
                self.settle();
            }
        }
        self.sent - begin
    }
}
