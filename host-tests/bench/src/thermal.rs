//! The measuring cell and its heater: the simplest thermal model with a heater.
//!
//! ```text
//! time constant * dT/dt = ambient + rise * duty - T
//! ```
//!
//! The model has one temperature and one time constant. The ambient is the temperature of the scene, the accelerometer reads that
//! of the cell. Before the first reading the cell has the ambient temperature. While the power is off it cools down by the same
//! equation.
//!
//! A sensor of GEMAC's reference line reaches its constant temperature, and clears its AccuracyWarning, about two minutes after a
//! start at 25 degC and four after one at -20 degC; the manual gives its accuracy after a running time of 10 minutes.

use crate::fault::Fault;
use crate::motion::Motion;
use plumbline::measure::Reading;
use plumbline::time::Instant;
use std::cell::RefCell;
use std::rc::Rc;

/// The thermal properties of a cell and its heater.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Body {
    /// Temperature rise of the cell above ambient with the heater fully on, in K.
    pub rise: f64,
    /// The time constant in s.
    pub time_constant: f64,
}

/// The state of a cell.
#[derive(Clone, Debug)]
pub struct Cell {
    body: Body,
    /// The time and the temperature of the last reading in degC; None before the first.
    last: Option<(Instant, f64)>,
}

impl Cell {
    /// A cell at ambient temperature.
    pub fn new(body: Body) -> Self {
        Self { body, last: None }
    }

    /// The reading of the accelerometer in the cell, for this heater duty in permille since the last reading. `scene` is the
    /// reading of the scene, with the ambient temperature.
    pub fn reading(&mut self, now: Instant, duty: u16, scene: Reading) -> Reading {
        let ambient = f64::from(scene.temperature) / 100.0;
        let temperature = self.last.map_or(ambient, |(then, temperature)| {
            let end = ambient + self.body.rise * f64::from(duty) / 1000.0;
            let seconds = now.ticks().saturating_sub(then.ticks()) as f64 / 1e6;
            end + (temperature - end) * (-seconds / self.body.time_constant).exp()
        });
        self.last = Some((now, temperature));
        Reading {
            // A cast saturates, so a value beyond the range of a reading is set to its limit.
            temperature: (temperature * 100.0).round() as i16,
            ..scene
        }
    }
}

/// A cell for an accelerometer that is simulated separately, as on a simulated microcontroller.
#[derive(Clone, Debug)]
pub struct Heated(Rc<RefCell<(Cell, u16)>>);

impl Heated {
    /// A cell at ambient temperature, not heated.
    pub fn new(body: Body) -> Self {
        Self(Rc::new(RefCell::new((Cell::new(body), 0))))
    }

    /// Sets the duty of the heater in permille from now on.
    pub fn set_duty(&self, duty: u16) {
        self.0.borrow_mut().1 = duty;
    }

    /// The motion of the accelerometer, at the temperature of the cell.
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

    fn supply(&mut self, now: Instant) -> u16 {
        self.motion.supply(now)
    }

    fn fault(&self, now: Instant) -> Option<Fault> {
        self.motion.fault(now)
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

    /// Reads every 5 ms with this duty; returns the final temperature in 0.01 degC.
    fn run(cell: &mut Cell, seconds: u64, duty: u16, around: i16) -> i16 {
        let step = |step: u64| Instant::from_ticks(step * 5000);
        let readings = (0..=seconds * 200).map(|n| cell.reading(step(n), duty, ambient(around)));
        readings.last().map_or(0, |reading| reading.temperature)
    }

    #[test]
    fn cell_stays_at_ambient_without_heat() {
        let mut cell = Cell::new(BODY);
        assert_eq!(run(&mut cell, 100, 0, -20_00), -20_00);
    }

    /// 63.21 % of the rise after one time constant, 100 % after many; the same in small steps and in one step.
    #[test]
    fn heat_raises_cell_temperature_exponentially() {
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
    fn cell_changes_only_temperature_of_reading() {
        let scene = Reading {
            clipped: true,
            acceleration: plumbline::measure::I32x3 { x: 1, y: 2, z: 3 },
            ..ambient(25_00)
        };
        assert_eq!(Cell::new(BODY).reading(at(0), 0, scene), scene);
    }
}
