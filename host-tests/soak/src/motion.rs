//! The motion of the sensor: rest, vibration, shocks and faults of the accelerometer.

use crate::random::Random;
use bench::fault::{Fault, FaultFrom};
use bench::motion::Motion;
use bench::scene::{Axes, Scene};
use bench::stage::Stage;
use plumbline::measure::{I32x3, ONE_G, RANGE, Reading};
use plumbline::time::Instant;

/// At rest at a random tilt, and this tilt in degrees.
pub fn rest(random: &mut Random, axes: Axes) -> (Scene, [f64; 2]) {
    loop {
        let (x, y) = (random.signed() * 40.0, random.signed() * 40.0);
        if let Ok(scene) = Scene::tilt(x, y, axes) {
            return (scene, [x, y]);
        }
    }
}

/// A random motion: rest, vibration with shocks.
pub fn any(random: &mut Random, axes: Axes) -> Box<dyn Motion> {
    let (scene, _) = rest(random, axes);
    match random.below(3) {
        0 => Box::new(scene),
        1 => {
            let from = Instant::from_ticks(0);
            let fault =
                *random.one_of(&[Fault::Zero, Fault::Frozen, Fault::Stopped, Fault::Silent]);
            Box::new(Stage::new(scene, &[FaultFrom { fault, from }]))
        }
        _ => Box::new(Shaken {
            scene,
            random: random.clone(),
            amplitude: random.below(ONE_G as u32),
        }),
    }
}

/// Vibration of any frequency, and a shock now and then.
struct Shaken {
    scene: Scene,
    random: Random,
    amplitude: u32,
}

impl Motion for Shaken {
    fn reading(&mut self, now: Instant) -> Reading {
        let rest = self.scene.reading(now);
        let is_shock = self.random.below(2_000) == 0;
        let amplitude = match is_shock {
            true => 3 * RANGE as u32,
            false => self.amplitude,
        };
        let random = &mut self.random;
        let mut clipped = false;
        let mut shaken = |value: i32, amplitude: u32| {
            let value = value.saturating_add((random.signed() * f64::from(amplitude)) as i32);
            clipped |= value.abs() > RANGE;
            value.clamp(-RANGE, RANGE)
        };
        let I32x3 { x, y, z } = rest.acceleration;
        let acceleration = I32x3 {
            x: shaken(x, amplitude),
            y: shaken(y, amplitude),
            z: shaken(z, amplitude),
        };
        let angular_rate = I32x3 {
            x: shaken(0, amplitude / 16),
            y: shaken(0, amplitude / 16),
            z: shaken(0, amplitude / 16),
        };
        Reading {
            acceleration,
            angular_rate,
            clipped,
            ..rest
        }
    }
}
