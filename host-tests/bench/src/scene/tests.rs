//! Scenes against the angle definitions of the sensors.

use super::*;
use plumbline::time::{Duration, after};
use proptest::prelude::*;

fn first(scene: Result<Scene, SceneError>) -> [f64; 3] {
    force(&scene.unwrap().reading(Instant::from_ticks(0)))
}

/// The acceleration of a reading in g.
fn force(reading: &Reading) -> [f64; 3] {
    let a = reading.acceleration;
    [a.x, a.y, a.z].map(|value| f64::from(value) / f64::from(ONE_G))
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// The perpendicular angles in degrees: of g = (-ux, uy, uz) against the planes YZ and XZ.
fn perpendicular(u: [f64; 3]) -> (f64, f64) {
    let [gx, gy, gz] = [-u[0], u[1], u[2]];
    (
        gx.atan2(gy.hypot(gz)).to_degrees(),
        gy.atan2(gx.hypot(gz)).to_degrees(),
    )
}

#[test]
fn level_and_upright_are_exact() {
    assert_eq!(first(Scene::tilt(0.0, 0.0, Axes::Two)), [0.0, 0.0, 1.0]);
    assert_eq!(first(Scene::tilt(0.0, 0.0, Axes::One)), [0.0, 1.0, 0.0]);
    assert_eq!(first(Scene::tilt(90.0, 0.0, Axes::One)), [1.0, 0.0, 0.0]);
    assert_eq!(first(Scene::tilt(270.0, 0.0, Axes::One)), [-1.0, 0.0, 0.0]);
    assert_eq!(first(Scene::tilt(0.0, 90.0, Axes::One)), [0.0, 0.0, 1.0]);
    assert_eq!(first(Scene::tilt(90.0, 0.0, Axes::Two)), [-1.0, 0.0, 0.0]);
    assert_eq!(first(Scene::tilt(0.0, -90.0, Axes::Two)), [0.0, -1.0, 0.0]);
}

#[test]
fn tilt_is_at_rest_and_noise_free() {
    let mut scene = Scene::tilt(12.0, -7.0, Axes::Two).unwrap();
    let first = scene.reading(Instant::from_ticks(0));
    assert_eq!(first, scene.reading(Instant::from_ticks(987_654_321)));
    assert_eq!(first.temperature, 2500);
    assert_eq!(first.angular_rate, I32x3 { x: 0, y: 0, z: 0 });
    assert!(!first.clipped);
}

#[test]
fn tilt_beyond_range_of_two_axes_is_refused() {
    for (x, y) in [(45.0, 45.0), (-45.0, 45.0), (30.0, -60.0), (90.0, 0.0)] {
        assert!(first(Scene::tilt(x, y, Axes::Two))[2] < 1e-5, "{x},{y}");
    }
    for (x, y) in [(45.001, 45.0), (90.0, 0.01), (60.0, 60.0)] {
        let error = Scene::tilt(x, y, Axes::Two).unwrap_err().to_string();
        assert!(
            error.contains(&format!("{x},{y} does not exist")),
            "{error}"
        );
    }
    for (x, y, axes) in [
        (90.1, 0.0, Axes::Two),
        (0.0, -91.0, Axes::Two),
        (0.0, 90.5, Axes::One),
    ] {
        let error = Scene::tilt(x, y, axes).unwrap_err().to_string();
        assert!(error.contains("-90 to 90 degrees"), "{error}");
    }
}

#[test]
fn argument_is_tilt_or_file() {
    let parse = |text: &str| text.parse::<SceneArgument>();
    assert_eq!(parse("tilt=10,-2.5"), Ok(SceneArgument::Tilt(10.0, -2.5)));
    assert_eq!(parse("tilt= 0 , 1e1"), Ok(SceneArgument::Tilt(0.0, 10.0)));
    assert_eq!(
        parse("tilt.csv"),
        Ok(SceneArgument::File("tilt.csv".into()))
    );
    for text in [
        "tilt=",
        "tilt=1",
        "tilt=1,",
        "tilt=1,2,3",
        "tilt=a,b",
        "tilt=nan,0",
        "tilt=inf,0",
    ] {
        assert!(
            parse(text).unwrap_err().to_string().contains("tilt=X,Y"),
            "{text}"
        );
    }
}

#[test]
fn unreadable_recording_is_named() {
    let error = Scene::recording(Path::new("no/such.csv")).unwrap_err();
    assert!(
        error.to_string().starts_with("cannot read no/such.csv: "),
        "{error}"
    );
}

#[test]
fn more_than_8_g_is_clipped() {
    let reading = |force: [f64; 3]| Sample::at_rest(force).reading();
    let at_the_limit = reading([8.0, -8.0, 1.0]);
    assert!(!at_the_limit.clipped);
    let beyond = reading([8.001, -9.0, 1.0]);
    assert!(beyond.clipped);
    assert_eq!(beyond.acceleration, at_the_limit.acceleration);
    assert_eq!(force(&beyond), [8.0, -8.0, 1.0]);
}

#[test]
fn rate_and_temperature_have_units_of_reading() {
    let sample = Sample {
        force: [0.0, 0.0, 1.0],
        rate: [1.0, -0.5, 1e9],
        temperature: -40.25,
        supply: 24.0,
    };
    let reading = sample.reading();
    assert_eq!(
        reading.angular_rate,
        I32x3 {
            x: 65536,
            y: -32768,
            z: i32::MAX
        }
    );
    assert_eq!(reading.temperature, -4025);
}

#[test]
fn sway_moves_repeatably_near_one_g() {
    for axes in [Axes::One, Axes::Two] {
        let (mut scene, mut again) = (Scene::sway(axes), Scene::sway(axes));
        let mut span = (f64::MAX, f64::MIN);
        let mut now = Instant::from_ticks(0);
        for _ in 0..6000 {
            let reading = scene.reading(now);
            assert_eq!(reading, again.reading(now));
            let u = force(&reading);
            assert!((length(u) - 1.0).abs() < 0.01);
            span = (span.0.min(u[0]), span.1.max(u[0]));
            now = after(now, Duration::from_ticks(5000));
        }
        assert!(span.1 - span.0 > 0.2, "{axes:?}: {span:?}");
    }
}

/// The measured rates rotate the up vector in the opposite direction.
#[test]
fn rates_of_sway_match_its_motion() {
    for axes in [Axes::One, Axes::Two] {
        let mut u = sway(0.0, axes).force;
        let dt = 1e-3;
        for step in 0..5000 {
            let rate = sway((f64::from(step) + 0.5) * dt, axes)
                .rate
                .map(f64::to_radians);
            let turn = cross(rate, u);
            u = [0, 1, 2].map(|i| u[i] - turn[i] * dt);
        }
        let there = sway(5.0, axes).force;
        let error = length([0, 1, 2].map(|i| u[i] - there[i]));
        assert!(error < 0.01, "{axes:?}: {error}");
        let start = sway(0.0, axes).force;
        assert!(length([0, 1, 2].map(|i| there[i] - start[i])) > 0.05);
    }
}

/// The error of a length in g whose three axes are rounded by at most half a unit.
const ROUNDING: f64 = 1.74 / 2.0 / ONE_G as f64;

proptest! {
    #[test]
    fn two_axes_show_requested_angles(x in -89.0f64..89.0, part in -0.999f64..0.999) {
        // Y in the range that X permits.
        let y = part * (90.0 - x.abs());
        let u = first(Scene::tilt(x, y, Axes::Two));
        prop_assert!((length(u) - 1.0).abs() < ROUNDING);
        prop_assert!(u[2] >= 0.0);
        let (found_x, found_y) = perpendicular(u);
        prop_assert!((found_x - x).abs() < 1e-4 && (found_y - y).abs() < 1e-4, "{found_x} {found_y}");
    }

    #[test]
    fn one_axis_shows_angle_modulo_360(x in -1000.0f64..1000.0, y in -89.0f64..89.0) {
        let u = first(Scene::tilt(x, y, Axes::One));
        prop_assert!((length(u) - 1.0).abs() < ROUNDING);
        let difference = (u[0].atan2(u[1]).to_degrees() - x).rem_euclid(360.0);
        prop_assert!(difference.min(360.0 - difference) < 1e-4);
        prop_assert!((u[2].asin().to_degrees() - y).abs() < 1e-4);
    }
}
