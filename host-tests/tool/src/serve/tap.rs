//! Counts of the frames of an adapter, the newest frame of each identifier, and the messages that sensors send by themselves: they are
//! noticed here, so that none is lost while a command waits for its answer.

use crate::cyclic::Message;
use crate::cyclic::Source;
use crate::decode::{Bus, Decoded};
use plumbline::can::Frame;
use plumbline::time::Instant;
use serde_json::{Value, json};
use std::collections::{HashMap, VecDeque};

/// The maximum number of identifiers that are kept. A new one replaces the one that has been silent for the longest time.
const IDENTIFIERS: usize = 256;

/// The maximum number of messages of a sensor that wait: 10 s at 1 kHz.
const MESSAGES: usize = 10_000;

/// The newest frame of an identifier.
struct Newest {
    frame: Frame,
    /// What it is, if that is known.
    decoded: Option<Decoded>,
    at: Instant,
    /// The time since the frame before it, in us.
    period: Option<u64>,
    count: u64,
    /// It was sent by this program.
    own: bool,
    /// It has not been published yet.
    is_new: bool,
}

/// The frames of an adapter.
#[derive(Default)]
pub struct Tap {
    newest: HashMap<u32, Newest>,
    /// Finds out what the frames are.
    bus: Bus,
    /// By the number of its sensor: what it sends by itself, and what has come.
    sources: HashMap<u64, (Source, VecDeque<Message>)>,
    /// Nobody shows the frames: only the messages are kept.
    is_hidden: bool,
    /// The frames that were received.
    pub received: u64,
    /// The frames that were sent.
    pub sent: u64,
}

impl Tap {
    /// Only the messages of sensors are kept, not the frames.
    pub fn hidden() -> Self {
        Self {
            is_hidden: true,
            ..Self::default()
        }
    }

    /// A frame was received at this time.
    pub fn received(&mut self, at: Instant, frame: &Frame) {
        self.received += 1;
        self.note(at, frame, false);
        for (source, messages) in self.sources.values_mut() {
            if let Some(message) = (source.message)(at, frame) {
                if messages.len() == MESSAGES {
                    messages.pop_front();
                }
                messages.push_back(message);
            }
        }
    }

    /// Keeps the messages of a sensor from now on; None: no longer.
    pub fn follow(&mut self, sensor: u64, source: Option<Source>) {
        match source {
            Some(source) => self.sources.insert(sensor, (source, VecDeque::new())),
            None => self.sources.remove(&sensor),
        };
    }

    /// The messages of a sensor since the last call.
    pub(crate) fn messages(&mut self, sensor: u64) -> VecDeque<Message> {
        let own = self.sources.get_mut(&sensor);
        own.map(|(_, messages)| std::mem::take(messages))
            .unwrap_or_default()
    }

    /// A frame was sent at this time.
    pub fn sent(&mut self, at: Instant, frame: &Frame) {
        self.sent += 1;
        self.note(at, frame, true);
    }

    fn note(&mut self, at: Instant, frame: &Frame, own: bool) {
        if self.is_hidden {
            return;
        }
        let id = frame.can_id().bits();
        let decoded = self.bus.decode(frame);
        if let Some(newest) = self.newest.get_mut(&id) {
            newest.period = Some(at.ticks().saturating_sub(newest.at.ticks()));
            newest.count += 1;
            (newest.frame, newest.decoded) = (*frame, decoded);
            (newest.at, newest.own, newest.is_new) = (at, own, true);
            return;
        }
        if self.newest.len() >= IDENTIFIERS {
            let oldest = self.newest.iter().min_by_key(|(_, newest)| newest.at);
            if let Some(id) = oldest.map(|(id, _)| *id) {
                self.newest.remove(&id);
            }
        }
        let newest = Newest {
            frame: *frame,
            decoded,
            at,
            period: None,
            count: 1,
            own,
            is_new: true,
        };
        self.newest.insert(id, newest);
    }

    /// Forgets all frames and counts.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// The newest frame of each identifier, if there is a new one.
    pub fn take(&mut self) -> Option<Value> {
        if !self.newest.values().any(|newest| newest.is_new) {
            return None;
        }
        let mut rows: Vec<(&u32, &mut Newest)> = self.newest.iter_mut().collect();
        rows.sort_unstable_by_key(|(id, _)| **id);
        let rows = rows.into_iter().map(|(_, newest)| {
            newest.is_new = false;
            json!({
                "id": crate::number::shown(newest.frame.can_id()),
                "data": newest.frame.bytes().iter().map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(" "),
                "remote": newest.frame.is_remote(),
                "count": newest.count,
                "period": newest.period.map(|period| period / 100 * 100),
                "own": newest.own,
                "meaning": newest.decoded.as_ref().map(Decoded::to_string),
            })
        });
        Some(rows.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::can::CanId;

    fn frame(id: u16, byte: u8) -> Frame {
        Frame::data(CanId::standard(id).into(), &[byte]).expect("a frame")
    }

    #[test]
    fn newest_frame_of_each_identifier_has_count_and_period() {
        let mut tap = Tap::default();
        tap.received(Instant::from_ticks(1000), &frame(0x181, 1));
        tap.sent(Instant::from_ticks(1500), &frame(0x80, 2));
        tap.received(Instant::from_ticks(11_000), &frame(0x181, 3));
        let rows = tap.take().expect("new frames");
        assert_eq!(
            rows,
            json!([
                {"id": "080h", "data": "02", "remote": false, "count": 1, "period": null, "own": true, "meaning": "canopen: SYNC, counter = 2"},
                {"id": "181h", "data": "03", "remote": false, "count": 2, "period": 10_000, "own": false, "meaning": null},
            ])
        );
        assert_eq!((tap.received, tap.sent), (2, 1));
        assert_eq!(tap.take(), None);
    }

    #[test]
    fn identifiers_are_bounded_and_the_oldest_goes_first() {
        let mut tap = Tap::default();
        for id in 0..300 {
            tap.received(Instant::from_ticks(id.into()), &frame(id, 0));
        }
        let rows = tap.take().expect("new frames");
        let rows = rows.as_array().expect("rows");
        assert_eq!(rows.len(), IDENTIFIERS);
        assert_eq!(rows[0]["id"], "02Ch");
    }
}
