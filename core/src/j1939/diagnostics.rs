//! Active diagnostic trouble codes: DM1 (SAE J1939-73, 5.7.1).
//!
//! ```text
//!  byte 0       1       2                                     6
//!       +-------+-------+-------------------------------------+-----
//!       | lamps | FFh   | code                                | further codes
//!       +-------+-------+-------------------------------------+-----
//!
//!  lamps  04h: amber warning lamp on, 00h: no code is active
//!  code   SPN bits 0..15, then 3 bits SPN 16..18 and 5 bits FMI, then the number of occurrences (7 bits)
//! ```
//!
//! Without active code, the code is 0. A message with fewer than two codes has eight bytes, unused ones are FFh.

use super::transport::Message;
use crate::mistake::Origin;
use crate::time::{Deadline, Duration, Instant, millis};
use crate::walk::{each, put};

/// The time between two DM1 messages while no code changes.
pub const PERIOD: Duration = millis(1000);

/// The shortest time between two messages because of changes.
const INTERVAL: Duration = millis(50);

/// The maximum number of codes of a product.
pub const CODES: usize = 14;

/// The largest number of occurrences.
const OCCURRENCES: u8 = 126;

/// The amber warning lamp is on.
const AMBER: u8 = 0x04;

/// A trouble code: what is wrong, and how.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Code {
    /// The suspect parameter number, 19 bits.
    pub spn: u32,
    /// The failure mode identifier, 0 to 31.
    pub fmi: u8,
}

/// A trouble code in the table of a product.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Trouble {
    /// The code.
    pub code: Code,
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

impl Trouble {
    /// The code with this suspect parameter number and failure mode identifier.
    #[track_caller]
    pub const fn new(spn: u32, fmi: u8) -> Self {
        Self {
            code: Code { spn, fmi },
            origin: Origin::here(),
        }
    }

    /// The codes, in the form that the device uses.
    pub const fn codes<const N: usize>(troubles: &[Self]) -> [Code; N] {
        let mut codes = [Code { spn: 0, fmi: 0 }; N];
        each!(place, trouble in troubles => { put(&mut codes, place, trouble.code) });
        codes
    }
}

/// The trouble codes of a node: one bit for each code of the table of its product.
#[derive(Clone, Debug)]
pub struct Diagnostics {
    active: u16,
    /// The codes that have become active since the last message: the next one has them, also if they are not active any more.
    begun: u16,
    /// The number of occurrences of each code since the start.
    occurrences: [u8; CODES],
    /// A message must be sent.
    changed: bool,
    /// The end of the period.
    due: Deadline,
    /// The end of the time in which changes wait.
    inhibited: Deadline,
}

impl Diagnostics {
    /// No code was active, and no message is sent. All bits are 0.
    pub const OFF: Self = Self {
        active: 0,
        begun: 0,
        occurrences: [0; CODES],
        changed: false,
        due: Deadline::NEVER,
        inhibited: Deadline::NEVER,
    };

    /// Begins to send, at once. Codes that became inactive before are counted, but not sent.
    pub fn start(&mut self, now: Instant) {
        self.begun = 0;
        self.changed = false;
        self.due = Deadline::after(now, Duration::from_ticks(0));
        self.inhibited = Deadline::NEVER;
    }

    /// Ends sending. The codes continue.
    pub fn stop(&mut self) {
        self.due = Deadline::NEVER;
        self.inhibited = Deadline::NEVER;
    }

    /// The active codes, as bits: bit n is code n of the product's table.
    pub fn active(&self) -> u16 {
        self.active
    }

    /// Sets the active codes, and counts the codes that have become active.
    pub fn set(&mut self, active: u16) {
        let begun = active & !self.active;
        self.changed |= active != self.active;
        self.active = active;
        self.begun |= begun;
        for (place, count) in self.occurrences.iter_mut().enumerate() {
            if begun >> place & 1 != 0 && *count < OCCURRENCES {
                *count += 1;
            }
        }
    }

    /// Whether a message must be sent now. [`sent`](Self::sent) must follow.
    pub fn is_due(&self, now: Instant) -> bool {
        let waits = self.inhibited.is_set() && !self.inhibited.is_reached(now);
        self.due.is_reached(now) || self.changed && self.due.is_set() && !waits
    }

    /// The message is sent. Codes in it that are not active any more are a change.
    pub fn sent(&mut self, now: Instant) {
        self.changed = self.reported() != self.active;
        self.begun = 0;
        self.due = Deadline::after(now, PERIOD);
        self.inhibited = Deadline::after(now, INTERVAL);
    }

    /// The time at which a message is due.
    pub fn deadline(&self) -> Deadline {
        if self.changed && self.due.is_set() && self.inhibited.is_set() {
            return self.inhibited;
        }
        self.due
    }

    /// The codes in the next message that the period or a change causes: the active codes, and the codes that were active since the last
    /// message.
    pub fn reported(&self) -> u16 {
        self.active | self.begun
    }

    /// The message with these codes of the table.
    pub fn message(&self, codes: &[Code], reported: u16) -> Message {
        let mut message = Message::new();
        let lamps = if reported == 0 { 0 } else { AMBER };
        // There is always room.
        let mut append = |bytes: &[u8]| {
            let _ = message.extend_from_slice(bytes);
        };
        append(&[lamps, 0xFF]);
        if reported == 0 {
            append(&[0; 4]);
        }
        for (place, (code, count)) in codes.iter().zip(self.occurrences).enumerate() {
            if reported >> place & 1 != 0 {
                let [low, middle, high, _] = code.spn.to_le_bytes();
                append(&[low, middle, high << 5 | code.fmi & 0x1F, count]);
            }
        }
        while message.len() < 8 {
            let _ = message.push(0xFF);
        }
        message
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::String;

    const TABLE: [Code; 3] = [
        Code { spn: 4976, fmi: 0 },
        Code { spn: 4977, fmi: 12 },
        Code {
            spn: 0x7_FFFF,
            fmi: 31,
        },
    ];

    fn at(ms: u64) -> Instant {
        Instant::from_ticks(ms * 1000)
    }

    fn text(diagnostics: &Diagnostics) -> String {
        let message = diagnostics.message(&TABLE, diagnostics.reported());
        message
            .iter()
            .map(|byte| std::format!("{byte:02X}"))
            .collect()
    }

    #[test]
    fn message_has_all_active_codes() {
        let mut diagnostics = Diagnostics::OFF;
        assert_eq!(text(&diagnostics), "00FF00000000FFFF");
        diagnostics.set(1);
        assert_eq!(text(&diagnostics), "04FF70130001FFFF");
        diagnostics.set(7);
        assert_eq!(text(&diagnostics), "04FF7013000171130C01FFFFFF01");
    }

    #[test]
    fn occurrences_count_up_to_126() {
        let mut diagnostics = Diagnostics::OFF;
        for count in 1..200 {
            diagnostics.set(2);
            diagnostics.set(2);
            let expected = std::format!("04FF71130C{:02X}FFFF", count.min(126));
            assert_eq!(text(&diagnostics), expected);
            diagnostics.set(0);
        }
    }

    #[test]
    fn code_cleared_before_the_message_is_in_this_message_only() {
        let mut diagnostics = Diagnostics::OFF;
        diagnostics.start(at(250));
        diagnostics.sent(at(250));
        diagnostics.set(1);
        diagnostics.set(2);
        diagnostics.set(0);
        assert_eq!(diagnostics.deadline().time(), Some(at(300)));
        assert_eq!(text(&diagnostics), "04FF7013000171130C01");
        diagnostics.sent(at(300));
        assert_eq!(diagnostics.deadline().time(), Some(at(350)));
        assert_eq!(text(&diagnostics), "00FF00000000FFFF");
        diagnostics.sent(at(350));
        assert_eq!(diagnostics.deadline().time(), Some(at(1350)));
    }

    #[test]
    fn code_cleared_before_the_start_is_counted_but_not_in_the_first_message() {
        let mut diagnostics = Diagnostics::OFF;
        diagnostics.set(1);
        diagnostics.set(2);
        diagnostics.start(at(250));
        assert_eq!(text(&diagnostics), "04FF71130C01FFFF");
        diagnostics.sent(at(250));
        assert_eq!(diagnostics.deadline().time(), Some(at(1250)));
        diagnostics.set(1);
        assert_eq!(text(&diagnostics), "04FF70130002FFFF");
    }

    #[test]
    fn message_is_due_every_second_and_after_a_change() {
        let mut diagnostics = Diagnostics::OFF;
        diagnostics.set(1);
        assert!(!diagnostics.is_due(at(0)) && !diagnostics.deadline().is_set());
        diagnostics.start(at(250));
        assert!(diagnostics.is_due(at(250)));
        diagnostics.sent(at(250));
        assert!(!diagnostics.is_due(at(1249)) && diagnostics.is_due(at(1250)));
        diagnostics.set(1);
        assert!(!diagnostics.is_due(at(400)), "no change");
        diagnostics.set(0);
        assert!(diagnostics.is_due(at(400)));
        diagnostics.sent(at(400));
        assert_eq!(diagnostics.deadline().time(), Some(at(1400)));
        diagnostics.set(3);
        assert!(!diagnostics.is_due(at(449)) && diagnostics.is_due(at(450)));
        assert_eq!(diagnostics.deadline().time(), Some(at(450)));
        diagnostics.stop();
        assert!(!diagnostics.is_due(at(9999)));
    }
}
