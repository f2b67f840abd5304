//! Self-test of the axes of the accelerometer. The accelerometer applies a known force to its seismic mass, and the reading must
//! change (ifm JN2101 manual 9.8; ISM330DHCX datasheet, "linear acceleration self-test output change").
//!
//! Average some readings at rest, switch the self-test of the accelerometer on, wait until it has settled, and average the same
//! number of readings again. The range must be large enough for gravity plus the test force. The datasheet specifies the
//! test at +-4 g.

use super::{I32x3, ONE_G};
use crate::time::{Duration, millis};

/// The longest duration of the test. Without a result by then, the axes are faulty.
pub const LIMIT: Duration = millis(4000);

/// The smallest change of a working axis, 1 g = 2^26: 90 mg.
pub const LEAST: u32 = (ONE_G as u64 * 90 / 1000) as u32;

/// The largest change of a working axis, 1 g = 2^26: 1700 mg.
pub const MOST: u32 = (ONE_G as u64 * 1700 / 1000) as u32;

/// The result of the self-test: the axes that work.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Working {
    /// The acceleration along X changed as specified.
    pub x: bool,
    /// The acceleration along Y changed as specified.
    pub y: bool,
    /// The acceleration along Z changed as specified.
    pub z: bool,
}

/// Compares the mean acceleration without (`at_rest`) and with the self-test on (`pushed`), 1 g = 2^26. An axis works if they
/// differ by [`LEAST`] to [`MOST`], in either direction.
///
/// ```
/// use plumbline::measure::{I32x3, ONE_G, self_test};
///
/// let at_rest = I32x3 { x: 0, y: 0, z: ONE_G };
/// let pushed = I32x3 { x: ONE_G / 2, y: -ONE_G / 2, z: ONE_G };
/// let working = self_test::judge(at_rest, pushed);
/// assert!(working.x && working.y && !working.z);
/// ```
pub fn judge(at_rest: I32x3, pushed: I32x3) -> Working {
    let works = |rest: i32, pushed: i32| (LEAST..=MOST).contains(&rest.abs_diff(pushed));
    Working {
        x: works(at_rest.x, pushed.x),
        y: works(at_rest.y, pushed.y),
        z: works(at_rest.z, pushed.z),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn milli_g(value: f64) -> i32 {
        (value * f64::from(ONE_G) / 1000.0).round() as i32
    }

    #[test]
    fn change_of_90_to_1700_mg_on_each_axis_passes_in_both_directions() {
        let cases = [
            (0.0, false),
            (89.9, false),
            (90.1, true),
            (800.0, true),
            (1699.9, true),
            (1700.1, false),
            (3999.0, false),
        ];
        for (change, works) in cases {
            for sign in [1.0, -1.0] {
                for rest in [-1000.0, 0.0, 700.0] {
                    let (rest, pushed) = (milli_g(rest), milli_g(rest + sign * change));
                    let still = I32x3 {
                        x: rest,
                        y: rest,
                        z: rest,
                    };
                    let none = Working::default();
                    let x = judge(still, I32x3 { x: pushed, ..still });
                    assert_eq!(x, Working { x: works, ..none }, "{change}");
                    let y = judge(still, I32x3 { y: pushed, ..still });
                    assert_eq!(y, Working { y: works, ..none }, "{change}");
                    let z = judge(still, I32x3 { z: pushed, ..still });
                    assert_eq!(z, Working { z: works, ..none }, "{change}");
                }
            }
        }
    }

    #[test]
    fn extreme_integers_do_not_overflow() {
        let low = I32x3 {
            x: i32::MIN,
            y: i32::MIN,
            z: i32::MIN,
        };
        let high = I32x3 {
            x: i32::MAX,
            y: i32::MAX,
            z: i32::MAX,
        };
        assert_eq!(judge(low, high), Working::default());
        assert_eq!(judge(high, low), Working::default());
    }
}
