//! The motion of a sensor, its surroundings and the faults of its accelerometer, which change while the sensor runs.

use crate::fault::{Fault, FaultFrom};
use crate::motion::Motion;
use crate::scene::{Axes, Scene};
use plumbline::measure::Reading;
use plumbline::time::Instant;
use std::cell::RefCell;
use std::rc::Rc;

/// A scene that can be replaced at any time. Clones have the same state: one is the motion of a sensor, another changes it.
#[derive(Clone, Debug)]
pub struct Stage(Rc<RefCell<State>>);

#[derive(Debug)]
struct State {
    scene: Scene,
    /// The time at which the scene began.
    start: Instant,
    /// Temperature in degC and supply in V in place of those of the scene.
    temperature: Option<f64>,
    supply: Option<f64>,
    /// The faults in the order of their begin.
    faults: Vec<FaultFrom>,
}

impl State {
    /// The time since the scene began.
    fn elapsed(&self, now: Instant) -> Instant {
        Instant::from_ticks(now.ticks().saturating_sub(self.start.ticks()))
    }

    fn fault(&self, now: Instant) -> Option<Fault> {
        let begun = self.faults.iter().rev().find(|fault| fault.from <= now);
        begun.map(|begun| begun.fault)
    }
}

impl Stage {
    /// This scene from time 0 on, and these faults in any order. At each time, the fault that began last is in force.
    pub fn new(scene: Scene, faults: &[FaultFrom]) -> Self {
        let mut faults = faults.to_vec();
        faults.sort_by_key(|fault| fault.from);
        Self(Rc::new(RefCell::new(State {
            scene,
            start: Instant::from_ticks(0),
            temperature: None,
            supply: None,
            faults,
        })))
    }

    /// Replaces the scene; time 0 of the new one is `now`.
    pub fn play(&self, now: Instant, scene: Scene) {
        let mut state = self.0.borrow_mut();
        (state.scene, state.start) = (scene, now);
    }

    /// The angles in degrees that the force has now.
    pub fn angles(&self, now: Instant, axes: Axes) -> (f64, f64) {
        let state = self.0.borrow();
        state.scene.angles(state.elapsed(now), axes)
    }

    /// Sets the temperature in degC; None: that of the scene.
    pub fn set_temperature(&self, celsius: Option<f64>) {
        self.0.borrow_mut().temperature = celsius;
    }

    /// Sets the supply in V; None: that of the scene.
    pub fn set_supply(&self, volts: Option<f64>) {
        self.0.borrow_mut().supply = volts;
    }

    /// Replaces all faults, also those that have not begun yet. None: the accelerometer works.
    pub fn set_fault(&self, now: Instant, fault: Option<Fault>) {
        let fault = fault.map(|fault| FaultFrom { fault, from: now });
        self.0.borrow_mut().faults = fault.into_iter().collect();
    }
}

impl Motion for Stage {
    fn reading(&mut self, now: Instant) -> Reading {
        let mut state = self.0.borrow_mut();
        let elapsed = state.elapsed(now);
        let reading = state.scene.reading(elapsed);
        let temperature = state.temperature.map_or(reading.temperature, |celsius| {
            // A cast saturates, at 327 degC.
            (celsius * 100.0).round() as i16
        });
        let reading = Reading {
            temperature,
            ..reading
        };
        match state.fault(now) {
            Some(fault) => fault.of(reading),
            None => reading,
        }
    }

    fn supply(&mut self, now: Instant) -> u16 {
        let mut state = self.0.borrow_mut();
        let elapsed = state.elapsed(now);
        match state.supply {
            // A cast saturates, at 65.5 V.
            Some(volts) => (volts * 1000.0).round() as u16,
            None => state.scene.supply(elapsed),
        }
    }

    fn fault(&self, now: Instant) -> Option<Fault> {
        self.0.borrow().fault(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::measure::ONE_G;

    fn at(seconds: u64) -> Instant {
        Instant::from_ticks(seconds * 1_000_000)
    }

    #[test]
    fn fault_that_began_last_is_in_force_until_it_is_replaced() {
        let faults = ["zero@3", "silent@2"].map(|text| {
            let text = format!("accelerometer={text}");
            text.parse().expect("a fault")
        });
        let level = Scene::tilt(0.0, 0.0, Axes::Two).expect("it exists");
        let mut stage = Stage::new(level, &faults);
        let mut see = |s: u64| (stage.fault(at(s)), stage.reading(at(s)).acceleration.z);
        assert_eq!(see(1), (None, ONE_G));
        assert_eq!(see(2), (Some(Fault::Silent), ONE_G));
        assert_eq!(see(3), (Some(Fault::Zero), 0));
        stage.set_fault(at(4), None);
        let mut see = |s: u64| (stage.fault(at(s)), stage.reading(at(s)).acceleration.z);
        assert_eq!(see(4), (None, ONE_G));
    }

    #[test]
    fn scene_begins_when_it_is_played_and_goes_on_from_its_angles() {
        let axes = Axes::Two;
        let level = Scene::tilt(3.0, 4.0, axes).expect("it exists");
        let stage = Stage::new(level, &[]);
        let (x, y) = stage.angles(at(100), axes);
        let turn = Scene::turn((x, y), (2.0, 0.0), Some(5.0), axes).expect("it exists");
        stage.play(at(100), turn);
        for (s, expected) in [(100, 3.0), (101, 5.0), (105, 13.0), (500, 13.0)] {
            let (x, y) = stage.angles(at(s), axes);
            assert!(
                (x - expected).abs() < 1e-9 && (y - 4.0).abs() < 1e-9,
                "{s}: {x} {y}"
            );
        }
        let mut motion = stage.clone();
        let rate = motion.reading(at(102)).angular_rate;
        // 2 deg/s about Y, 1 deg/s = 2^16: the up vector (-sin X, sin Y, ...) turns towards -X.
        assert!(
            rate.x.abs() < 16_000 && (rate.y.abs() - 131_072).abs() < 1500,
            "{rate:?}"
        );
        assert_eq!(motion.reading(at(106)).angular_rate.y, 0);
    }

    #[test]
    fn temperature_and_supply_replace_those_of_the_scene() {
        let scene = Scene::recorded("t_s,ax_g,ay_g,az_g,temp_c,supply_v\n0,0,0,1,-10,12\n");
        let mut stage = Stage::new(scene.expect("a recording"), &[]);
        let see = |stage: &mut Stage| (stage.reading(at(1)).temperature, stage.supply(at(1)));
        assert_eq!(see(&mut stage), (-10_00, 12_000));
        stage.set_temperature(Some(71.5));
        stage.set_supply(Some(8.25));
        assert_eq!(see(&mut stage), (71_50, 8_250));
        stage.set_temperature(None);
        stage.set_supply(None);
        assert_eq!(see(&mut stage), (-10_00, 12_000));
    }
}
