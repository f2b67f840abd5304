//! The blink patterns of LEDs, recognised from their changes: a sample would show whether an LED is lit at that moment.

use plumbline::node::{Channels, Leds, Pattern, Patterns};
use plumbline::time::Instant;

/// No pattern stays in a phase longer, in ms.
const LONGEST: u64 = 1100;

/// A pattern is recognised from its third flash on. A self-test lights each colour once or twice, which is not a pattern.
const FLASHES: usize = 3;

/// The latest changes that can belong to a pattern, in ms: three single flashes take 3.6 s.
const SEEN: u64 = 4000;

/// The patterns at the end of a history of states.
pub fn patterns<'a>(
    now: Instant,
    history: impl DoubleEndedIterator<Item = &'a (Instant, Leds)> + Clone,
) -> Patterns {
    let of = |channel: fn(&Leds) -> bool| {
        let states = history.clone().map(|(at, leds)| (*at, channel(leds)));
        pattern(now, states)
    };
    Channels {
        run: of(|leds| leds.run),
        error: of(|leds| leds.error),
        module_green: of(|leds| leds.module_green),
        module_red: of(|leds| leds.module_red),
    }
}

/// The pattern of one LED, from its states, oldest first.
fn pattern(now: Instant, states: impl DoubleEndedIterator<Item = (Instant, bool)>) -> Pattern {
    let age = |at: Instant| now.ticks().saturating_sub(at.ticks()) / 1000;
    // The phases, newest first: their state and their start.
    let mut phases: Vec<(bool, Instant)> = Vec::new();
    for (at, lit) in states.rev() {
        match phases.last_mut() {
            Some((state, start)) if *state == lit => *start = at,
            Some((_, start)) if age(*start) > SEEN => break,
            _ => phases.push((lit, at)),
        }
    }
    let Some((lit, last)) = phases.first().copied() else {
        return Pattern::Off;
    };
    let steady = if lit { Pattern::On } else { Pattern::Off };
    // The lengths of the complete phases, newest first.
    let lengths: Vec<(bool, u64)> = phases
        .windows(2)
        .map(|pair| (pair[1].0, age(pair[1].1) - age(pair[0].1)))
        .take_while(|(_, length)| *length <= LONGEST)
        .collect();
    let length_of = |state: bool| lengths.iter().filter(move |phase| phase.0 == state);
    let Some((_, flash)) = length_of(true).next() else {
        return steady;
    };
    if length_of(true).count() < FLASHES {
        return steady;
    }
    if age(last) > LONGEST || *flash > 700 {
        return steady;
    }
    let pauses = || length_of(false).map(|(_, length)| *length);
    let has_short_pause = pauses().take(2).any(|pause| pause < 600);
    let has_long_pause = pauses().take(2).any(|pause| pause >= 600) || !lit && age(last) >= 600;
    match flash {
        0..125 => Pattern::Flickering,
        350.. => Pattern::Flashing,
        _ if !has_long_pause => Pattern::Blinking,
        _ if has_short_pause => Pattern::DoubleFlash,
        _ => Pattern::SingleFlash,
    }
}

/// The name of a pattern that changes (CiA 303-3); None for one that does not.
pub fn name(pattern: Pattern) -> Option<&'static str> {
    match pattern {
        Pattern::Off | Pattern::On => None,
        Pattern::Flickering => Some("flickering"),
        Pattern::Blinking => Some("blinking"),
        Pattern::Flashing => Some("flashing"),
        Pattern::SingleFlash => Some("single flash"),
        Pattern::DoubleFlash => Some("double flash"),
    }
}

/// The name of any pattern.
pub fn label(pattern: Pattern) -> &'static str {
    match name(pattern) {
        Some(name) => name,
        None if pattern == Pattern::On => "on",
        None => "off",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::node::Indicator;
    use plumbline::time::{after, millis};

    /// The states of the LEDs that show these patterns one after the other, each for some seconds, and the pattern that is
    /// recognised every 10 ms.
    fn recognised(shown: &[(Pattern, u32)]) -> Vec<(u32, Pattern)> {
        let mut indicator = Indicator::DARK;
        let (mut history, mut found) = (Vec::new(), Vec::new());
        let (mut now, mut time) = (Instant::from_ticks(5_000_000), 0);
        for (error, seconds) in shown {
            let all = Patterns {
                error: *error,
                // Its changes are in the same history.
                module_green: Pattern::Flickering,
                ..Patterns::DARK
            };
            indicator.show(now, all);
            for _ in 0..seconds * 100 {
                if let Some(leds) = indicator.poll(now) {
                    history.push((now, leds));
                }
                found.push((time, patterns(now, history.iter()).error));
                now = after(now, millis(10));
                time += 10;
            }
        }
        found
    }

    #[test]
    fn each_pattern_is_recognised_after_three_flashes_and_never_as_another() {
        for pattern in [
            Pattern::Off,
            Pattern::On,
            Pattern::Flickering,
            Pattern::Blinking,
            Pattern::Flashing,
            Pattern::SingleFlash,
            Pattern::DoubleFlash,
        ] {
            for (at, found) in recognised(&[(pattern, 20)]) {
                let is_unnamed = at < 3300 && name(found).is_none();
                assert!(
                    is_unnamed || found == pattern,
                    "{pattern:?}: {found:?} at {at}"
                );
            }
        }
    }

    /// The self-test of a TILTIX: one flash of each colour, and the module LED is green afterwards.
    #[test]
    fn flashes_of_a_self_test_are_not_a_pattern() {
        let changes = [(57, true), (307, false), (1057, true), (2057, false)];
        let at = |ms: u64| Instant::from_ticks(ms * 1000);
        let mut history = Vec::new();
        for ms in 0..8000 {
            for (_, lit) in changes.iter().filter(|(change, _)| *change == ms) {
                let leds = Leds {
                    run: false,
                    error: false,
                    module_green: *lit,
                    module_red: false,
                };
                history.push((at(ms), leds));
            }
            let found = patterns(at(ms), history.iter()).module_green;
            assert_eq!(name(found), None, "at {ms}");
        }
    }

    #[test]
    fn end_of_a_pattern_is_recognised() {
        for pattern in [Pattern::Flickering, Pattern::SingleFlash, Pattern::Blinking] {
            for steady in [Pattern::On, Pattern::Off] {
                for (at, found) in recognised(&[(pattern, 5), (steady, 5)]) {
                    let is_settled = at > 7300;
                    assert!(
                        !is_settled || found == steady,
                        "{pattern:?} {steady:?} {at}"
                    );
                }
            }
        }
        let long = recognised(&[(Pattern::On, 5), (Pattern::Off, 5)]);
        assert!(long.iter().all(|(_, found)| name(*found).is_none()));
    }

    #[test]
    fn led_that_never_changed_is_off() {
        let none: [(Instant, Leds); 0] = [];
        assert_eq!(
            patterns(Instant::from_ticks(0), none.iter()),
            Patterns::DARK
        );
    }
}
