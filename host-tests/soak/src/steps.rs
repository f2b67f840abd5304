//! Random inputs of the node of each product: frames, samples, times, events of the bus, faults of the memory
//! ([`host_tests::fuzz`]).

use crate::random::Random;
use host_tests::fuzz::{KINDS, Sensor};
use std::panic;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

/// Steps with one sensor; then a new one is used.
const ROUND: u64 = 2_000;

/// What happened.
#[derive(Clone, Copy, Debug, Default)]
pub struct Done {
    /// The number of steps.
    pub steps: u64,
    /// Frames that the sensors have sent.
    pub sent: u64,
    /// Saves that they have confirmed.
    pub saves: u64,
    /// Times that their supply was cut.
    pub power_cuts: u64,
}

/// Performs at least this number of steps, spread over all kinds of sensors, on all processors.
///
/// # Errors
/// A sensor has panicked, or has lost a setting: how to repeat it.
pub fn run(steps: u64, seed: u64) -> Result<Done, String> {
    let rounds = steps.div_ceil(ROUND);
    let next = AtomicU64::new(0);
    let work = || {
        let mut done = Done::default();
        loop {
            let round = next.fetch_add(1, Ordering::Relaxed);
            if round >= rounds {
                return Ok(done);
            }
            let seed = seed.wrapping_add(round);
            let result = panic::catch_unwind(|| {
                let mut random = Random::new(seed);
                let mut sensor = Sensor::of_kind((seed % KINDS as u64) as usize);
                (0..ROUND).for_each(|_| sensor.step(&mut random));
                sensor.finish();
                [sensor.sent, sensor.saves, sensor.power_cuts]
            });
            let repeat = |_| format!("soak --steps {ROUND} --seed {seed} repeats it");
            let [sent, saves, power_cuts] = result.map_err(repeat)?;
            done.steps += ROUND;
            done.sent += sent;
            done.saves += saves;
            done.power_cuts += power_cuts;
        }
    };
    let processors = thread::available_parallelism().map_or(1, usize::from);
    let results: Vec<Result<Done, String>> = thread::scope(|scope| {
        let threads: Vec<_> = (0..processors).map(|_| scope.spawn(work)).collect();
        let ended = threads.into_iter().map(thread::ScopedJoinHandle::join);
        ended
            .map(|result| result.unwrap_or_else(|_| Err("a thread has panicked".to_owned())))
            .collect()
    });
    let mut sum = Done::default();
    for result in results {
        let done = result?;
        sum.steps += done.steps;
        sum.sent += done.sent;
        sum.saves += done.saves;
        sum.power_cuts += done.power_cuts;
    }
    Ok(sum)
}
