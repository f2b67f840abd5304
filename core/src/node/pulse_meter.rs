//! Measures the bit time of a bus from its dominant pulses.
//!
//! The shortest dominant pulse of an acknowledged frame has one bit: the ACK slot is one dominant bit between two recessive ones,
//! the CRC delimiter and the ACK delimiter. Without acknowledge it has one bit in most frames, 2 to 4 bits in the others. A frame has
//! at most 5 equal bits in sequence, so 6 recessive bits are its end. The unit is the shortest pulse itself, so the bit rate need not
//! be known.
//!
//! A timer captures its counter at the start and at the end of each pulse.

use super::BitTime;
use crate::time::Instant;

/// The recessive time after a pulse that is the end of a frame, in units of the shortest pulse.
const END_OF_FRAME: u16 = 6;

/// The recessive time, in us, at the end of a frame on a bus that is silent after it. The ends of two pulses of a frame are at most
/// 10 bits apart, 1 ms at 10 kbit/s. With polls every millisecond the silence is detected before the counter overflows, 4 ms after
/// the pulse.
const SILENCE: i16 = 1200;

/// The longest pulse that is measured; longer ones have more than 4 bits at every bit rate.
const LONGEST: u16 = 7000;

/// The length before the first pulse.
const NONE: u16 = u16::MAX;

/// The measurement of the bit time. Its times are those of a counter with [`BitTime::PER_US`] ticks per microsecond.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct PulseMeter {
    /// The shortest pulse of the present frame.
    shortest: u16,
    /// The shortest pulse of the last complete frame.
    complete: u16,
    /// The end of the last pulse.
    end: u16,
    /// The time of the first poll after the last pulse: its lower 16 bits, in us. 0: no poll since the pulse. While a result is
    /// pending, polls are more frequent than the overflow of these bits.
    silent_since: u16,
    /// Pulses before the next one are missing.
    skips: bool,
}

impl PulseMeter {
    /// The state before the first edge.
    pub const EMPTY: Self = Self {
        shortest: NONE,
        complete: NONE,
        end: 0,
        silent_since: 0,
        skips: false,
    };

    /// Measures a dominant pulse that has ended: the captured counter at its start and at its end.
    pub fn pulse(&mut self, start: u16, end: u16) {
        self.silent_since = 0;
        let recessive = start.wrapping_sub(self.end);
        let width = end.wrapping_sub(start);
        self.end = end;
        if width > i16::MAX as u16 {
            // The captures were read late: the start is that of the next pulse.
            return;
        }
        let skipped = core::mem::take(&mut self.skips);
        if self.shortest != NONE && !skipped && recessive >= END_OF_FRAME * self.shortest {
            self.complete = self.shortest;
            self.shortest = NONE;
        }
        if width <= LONGEST {
            self.shortest = self.shortest.min(width);
        }
    }

    /// Reports missing pulses: the time before the next pulse is not evaluated as the end of a frame.
    pub fn skip(&mut self) {
        self.skips = true;
    }

    /// True while [`poll`](Self::poll) can have a result without another pulse.
    pub fn is_pending(&self) -> bool {
        self.shortest != NONE || self.complete != NONE
    }

    /// The bit time of the last frame, once. Call it after each pulse and, while a result is [pending](Self::is_pending), at least
    /// every millisecond.
    pub fn poll(&mut self, now: Instant) -> Option<BitTime> {
        let now = now.ticks() as u16;
        if self.silent_since == 0 {
            self.silent_since = now.max(1);
        } else if now.wrapping_sub(self.silent_since) as i16 >= SILENCE && self.shortest != NONE {
            self.complete = self.shortest;
            self.shortest = NONE;
        }
        let width = core::mem::replace(&mut self.complete, NONE);
        (width != NONE).then_some(BitTime(width))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::BitRate;
    use crate::time::millis;

    /// Measures the pulses of these bits (dominant: 0) at this bit rate, the first bit at `start`. Returns the counter after the
    /// last bit.
    fn after(meter: &mut PulseMeter, rate: BitRate, start: u16, bits: &str) -> u16 {
        let bit = BitTime::of(rate).0;
        let (mut at, mut fall, mut level) = (start, start, '1');
        for next in bits.chars() {
            match (level, next) {
                ('1', '0') => fall = at,
                ('0', '1') => meter.pulse(fall, at),
                _ => {}
            }
            level = next;
            at = at.wrapping_add(bit);
        }
        at
    }

    fn ms(ms: u32) -> Instant {
        Instant::from_ticks(0) + millis(ms)
    }

    /// A frame with identifier 000h and no data whose only pulse of one bit is the ACK slot, then end of frame and intermission.
    const FRAME: &str = "0000010000011000001000001100011011 01 1111111111";

    fn frame() -> String {
        FRAME.replace(' ', "")
    }

    #[test]
    fn shortest_pulse_is_reported_on_silent_bus_once() {
        for rate in BitRate::ALL {
            let mut meter = PulseMeter::EMPTY;
            assert!(!meter.is_pending());
            after(&mut meter, rate, 0xFFF0, &frame());
            assert!(meter.is_pending());
            assert_eq!(meter.poll(ms(10)), None);
            assert_eq!(meter.poll(ms(11)), None);
            assert_eq!(meter.poll(ms(12)), Some(BitTime::of(rate)));
            assert!(!meter.is_pending());
            assert_eq!(meter.poll(ms(20)), None);
        }
    }

    #[test]
    fn shortest_pulse_is_reported_in_back_to_back_frames() {
        for rate in BitRate::ALL {
            for from in 0..frame().len() {
                let mut meter = PulseMeter::EMPTY;
                // The measurement begins within a frame.
                let at = after(&mut meter, rate, 7, &frame()[from..]);
                assert_eq!(meter.poll(ms(0)), None, "not the end of the frame yet");
                let at = after(&mut meter, rate, at, &frame());
                after(&mut meter, rate, at, &frame());
                assert_eq!(meter.poll(ms(1)), Some(BitTime::of(rate)));
            }
        }
    }

    #[test]
    fn end_captured_before_start_of_next_pulse_is_ignored() {
        let mut meter = PulseMeter::EMPTY;
        // The handler was late: the captured start is that of the next pulse.
        for recessive in [16, 100, 17_600, 40_000] {
            meter.pulse(1000 + recessive, 1000);
        }
        assert!(!meter.is_pending());
    }

    /// Missing pulses look like recessive bits.
    #[test]
    fn missing_pulses_are_not_the_end_of_a_frame() {
        let mut meter = PulseMeter::EMPTY;
        meter.pulse(1000, 1064);
        meter.skip();
        meter.pulse(2000, 2016);
        assert_eq!(meter.poll(ms(1)), None);
        assert_eq!(meter.poll(ms(3)), Some(BitTime(16)));
        meter.pulse(1000, 1064);
        meter.pulse(2000, 2016);
        assert_eq!(meter.poll(ms(4)), Some(BitTime(64)));
    }

    /// The captured start is that of the next pulse, which follows soon.
    #[test]
    fn end_that_is_read_late_is_not_the_end_of_a_frame() {
        let mut meter = PulseMeter::EMPTY;
        meter.pulse(1000, 1016);
        meter.pulse(1500, 1480);
        meter.pulse(1500, 1516);
        assert_eq!(meter.poll(ms(1)), None);
        assert_eq!(meter.poll(ms(3)), Some(BitTime(16)));
    }
}
