//! Computes the calibration of a unit from a six-position measurement.
//!
//! The measurement is a CSV file with the columns `up,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps,temp_c`: which axis was up (`+x`, `-x`, ...
//! `-z`), the averaged raw acceleration and angular rate in that position, and the temperature. Without a gyroscope there are no columns
//! of the rate. A row `# element adxl355` names the measuring element; without it, it is an ISM330DHCX. Six rows make a set; a second set at another temperature (at least 5 K apart) gives the temperature drift. The formulas are those of [`plumbline::measure::calibration`].

mod units;

pub use units::Units;

use plumbline::measure::calibration::{Calibration, OFFSET_ONE_G, Part};
use std::fmt::{self, Display, Formatter};

/// The temperatures of the rows of one set differ by less than this, in K.
const SAME_TEMPERATURE: f64 = 5.0;

/// The temperature at which the drift is zero, in degC.
const REFERENCE: f64 = 25.0;

/// The first row of a measurement.
pub const HEADER: &str = "up,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps,temp_c";

/// The first row of a measurement without a gyroscope.
pub const HEADER_WITHOUT_RATE: &str = "up,ax_g,ay_g,az_g,temp_c";

/// The start of the row with the name of the measuring element.
pub const ELEMENT: &str = "# element ";

const AXES: [&str; 3] = ["x", "y", "z"];

type Vector = [f64; 3];

/// The side of the sensor that is up.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Side {
    /// The vertical axis: 0 is x, 1 is y, 2 is z.
    pub axis: usize,
    /// The axis points up, otherwise down.
    pub up: bool,
}

impl Display for Side {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let sign = if self.up { '+' } else { '-' };
        let axis = AXES.get(self.axis).copied().unwrap_or_default();
        write!(f, "{sign}{axis}")
    }
}

/// One position: the side, the acceleration in g, the angular rate in deg/s, the temperature in degC.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Position {
    side: Side,
    acceleration: Vector,
    rate: Vector,
    temperature: f64,
}

/// The six positions at one temperature: up and down for each axis.
struct Set {
    up: [Vector; 3],
    down: [Vector; 3],
    /// The mean of the angular rates.
    zero: Vector,
    temperature: f64,
}

/// The measuring element of the measurement in `text`; None: it has no such row, and is an ISM330DHCX.
///
/// # Errors
/// One sentence with the file name and the line.
pub fn element(name: &str, text: &str) -> Result<Option<Part>, String> {
    let mut rows = (1..).zip(text.lines());
    let Some((line, part)) = rows.find_map(|(line, row)| Some((line, row.strip_prefix(ELEMENT)?)))
    else {
        return Ok(None);
    };
    let mut parts = Part::ALL.iter();
    let known = parts.find(|known| known.name() == part.trim());
    let known = known.ok_or_else(|| format!("{name}:{line}: unknown measuring element {part}"))?;
    Ok(Some(*known))
}

/// Computes the calibration from the measurement in `text`. `name` is the file name for error messages.
///
/// # Errors
/// One sentence with the file name and, if known, the line.
pub fn calibration(name: &str, text: &str) -> Result<Calibration, String> {
    let part = element(name, text)?.unwrap_or_default();
    let positions = parse(name, text)?;
    let mut sets = sets(name, &positions)?;
    sets.sort_by(|a, b| a.temperature.total_cmp(&b.temperature));
    let (Some(cold), Some(hot)) = (sets.first(), sets.last()) else {
        return Err(format!("{name}: no positions"));
    };
    let span = hot.temperature - cold.temperature;
    let slope = |of: &dyn Fn(&Set) -> Vector| {
        if span > 0.0 {
            combine(of(hot), of(cold), |hot, cold| (hot - cold) / span)
        } else {
            [0.0; 3]
        }
    };
    let drift = slope(&Set::offset);
    let zero_drift = slope(&|set| set.zero);
    let distance = |set: &Set| (set.temperature - REFERENCE).abs();
    let nearest = sets
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .unwrap_or(cold);
    let away = nearest.temperature - REFERENCE;
    let offset = combine(nearest.offset(), drift, |offset, drift| {
        offset - drift * away
    });
    let zero = combine(nearest.zero, zero_drift, |zero, drift| zero - drift * away);
    let deviation = nearest
        .deviation()
        .ok_or_else(|| format!("{name}: the six positions are not different"))?;

    let number = |value: f64, unit: f64| (value / unit).round() as i32;
    let short =
        |value: f64, unit: f64| number(value, unit).clamp(i16::MIN.into(), i16::MAX.into()) as i16;
    Calibration::new(
        offset.map(|g| number(g, 1.0 / f64::from(OFFSET_ONE_G))),
        deviation.map(|row| row.map(|value| short(value, 1.0 / 262_144.0))),
        drift.map(|g| short(g, 1.0 / 16_777_216.0)),
    )
    .and_then(|calibration| {
        calibration.with_zero_rate(
            zero.map(|rate| short(rate, 1.0 / 4096.0)),
            zero_drift.map(|rate| short(rate, 1.0 / 1_048_576.0)),
        )
    })
    .map(|calibration| calibration.of(part))
    .ok_or_else(|| format!("{name}: out of the range of a calibration: offset {offset:.4?} g, gain and cross axes {deviation:.4?}, drift {drift:.6?} g/K, zero rate {zero:.3?} deg/s, its drift {zero_drift:.5?} deg/s/K"))
}

fn parse(name: &str, text: &str) -> Result<Vec<Position>, String> {
    let mut lines = (1..)
        .zip(text.lines().map(str::trim))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let has_rate = match lines.next() {
        Some((_, HEADER)) => true,
        Some((_, HEADER_WITHOUT_RATE)) => false,
        Some((line, _)) => {
            return Err(format!(
                "{name}:{line}: the first row must be {HEADER_WITHOUT_RATE}, with a gyroscope {HEADER}"
            ));
        }
        None => return Err(format!("{name}: the file is empty")),
    };
    lines
        .map(|(line, row)| {
            position(row, has_rate).ok_or_else(|| format!("{name}:{line}: not a position: {row}"))
        })
        .collect()
}

fn position(row: &str, has_rate: bool) -> Option<Position> {
    let fields: Vec<&str> = row.split(',').map(str::trim).collect();
    let (up, [x, y, z], rate, temperature) = match (has_rate, &fields[..]) {
        (true, &[up, x, y, z, gx, gy, gz, temperature]) => {
            (up, [x, y, z], [gx, gy, gz], temperature)
        }
        (false, &[up, x, y, z, temperature]) => (up, [x, y, z], ["0"; 3], temperature),
        _ => return None,
    };
    let [gx, gy, gz] = rate;
    let number = |text: &str| text.parse::<f64>().ok().filter(|value| value.is_finite());
    let (sign, axis) = up.split_at_checked(1)?;
    Some(Position {
        side: Side {
            axis: AXES.iter().position(|name| *name == axis)?,
            up: match sign {
                "+" => true,
                "-" => false,
                _ => return None,
            },
        },
        acceleration: [number(x)?, number(y)?, number(z)?],
        rate: [number(gx)?, number(gy)?, number(gz)?],
        temperature: number(temperature)?,
    })
}

/// The set of the measurement in `text` to which a position at this temperature in degC belongs: its temperature, and the sides that
/// it has. None: the position begins a new set.
///
/// # Errors
/// One sentence with the file name and, if known, the line.
pub fn set_at(
    name: &str,
    text: &str,
    temperature: f64,
) -> Result<Option<(f64, Vec<Side>)>, String> {
    let mut groups = groups(&parse(name, text)?).into_iter();
    let own = groups.find(|(own, _)| (own - temperature).abs() < SAME_TEMPERATURE);
    Ok(own.map(|(own, set)| (own, set.iter().map(|position| position.side).collect())))
}

/// Sorts the positions by their temperature.
fn groups(positions: &[Position]) -> Vec<(f64, Vec<Position>)> {
    let mut sets: Vec<(f64, Vec<Position>)> = Vec::new();
    for position in positions {
        let near = |(temperature, _): &&mut (f64, Vec<Position>)| {
            (*temperature - position.temperature).abs() < SAME_TEMPERATURE
        };
        match sets.iter_mut().find(near) {
            Some((_, set)) => set.push(*position),
            None => sets.push((position.temperature, vec![*position])),
        }
    }
    sets
}

/// The complete sets of six positions.
fn sets(name: &str, positions: &[Position]) -> Result<Vec<Set>, String> {
    let complete = |(temperature, set): &(f64, Vec<Position>)| {
        let of = |axis, up| {
            let found: Vec<_> = set
                .iter()
                .filter(|position| position.side == Side { axis, up })
                .collect();
            match found[..] {
                [position] => Ok(position.acceleration),
                _ => Err(format!(
                    "{name}: {} rows for {} at {temperature} degC instead of one",
                    found.len(),
                    Side { axis, up }
                )),
            }
        };
        Ok(Set {
            up: [of(0, true)?, of(1, true)?, of(2, true)?],
            down: [of(0, false)?, of(1, false)?, of(2, false)?],
            zero: set.iter().fold([0.0; 3], |sum, position| {
                combine(sum, position.rate, |sum, rate| {
                    sum + rate / set.len() as f64
                })
            }),
            temperature: set.iter().map(|position| position.temperature).sum::<f64>()
                / set.len() as f64,
        })
    };
    groups(positions).iter().map(complete).collect()
}

impl Set {
    /// The output of the accelerometer without gravity.
    fn offset(&self) -> Vector {
        let all = self.up.iter().chain(&self.down);
        all.fold([0.0; 3], |sum, value| {
            combine(sum, *value, |sum, value| sum + value / 6.0)
        })
    }

    /// The correction matrix minus the identity; None if the response matrix cannot be inverted.
    fn deviation(&self) -> Option<[Vector; 3]> {
        // The columns of the response matrix: the output of the accelerometer for 1 g along an axis.
        let s: [Vector; 3] = std::array::from_fn(|axis| {
            combine(self.up[axis], self.down[axis], |up, down| (up - down) / 2.0)
        });
        let cross = |a: Vector, b: Vector| -> Vector {
            std::array::from_fn(|i| {
                a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3]
            })
        };
        let normal = [cross(s[1], s[2]), cross(s[2], s[0]), cross(s[0], s[1])];
        let determinant: f64 = (0..3).map(|i| s[0][i] * normal[0][i]).sum();
        (determinant.abs() > 0.5).then(|| {
            std::array::from_fn(|row| {
                std::array::from_fn(|column| {
                    normal[row][column] / determinant - f64::from(u8::from(row == column))
                })
            })
        })
    }
}

fn combine(a: Vector, b: Vector, f: impl Fn(f64, f64) -> f64) -> Vector {
    std::array::from_fn(|i| f(a[i], b[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::measure::{I32x3, ONE_G};

    /// The measurement of a unit with this offset at 25 degC, response (columns) and drift, in all six positions.
    fn measured(offset: Vector, response: [Vector; 3], drift: Vector, temperature: f64) -> String {
        let mut rows = String::new();
        for (axis, name) in ["x", "y", "z"].iter().enumerate() {
            for (sign, factor) in [("+", 1.0), ("-", -1.0)] {
                let show = |i: usize| {
                    offset[i] + drift[i] * (temperature - 25.0) + factor * response[axis][i]
                };
                let rate = |i: usize| ZERO[i] + ZERO_DRIFT[i] * (temperature - 25.0);
                rows += &format!(
                    "{sign}{name},{},{},{},{},{},{},{temperature}\n",
                    show(0),
                    show(1),
                    show(2),
                    // The rotation of the earth, with the sensor.
                    rate(0) + factor * 0.004,
                    rate(1),
                    rate(2)
                );
            }
        }
        rows
    }

    const OFFSET: Vector = [0.02, -0.03, 0.05];
    const RESPONSE: [Vector; 3] = [[1.02, 0.01, 0.0], [-0.01, 0.97, 0.02], [0.005, 0.0, 1.01]];
    const DRIFT: Vector = [0.0001, -0.0002, 0.0];
    const ZERO: Vector = [0.5, -1.2, 0.1];
    const ZERO_DRIFT: Vector = [0.005, 0.0, -0.01];

    #[test]
    fn calibration_belongs_to_the_element_in_the_measurement() {
        let rows = measured(OFFSET, RESPONSE, DRIFT, 25.0);
        for (row, expected) in [
            ("", Ok(Part::Ism330dhcx)),
            ("# element adxl355\n", Ok(Part::Adxl355)),
            ("# element ism330dhcx\r\n", Ok(Part::Ism330dhcx)),
            (
                "# element x\n",
                Err("test:2: unknown measuring element x".to_owned()),
            ),
        ] {
            let found = calibration("test", &format!("{HEADER}\n{row}{rows}"));
            assert_eq!(found.map(|found| found.part()), expected);
        }
    }

    #[test]
    fn calibrated_unit_measures_gravity_and_no_rate_at_rest() {
        let text = format!("{HEADER}\n")
            + &measured(OFFSET, RESPONSE, DRIFT, -20.0)
            + "# the hot chamber\n"
            + &measured(OFFSET, RESPONSE, DRIFT, 60.0);
        let calibration = calibration("test", &text).unwrap();
        for temperature in [-20.0, 25.0, 60.0] {
            let rate: [f64; 3] =
                std::array::from_fn(|i| ZERO[i] + ZERO_DRIFT[i] * (temperature - 25.0));
            let [x, y, z] = rate.map(|rate| (rate * 65_536.0) as i32);
            let still = calibration.apply_to_rate(I32x3 { x, y, z }, (temperature * 100.0) as i16);
            for rate in still.to_array() {
                assert!(rate.abs() < 30, "{temperature} degC: {rate} / 65536 deg/s");
            }
            for (axis, response) in RESPONSE.iter().enumerate() {
                let shown: [f64; 3] = std::array::from_fn(|i| {
                    OFFSET[i] + DRIFT[i] * (temperature - 25.0) + response[i]
                });
                let [x, y, z] = shown.map(|g| (g * f64::from(ONE_G)).round() as i32);
                let I32x3 { x, y, z } =
                    calibration.apply(I32x3 { x, y, z }, (temperature * 100.0) as i16);
                for (i, value) in [x, y, z].into_iter().enumerate() {
                    let expected = if i == axis { 1.0 } else { 0.0 };
                    let error = f64::from(value) / f64::from(ONE_G) - expected;
                    assert!(
                        error.abs() < 1e-5,
                        "{temperature} degC, axis {axis}: {i} is off by {error} g"
                    );
                }
            }
        }
    }

    #[test]
    fn measurement_without_rate_gives_no_zero_rate() {
        let with = measured(OFFSET, RESPONSE, DRIFT, 25.0);
        let without: String = with
            .lines()
            .map(|row| {
                let fields: Vec<&str> = row.split(',').collect();
                [&fields[..4], &fields[7..]].concat().join(",") + "\n"
            })
            .collect();
        let with = calibration("test", &format!("{HEADER}\n{with}")).unwrap();
        let without = calibration("test", &format!("{HEADER_WITHOUT_RATE}\n{without}")).unwrap();
        assert_eq!(without.zero_rate(), ([0; 3], [0; 3]));
        assert_eq!(without.numbers(), with.numbers());
        assert_eq!(with.zero_rate(), ([2048, -4915, 410], [0; 3]));
    }

    #[test]
    fn position_belongs_to_the_set_within_5_kelvin() {
        let text = format!("{HEADER_WITHOUT_RATE}\n+x,1,0,0,20\n-z,0,0,-1,24.9\n+x,1,0,0,60\n");
        let at = |temperature| set_at("test", &text, temperature).unwrap();
        let [plus_x, minus_z] = [(0, true), (2, false)].map(|(axis, up)| Side { axis, up });
        assert_eq!(at(16.0), Some((20.0, vec![plus_x, minus_z])));
        assert_eq!(at(25.0), None);
        assert_eq!(at(64.9), Some((60.0, vec![plus_x])));
        assert_eq!(
            (plus_x.to_string(), minus_z.to_string()),
            ("+x".to_owned(), "-z".to_owned())
        );
    }

    #[test]
    fn error_names_the_file_and_the_line() {
        let error = |text: &str| calibration("six.csv", text).unwrap_err();
        let header = "up,ax_g,ay_g,az_g,temp_c\n";
        assert_eq!(error(""), "six.csv: the file is empty");
        assert_eq!(
            error("up,x\n"),
            "six.csv:1: the first row must be up,ax_g,ay_g,az_g,temp_c, with a gyroscope \
             up,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps,temp_c"
        );
        assert_eq!(
            error(&(header.to_owned() + "+x,1,0,zero,25\n")),
            "six.csv:2: not a position: +x,1,0,zero,25"
        );
        assert_eq!(
            error(&(header.to_owned() + "+x,1,0,0,25\n")),
            "six.csv: 0 rows for +y at 25 degC instead of one"
        );
        assert_eq!(error(header), "six.csv: no positions");
        let far_off = format!("{HEADER}\n") + &measured([0.3, 0.0, 0.0], RESPONSE, DRIFT, 25.0);
        assert!(error(&far_off).contains("out of the range of a calibration"));
    }
}
