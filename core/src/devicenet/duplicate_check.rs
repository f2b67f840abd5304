//! The duplicate MAC ID check: before a node is on-line it asks twice whether another node has its MAC ID.
//!
//! ```text
//!  byte 0          1..2         3..6
//!     +------------+------------+----------------+
//!     | 80h        | vendor,    | serial number, |    80h: response, otherwise request; bits 0 to 6: the port
//!     | and port   | u16        | u32            |
//!     +------------+------------+----------------+
//! ```
//!
//! Each wait begins when the request was sent: while nobody acknowledges it, the request stays pending.

use crate::can::Frame;
use crate::time::{Deadline, Duration, Instant, millis};

/// The wait after each request.
const WAIT: Duration = millis(1000);

/// The length of a message in bytes.
const LENGTH: u8 = 7;

/// Bit of byte 0: response.
const RESPONSE: u8 = 0x80;

/// The network access of a node.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum State {
    /// Not started, or the bus is not accessible.
    Off,
    /// A request is being sent.
    Sending,
    /// The request is on the bus. Another node with this MAC ID can respond.
    Waiting,
    /// No other node has this MAC ID.
    Online,
    /// Another node has this MAC ID, or the bus is not usable: nothing is sent.
    Faulted,
}

/// The duplicate MAC ID check.
#[derive(Clone, Copy, Debug)]
pub(super) struct DuplicateCheck {
    state: State,
    /// The number of requests that must still be sent.
    left: u8,
    until: Deadline,
}

/// What a step of the check requests.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Step {
    None,
    /// A request of the check must be sent.
    Request,
    /// Another node checks our MAC ID: a response must be sent.
    Respond,
    /// The node is on-line now.
    Online,
    /// The node is faulted now.
    Fault,
}

impl DuplicateCheck {
    pub const OFF: Self = Self {
        state: State::Off,
        left: 0,
        until: Deadline::NEVER,
    };

    /// Starts the check: the caller sends the first request.
    pub fn start(&mut self) {
        *self = Self {
            state: State::Sending,
            left: 1,
            until: Deadline::NEVER,
        };
    }

    /// Stops the check, or leaves the network, until the next start.
    pub fn stop(&mut self) {
        *self = Self::OFF;
    }

    pub fn fault(&mut self) {
        *self = Self {
            state: State::Faulted,
            ..Self::OFF
        };
    }

    /// Whether the node is on-line.
    pub fn is_online(&self) -> bool {
        self.state == State::Online
    }

    /// Whether the node is communication faulted.
    pub fn is_faulted(&self) -> bool {
        self.state == State::Faulted
    }

    /// Handles that all frames have been sent. Returns true if the wait begins.
    pub fn sent(&mut self, now: Instant) -> bool {
        let begins = self.state == State::Sending;
        if begins {
            self.state = State::Waiting;
            self.until = Deadline::after(now, WAIT);
        }
        begins
    }

    /// Handles a received message of the check. Ignores frames of another length.
    pub fn receive(&mut self, frame: &Frame) -> Step {
        let &[kind, _, _, _, _, _, _] = frame.bytes() else {
            return Step::None;
        };
        let is_response = kind & RESPONSE != 0;
        match self.state {
            State::Online if !is_response => Step::Respond,
            State::Sending | State::Waiting | State::Online => {
                self.fault();
                Step::Fault
            }
            State::Off | State::Faulted => Step::None,
        }
    }

    /// Handles the end of a wait.
    pub fn poll(&mut self, now: Instant) -> Step {
        if !self.until.is_reached(now) {
            return Step::None;
        }
        self.until = Deadline::NEVER;
        if self.left > 0 {
            self.left -= 1;
            self.state = State::Sending;
            return Step::Request;
        }
        self.state = State::Online;
        Step::Online
    }

    /// The end of the wait.
    pub fn deadline(&self) -> Deadline {
        self.until
    }
}

/// The data of a request or a response, and its length.
pub(super) fn message(is_response: bool, vendor: u16, serial: u32) -> (u64, u8) {
    let kind = if is_response { RESPONSE } else { 0 };
    let data = u64::from(serial) << 24 | u64::from(vendor) << 8 | u64::from(kind);
    (data, LENGTH)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::standard;

    const REQUEST: [u8; 7] = [0, 0x62, 1, 1, 0, 0, 0];
    const REPLY: [u8; 7] = [0x80, 0x62, 1, 1, 0, 0, 0];

    fn frame(data: &[u8]) -> Frame {
        Frame::data(standard(0x41F), data).unwrap()
    }

    fn at(ms: u32) -> Instant {
        Instant::from_ticks(0) + millis(ms)
    }

    fn online() -> DuplicateCheck {
        let mut check = DuplicateCheck::OFF;
        check.start();
        assert!(check.sent(at(5)));
        assert_eq!(check.poll(at(1005)), Step::Request);
        assert!(check.sent(at(1010)));
        assert_eq!(check.poll(at(2010)), Step::Online);
        check
    }

    #[test]
    fn messages_have_vendor_and_serial_number() {
        for (is_response, expected) in [(false, REQUEST), (true, REPLY)] {
            let (data, length) = message(is_response, 0x162, 1);
            assert_eq!(length, 7);
            assert_eq!(data.to_le_bytes()[..7], expected);
        }
    }

    #[test]
    fn node_is_online_a_second_after_its_second_request_is_sent() {
        let mut check = DuplicateCheck::OFF;
        check.start();
        // Nobody acknowledges the request: it stays pending.
        assert_eq!(check.deadline(), Deadline::NEVER);
        assert_eq!(check.poll(at(60_000)), Step::None);
        assert!(check.sent(at(60_000)));
        assert_eq!(check.poll(at(60_999)), Step::None);
        assert_eq!(check.poll(at(61_000)), Step::Request);
        assert!(!check.is_online());
        assert_eq!(check.poll(at(70_000)), Step::None);
        assert!(check.sent(at(70_000)));
        assert!(!check.sent(at(70_500)), "another frame");
        assert_eq!(check.poll(at(70_999)), Step::None);
        assert_eq!(check.poll(at(71_000)), Step::Online);
        assert!(check.is_online());
    }

    #[test]
    fn message_for_own_mac_id_faults_the_waiting_node() {
        for data in [REQUEST, REPLY] {
            for sent in [false, true] {
                let mut check = DuplicateCheck::OFF;
                check.start();
                if sent {
                    check.sent(at(0));
                }
                assert_eq!(check.receive(&frame(&data)), Step::Fault);
                assert!(check.is_faulted());
                assert_eq!(check.receive(&frame(&data)), Step::None);
                assert_eq!(check.deadline(), Deadline::NEVER);
                assert!(!check.sent(at(1)));
            }
        }
    }

    #[test]
    fn online_node_answers_a_request_and_is_faulted_by_a_response() {
        let mut check = online();
        assert_eq!(check.receive(&frame(&REQUEST)), Step::Respond);
        assert!(check.is_online());
        assert_eq!(check.receive(&frame(&REPLY)), Step::Fault);
        assert!(!check.is_online());
    }

    #[test]
    fn frame_of_another_length_is_ignored() {
        let mut check = online();
        for length in [0, 1, 6] {
            assert_eq!(check.receive(&frame(&REPLY[..length])), Step::None);
        }
        let remote = Frame::remote(standard(0x41F), 7).unwrap();
        assert_eq!(check.receive(&remote), Step::None);
        assert!(check.is_online());
    }
}
