//! Each kind of sensor in random use for some simulated minutes.

use soak::stand::kinds;
use soak::step::Step;
use soak::steps;
use soak::use_case::UseCase;

/// Steps with each kind of sensor.
const STEPS: u32 = 150;

#[test]
fn each_sensor_in_random_use_answers_and_keeps_its_settings() {
    let mut updates = 0;
    for kind in kinds() {
        let mut sensor =
            UseCase::new(&kind, 7).unwrap_or_else(|failure| panic!("{kind}: {failure}"));
        for number in 1..=STEPS {
            let result = sensor.step();
            result.unwrap_or_else(|(step, failure)| {
                panic!("{kind}, step {number} {step:?}: {failure}")
            });
        }
        assert!(
            sensor.counts.of(Step::PowerCut) > 3 && sensor.counts.of(Step::BusFault) > 3,
            "{kind}: {}",
            sensor.counts
        );
        updates += sensor.counts.of(Step::Update);
    }
    assert!(updates > 20, "{updates}");
}

#[test]
fn random_steps_are_counted() {
    let done = steps::run(30_000, 1).expect("no sensor fails");
    assert_eq!(done.steps, 30_000);
    assert!(done.sent > 0 && done.power_cuts > 0, "{done:?}");
}
