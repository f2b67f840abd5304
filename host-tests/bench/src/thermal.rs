//! The measuring cell and its heater: the simplest body that a heater can warm.
//!
//! ```text
//! time constant * dT/dt = ambient + rise * duty - T
//! ```
//!
//! One temperature, one time constant. The ambient is the temperature of the scene, the accelerometer reads the cell's. Before the first
//! reading the cell is as warm as what is around it, and while the power is off it cools down by the same law.
//!
//! A model of GEMAC's reference line is at its constant temperature, and clears its AccuracyWarning, about two minutes after a start at
//! 25 degC and four after one at -20 degC; the manual gives its accuracy after a running time of 10 minutes.

use crate::motion::Motion;
use plumbline::measure::Reading;
use plumbline::time::Instant;
use std::cell::RefCell;
use std::rc::Rc;

/// What a model's cell and heater are like.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Body {
    /// How much warmer than what is around it the cell gets with the heater fully on, in K.
    pub rise: f64,
    /// In s.
    pub time_constant: f64,
}

/// A cell at some time.
#[derive(Clone, Debug)]
pub struct Cell {
    body: Body,
    /// The time and the temperature of the last reading in degC; None before the first.
    last: Option<(Instant, f64)>,
}

impl Cell {
    /// A cell that has the temperature of what is around it.
    pub fn new(body: Body) -> Self {
        Self { body, last: None }
    }

    /// The reading of the accelerometer in the cell, when the heater has had this duty in permille since the last one. `scene` is the
    /// reading that the scene gives, with the temperature around the cell.
    pub fn reading(&mut self, now: Instant, duty: u16, scene: Reading) -> Reading {
        let ambient = f64::from(scene.temperature) / 100.0;
        let temperature = self.last.map_or(ambient, |(then, temperature)| {
            let end = ambient + self.body.rise * f64::from(duty) / 1000.0;
            let seconds = now.ticks().saturating_sub(then.ticks()) as f64 / 1e6;
            end + (temperature - end) * (-seconds / self.body.time_constant).exp()
        });
        self.last = Some((now, temperature));
        Reading {
            // A cast saturates, so what is beyond the range of a reading ends at its limits.
            temperature: (temperature * 100.0).round() as i16,
            ..scene
        }
    }
}

/// A cell around an accelerometer that is read by itself, as that of a simulated microcontroller is.
#[derive(Clone, Debug)]
pub struct Heated(Rc<RefCell<(Cell, u16)>>);

impl Heated {
    /// A cell that has the temperature of what is around it, not heated.
    pub fn new(body: Body) -> Self {
        Self(Rc::new(RefCell::new((Cell::new(body), 0))))
    }

    /// From now on the heater has this duty in permille.
    pub fn set_duty(&self, duty: u16) {
        self.0.borrow_mut().1 = duty;
    }

    /// What moves the accelerometer, at the temperature of the cell.
    pub fn around(&self, motion: Box<dyn Motion>) -> Box<dyn Motion> {
        Box::new(Inside {
            heated: self.clone(),
            motion,
        })
    }
}

struct Inside {
    heated: Heated,
    motion: Box<dyn Motion>,
}

impl Motion for Inside {
    fn reading(&mut self, now: Instant) -> Reading {
        let scene = self.motion.reading(now);
        let (cell, duty) = &mut *self.heated.0.borrow_mut();
        cell.reading(now, *duty, scene)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: Body = Body {
        rise: 150.0,
        time_constant: 150.0,
    };

    fn at(seconds: u64) -> Instant {
        Instant::from_ticks(seconds * 1_000_000)
    }

    fn ambient(temperature: i16) -> Reading {
        Reading {
            temperature,
            ..Reading::default()
        }
    }

    /// Reads every 5 ms with this duty; the temperature at the end in 0.01 degC.
    fn run(cell: &mut Cell, seconds: u64, duty: u16, around: i16) -> i16 {
        let step = |step: u64| Instant::from_ticks(step * 5000);
        let readings = (0..=seconds * 200).map(|n| cell.reading(step(n), duty, ambient(around)));
        readings.last().map_or(0, |reading| reading.temperature)
    }

    #[test]
    fn it_starts_at_the_ambient_and_stays_there_without_heat() {
        let mut cell = Cell::new(BODY);
        assert_eq!(run(&mut cell, 100, 0, -20_00), -20_00);
    }

    /// After one time constant 63.21 % of the way, after many all of it, in small steps as in one.
    #[test]
    fn heat_raises_it_exponentially() {
        let mut cell = Cell::new(BODY);
        assert_eq!(cell.reading(at(0), 1000, ambient(25_00)).temperature, 25_00);
        let mut stepwise = cell.clone();
        assert_eq!(run(&mut stepwise, 150, 1000, 25_00), 25_00 + 94_82);
        let mut temperature = |seconds, duty, around| {
            let reading = cell.reading(at(seconds), duty, ambient(around));
            reading.temperature
        };
        assert_eq!(temperature(150, 1000, 25_00), 25_00 + 94_82);
        assert_eq!(temperature(10_000, 1000, 25_00), 17_500);
        assert_eq!(temperature(20_000, 500, -20_00), 55_00);
    }

    #[test]
    fn the_rest_of_a_reading_is_the_scenes() {
        let scene = Reading {
            clipped: true,
            acceleration: plumbline::measure::I32x3 { x: 1, y: 2, z: 3 },
            ..ambient(25_00)
        };
        assert_eq!(Cell::new(BODY).reading(at(0), 0, scene), scene);
    }
}
