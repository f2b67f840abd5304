use super::*;
use plumbline::time::{after, millis};

/// The missing values after values at these times in us, with a period of 1 ms.
fn lost(times: impl IntoIterator<Item = u64>) -> u64 {
    let mut count = Count::new(Some(millis(1)), Instant::from_ticks(0));
    let mut last = Instant::from_ticks(0);
    for time in times {
        last = Instant::from_ticks(time);
        count.take(last, None);
    }
    count.missing(last)
}

/// The time of a value that an adapter hands over every `step` us.
fn read(time: u64, step: u64) -> u64 {
    time.div_ceil(step) * step
}

#[test]
fn values_on_the_grid_are_complete_with_any_sensor_clock() {
    for period in [990, 995, 1000, 1005, 1010] {
        let times = (0..100_000).map(|place| place * period);
        assert_eq!(lost(times), 0, "{period}");
    }
}

#[test]
fn missing_values_are_counted() {
    let is_there = |place: &u64| place % 10 != 3 && !(500..600).contains(place);
    for step in [1, 200, 1900, 16_000] {
        // Ten of the hundred are missing anyway.
        let times = (0..1000).filter(is_there);
        let lost = lost(times.map(|place| read(place * 1000, step)));
        // The last ones can still come, and an adapter that is late all the time hides when one is missing.
        let most = 194 + step / 1000;
        assert!((188..=most).contains(&lost), "{step} {lost}");
    }
    // A value in 14 is missing all the time.
    let overloaded = lost((0..2798).map(|place| place * 1072));
    assert!((200..=202).contains(&overloaded), "{overloaded}");
}

#[test]
fn values_that_come_late_and_at_once_are_not_missing() {
    for step in [200, 1000, 1100, 1900, 5000, 7300] {
        let times = (0..20_000).map(|place| match read(place * 1000, step) {
            200_000..280_000 => 280_000,
            time => time,
        });
        let lost = lost(times);
        assert!(lost <= step / 1000, "{step} {lost}");
    }
    let deviation = [0, 400, 700, 100, 650, 300];
    let jitter = (0..1000_u64).map(|place| place * 1000 + deviation[place as usize % 6]);
    assert_eq!(lost(jitter), 0);
}

#[test]
fn counter_gives_the_missing_values_independent_of_the_time() {
    let mut count = Count::new(Some(millis(1)), Instant::from_ticks(0));
    let at = Instant::from_ticks(5_000_000);
    for (counter, expected) in [(0xFFFE, 0), (0xFFFF, 0), (2, 2), (3, 2)] {
        count.take(at, Some(counter));
        assert_eq!(count.missing(at), expected);
    }
    assert_eq!(count.missing(after(at, millis(4))), 5);
}

#[test]
fn without_a_period_nothing_is_counted() {
    let mut count = Count::new(None, Instant::from_ticks(0));
    for time in [0, 1000, 900_000] {
        count.take(Instant::from_ticks(time), None);
    }
    assert_eq!(count.missing(Instant::from_ticks(5_000_000)), 0);
}

#[test]
fn period_is_correct_if_one_value_is_missing() {
    let times = |places: &[u64]| -> Vec<Instant> {
        let times = places
            .iter()
            .map(|place| Instant::from_ticks(place * 10_000));
        times.collect()
    };
    assert_eq!(period(&times(&[0, 1, 2, 4, 5, 6])), Some(millis(10)));
    assert_eq!(period(&times(&[0, 1, 2, 3, 4])), None);
    assert_eq!(period(&[]), None);
}

#[test]
fn values_without_regularity_have_no_period() {
    let times = |times: &[u64]| -> Vec<Instant> {
        let times = times.iter().map(|time| Instant::from_ticks(time * 1000));
        times.collect()
    };
    assert_eq!(period(&times(&[0, 5, 13, 40, 45, 57, 61])), None);
    assert_eq!(period(&times(&[0, 10, 20, 30, 40, 54])), None);
    // An adapter with steps of 1 ms.
    let stepped = period(&times(&[0, 5, 11, 15, 20, 25]));
    assert_eq!(stepped, Some(millis(5)));
}

#[test]
fn counter_restart_does_not_change_the_time() {
    for (before, after_it) in [(30_000_u16, 0), (40_000, 17), (100, 3)] {
        let mut count = Count::new(Some(millis(1)), Instant::from_ticks(0));
        let start = 5_000_000;
        let at = |ms: u64| Instant::from_ticks(start + ms * 1000);
        count.take(at(0), Some(before.wrapping_sub(1)));
        count.take(at(1), Some(before));
        let time = count.take(at(301), Some(after_it));
        assert_eq!(time, millis(301));
        assert_eq!((count.missing(at(301)), count.restarts()), (299, 1));
        count.take(at(302), Some(after_it + 1));
        assert_eq!((count.missing(at(302)), count.restarts()), (299, 1));
    }
}

#[test]
fn values_that_are_lost_while_the_computer_is_late_are_counted_by_the_counter() {
    let mut count = Count::new(Some(millis(1)), Instant::from_ticks(0));
    for counter in 0..1000 {
        count.take(
            Instant::from_ticks(u64::from(counter) * 1000),
            Some(counter),
        );
    }
    // Nothing is read for 5 s. Then all values that were not lost come at once.
    let late = Instant::from_ticks(6_000_000);
    for counter in [1000, 1001, 4900, 5999] {
        count.take(late, Some(counter));
    }
    assert_eq!((count.missing(late), count.restarts()), (4996, 0));
    // The clock of a sensor that is 1 % fast does not look like a restart.
    let mut count = Count::new(Some(millis(1)), Instant::from_ticks(0));
    for value in 0..300_000_u64 {
        count.take(Instant::from_ticks(value * 990), Some(value as u16));
    }
    assert_eq!(count.restarts(), 0);
}
