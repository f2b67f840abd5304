//! Whether the sensor is at rest, and which side is up: from the raw acceleration of the last 3 s.

use super::log::Sample;
use host_tests::calibrate::Side;
use std::collections::VecDeque;

/// The samples of the measurement: 3 s.
pub const WINDOW: usize = 600;

/// The samples of a mean of which the spread is made: 0.3 s. A mean has less noise than a sample.
const BLOCK: usize = 60;

/// The largest spread at rest, in g.
const QUIET: f64 = 0.002;

/// The acceleration along the vertical axis, in g: 1 g with the largest offset and gain that a calibration corrects.
const VERTICAL: std::ops::RangeInclusive<f64> = 0.65..=1.4;

/// The largest acceleration along another axis, in g: the largest offset and cross-axis error, and a surface that is 2 deg off level.
const HORIZONTAL: f64 = 0.385;

/// The mean of the last samples.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Average {
    /// The mean acceleration in g.
    pub acceleration: [f64; 3],
    /// The angular rate in deg/s.
    pub rate: [f64; 3],
    /// The mean temperature in degC.
    pub temperature: f64,
    /// The difference of the largest and the smallest mean of 0.3 s, in g, of the axis with the largest one.
    pub spread: f64,
}

impl Average {
    /// Whether the sensor was at rest.
    pub fn is_at_rest(&self) -> bool {
        self.spread <= QUIET
    }

    /// The side that is up; None: no side is.
    pub fn side(&self) -> Option<Side> {
        let size = |axis: usize| self.acceleration[axis].abs();
        let axis = (0..3).find(|axis| VERTICAL.contains(&size(*axis)))?;
        let is_level = (0..3).all(|other| other == axis || size(other) <= HORIZONTAL);
        is_level.then_some(Side {
            axis,
            up: self.acceleration[axis] > 0.0,
        })
    }
}

/// The samples of the last seconds.
#[derive(Clone, Debug, Default)]
pub struct Window {
    samples: VecDeque<Sample>,
}

impl Window {
    /// Adds a sample; the oldest one goes if the window is full.
    pub fn push(&mut self, sample: Sample) {
        if self.samples.len() == WINDOW {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
    }

    /// Forgets all samples, for example after a gap.
    pub fn clear(&mut self) {
        self.samples.clear();
    }

    /// The mean of the last samples; None: there are too few.
    pub fn average(&self) -> Option<Average> {
        if self.samples.len() < WINDOW {
            return None;
        }
        let samples: Vec<Sample> = self.samples.iter().copied().collect();
        let blocks: Vec<[f64; 3]> = samples
            .chunks(BLOCK)
            .map(|block| mean(block, |sample, axis| sample.acceleration[axis]))
            .collect();
        let spread = |axis: usize| {
            let means = blocks.iter().map(|block| block[axis]);
            means.clone().fold(f64::MIN, f64::max) - means.fold(f64::MAX, f64::min)
        };
        let [temperature, ..] = mean(&samples, |sample, _| sample.temperature);
        Some(Average {
            acceleration: mean(&samples, |sample, axis| sample.acceleration[axis]),
            rate: mean(&samples, |sample, axis| sample.rate[axis]),
            temperature,
            spread: (0..3).map(spread).fold(0.0, f64::max),
        })
    }
}

fn mean(samples: &[Sample], value: impl Fn(&Sample, usize) -> f64) -> [f64; 3] {
    let count = samples.len().max(1) as f64;
    std::array::from_fn(|axis| {
        let values = samples.iter().map(|sample| value(sample, axis));
        values.sum::<f64>() / count
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(count: usize, sample: impl Fn(usize) -> [f64; 3]) -> Window {
        let mut window = Window::default();
        for place in 0..count {
            window.push(Sample {
                acceleration: sample(place),
                rate: [0.5, 0.0, -0.25],
                temperature: 25.0,
            });
        }
        window
    }

    #[test]
    fn sensor_is_at_rest_after_3_seconds_without_motion() {
        assert_eq!(window(WINDOW - 1, |_| [0.0, 0.0, 1.0]).average(), None);
        // Noise of 20 mg from sample to sample.
        let noise = |place: usize| if place.is_multiple_of(2) { 0.02 } else { -0.02 };
        let still = window(WINDOW, |place| [noise(place), 0.0, 1.0]);
        let average = still.average().unwrap();
        assert!(average.is_at_rest(), "{average:?}");
        assert!((average.acceleration[2] - 1.0).abs() < 1e-9);
        assert_eq!(average.rate, [0.5, 0.0, -0.25]);
        // It was moved 2.9 s ago, by 0.2 deg.
        let moved = window(WINDOW, |place| {
            [if place < 20 { 0.0 } else { 0.0035 }, 0.0, 1.0]
        });
        assert!(moved.average().unwrap().is_at_rest(), "a third of a mean");
        let moved = window(WINDOW, |place| {
            [if place < 60 { 0.0 } else { 0.0035 }, 0.0, 1.0]
        });
        assert!(!moved.average().unwrap().is_at_rest());
        // Old samples do not count.
        let moved = window(WINDOW + 60, |place| {
            [if place < 60 { 0.5 } else { 0.0 }, 0.0, 1.0]
        });
        assert!(moved.average().unwrap().is_at_rest());
    }

    #[test]
    fn side_is_up_within_the_errors_that_a_calibration_corrects() {
        let side = |acceleration| {
            let average = window(WINDOW, |_| acceleration).average().unwrap();
            average.side().map(|side| side.to_string())
        };
        for (acceleration, expected) in [
            ([1.0, 0.0, 0.0], Some("+x")),
            ([-0.7, 0.3, 0.3], Some("-x")),
            ([0.35, 1.35, -0.35], Some("+y")),
            ([0.0, 0.0, -1.0], Some("-z")),
            ([0.0, 0.5, 0.866], None),
            ([0.0, 0.707, 0.707], None),
            ([0.0, 0.0, 0.0], None),
            ([0.0, 0.0, 2.0], None),
        ] {
            assert_eq!(side(acceleration).as_deref(), expected, "{acceleration:?}");
        }
    }
}
