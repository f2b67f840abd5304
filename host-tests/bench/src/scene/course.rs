//! Angles that change with the time: a turn with a constant rate, and an oscillation.

use super::{Axes, SceneError, attitude, up};
use std::f64::consts::TAU;

/// The highest rate in deg/s.
const FASTEST: f64 = 10_000.0;

/// The highest frequency in Hz: the accelerometer has 833 values/s.
const HIGHEST: f64 = 400.0;

/// The longest turn in s.
const LONGEST: f64 = 1e6;

/// The angles of a sensor over the time.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Course {
    Turn {
        from: (f64, f64),
        rates: (f64, f64),
        time: f64,
    },
    Sine {
        around: (f64, f64),
        amplitudes: (f64, f64),
        hertz: f64,
    },
}

impl Course {
    /// A turn for this time, or as long as the angles exist.
    pub(super) fn turn(
        from: (f64, f64),
        rates: (f64, f64),
        time: Option<f64>,
        axes: Axes,
    ) -> Result<Self, SceneError> {
        attitude(from.0, from.1, axes)?;
        if rates.0.abs().max(rates.1.abs()) > FASTEST {
            return Err(SceneError::Argument(format!(
                "a rate is at most {FASTEST} deg/s"
            )));
        }
        let turn = |time| Self::Turn { from, rates, time };
        let Some(time) = time else {
            return Ok(turn(end(from, rates, axes)));
        };
        if !(0.0..=LONGEST).contains(&time) {
            return Err(SceneError::Argument(format!(
                "the time of a turn is 0 to {LONGEST} s"
            )));
        }
        let course = turn(time);
        let (x, y) = course.angles(time);
        attitude(x, y, axes)?;
        Ok(course)
    }

    /// An oscillation, whose angles must all exist.
    pub(super) fn sine(
        around: (f64, f64),
        amplitudes: (f64, f64),
        hertz: f64,
        axes: Axes,
    ) -> Result<Self, SceneError> {
        for side in [-1.0, 1.0] {
            let (x, y) = amplitudes;
            attitude(around.0 + side * x, around.1 + side * y, axes)?;
        }
        if !(hertz > 0.0 && hertz <= HIGHEST) {
            return Err(SceneError::Argument(format!(
                "the frequency is more than 0 and at most {HIGHEST} Hz"
            )));
        }
        Ok(Self::Sine {
            around,
            amplitudes,
            hertz,
        })
    }

    /// The time at which a turn ends.
    pub(super) fn end(&self) -> Option<f64> {
        match self {
            Self::Turn { time, .. } => Some(*time),
            Self::Sine { .. } => None,
        }
    }

    /// The angles in degrees at this time.
    pub(super) fn angles(&self, seconds: f64) -> (f64, f64) {
        let (from, change, factor) = match *self {
            Self::Turn { from, rates, time } => (from, rates, seconds.clamp(0.0, time)),
            Self::Sine {
                around,
                amplitudes,
                hertz,
            } => (around, amplitudes, (TAU * hertz * seconds).sin()),
        };
        (from.0 + factor * change.0, from.1 + factor * change.1)
    }
}

/// The time until the angles of a turn do not exist any more. Those that exist have no gap, so halves find the end.
fn end(from: (f64, f64), rates: (f64, f64), axes: Axes) -> f64 {
    let exists = |time: f64| {
        let (x, y) = (from.0 + time * rates.0, from.1 + time * rates.1);
        let limited = match axes {
            Axes::One => y.abs(),
            Axes::Two => x.abs().max(y.abs()),
        };
        limited <= 90.0 && up(x, y, axes).is_some()
    };
    let (mut good, mut bad) = (0.0, LONGEST);
    if exists(bad) {
        return bad;
    }
    for _ in 0..100 {
        let middle = f64::midpoint(good, bad);
        if exists(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turn_ends_after_its_time_or_where_the_angles_end() {
        let turn = |from, rates, time, axes| Course::turn(from, rates, time, axes).unwrap();
        let course = turn((10.0, -2.0), (5.0, 1.0), Some(4.0), Axes::Two);
        assert_eq!(course.angles(1.0), (15.0, -1.0));
        assert_eq!(course.angles(4.0), course.angles(1e9));
        assert_eq!(course.angles(1e9), (30.0, 2.0));
        let (x, y) = turn((0.0, 30.0), (1.0, 0.0), None, Axes::Two).angles(1e9);
        assert!((x - 60.0).abs() < 1e-4 && y == 30.0, "{x}");
        let round = turn((0.0, 0.0), (100.0, 0.0), None, Axes::One);
        assert_eq!(round.angles(7.5), (750.0, 0.0));
    }

    #[test]
    fn course_beyond_the_angles_is_refused() {
        let refused = |course: Result<Course, SceneError>| course.unwrap_err().to_string();
        let turn = |rate, time| Course::turn((0.0, 30.0), (rate, 0.0), time, Axes::Two);
        assert!(refused(turn(10.0, Some(6.1))).contains("does not exist"));
        assert!(refused(turn(10.0, Some(9.1))).contains("-90 to 90"));
        assert!(refused(turn(1.0, Some(-1.0))).contains("0 to 1000000 s"));
        assert!(refused(turn(1e5, None)).contains("at most 10000 deg/s"));
        let sine = |x, hertz| Course::sine((80.0, 0.0), (x, 0.0), hertz, Axes::Two);
        assert!(refused(sine(-11.0, 1.0)).contains("-90 to 90"));
        assert!(refused(sine(5.0, 0.0)).contains("more than 0"));
        assert!(refused(sine(5.0, 401.0)).contains("400 Hz"));
    }

    #[test]
    fn oscillation_has_amplitude_and_frequency() {
        let course = Course::sine((5.0, 1.0), (10.0, 2.0), 0.5, Axes::Two).unwrap();
        assert_eq!(course.angles(0.0), (5.0, 1.0));
        assert_eq!(course.angles(0.5), (15.0, 3.0));
        let (x, y) = course.angles(1.5);
        assert!((x + 5.0).abs() < 1e-9 && (y + 1.0).abs() < 1e-9);
    }
}
