//! Tests of the heater on a thermal model: a body with a capacity, a loss to ambient and a sensor that lags.

use super::*;
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

/// The period in s.
const STEP: f64 = 0.2;

/// Temperatures in degC.
#[derive(Clone, Debug)]
struct Body {
    temperature: f64,
    sensed: f64,
    ambient: f64,
    /// How much warmer than ambient the heater makes it when fully on, in K.
    rise: f64,
    /// In s.
    time_constant: f64,
    /// By how much the sensor lags, in s.
    lag: f64,
}

impl Body {
    /// A body at the temperature around it.
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

    /// What the sensor says: steps of 1/256 K.
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

    /// `seconds` of regulation; what comes of it after each period.
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
    rises.into_iter().flat_map(move |rise| {
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
    })
}

/// How a run went, in K from the set point.
#[derive(Default)]
struct Course {
    overshoot: f64,
    /// The largest distance in the last two minutes.
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
fn from_every_ambient_the_set_point_is_reached_with_at_most_0_6_kelvin_of_overshoot() {
    for ambient in (-40..=45).step_by(5) {
        for mut body in bodies(ambient.into()) {
            let mut heater = Heater::new(&SETTINGS);
            let course = regulated(&mut heater, &mut body);
            assert!(course.overshoot <= 0.6, "{body:?}: {}", course.overshoot);
            assert!(course.error <= 0.03, "{body:?}: {}", course.error);
            assert!(heater.is_steady());
            // What holds the temperature against the loss.
            let needed = (50.0 - body.ambient) / body.rise * 1500.0;
            assert!((f64::from(heater.power()) - needed).abs() < 15.0);
        }
    }
}

/// An hour of saturation, or two: what follows must be the same, and as good as a start in the cold.
#[test]
fn nothing_winds_up_while_the_heater_is_too_weak() {
    for body in bodies(-40.0) {
        // Fully on, the body gets to 0 or 20 degC only; then the set point comes within reach.
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

/// Here the set point is missed by less than the proportional band, so the integral does rise: to what the duty lacks and not
/// further.
#[test]
fn saturation_close_to_the_set_point_leaves_a_bounded_overshoot() {
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
fn nothing_winds_up_while_it_is_too_hot() {
    for body in bodies(80.0) {
        let lowest = [60, 7200].map(|seconds| {
            let mut body = body.clone();
            let mut heater = Heater::new(&SETTINGS);
            body.run(&mut heater, seconds, |_, heater| {
                assert_eq!(heater.duty(), 0);
            });
            assert!(!heater.is_steady());
            // It cools down past the set point, and is caught there.
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
fn above_the_set_point_it_stays_off() {
    for ambient in [51.0, 60.0, 80.0] {
        let mut body = Body::at(ambient);
        let mut heater = Heater::new(&SETTINGS);
        body.run(&mut heater, 600, |_, heater| {
            assert_eq!((heater.duty(), heater.power()), (0, 0));
        });
    }
}

#[test]
fn ambient_changes_are_made_up_for() {
    let mut body = Body::at(20.0);
    let mut heater = Heater::new(&SETTINGS);
    regulated(&mut heater, &mut body);
    for ambient in [-10.0, 30.0, -40.0, 40.0] {
        body.ambient = ambient;
        let mut off = 0f64;
        body.run(&mut heater, 60, |body, _| {
            off = off.max((body.temperature - 50.0).abs());
        });
        // An ambient that jumps by 80 K at once; without the regulator it would be half of that after a minute.
        assert!(off < 10.0, "{ambient}: {off}");
        assert!(regulated(&mut heater, &mut body).error <= 0.03);
    }
}

#[test]
fn a_missing_temperature_switches_off_at_once_and_the_regulator_starts_afresh() {
    let mut body = Body::at(20.0);
    let mut heater = Heater::new(&SETTINGS);
    regulated(&mut heater, &mut body);
    assert!(heater.is_steady() && heater.duty() > 0);
    assert_eq!(heater.regulate(None), 0);
    assert_eq!((heater.duty(), heater.power()), (0, 0));
    assert!(!heater.is_steady() && heater.is_enabled());
    let mut fresh = Heater::new(&SETTINGS);
    for temperature in [49_00, 49_10, 49_30] {
        let again = heater.regulate(Some(temperature));
        assert_eq!(again, fresh.regulate(Some(temperature)));
    }
}

#[test]
fn disabled_it_is_off_and_the_temperature_never_stands() {
    let mut body = Body::at(20.0);
    let mut heater = Heater::new(&SETTINGS);
    regulated(&mut heater, &mut body);
    heater.enable(false);
    assert_eq!((heater.duty(), heater.power()), (0, 0));
    assert!(!heater.is_steady() && !heater.is_enabled());
    for _ in 0..1000 {
        assert_eq!(heater.regulate(Some(50_00)), 0);
        assert!(!heater.is_steady());
    }
    heater.enable(true);
    assert_eq!(heater.regulate(Some(0)), 1000);
    // To enable it again disturbs nothing.
    let mut undisturbed = heater.clone();
    heater.enable(true);
    for temperature in [45_00, 46_00, 47_00] {
        let duty = heater.regulate(Some(temperature));
        assert_eq!(duty, undisturbed.regulate(Some(temperature)));
    }
}

#[test]
fn the_temperature_stands_after_thirty_seconds_within_half_a_kelvin() {
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
fn nothing_stands_before_it_has_been_measured() {
    static AT_ONCE: Settings = Settings {
        steady_after: 0,
        ..SETTINGS
    };
    let mut heater = Heater::new(&AT_ONCE);
    assert!(!heater.is_steady());
    heater.regulate(Some(50_00));
    assert!(heater.is_steady());
}

/// The formula of the file's doc, term by term.
#[test]
fn each_term_does_what_the_formula_says() {
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
    // At 1 K/s, 5 s of it are 5 K or 50 permille.
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
fn the_last_hundredth_of_a_kelvin_counts() {
    let mut heater = Heater::new(&SETTINGS);
    let first = heater.regulate(Some(49_99));
    assert_eq!(first, 0);
    // 0.5 permille at once, and as much again every 100 s.
    for _ in 0..500 * 20 {
        heater.regulate(Some(49_99));
    }
    assert!((9..=11).contains(&heater.duty()), "{}", heater.duty());
}

proptest! {
    #[test]
    fn any_settings_and_temperatures_are_safe(
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
