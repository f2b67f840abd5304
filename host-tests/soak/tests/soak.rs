//! Each kind of sensor in random use for some simulated minutes.

use soak::stand::kinds;
use soak::step::Step;
use soak::steps;
use soak::use_case::UseCase;
use std::thread;

/// Steps with each kind of sensor.
const STEPS: u32 = 150;

#[test]
fn each_sensor_in_random_use_answers_and_keeps_its_settings() {
    let kinds = kinds();
    let updates: u64 = thread::scope(|scope| {
        let runs: Vec<_> = kinds
            .iter()
            .map(|kind| scope.spawn(|| updates_in_random_use(kind)))
            .collect();
        let updates = runs.into_iter().map(|run| run.join().expect("no failure"));
        updates.sum()
    });
    assert!(updates > 20, "{updates}");
}

/// The number of updates of a sensor of this kind.
fn updates_in_random_use(kind: &str) -> u64 {
    let mut sensor = UseCase::new(kind, 7).unwrap_or_else(|failure| panic!("{kind}: {failure}"));
    for number in 1..=STEPS {
        let result = sensor.step();
        result
            .unwrap_or_else(|(step, failure)| panic!("{kind}, step {number} {step:?}: {failure}"));
    }
    assert!(
        sensor.counts.of(Step::PowerCut) > 3 && sensor.counts.of(Step::BusFault) > 3,
        "{kind}: {}",
        sensor.counts
    );
    sensor.counts.of(Step::Update)
}

#[test]
fn random_steps_are_counted() {
    let done = steps::run(30_000, 1).expect("no sensor fails");
    assert_eq!(done.steps, 30_000);
    assert!(done.sent > 0 && done.power_cuts > 0, "{done:?}");
}
