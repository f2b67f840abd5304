//! Whether the angles of a sensor are at rest: from the samples of the last 3 s.

use std::collections::VecDeque;

/// The pause between two samples in ms.
pub const PERIOD: u32 = 50;

/// The samples of a measurement: 3 s.
pub const WINDOW: usize = 60;

/// The samples of a mean of which the spread is made: 0.5 s. A mean has less noise than a sample.
const BLOCK: usize = 10;

/// The largest spread of an angle at rest in degrees, if its number has smaller steps.
const QUIET: f64 = 0.1;

/// The angle of a full turn in degrees.
const TURN: f64 = 360.0;

/// The same angle between -180 and 180 deg.
pub fn wrapped(angle: f64) -> f64 {
    angle - TURN * (angle / TURN).round()
}

/// An angle in the last seconds, in degrees.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Rest {
    /// The mean.
    pub angle: f64,
    /// The difference of the largest and the smallest mean of 0.5 s.
    pub spread: f64,
}

impl Rest {
    /// Whether an angle with steps of this size was at rest.
    pub fn is_quiet(&self, step: f64) -> bool {
        self.spread <= QUIET.max(step)
    }
}

/// The samples of the last seconds.
#[derive(Debug, Default)]
pub struct Window {
    samples: VecDeque<Vec<f64>>,
}

impl Window {
    /// Adds the angles of a sample in degrees; the oldest sample goes if the window is full.
    pub fn push(&mut self, angles: Vec<f64>) {
        if self.samples.len() == WINDOW {
            self.samples.pop_front();
        }
        self.samples.push_back(angles);
    }

    /// Forgets all samples, for example after one without a valid angle.
    pub fn clear(&mut self) {
        self.samples.clear();
    }

    /// Each angle; None: there are too few samples.
    pub fn rest(&self) -> Option<Vec<Rest>> {
        let first = self.samples.front()?;
        if self.samples.len() < WINDOW {
            return None;
        }
        let angles = first.iter().enumerate();
        let rest = angles.map(|(place, first)| {
            // An angle of a full turn can change between 359.99 and 0 deg.
            let samples = self.samples.iter();
            let turned: Vec<f64> = samples.map(|own| wrapped(own[place] - first)).collect();
            let means: Vec<f64> = turned.chunks(BLOCK).map(mean).collect();
            let largest = means.iter().copied().fold(f64::MIN, f64::max);
            let smallest = means.iter().copied().fold(f64::MAX, f64::min);
            Rest {
                angle: first + mean(&turned),
                spread: largest - smallest,
            }
        });
        Some(rest.collect())
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The offset of the mounting and the inclination of the surface, of the angle in one direction and that after a turn by 180 deg about the
/// vertical axis. The turn inverts the sign of the inclination only.
pub fn reversal(first: f64, turned: f64) -> (f64, f64) {
    let surface = wrapped(first - turned) / 2.0;
    (wrapped(first - surface), surface)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(count: usize, sample: impl Fn(usize) -> f64) -> Window {
        let mut window = Window::default();
        for place in 0..count {
            window.push(vec![sample(place)]);
        }
        window
    }

    #[test]
    fn angle_is_at_rest_after_3_seconds_without_motion() {
        assert_eq!(window(WINDOW - 1, |_| 1.0).rest(), None);
        // Noise of 0.2 deg from sample to sample.
        let noisy = window(WINDOW, |place| 1.0 + 0.2 * (place % 2) as f64);
        let rest = noisy.rest().unwrap()[0];
        assert!(rest.is_quiet(0.01), "{rest:?}");
        assert!((rest.angle - 1.1).abs() < 1e-9, "{rest:?}");
        let moved = window(WINDOW, |place| if place < BLOCK { 1.0 } else { 1.2 });
        assert!(!moved.rest().unwrap()[0].is_quiet(0.01));
        // A step of the number is no motion.
        assert!(moved.rest().unwrap()[0].is_quiet(1.0));
        // Old samples do not count.
        let moved = window(
            WINDOW + BLOCK,
            |place| if place < BLOCK { 1.0 } else { 9.0 },
        );
        assert!(moved.rest().unwrap()[0].is_quiet(0.01));
    }

    #[test]
    fn angle_at_the_end_of_a_turn_is_at_rest() {
        let rest = window(WINDOW, |place| if place % 2 == 0 { 359.99 } else { 0.01 });
        let rest = rest.rest().unwrap()[0];
        assert!(rest.is_quiet(0.01), "{rest:?}");
        assert!(wrapped(rest.angle).abs() < 1e-9, "{rest:?}");
    }

    #[test]
    fn reversal_separates_mounting_and_surface() {
        for (mounting, surface) in [
            (0.0, 0.0),
            (1.5, 0.25),
            (-3.0, -10.0),
            (179.5, 2.0),
            (-0.5, 30.0),
        ] {
            let (own, inclination) = reversal(
                (mounting + surface + TURN) % TURN,
                (mounting - surface + TURN) % TURN,
            );
            assert!((own - mounting).abs() < 1e-9, "{mounting} {surface}: {own}");
            assert!((inclination - surface).abs() < 1e-9, "{inclination}");
        }
    }
}
