//! The numbers of a calibration in units that people read.

use super::{AXES, Vector};
use plumbline::measure::calibration::{Calibration, OFFSET_ONE_G};
use std::fmt::{self, Display, Formatter};

/// A calibration in physical units. Printed, it has a line for each correction.
pub struct Units {
    /// The offset of each axis in mg.
    pub offset: Vector,
    /// The correction matrix less the identity, row by row.
    pub deviation: [Vector; 3],
    /// The drift of the offset in mg/K.
    pub drift: Vector,
    /// The zero rate in deg/s.
    pub zero_rate: Vector,
    /// The drift of the zero rate in deg/s/K.
    pub zero_rate_drift: Vector,
}

impl From<&Calibration> for Units {
    fn from(calibration: &Calibration) -> Self {
        let (offset, deviation, drift) = calibration.numbers();
        let (zero, zero_drift) = calibration.zero_rate();
        // The resolutions are those of the byte map.
        Self {
            offset: offset.map(|value| f64::from(value) / f64::from(OFFSET_ONE_G) * 1e3),
            deviation: deviation.map(|row| row.map(|value| f64::from(value) / 262_144.0)),
            drift: drift.map(|value| f64::from(value) / 16_777_216.0 * 1e3),
            zero_rate: zero.map(|value| f64::from(value) / 4096.0),
            zero_rate_drift: zero_drift.map(|value| f64::from(value) / 1_048_576.0),
        }
    }
}

impl Display for Units {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.offset;
        writeln!(f, "offset  x {x:.3} mg, y {y:.3} mg, z {z:.3} mg")?;
        for (axis, [x, y, z]) in AXES.iter().zip(self.deviation) {
            writeln!(f, "correction of {axis}  {x:+.6} {y:+.6} {z:+.6}")?;
        }
        let [x, y, z] = self.drift;
        writeln!(f, "drift  x {x:.4} mg/K, y {y:.4} mg/K, z {z:.4} mg/K")?;
        let [x, y, z] = self.zero_rate;
        writeln!(
            f,
            "zero rate  x {x:.3} deg/s, y {y:.3} deg/s, z {z:.3} deg/s"
        )?;
        let [x, y, z] = self.zero_rate_drift;
        write!(
            f,
            "drift of the zero rate  x {x:.5} deg/s/K, y {y:.5} deg/s/K, z {z:.5} deg/s/K"
        )
    }
}

#[cfg(test)]
mod tests {
    use crate::calibrate::{Units, calibration};

    #[test]
    fn each_number_of_a_calibration_has_its_unit() {
        let text = "up,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps,temp_c
            +x,1.02,-0.03,0.05,0.25,-0.5,0.125,25\n-x,-0.98,-0.03,0.05,0.25,-0.5,0.125,25
            +y,0.02,0.97,0.05,0.25,-0.5,0.125,25\n-y,0.02,-1.03,0.05,0.25,-0.5,0.125,25
            +z,0.02,-0.03,1.06,0.25,-0.5,0.125,25\n-z,0.02,-0.03,-0.96,0.25,-0.5,0.125,25
            +x,1.022,-0.03,0.05,0.35,-0.5,0.125,45\n-x,-0.978,-0.03,0.05,0.35,-0.5,0.125,45
            +y,0.022,0.97,0.05,0.35,-0.5,0.125,45\n-y,0.022,-1.03,0.05,0.35,-0.5,0.125,45
            +z,0.022,-0.03,1.06,0.35,-0.5,0.125,45\n-z,0.022,-0.03,-0.96,0.35,-0.5,0.125,45";
        let text: String = text
            .split_whitespace()
            .map(|row| format!("{row}\n"))
            .collect();
        let calibration = calibration("rows", &text).unwrap();
        // 1 / 1.01 - 1 in steps of 2^-18 along z; 0.002 g and 0.1 deg/s in 20 K along x.
        assert_eq!(
            Units::from(&calibration).to_string(),
            "offset  x 20.000 mg, y -30.000 mg, z 50.000 mg\n\
             correction of x  +0.000000 +0.000000 +0.000000\n\
             correction of y  +0.000000 +0.000000 +0.000000\n\
             correction of z  +0.000000 +0.000000 -0.009899\n\
             drift  x 0.1000 mg/K, y 0.0000 mg/K, z 0.0000 mg/K\n\
             zero rate  x 0.250 deg/s, y -0.500 deg/s, z 0.125 deg/s\n\
             drift of the zero rate  x 0.00500 deg/s/K, y 0.00000 deg/s/K, z 0.00000 deg/s/K"
        );
    }
}
