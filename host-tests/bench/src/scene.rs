//! The motion of a virtual sensor: a fixed tilt, a recording in a CSV file, a turn, an oscillation, or a slow sway.

mod course;
mod recording;

use crate::motion::{Motion, NOMINAL_SUPPLY};
use crate::{Flash, NodeType, STORE_BUFFER};
use course::Course;
use plumbline::measure::{I32x3, ONE_G, RANGE, Reading};
use plumbline::node::Boot;
use plumbline::store::Store;
use plumbline::time::Instant;
use recording::Recording;
use std::f64::consts::TAU;
use std::path::Path;
use std::str::FromStr;

/// The number of angles that the sensor in the scene measures. The two types are mounted differently, so the same angles are
/// different positions in space.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Axes {
    /// 360 deg about Z, which is horizontal. Angle 0: Y points up; 90 deg: X points up.
    One,
    /// X and Y, perpendicular angles of +-90 deg. Level: Z points up.
    Two,
}

impl Axes {
    /// The number of angles of a sensor of this type as delivered.
    pub fn of(node_type: &NodeType) -> Self {
        Self::after(node_type, &Boot::default())
    }

    /// The number of angles of a unit with this memory, which can select the variant.
    pub fn stored(node_type: &NodeType, serial: u32, memory: Flash) -> (Self, Flash) {
        let mut store: Store<_, [u8; STORE_BUFFER]> = Store::open(memory, node_type.owner(serial));
        let axes = Self::after(node_type, &store.boot());
        (axes, store.into_memory())
    }

    fn after(node_type: &NodeType, boot: &Boot) -> Self {
        let node = node_type.start(Instant::from_ticks(0), boot);
        match node.readout().y {
            None => Self::One,
            Some(_) => Self::Two,
        }
    }
}

/// The temperatures in degC that a scene can have.
pub const TEMPERATURES: (f64, f64) = (-100.0, 200.0);

/// The supplies in V that a scene can have.
pub const SUPPLIES: (f64, f64) = (0.0, 60.0);

/// The reason why a scene cannot be played.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum SceneError {
    /// The text after `--scene` is invalid, or the requested scene is impossible.
    #[error("{0}")]
    Argument(String),
    /// The recording cannot be read or has an error.
    #[error("{0}")]
    File(String),
}

/// The argument of `--scene`: a constant tilt or a recording.
#[derive(Clone, PartialEq, Debug)]
pub enum SceneArgument {
    /// `tilt=X,Y`, in degrees.
    Tilt(f64, f64),
    /// The name of a recording.
    File(std::path::PathBuf),
}

impl FromStr for SceneArgument {
    type Err = SceneError;

    fn from_str(text: &str) -> Result<Self, SceneError> {
        let Some(angles) = text.strip_prefix("tilt=") else {
            return Ok(Self::File(text.into()));
        };
        let number = |text: &str| {
            text.trim()
                .parse()
                .ok()
                .filter(|angle: &f64| angle.is_finite())
        };
        angles
            .split_once(',')
            .and_then(|(x, y)| Some(Self::Tilt(number(x)?, number(y)?)))
            .ok_or_else(|| {
                SceneError::Argument(format!(
                    "\"{text}\" is not a tilt: write tilt=X,Y with two angles in degrees, as in tilt=10,-2.5"
                ))
            })
    }
}

/// The motion of the virtual sensor. Its time is simulation time, which starts with the process.
#[derive(Clone, PartialEq, Debug)]
pub struct Scene(Kind);

#[derive(Clone, PartialEq, Debug)]
enum Kind {
    Rest(Sample),
    Recording(Recording),
    Course(Course, Axes),
    Sway(Axes),
}

impl Scene {
    /// The scene of `--scene`; None: the sway.
    pub fn open(argument: Option<&SceneArgument>, axes: Axes) -> Result<Self, SceneError> {
        match argument {
            None => Ok(Self::sway(axes)),
            Some(SceneArgument::Tilt(x, y)) => Self::tilt(*x, *y, axes),
            Some(SceneArgument::File(path)) => Self::recording(path),
        }
    }

    /// At rest and noise-free, at these angles in degrees.
    ///
    /// With two axes X and Y are the perpendicular angles; the sum of the squares of their sines cannot exceed 1. With one axis
    /// X is the angle (any; it repeats every 360 deg) and Y the cross slope of +-90 deg.
    pub fn tilt(x: f64, y: f64, axes: Axes) -> Result<Self, SceneError> {
        attitude(x, y, axes).map(|up| Self(Kind::Rest(Sample::at_rest(up))))
    }

    /// A recording: a CSV file with the columns `t_s,ax_g,ay_g,az_g[,gx_dps,gy_dps,gz_dps][,temp_c][,supply_v]`.
    ///
    /// Specific force in g, angular rate in deg/s (0 without these columns), temperature in degC (25), in the sensor frame, and the
    /// supply of the sensor in V (24). Values are linear between rows; the first row is held before its time, the last after its
    /// time. Lines that start with `#` are comments.
    pub fn recording(path: &Path) -> Result<Self, SceneError> {
        Recording::open(path)
            .map(|recording| Self(Kind::Recording(recording)))
            .map_err(SceneError::File)
    }

    /// A recording whose file has this text.
    pub fn recorded(text: &str) -> Result<Self, SceneError> {
        Recording::of_text(text)
            .map(|recording| Self(Kind::Recording(recording)))
            .map_err(SceneError::File)
    }

    /// A turn from these angles (in degrees) with these rates (in deg/s), for this time (in s), then at rest. Without a time the turn
    /// ends where the angles end.
    pub fn turn(
        from: (f64, f64),
        rates: (f64, f64),
        time: Option<f64>,
        axes: Axes,
    ) -> Result<Self, SceneError> {
        Course::turn(from, rates, time, axes).map(|course| Self(Kind::Course(course, axes)))
    }

    /// An oscillation around these angles with these amplitudes (both in degrees), at this frequency in Hz.
    pub fn sine(
        around: (f64, f64),
        amplitudes: (f64, f64),
        hertz: f64,
        axes: Axes,
    ) -> Result<Self, SceneError> {
        Course::sine(around, amplitudes, hertz, axes).map(|course| Self(Kind::Course(course, axes)))
    }

    /// A slow sway with a little vibration; the same in every run.
    pub fn sway(axes: Axes) -> Self {
        Self(Kind::Sway(axes))
    }

    /// The angles in degrees that the force has at this time.
    pub fn angles(&self, now: Instant, axes: Axes) -> (f64, f64) {
        let [x, y, z] = self.sample(now).force;
        let (x, y) = match axes {
            Axes::One => (x.atan2(y), z.atan2(x.hypot(y))),
            Axes::Two => ((-x).atan2(y.hypot(z)), y.atan2(x.hypot(z))),
        };
        (x.to_degrees(), y.to_degrees())
    }

    /// The time from which on the angles do not change any more; None: they never change, or always do.
    pub fn end(&self) -> Option<Instant> {
        let seconds = match &self.0 {
            Kind::Rest(_) | Kind::Sway(_) => None,
            Kind::Recording(recording) => Some(recording.end()),
            Kind::Course(course, _) => course.end(),
        };
        // A cast saturates: a recording may end before its beginning.
        seconds.map(|seconds| Instant::from_ticks((seconds * 1e6).round() as u64))
    }

    fn sample(&self, now: Instant) -> Sample {
        let seconds = now.ticks() as f64 / 1e6;
        match &self.0 {
            Kind::Rest(sample) => *sample,
            Kind::Recording(recording) => recording.at(seconds),
            Kind::Course(course, axes) => moving(seconds, |at| course.angles(at), *axes),
            Kind::Sway(axes) => sway(seconds, *axes),
        }
    }
}

impl Motion for Scene {
    fn reading(&mut self, now: Instant) -> Reading {
        self.sample(now).reading()
    }

    fn supply(&mut self, now: Instant) -> u16 {
        match &self.0 {
            Kind::Recording(recording) => {
                let volts = recording.at(now.ticks() as f64 / 1e6).supply;
                // A cast saturates, at 65.5 V.
                (volts * 1000.0).round() as u16
            }
            Kind::Rest(_) | Kind::Course(..) | Kind::Sway(_) => NOMINAL_SUPPLY,
        }
    }
}

/// A reading in g, deg/s and degC, and the supply.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Sample {
    /// The specific force along each axis, in g.
    force: [f64; 3],
    /// The angular rate about each axis, in deg/s.
    rate: [f64; 3],
    /// The temperature of the measuring cell in degC.
    temperature: f64,
    /// The supply voltage in V.
    supply: f64,
}

impl Sample {
    /// The range of the accelerometer in g.
    const RANGE: f64 = RANGE as f64 / ONE_G as f64;
    /// The default temperature in degC.
    const ROOM: f64 = 25.0;
    /// The default supply in V.
    const SUPPLY: f64 = NOMINAL_SUPPLY as f64 / 1000.0;

    fn at_rest(force: [f64; 3]) -> Self {
        Self {
            force,
            rate: [0.0; 3],
            temperature: Self::ROOM,
            supply: Self::SUPPLY,
        }
    }

    fn reading(&self) -> Reading {
        // Casts saturate, so rates and temperatures beyond the range of a reading are set to its limits.
        let vector = |values: [f64; 3], unit: f64| {
            let [x, y, z] = values.map(|value| (value * unit).round() as i32);
            I32x3 { x, y, z }
        };
        let range = Self::RANGE;
        Reading {
            acceleration: vector(
                self.force.map(|value| value.clamp(-range, range)),
                ONE_G.into(),
            ),
            angular_rate: vector(self.rate, 65536.0),
            temperature: (self.temperature * 100.0).round() as i16,
            clipped: self.force.iter().any(|value| value.abs() > range),
        }
    }
}

/// The up vector (length 1) at these angles in degrees, or why there is none.
fn attitude(x: f64, y: f64, axes: Axes) -> Result<[f64; 3], SceneError> {
    let limit = match axes {
        Axes::One => f64::INFINITY,
        Axes::Two => 90.0,
    };
    if x.abs() > limit || y.abs() > 90.0 {
        return Err(SceneError::Argument(format!(
            "a tilt of {x},{y} is out of range: {} must be within -90 to 90 degrees",
            match axes {
                Axes::One => "the cross slope Y",
                Axes::Two => "X and Y",
            }
        )));
    }
    up(x, y, axes).ok_or_else(|| {
        SceneError::Argument(format!(
            "a tilt of {x},{y} does not exist: the squares of the sines of X and Y must not add up to more than 1"
        ))
    })
}

/// The up vector (length 1) at these angles in degrees; None for impossible angles.
fn up(x: f64, y: f64, axes: Axes) -> Option<[f64; 3]> {
    let (x, y) = (x.to_radians(), y.to_radians());
    match axes {
        Axes::One => Some([y.cos() * x.sin(), y.cos() * x.cos(), y.sin()]),
        Axes::Two => {
            let (x, y) = (x.sin(), y.sin());
            let rest = 1.0 - x * x - y * y;
            // 45,45 is on the limit and must not fail because of a rounding error of a sine.
            (rest > -1e-12).then(|| [-x, y, rest.max(0.0).sqrt()])
        }
    }
}

/// Sways by several degrees within tens of seconds, like a boom, with a vibration of a few mg.
fn sway(seconds: f64, axes: Axes) -> Sample {
    let wave = |seconds: f64, period: f64| (TAU * seconds / period).sin();
    let angles = |seconds: f64| {
        let wave = |period: f64| wave(seconds, period);
        match axes {
            Axes::One => (30.0 * wave(24.0), 1.5 * wave(11.0)),
            Axes::Two => (8.0 * wave(20.0), 5.0 * wave(13.0)),
        }
    };
    let still = moving(seconds, angles, axes);
    let vibration = [
        0.003 * wave(seconds, 1.0 / 17.3),
        0.003 * wave(seconds, 1.0 / 23.9),
        0.002 * wave(seconds, 1.0 / 31.1),
    ];
    Sample {
        force: [0, 1, 2].map(|i| still.force[i] + vibration[i]),
        ..still
    }
}

/// The sample of a sensor whose angles change with the time.
fn moving(seconds: f64, angles: impl Fn(f64) -> (f64, f64), axes: Axes) -> Sample {
    let attitude = |seconds: f64| {
        let (x, y) = angles(seconds);
        up(x, y, axes).unwrap_or([0.0, 0.0, 1.0])
    };
    let step = 1e-3;
    let (before, now, after) = (
        attitude(seconds - step),
        attitude(seconds),
        attitude(seconds + step),
    );
    // The up vector u is constant in the world, so in the sensor frame du/dt = u x w; without a rotation about u itself the rate
    // is w = du/dt x u.
    let change = [0, 1, 2].map(|i| (after[i] - before[i]) / (2.0 * step));
    Sample {
        rate: cross(change, now).map(f64::to_degrees),
        ..Sample::at_rest(now)
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests;
