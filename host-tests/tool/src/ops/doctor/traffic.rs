//! What the frames and the errors of a bus show: load, errors by identifier, a sender that nobody acknowledges, two senders of one
//! identifier.

use can_wire::frame_length::{INTERMISSION, frame_bits};
use plumbline::can::{BitRate, CanId, Frame};
use plumbline::time::{Instant, millis};

/// The times that are kept of an identifier.
const TIMES: usize = 2000;

/// The fewest intervals that show two senders.
const INTERVALS: usize = 8;

/// The shortest interval of a cyclic message of one sender.
const SHORTEST: u64 = millis(5).ticks();

/// A longer time between two frames is a pause of their sender, and not of an adapter that hands over several frames together.
const BLOCK: u64 = millis(100).ticks();

/// An identifier on the bus.
#[derive(Clone, Debug)]
pub struct Identifier {
    /// The identifier.
    pub id: CanId,
    /// Its frames.
    pub frames: u64,
    /// The errors before its frames. A frame with an error is repeated, so the next frame is mostly the same one.
    pub errors: u64,
    /// When its first frames came.
    times: Vec<Instant>,
}

/// The traffic of a bus.
#[derive(Debug, Default)]
pub struct Traffic {
    /// The identifiers in the order of their first frames.
    pub identifiers: Vec<Identifier>,
    /// All frames.
    pub frames: u64,
    /// The bits of the frames with the intermission.
    bits: u64,
    /// The frames that are the one before again.
    repeated: u64,
    /// The time between them and those before in us, and that of repetitions as soon as the bus permits.
    waited: u64,
    permitted: u64,
    last: Option<(Instant, Frame)>,
}

impl Traffic {
    /// Takes a frame, and the number of errors that came before it.
    pub fn take(&mut self, at: Instant, frame: &Frame, errors: u64, rate: Option<BitRate>) {
        let bits = u64::from(frame_bits(frame) + INTERMISSION);
        self.frames += 1;
        self.bits += bits;
        if let (Some((last, own)), Some(rate)) = (self.last, rate)
            && own == *frame
            && at.ticks().saturating_sub(last.ticks()) <= BLOCK
        {
            self.repeated += 1;
            self.waited += at.ticks().saturating_sub(last.ticks());
            // An error frame and the wait of an error-passive node take less than half of a frame.
            self.permitted += bits * 3 / 2 * 1_000_000 / u64::from(rate.bits_per_second());
        }
        self.last = Some((at, *frame));
        let id = frame.can_id();
        let place = self.identifiers.iter().position(|own| own.id == id);
        let place = place.unwrap_or_else(|| {
            self.identifiers.push(Identifier {
                id,
                frames: 0,
                errors: 0,
                times: Vec::new(),
            });
            self.identifiers.len() - 1
        });
        let own = &mut self.identifiers[place];
        own.frames += 1;
        own.errors += errors;
        if own.times.len() < TIMES {
            own.times.push(at);
        }
    }

    /// The share of the time in which the bus is busy, in percent; None: the rate is unknown.
    pub fn load(&self, rate: Option<BitRate>, ticks: u64) -> Option<f64> {
        let bits = u64::from(rate?.bits_per_second()) as f64 * ticks as f64 / 1e6;
        Some((self.bits as f64 / bits.max(1.0) * 1e4).round() / 100.0)
    }

    /// Whether most frames are repeated at once: no node acknowledges their sender. Adapters hand over several frames together, so only the
    /// sum of the times counts.
    pub fn is_unacknowledged(&self) -> bool {
        let most = self.frames >= 10 && self.repeated * 10 >= self.frames * 9;
        most && self.waited <= self.permitted
    }

    /// The identifiers that two nodes seem to send with the same period.
    pub fn doubled(&self) -> impl Iterator<Item = CanId> {
        let doubled = self.identifiers.iter().filter(|own| is_doubled(&own.times));
        doubled.map(|own| own.id)
    }

    /// The identifier that has nearly all errors, though most frames have another one.
    pub fn disturbed(&self) -> Option<&Identifier> {
        let all: u64 = self.identifiers.iter().map(|own| own.errors).sum();
        let mut own = self.identifiers.iter();
        own.find(|own| all >= 3 && own.errors * 10 >= all * 8 && own.frames * 2 < self.frames)
    }
}

/// Whether times are those of two cyclic messages: the intervals alternate, and each two of them together are the same.
fn is_doubled(times: &[Instant]) -> bool {
    let passed = |from: &Instant, to: &Instant| to.ticks().saturating_sub(from.ticks());
    let intervals: Vec<u64> = times
        .windows(2)
        .map(|two| passed(&two[0], &two[1]))
        .collect();
    if intervals.len() < INTERVALS {
        return false;
    }
    let close = |one: u64, other: u64, of: u64| one.abs_diff(other) * 20 <= of;
    let periods: Vec<u64> = intervals.windows(2).map(|two| two[0] + two[1]).collect();
    let period = periods[0];
    let is_cyclic = period >= 2 * SHORTEST && periods.iter().all(|own| close(*own, period, period));
    let [first, second] = [intervals[0], intervals[1]];
    let mut pairs = intervals.chunks_exact(2);
    is_cyclic
        && first.abs_diff(second) * 10 > period
        && pairs.all(|two| close(two[0], first, period) && close(two[1], second, period))
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::can::standard;
    use plumbline::time::{Duration, after};

    fn at(us: u64) -> Instant {
        after(Instant::from_ticks(0), Duration::micros(us))
    }

    fn frame(id: u16, byte: u8) -> Frame {
        Frame::data(standard(id), &[byte; 8]).expect("a frame")
    }

    /// Frames with identifier, time in us and the errors before them, at 250 kbit/s.
    fn traffic(frames: &[(u16, u64, u64)]) -> Traffic {
        let mut traffic = Traffic::default();
        for (place, (id, time, errors)) in frames.iter().enumerate() {
            let frame = frame(*id, place as u8);
            traffic.take(at(*time), &frame, *errors, Some(BitRate::K250));
        }
        traffic
    }

    #[test]
    fn load_is_the_share_of_the_bits_with_intermission() {
        // Eight bytes 55h have 111 bits and some stuff bits in the CRC at most, every 1000 us = 250 bits.
        let mut load = Traffic::default();
        for place in 0..100 {
            let rate = Some(BitRate::K250);
            load.take(at(place * 1000), &frame(0x555, 0x55), 0, rate);
        }
        let bits = f64::from(frame_bits(&frame(0x555, 0x55)) + 3);
        let expected = (bits / 250.0 * 1e4).round() / 100.0;
        assert_eq!(load.load(Some(BitRate::K250), 100_000), Some(expected));
        assert!((44.0..48.0).contains(&expected), "{expected}");
        assert_eq!(load.load(None, 100_000), None);
    }

    #[test]
    fn frame_that_is_repeated_at_once_is_not_acknowledged() {
        // The adapter hands over what has come in each time of a block.
        let is_repeated = |gap: u64, block: u64, rate| {
            let mut traffic = Traffic::default();
            for place in 0..100 {
                let time = (place * gap).next_multiple_of(block);
                traffic.take(at(time), &frame(0x701, 0), 0, rate);
            }
            traffic.is_unacknowledged()
        };
        let rate = Some(BitRate::K250);
        for block in [1, 1000, 5000] {
            assert!(is_repeated(600, block, rate), "{block}");
            assert!(!is_repeated(2000, block, rate), "{block}");
            assert!(!is_repeated(600, block, None), "{block}");
        }
        let mut paused = Traffic::default();
        for start in [0, 2_000_000] {
            for place in 0..100 {
                paused.take(at(start + place * 600), &frame(0x701, 0), 0, rate);
            }
        }
        assert!(paused.is_unacknowledged());
        let mut busy = Traffic::default();
        for place in 0..100 {
            busy.take(at(place * 600), &frame(0x181, place as u8), 0, rate);
        }
        assert!(!busy.is_unacknowledged());
    }

    #[test]
    fn alternating_intervals_show_two_senders() {
        let frames = |times: &dyn Fn(u64) -> u64| -> Vec<(u16, u64, u64)> {
            (0..20).map(|place| (0x70A, times(place), 0)).collect()
        };
        let doubled = |frames: &[_]| traffic(frames).doubled().count();
        // Two heartbeats of 1 s, the second one 300 ms later.
        let two = |place: u64| place / 2 * 1_000_000 + place % 2 * 300_000;
        assert_eq!(doubled(&frames(&two)), 1);
        // One heartbeat, with a jitter of 10 ms.
        let one = |place: u64| place * 1_000_000 + place % 2 * 10_000;
        assert_eq!(doubled(&frames(&one)), 0);
        // No period.
        let free = |place: u64| place * place * 90_000 + place % 2 * 30_000;
        assert_eq!(doubled(&frames(&free)), 0);
        assert_eq!(doubled(&frames(&two)[..INTERVALS]), 0);
    }

    #[test]
    fn errors_of_one_identifier_name_it() {
        let mut frames = vec![(0x181, 0, 0); 20];
        frames.extend([(0x301, 1, 2), (0x301, 2, 3), (0x301, 3, 0)]);
        let disturbed = traffic(&frames);
        let own = disturbed.disturbed().expect("an identifier");
        assert_eq!(
            (own.id, own.frames, own.errors),
            (standard(0x301).into(), 3, 5)
        );
        frames[0].2 = 3;
        assert!(traffic(&frames).disturbed().is_none());
        // All frames have this identifier.
        assert!(traffic(&frames[20..]).disturbed().is_none());
    }
}
