//! Zero offset: added to the measured angle before output (GEMAC manual 9.2, 9.10.6). All angles are in 0.01 deg.

/// 360 deg.
const TURN: u32 = 36_000;

/// The limit of the offset and the output of a 2-axis sensor, positive and negative.
const LIMIT: i32 = 9_000;

/// A 1-axis angle with its offset: (`measured` + `offset`) mod 360.00 deg, 0..=35999.
///
/// ```
/// use plumbline::measure::zero;
///
/// assert_eq!(zero::one_axis(350_00, 20_00), 10_00);
/// ```
pub const fn one_axis(measured: u16, offset: u16) -> u16 {
    ((measured as u32 + offset as u32) % TURN) as u16
}

/// The offset, 0..=35999, for which the output of a 1-axis sensor is 0 at `measured` (automatic zero point adjustment).
pub const fn one_axis_auto(measured: u16) -> u16 {
    ((TURN - measured as u32 % TURN) % TURN) as u16
}

/// A 2-axis angle with its offset: `measured` + `offset`, limited to -90.00..=90.00 deg.
///
/// ```
/// use plumbline::measure::zero;
///
/// assert_eq!(zero::two_axis(-12_00, 2_00), -10_00);
/// assert_eq!(zero::two_axis(80_00, 20_00), 90_00);
/// ```
pub const fn two_axis(measured: i32, offset: i16) -> i16 {
    clamp(measured.saturating_add(offset as i32))
}

/// The offset, -9000..=9000, for which the output of a 2-axis sensor is 0 at `measured` (automatic zero point adjustment).
pub const fn two_axis_auto(measured: i32) -> i16 {
    clamp(measured.saturating_neg())
}

const fn clamp(value: i32) -> i16 {
    if value > LIMIT {
        LIMIT as i16
    } else if value < -LIMIT {
        -LIMIT as i16
    } else {
        value as i16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_axis_wraps_and_auto_offset_gives_0() {
        assert_eq!(one_axis(0, 0), 0);
        assert_eq!(one_axis(35_999, 1), 0);
        assert_eq!(one_axis(35_999, 35_999), 35_998);
        assert_eq!(one_axis_auto(0), 0);
        assert_eq!(one_axis_auto(1), 35_999);
        for measured in 0..36_000 {
            let offset = one_axis_auto(measured);
            assert!(offset < 36_000);
            assert_eq!(one_axis(measured, offset), 0);
            assert_eq!(one_axis((measured + 1) % 36_000, offset), 1);
        }
    }

    #[test]
    fn two_axis_is_limited_and_auto_offset_gives_0() {
        assert_eq!(two_axis(9_000, 1), 9_000);
        assert_eq!(two_axis(-9_000, -9_000), -9_000);
        assert_eq!(two_axis(-9_000, 9_000), 0);
        assert_eq!(two_axis(i32::MAX, i16::MAX), 9_000);
        assert_eq!(two_axis_auto(i32::MIN), 9_000);
        for measured in -9_000..=9_000 {
            let offset = two_axis_auto(measured);
            assert_eq!(i32::from(offset), -measured);
            assert_eq!(two_axis(measured, offset), 0);
        }
    }
}
