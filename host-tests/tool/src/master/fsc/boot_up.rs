//! Boot-up messages of sensors with function select codes.
//!
//! ```text
//!  byte 0   1        2..5                6..7
//!  FFh      status   Set-Parameter-ID    software version
//! ```
//!
//! The identifier is the Reply-Parameter-ID. A sensor sends the message twice at once, and repeats it as long as nobody acknowledges it.
//! Other devices send frames with the same first byte (J1939 fills with FFh), so one frame is not sufficient.

use crate::master::Master;
use crate::master::fsc::request::Sensor;
use plumbline::can::{CanId, Frame};
use plumbline::time::{Duration, Instant, after, millis};

/// The longest time between the two messages.
const PAIR: Duration = millis(100);

/// The longest time between two messages that nobody acknowledges, on average: at 10 kbit/s one takes 16 ms.
const REPEATED: Duration = millis(20);

/// The time without a third message after which two are a pair. A cyclic frame comes earlier.
const SETTLED: Duration = millis(200);

/// Two different messages with the same identifier within this time are from another device: a sensor does not restart twice in it.
const CHANGED: Duration = millis(1000);

/// The maximum number of sensors that are kept. Other devices can send frames with the same first byte and any others.
const SENSORS: usize = 64;

/// Identifiers at which a question is a command to other devices: network management, SYNC, layer setting services.
pub(super) const RESERVED: [CanId; 4] = [
    CanId::standard(0x000),
    CanId::standard(0x080),
    CanId::standard(0x7E4),
    CanId::standard(0x7E5),
];

/// The sensor of a frame that has the form of a boot-up message.
pub fn boot_up(frame: &Frame) -> Option<Sensor> {
    let &[0xFF, _, a, b, c, d, _, _] = frame.bytes() else {
        return None;
    };
    let bits = u32::from_le_bytes([a, b, c, d]);
    let request = CanId::from_bits(bits);
    (request.bits() == bits && request != frame.can_id()).then(|| Sensor {
        request,
        reply: Some(frame.can_id()),
    })
}

/// Whether this number of messages between these times are repetitions of one message that nobody acknowledges.
pub fn is_repeated(count: u32, first: Instant, last: Instant) -> bool {
    let time = last.ticks().saturating_sub(first.ticks());
    count >= 2 && time <= u64::from(count - 1) * REPEATED.ticks()
}

/// The messages of a sensor.
#[derive(Clone, Copy, Debug)]
struct Seen {
    sensor: Sensor,
    first: Instant,
    last: Instant,
    count: u32,
    is_taken: bool,
}

impl Seen {
    /// Exactly two messages, one directly after the other: cyclic values come more often or later.
    fn is_pair(&self) -> bool {
        self.count == 2 && self.last.ticks() - self.first.ticks() <= PAIR.ticks()
    }

    /// The messages come one after the other: nobody acknowledges them.
    fn is_repeated(&self) -> bool {
        is_repeated(self.count, self.first, self.last)
    }

    /// Whether the sensor may be asked after it has settled.
    fn is_new(&self) -> bool {
        self.is_pair() && !self.is_taken && !self.sensor.is_reserved()
    }
}

/// The boot-up messages on a bus.
#[derive(Clone, Debug, Default)]
pub struct BootUps {
    seen: Vec<Seen>,
    /// The identifiers of other devices: their frames have the form of a boot-up message, with a changing Set-Parameter-ID.
    foreign: Vec<CanId>,
    /// The number of other frames.
    others: u64,
}

impl BootUps {
    /// The messages among received frames.
    pub fn of(frames: &[(Instant, Frame)]) -> Self {
        let mut messages = Self::default();
        for (at, frame) in frames {
            messages.take(*at, frame);
        }
        messages
    }

    /// Takes a received frame: a boot-up message, or another frame.
    pub fn take(&mut self, at: Instant, frame: &Frame) {
        let Some(sensor) = boot_up(frame) else {
            self.others += 1;
            return;
        };
        if self.foreign.contains(&frame.can_id()) {
            self.others += 1;
            return;
        }
        if let Some(seen) = self.seen.iter_mut().find(|seen| seen.sensor == sensor) {
            seen.count += 1;
            seen.last = at;
            return;
        }
        let is_other = |seen: &Seen| {
            let passed = at.ticks().saturating_sub(seen.last.ticks());
            seen.sensor.reply == sensor.reply && passed <= CHANGED.ticks()
        };
        if self.seen.iter().any(is_other) && self.foreign.len() < SENSORS {
            self.seen.retain(|seen| seen.sensor.reply != sensor.reply);
            self.foreign.push(frame.can_id());
            self.others += 1;
            return;
        }
        self.insert(at, sensor);
    }

    /// Adds a sensor. If there are too many sensors, the ones that can no longer form a pair are removed.
    fn insert(&mut self, at: Instant, sensor: Sensor) {
        if self.seen.len() >= SENSORS {
            let can_be = |seen: &Seen| {
                seen.is_pair() || at.ticks().saturating_sub(seen.last.ticks()) <= PAIR.ticks()
            };
            self.seen.retain(can_be);
        }
        if self.seen.len() >= SENSORS {
            self.others += 1;
            return;
        }
        self.seen.push(Seen {
            sensor,
            first: at,
            last: at,
            count: 1,
            is_taken: false,
        });
    }

    /// Whether a sensor has sent its messages: exactly two at once, or the same all the time because nobody else is on the bus.
    pub fn is_sure(&self, sensor: Sensor) -> bool {
        let is_alone = self.others == 0 && self.seen.len() == 1;
        let mut seen = self.seen.iter().filter(|seen| seen.sensor == sensor);
        seen.any(|seen| seen.is_pair() || (is_alone && seen.is_repeated()))
    }

    /// The time at which it is known whether the last two messages are all that a sensor sends; None: nothing is to be waited for.
    pub fn settled(&self) -> Option<Instant> {
        let new = self.seen.iter().filter(|seen| seen.is_new());
        new.map(|seen| after(seen.last, SETTLED)).max()
    }

    /// The sensors that have sent their two messages since the last call and nothing more until `now`, and may be asked.
    pub fn take_booted(&mut self, now: Instant) -> Vec<Sensor> {
        let mut booted = Vec::new();
        for seen in &mut self.seen {
            if seen.is_new() && now >= after(seen.last, SETTLED) {
                seen.is_taken = true;
                booted.push(seen.sensor);
            }
        }
        booted
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::can::standard;

    fn message(id: u16) -> Frame {
        let [low, high] = id.to_le_bytes();
        Frame::of(standard(0x7F0), [0xFF, 3, low, high, 0, 0, 0x44, 3], 8)
    }

    fn at(time: u32) -> Instant {
        after(Instant::from_ticks(0), millis(time))
    }

    #[test]
    fn two_messages_are_a_pair_when_no_third_one_comes() {
        let mut booted = BootUps::default();
        booted.take(at(0), &message(0x320));
        booted.take(at(90), &message(0x320));
        assert_eq!(booted.take_booted(at(100)), []);
        assert_eq!(booted.settled(), Some(at(290)));
        assert_eq!(booted.take_booted(at(290)).len(), 1);
        assert_eq!(booted.take_booted(at(291)), [], "once");
        // A cyclic frame is none.
        booted.take(at(300), &message(0x330));
        booted.take(at(390), &message(0x330));
        booted.take(at(480), &message(0x330));
        assert_eq!(
            (booted.settled(), booted.take_booted(at(999))),
            (None, vec![])
        );
    }

    #[test]
    fn frames_with_one_identifier_and_a_counter_belong_to_another_device() {
        let mut booted = BootUps::default();
        let times = (0..100).map(|place| (place * 50, 0x300 + place as u16 / 2));
        for (time, id) in times {
            booted.take(at(time), &message(id));
            assert_eq!(booted.take_booted(at(time)), []);
        }
        assert_eq!(
            (booted.settled(), booted.take_booted(at(9000))),
            (None, vec![])
        );
        // A sensor with another identifier is still found, and one that restarts with new settings.
        let other = |id: u8| Frame::of(standard(0x301), [0xFF, 3, id, 3, 0, 0, 0x44, 3], 8);
        for (time, id) in [(10_000, 0x50), (12_000, 0x51)] {
            booted.take(at(time), &other(id));
            booted.take(at(time + 1), &other(id));
            assert_eq!(booted.take_booted(at(time + 500)).len(), 1);
        }
    }

    #[test]
    fn foreign_frames_use_no_memory_and_replace_no_sensor() {
        let mut booted = BootUps::default();
        for place in 0..1000 {
            let foreign = Frame::of(standard(place % 700), [0xFF, 3, 1, 7, 0, 0, 0x44, 3], 8);
            booted.take(at(u32::from(place) * 10), &foreign);
        }
        assert!(booted.seen.len() <= SENSORS);
        booted.take(at(20_000), &message(0x6A5));
        booted.take(at(20_001), &message(0x6A5));
        let sensors = booted.take_booted(at(30_000));
        assert_eq!(sensors[0].request, CanId::standard(0x6A5));
    }
}
