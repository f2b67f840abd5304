//! Tests of the heater with a thermal model: a body with a heat capacity, a heat loss to ambient and a delayed sensor.

use super::*;
use crate::sweep::every;
use proptest::prelude::*;

static SETTINGS: Settings = Settings {
    set_point: 50_00,
    proportional: 50,
    integral_time: 100,
    derivative_time: 30,
    full_power: 1500,
    tolerance: 50,
    steady_after: 30,
};

/// The period of the controller in s.
const STEP: f64 = 0.2;

/// A simulated cell. All temperatures are in degC.
#[derive(Clone, Debug)]
struct Body {
    temperature: f64,
    sensed: f64,
    ambient: f64,
    /// The temperature rise above ambient at full power, in K.
    rise: f64,
    /// Time constant of the body in s.
    time_constant: f64,
    /// Time constant of the sensor in s.
    lag: f64,
}

impl Body {
    /// A body at ambient temperature.
    fn at(ambient: f64) -> Self {
        Self {
            temperature: ambient,
            sensed: ambient,
            ambient,
            rise: 120.0,
            time_constant: 90.0,
            lag: 2.0,
        }
    }

    /// The temperature of the sensor, with a resolution of 1/256 K.
    fn reading(&self) -> i16 {
        ((self.sensed * 256.0).round() / 256.0 * 100.0).round() as i16
    }

    /// One period with `duty` in permille.
    fn advance(&mut self, duty: u16) {
        let end = self.ambient + self.rise * f64::from(duty) / 1000.0;
        for _ in 0..20 {
            self.temperature += (end - self.temperature) * STEP / 20.0 / self.time_constant;
            self.sensed += (self.temperature - self.sensed) * STEP / 20.0 / self.lag;
        }
    }

    /// Runs the controller for `seconds` and calls `after` after each period.
    fn run(&mut self, heater: &mut Heater, seconds: u32, mut after: impl FnMut(&Self, &Heater)) {
        for _ in 0..seconds * RATE {
            let duty = heater.regulate(Some(self.reading()));
            assert!(duty <= 1000 && duty == heater.duty());
            self.advance(duty);
            after(self, heater);
        }
    }
}

fn bodies(ambient: f64) -> impl Iterator<Item = Body> {
    let rises = [105.0, 120.0, 180.0];
    let bodies = rises.into_iter().flat_map(move |rise| {
        [60.0, 90.0, 120.0]
            .into_iter()
            .flat_map(move |time_constant| {
                [1.0, 2.0, 4.0].into_iter().map(move |lag| Body {
                    rise,
                    time_constant,
                    lag,
                    ..Body::at(ambient)
                })
            })
    });
    // The two extremes and the one in the middle.
    bodies.step_by(every(13))
}

/// The control errors of a run in K.
#[derive(Default)]
struct Course {
    overshoot: f64,
    /// The largest error in the last two minutes.
    error: f64,
}

fn regulated(heater: &mut Heater, body: &mut Body) -> Course {
    let mut course = Course::default();
    body.run(heater, 1200, |body, _| {
        course.overshoot = course.overshoot.max(body.temperature - 50.0);
    });
    body.run(heater, 120, |body, _| {
        course.error = course.error.max((body.temperature - 50.0).abs());
    });
    course
}

#[test]
fn temperature_from_any_ambient_overshoots_by_at_most_0_6_kelvin() {
    for ambient in (-40..=45).step_by(5 * every(17)) {
        for mut body in bodies(ambient.into()) {
            let mut heater = Heater::new(&SETTINGS);
            let course = regulated(&mut heater, &mut body);
            assert!(course.overshoot <= 0.6, "{body:?}: {}", course.overshoot);
            assert!(course.error <= 0.03, "{body:?}: {}", course.error);
            assert!(heater.is_steady());
            // The power that compensates the heat loss.
            let needed = (50.0 - body.ambient) / body.rise * 1500.0;
            assert!((f64::from(heater.power()) - needed).abs() < 15.0);
        }
    }
}

/// One and two hours at full power must give the same course afterwards, as good as after a cold start.
#[test]
fn integral_at_full_power_does_not_wind_up() {
    for body in bodies(-40.0) {
        // At full power the body reaches only 0 or 20 degC. Then the ambient rises and the set point is reachable.
        for reached in [0.0, 20.0] {
            let after = [3600, 7200].map(|seconds| {
                let mut body = body.clone();
                let mut heater = Heater::new(&SETTINGS);
                body.ambient = reached - body.rise;
                body.run(&mut heater, seconds, |_, heater| {
                    assert_eq!(heater.duty(), 1000);
                });
                assert!(!heater.is_steady());
                body.ambient = -20.0;
                regulated(&mut heater, &mut body)
            });
            for course in &after {
                assert!(course.overshoot <= 0.6, "{body:?}: {}", course.overshoot);
                assert!(course.error <= 0.03, "{body:?}: {}", course.error);
            }
            let [hour, two] = after;
            assert!((hour.overshoot - two.overshoot).abs() < 0.01);
        }
    }
}

/// The temperature is below the set point by less than the proportional band, so the integral rises until the duty is at its
/// limit.
#[test]
fn saturation_close_to_set_point_has_limited_overshoot() {
    for body in bodies(-40.0) {
        let after = [3600, 7200].map(|seconds| {
            let mut body = body.clone();
            let mut heater = Heater::new(&SETTINGS);
            body.ambient = 45.0 - body.rise;
            body.run(&mut heater, seconds, |_, _| {});
            assert_eq!(heater.duty(), 1000);
            body.ambient += 15.0;
            regulated(&mut heater, &mut body)
        });
        for course in &after {
            assert!(course.overshoot <= 2.0, "{body:?}: {}", course.overshoot);
            assert!(course.error <= 0.03, "{body:?}: {}", course.error);
        }
        let [hour, two] = after;
        assert!((hour.overshoot - two.overshoot).abs() < 0.05);
    }
}

#[test]
fn integral_above_set_point_does_not_wind_up() {
    for body in bodies(80.0) {
        let lowest = [60, 7200].map(|seconds| {
            let mut body = body.clone();
            let mut heater = Heater::new(&SETTINGS);
            body.run(&mut heater, seconds, |_, heater| {
                assert_eq!(heater.duty(), 0);
            });
            assert!(!heater.is_steady());
            // It cools to the set point and is controlled there.
            body.ambient = 0.0;
            let mut lowest = f64::MAX;
            body.run(&mut heater, 600, |body, _| {
                lowest = lowest.min(body.temperature);
            });
            assert!(regulated(&mut heater, &mut body).error <= 0.03);
            lowest
        });
        let [minute, hours] = lowest;
        assert!((minute - hours).abs() < 0.01, "{minute} {hours}");
    }
}

#[test]
fn heater_above_set_point_stays_off() {
    for ambient in [51.0, 60.0, 80.0] {
        let mut body = Body::at(ambient);
        let mut heater = Heater::new(&SETTINGS);
        body.run(&mut heater, 600, |_, heater| {
            assert_eq!((heater.duty(), heater.power()), (0, 0));
        });
    }
}

#[test]
fn ambient_change_is_compensated() {
    let mut body = Body::at(20.0);
    let mut heater = Heater::new(&SETTINGS);
    regulated(&mut heater, &mut body);
    for ambient in [-10.0, 30.0, -40.0, 40.0] {
        body.ambient = ambient;
        let mut off = 0f64;
        body.run(&mut heater, 60, |body, _| {
            off = off.max((body.temperature - 50.0).abs());
        });
        // The ambient changes by up to 80 K at once. Without control, the error after a minute would be half of that.
        assert!(off < 10.0, "{ambient}: {off}");
        assert!(regulated(&mut heater, &mut body).error <= 0.03);
    }
}

#[test]
fn missing_temperature_switches_off_and_resets_controller() {
    let mut body = Body::at(20.0);
    let mut heater = Heater::new(&SETTINGS);
    regulated(&mut heater, &mut body);
    assert!(heater.is_steady() && heater.duty() > 0);
    assert_eq!(heater.regulate(None), 0);
    assert_eq!((heater.duty(), heater.power()), (0, 0));
    assert!(!heater.is_steady());
    let mut fresh = Heater::new(&SETTINGS);
    for temperature in [49_00, 49_10, 49_30] {
        let again = heater.regulate(Some(temperature));
        assert_eq!(again, fresh.regulate(Some(temperature)));
    }
}

#[test]
fn disabled_heater_is_off_and_never_steady() {
    let mut body = Body::at(20.0);
    let mut heater = Heater::new(&SETTINGS);
    regulated(&mut heater, &mut body);
    heater.enable(false);
    assert_eq!((heater.duty(), heater.power()), (0, 0));
    assert!(!heater.is_steady());
    for _ in 0..1000 {
        assert_eq!(heater.regulate(Some(50_00)), 0);
        assert!(!heater.is_steady());
    }
    heater.enable(true);
    assert_eq!(heater.regulate(Some(0)), 1000);
    // Enabling it again has no effect.
    let mut undisturbed = heater.clone();
    heater.enable(true);
    for temperature in [45_00, 46_00, 47_00] {
        let duty = heater.regulate(Some(temperature));
        assert_eq!(duty, undisturbed.regulate(Some(temperature)));
    }
}

#[test]
fn temperature_within_half_a_kelvin_is_steady_after_30_s() {
    for close in [49_50, 50_00, 50_50] {
        let mut heater = Heater::new(&SETTINGS);
        for _ in 1..150 {
            heater.regulate(Some(close));
            assert!(!heater.is_steady());
        }
        heater.regulate(Some(close));
        assert!(heater.is_steady());
        for far in [49_49, 50_51] {
            let mut heater = heater.clone();
            heater.regulate(Some(far));
            assert!(!heater.is_steady(), "at once");
            for _ in 1..150 {
                heater.regulate(Some(close));
                assert!(!heater.is_steady());
            }
            heater.regulate(Some(close));
            assert!(heater.is_steady());
        }
    }
}

#[test]
fn temperature_before_first_measurement_is_not_steady() {
    static AT_ONCE: Settings = Settings {
        steady_after: 0,
        ..SETTINGS
    };
    let mut heater = Heater::new(&AT_ONCE);
    assert!(!heater.is_steady());
    heater.regulate(Some(50_00));
    assert!(heater.is_steady());
}

/// Checks the formula of the module documentation, term by term.
#[test]
fn each_term_matches_formula() {
    static TERMS: Settings = Settings {
        proportional: 10,
        integral_time: 100,
        derivative_time: 0,
        ..SETTINGS
    };
    // 10 permille per K, 20 K: 200 permille; one period adds 1/500 of that.
    let mut heater = Heater::new(&TERMS);
    assert_eq!(heater.regulate(Some(30_00)), 200);
    // After Ti, the integral has doubled it.
    for _ in 1..500 {
        heater.regulate(Some(30_00));
    }
    assert_eq!(heater.duty(), 400);

    static SLOPE: Settings = Settings {
        proportional: 10,
        integral_time: 4000,
        derivative_time: 50,
        ..SETTINGS
    };
    // A slope of 1 K/s times Td of 5 s is 5 K or 50 permille.
    let mut heater = Heater::new(&SLOPE);
    let mut duty = 0;
    for n in 0..100 {
        duty = heater.regulate(Some(20_00 + 20 * n));
    }
    // 10.2 K are left; the integral is the mean of 20.1 K for 20 s.
    let integral = 10.0 * 20.1 * 20.0 / 4000.0;
    assert!(
        (f64::from(duty) - (102.0 - 50.0 + integral)).abs() < 2.0,
        "{duty}"
    );
}

#[test]
fn error_of_0_01_kelvin_changes_duty() {
    let mut heater = Heater::new(&SETTINGS);
    let first = heater.regulate(Some(49_99));
    assert_eq!(first, 0);
    // 0.5 permille at once, and 0.5 permille more every 100 s.
    for _ in 0..500 * 20 {
        heater.regulate(Some(49_99));
    }
    assert!((9..=11).contains(&heater.duty()), "{}", heater.duty());
}

proptest! {
    #[test]
    fn duty_and_power_with_any_settings_stay_in_range(
        set_point: i16,
        proportional: u16,
        integral_time: u16,
        derivative_time: u16,
        full_power: u16,
        tolerance: u16,
        steady_after: u16,
        temperatures: Vec<Option<i16>>,
    ) {
        let settings = Box::leak(Box::new(Settings {
            set_point,
            proportional,
            integral_time,
            derivative_time,
            full_power,
            tolerance,
            steady_after,
        }));
        let mut heater = Heater::new(settings);
        for temperature in temperatures {
            let duty = heater.regulate(temperature);
            prop_assert!(duty <= FULL);
            prop_assert!(heater.power() <= full_power);
            prop_assert!(temperature.is_some() || duty == 0);
        }
    }
}
