//! How long a scan listens at which bit rate.
//!
//! ```text
//!  all rates    15 ms to 50 ms each: a message that nobody acknowledges is repeated all the time
//!  two rates    1 s and some ms each: heartbeats and cyclic values
//!  all rates    ..
//! ```
//!
//! So a sensor that is switched on meanwhile, alone on the bus, is heard 2.4 s later at the latest. After the last two rates the round at
//! all rates is repeated. Ten rates take 12 s and what 80 openings of the adapter need; a short step is shorter by that, as long as its
//! two frames have the time.

use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant, after, millis};

/// The time in which a received frame comes from the adapter.
const ADAPTER: Duration = millis(15);

/// The shortest time of a step with the opening of the adapter.
const SHORTEST: Duration = millis(20);

/// The bits of two frames of 8 bytes, with an error frame after each.
const TWO_FRAMES: u64 = 350;

/// The longest time between two messages of a node, with the deviation of its clock.
const SECOND: Duration = millis(1005);

/// The number of times all rates are listened to at the end.
const LAST: usize = 2;

/// The long steps at the only rate: about the time of ten rates.
const PATIENT: usize = 10;

/// The time after which one message that is repeated all the time shows that its sender is alone on the bus.
const LONE: Duration = millis(250);

/// A step: so long at this rate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Step {
    /// The rate; None: the rate of the interface.
    pub rate: Option<BitRate>,
    /// The time until a first frame, with the opening of the adapter.
    pub time: Duration,
    /// The shortest time from the opening on.
    pub least: Duration,
    /// Without a progress bar it is a line.
    pub is_line: bool,
}

impl Step {
    /// Its end, if it has begun and the adapter was open at these times.
    pub fn until(&self, start: Instant, opened: Instant) -> Instant {
        after(start, self.time).max(after(opened, self.least))
    }

    /// Whether every node that sends once a second is heard.
    pub fn is_long(&self) -> bool {
        self.least >= SECOND
    }
}

/// The steps of a scan, which follow from the options.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Schedule {
    /// The steps in their order.
    pub steps: Vec<Step>,
    /// The user watches: each step is shown, and the first thing that is said is what to do meanwhile.
    pub is_shown: bool,
    /// The long steps at the bit rate of a bus whose traffic shows no sensor for sure: the user can switch one on.
    pub more: usize,
}

/// The time of these bits at a rate.
fn time_of(bits: u64, rate: Option<BitRate>) -> Duration {
    let rate = rate.map_or(10_000, BitRate::bits_per_second);
    Duration::micros(bits * 1_000_000 / u64::from(rate))
}

impl Schedule {
    /// The steps at these rates. With `waits`, a single rate is listened to as long as ten, so that there is time to switch a sensor on.
    pub fn of(rates: &[Option<BitRate>], waits: bool) -> Self {
        let quick = |is_line: bool| {
            rates.iter().map(move |rate| {
                let least = ADAPTER + time_of(TWO_FRAMES, *rate);
                Step {
                    rate: *rate,
                    time: SHORTEST.max(least),
                    least,
                    is_line,
                }
            })
        };
        let long = |rate: &Option<BitRate>| {
            let time = SECOND + ADAPTER + time_of(TWO_FRAMES, *rate);
            Step {
                rate: *rate,
                time,
                least: time,
                is_line: true,
            }
        };
        let mut steps: Vec<Step> = Vec::new();
        if let [only] = rates {
            let count = if waits { PATIENT } else { 1 };
            steps.extend(std::iter::repeat_n(long(only), count));
        } else {
            steps.extend(quick(true));
            for pair in rates.chunks(2) {
                steps.extend(pair.iter().map(long));
                steps.extend(quick(false));
            }
            for _ in 1..LAST {
                steps.extend(quick(false));
            }
        }
        Self {
            steps,
            is_shown: false,
            more: if waits { PATIENT } else { 0 },
        }
    }

    /// A short look after silence: two rounds at all rates, or one step at the only rate.
    pub fn again(&self) -> Self {
        let quick = self.steps.iter().take_while(|step| !step.is_long());
        let mut steps: Vec<Step> = quick.copied().collect();
        steps.extend(steps.clone());
        if steps.is_empty() {
            steps.extend(self.steps.first());
        }
        Self {
            steps,
            is_shown: false,
            more: 0,
        }
    }

    /// The same for a user who watches.
    pub fn shown(mut self) -> Self {
        self.is_shown = true;
        self
    }
}

/// Whether the frames are one message that is repeated as fast as the bus permits: nobody acknowledges it, so its sender is alone.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lone {
    first: Option<(Instant, Frame)>,
    count: u64,
    is_other: bool,
}

impl Lone {
    /// Takes a frame. True: it is sure that the sender is alone.
    pub fn take(&mut self, at: Instant, frame: &Frame, rate: Option<BitRate>) -> bool {
        let (first, own) = *self.first.get_or_insert((at, *frame));
        self.is_other |= own != *frame;
        let passed = at.ticks().saturating_sub(first.ticks());
        // The bits of a frame, and half of them for stuff bits, an error frame and the wait of a node that is error-passive.
        let bits = 47 + 20 * u64::from(frame.can_id().bits() >> 31) + 8 * frame.dlc() as u64;
        let most = self.count * time_of(bits * 3 / 2, rate).ticks();
        self.count += 1;
        rate.is_some() && !self.is_other && passed >= LONE.ticks() && passed <= most
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::connect::RATES;
    use plumbline::can::standard;
    use plumbline::time::after;

    #[test]
    fn ten_rates_take_less_than_thirteen_seconds_and_each_comes_again_soon() {
        let schedule = Schedule::of(&RATES.map(Some), true);
        assert_eq!(schedule.steps.len(), 80);
        // An adapter that opens at once, and one with 3 ms for each of three answers.
        for (opening, least, most, again) in [
            (0, 11_900_000, 12_100_000, 2_500_000),
            (9, 12_400_000, 12_700_000, 2_500_000),
        ] {
            let at = Instant::from_ticks(0);
            let step_time = |step: &Step| step.until(at, after(at, millis(opening))).ticks();
            let total: u64 = schedule.steps.iter().map(step_time).sum();
            assert!((least..most).contains(&total), "{total}");
            for rate in RATES {
                let (mut now, mut last, mut longest) = (0, 0, 0);
                for step in &schedule.steps {
                    if step.rate == Some(rate) {
                        longest = longest.max(now + u64::from(opening) * 1000 - last);
                        last = now + step_time(step);
                    }
                    now += step_time(step);
                }
                assert!(longest < again, "{rate:?} {longest} us");
                assert!(now - last < 350_000, "{rate:?}");
                let long = schedule.steps.iter().filter(|step| {
                    step.rate == Some(rate) && step.is_long() && step.time < millis(1060)
                });
                assert_eq!(long.count(), 1, "{rate:?}");
            }
        }
    }

    #[test]
    fn step_with_a_slow_opening_has_the_time_of_two_frames() {
        let at = |time| after(Instant::from_ticks(0), millis(time));
        for step in Schedule::of(&RATES.map(Some), true).steps {
            let two = 15_000 + time_of(TWO_FRAMES, step.rate).ticks();
            assert!(step.until(at(0), at(0)).ticks() >= 20_000, "{step:?}");
            let left = step.until(at(0), at(48)).ticks() - 48_000;
            assert!(left >= two, "{step:?}");
            if step.is_long() {
                assert!(left >= 1_005_000 + two, "{step:?}");
            }
        }
    }

    #[test]
    fn single_rate_is_listened_to_once_or_as_long_as_ten() {
        let steps = |waits| Schedule::of(&[Some(BitRate::K250)], waits).steps;
        assert_eq!(steps(false).len(), 1);
        let total: u64 = steps(true).iter().map(|step| step.time.ticks()).sum();
        assert!((10_000_000..11_000_000).contains(&total), "{total}");
    }

    #[test]
    fn repeated_message_shows_a_lone_sender_after_a_quarter_of_a_second() {
        let at = |us: u32| after(Instant::from_ticks(0), Duration::micros(us.into()));
        let frame = |byte| Frame::data(standard(0x321), &[byte; 8]).unwrap();
        let rate = Some(BitRate::K250);
        let told = |gap: u32, changes: u32| {
            let mut lone = Lone::default();
            let mut told = (0..1100).filter(|place| {
                let byte = u8::from(*place == changes);
                lone.take(at(place * gap), &frame(byte), rate)
            });
            told.next().map(|place| place * gap / 1000)
        };
        // 150 bits.
        assert_eq!(told(600, 9999), Some(250));
        // A cyclic message, and two different ones.
        assert_eq!(told(1000, 9999), None);
        assert_eq!(told(600, 3), None);
        let mut lone = Lone::default();
        assert!((0..1000).all(|place| !lone.take(at(place * 600), &frame(0), None)));
    }
}
