//! The motions of the plots. The sensor moves in the plane of its X and Z axes, and the plane rotates about the vertical.

use std::f64::consts::TAU;

/// A motion, at rest before 0 s.
pub struct Motion {
    /// The name of the file.
    pub name: &'static str,
    /// The title of the plot.
    pub title: &'static str,
    /// The duration of the motion in s.
    pub seconds: f64,
    /// The longitudinal angle in deg at a time in s.
    pub angle: fn(f64) -> f64,
    /// The acceleration without gravity, forward and upward in the fixed frame, in g at a time in s.
    pub acceleration: fn(f64) -> [f64; 2],
    /// The angular rate about the vertical in deg/s at a time in s.
    pub slew: fn(f64) -> f64,
}

/// The motions in the order of the documents.
pub const MOTIONS: [Motion; 5] = [
    Motion {
        name: "latency",
        title: "Rotation from -45 deg to 45 deg within 0.3 s",
        seconds: 1.6,
        angle: |t| -45.0 + 90.0 * smooth(t, 0.3, 0.3),
        acceleration: |_| [0.0; 2],
        slew: |_| 0.0,
    },
    Motion {
        name: "vibration",
        title: "Horizontal vibration of 0.5 g at 3 Hz, from 0.5 s on",
        seconds: 5.0,
        angle: |_| 0.0,
        acceleration: |t| {
            [
                if t > 0.5 {
                    0.5 * sine(3.0, t - 0.5)
                } else {
                    0.0
                },
                0.0,
            ]
        },
        slew: |_| 0.0,
    },
    Motion {
        name: "digging",
        title: "Digging: stick of an excavator, with an impact at 1.2 s and at 5.5 s",
        seconds: 8.0,
        angle: |t| {
            -30.0 + 55.0 * smooth(t, 0.5, 0.8) - 85.0 * smooth(t, 2.0, 1.5)
                + 70.0 * smooth(t, 4.8, 0.7)
                - 40.0 * smooth(t, 6.3, 0.9)
        },
        acceleration: |t| {
            let impact = impact(t - 1.2) + impact(t - 5.5);
            [0.8 * impact, 0.5 * impact]
        },
        slew: |_| 0.0,
    },
    Motion {
        name: "travelling",
        title: "Travelling on rough ground: 0.1 g forward from 1 s, 0.28 g backward from 5 s",
        seconds: 8.0,
        angle: |t| 4.0 + started(t) * (2.0 * sine(0.4, t) + 0.8 * sine(1.7, t)),
        acceleration: |t| {
            let drive = 0.1 * (smooth(t, 1.0, 0.3) - smooth(t, 2.4, 0.3));
            let brake = -0.28 * (smooth(t, 5.0, 0.2) - smooth(t, 5.5, 0.2));
            let rough = started(t) * (0.15 * sine(7.3, t) + 0.1 * sine(11.9, t));
            [drive + brake + rough, 1.5 * rough]
        },
        slew: |_| 0.0,
    },
    Motion {
        name: "slewing",
        title: "Slewing by 90 deg with 45 deg/s, sensor 4 m from the centre: 0.25 g centripetal",
        seconds: 8.0,
        angle: |t| -25.0 + 30.0 * smooth(t, 5.5, 0.8),
        acceleration: |t| [-4.0 * slew_rate(t).to_radians().powi(2) / 9.806_65, 0.0],
        slew: slew_rate,
    },
];

/// To 45 deg/s within 1 s, constant for 1 s, to 0 within 1 s: 90 deg.
fn slew_rate(time: f64) -> f64 {
    45.0 * (smooth(time, 1.0, 1.0) - smooth(time, 3.0, 1.0))
}

/// From 0 to 1 within `length`, with a continuous acceleration.
fn smooth(time: f64, start: f64, length: f64) -> f64 {
    let part = ((time - start) / length).clamp(0.0, 1.0);
    part - (TAU * part).sin() / TAU
}

/// 1 after the first half second.
fn started(time: f64) -> f64 {
    smooth(time, 0.0, 0.5)
}

fn sine(frequency: f64, time: f64) -> f64 {
    (TAU * frequency * time).sin()
}

/// An oscillation of 20 Hz that decays within some tenths of a second.
fn impact(time: f64) -> f64 {
    if time < 0.0 {
        return 0.0;
    }
    (-time / 0.06).exp() * sine(20.0, time)
}

impl Motion {
    /// The coordinates of the forward and of the upward direction in the sensor.
    fn directions(&self, time: f64) -> [[f64; 3]; 2] {
        let (sin, cos) = (self.angle)(time).to_radians().sin_cos();
        [[cos, 0.0, sin], [-sin, 0.0, cos]]
    }

    /// The specific force in g in the frame of the sensor.
    pub fn force(&self, time: f64) -> [f64; 3] {
        let [forward, up] = self.directions(time);
        let [along, vertical] = (self.acceleration)(time);
        [0, 1, 2].map(|axis| forward[axis] * along + up[axis] * (1.0 + vertical))
    }

    /// The mean angular rate in deg/s in the `period` seconds before `time`.
    pub fn mean_rate(&self, time: f64, period: f64) -> [f64; 3] {
        let nod = ((self.angle)(time) - (self.angle)(time - period)) / period;
        let middle = time - period / 2.0;
        let [_, up] = self.directions(middle);
        let [x, y, z] = up.map(|component| component * (self.slew)(middle));
        [x, y + nod, z]
    }
}
