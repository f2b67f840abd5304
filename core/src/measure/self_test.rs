//! Self-test of the axes of the accelerometer. The accelerometer applies a known force to its seismic mass, and the reading must
//! change (ifm JN2101 manual 9.8; ISM330DHCX datasheet, "linear acceleration self-test output change").
//!
//! Average some readings at rest, switch the self-test of the accelerometer on, wait until it has settled, and average the same
//! number of readings again. The range must be large enough for gravity plus the test force. The datasheet of the accelerometer has the
//! [`Limits`], and the range for which they are specified.

use super::{I32x3, ONE_G};
use crate::time::{Duration, millis};

/// The longest duration of the test. Without a result by then, the axes are faulty.
pub const LIMIT: Duration = millis(4000);

/// The smallest and the largest change of X, Y and Z if the axis works, 1 g = 2^26.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Limits(pub [(u32, u32); 3]);

impl Limits {
    /// Limits in mg, at most 31000.
    pub const fn milli_g(axes: [(u32, u32); 3]) -> Self {
        const fn units(milli_g: u32) -> u32 {
            (ONE_G as u64 * milli_g as u64 / 1000) as u32
        }
        let [x, y, z] = axes;
        Self([
            (units(x.0), units(x.1)),
            (units(y.0), units(y.1)),
            (units(z.0), units(z.1)),
        ])
    }
}

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

/// Compares the mean acceleration without (`at_rest`) and with the self-test on (`pushed`), 1 g = 2^26. An axis works if the
/// change, in either direction, is within its limits.
///
/// ```
/// use plumbline::measure::{I32x3, ONE_G, self_test};
///
/// // 90 to 1700 mg.
/// let limits = self_test::Limits::milli_g([(90, 1700); 3]);
/// let at_rest = I32x3 { x: 0, y: 0, z: ONE_G };
/// let pushed = I32x3 { x: ONE_G / 2, y: -ONE_G / 2, z: ONE_G };
/// let working = self_test::judge(&limits, at_rest, pushed);
/// assert!(working.x && working.y && !working.z);
/// ```
pub fn judge(limits: &Limits, at_rest: I32x3, pushed: I32x3) -> Working {
    let works = |(least, most): (u32, u32), rest: i32, pushed: i32| {
        (least..=most).contains(&rest.abs_diff(pushed))
    };
    let Limits([x, y, z]) = *limits;
    Working {
        x: works(x, at_rest.x, pushed.x),
        y: works(y, at_rest.y, pushed.y),
        z: works(z, at_rest.z, pushed.z),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits::milli_g([(90, 1700); 3]);

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
                    let x = judge(&LIMITS, still, I32x3 { x: pushed, ..still });
                    assert_eq!(x, Working { x: works, ..none }, "{change}");
                    let y = judge(&LIMITS, still, I32x3 { y: pushed, ..still });
                    assert_eq!(y, Working { y: works, ..none }, "{change}");
                    let z = judge(&LIMITS, still, I32x3 { z: pushed, ..still });
                    assert_eq!(z, Working { z: works, ..none }, "{change}");
                }
            }
        }
    }

    #[test]
    fn each_axis_has_its_limits() {
        let limits = Limits::milli_g([(100, 600), (200, 700), (500, 3000)]);
        let still = I32x3 { x: 0, y: 0, z: 0 };
        for (change, x, y, z) in [
            (150.0, true, false, false),
            (550.0, true, true, true),
            (650.0, false, true, true),
            (2900.0, false, false, true),
        ] {
            let change = milli_g(change);
            let pushed = I32x3 {
                x: change,
                y: change,
                z: change,
            };
            assert_eq!(
                judge(&limits, still, pushed),
                Working { x, y, z },
                "{change}"
            );
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
        assert_eq!(judge(&LIMITS, low, high), Working::default());
        assert_eq!(judge(&LIMITS, high, low), Working::default());
    }
}
