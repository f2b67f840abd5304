//! How the inputs of the target are changed: an input is one byte for the product and then steps of a fixed size.
//!
//! A step is changed where it is, and steps are inserted, removed and joined as a whole, so that the meaning of the other steps
//! stays. New steps are random: the fuzzer then also finds values for which the coverage gives no hint.

use libfuzzer_sys::fuzzer_mutate;

/// The steps that one change inserts or removes at most.
const STEPS_MAX: usize = 8;

/// A generator of random numbers (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    /// A number below `end`, which is not 0.
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }
}

/// Changes the input in `data[..size]`, whose steps have `STEP` bytes; returns its new size, `max_size` at most.
pub fn mutate<const STEP: usize>(
    data: &mut [u8],
    size: usize,
    max_size: usize,
    seed: u32,
) -> usize {
    if max_size <= STEP {
        return fuzzer_mutate(data, size, max_size);
    }
    let mut random = Random(seed.into());
    let at = |step: usize| 1 + step * STEP;
    let room = (max_size - 1) / STEP;
    let count = (size.saturating_sub(1) / STEP).min(room);
    if size == 0 {
        data[0] = random.next() as u8;
    }
    match random.below(16) {
        0 => {
            data[0] = random.next() as u8;
            at(count)
        }
        1..=7 if count > 0 => {
            let step = at(random.below(count));
            fuzzer_mutate(&mut data[step..step + STEP], STEP, STEP);
            at(count)
        }
        8 if count > 1 => {
            let removed = 1 + random.below((count - 1).min(STEPS_MAX));
            let from = random.below(count - removed + 1);
            data.copy_within(at(from + removed)..at(count), at(from));
            at(count - removed)
        }
        9 if count > 0 && count < room => {
            let from = at(random.below(count));
            let to = at(random.below(count + 1));
            let step: [u8; STEP] = std::array::from_fn(|byte| data[from + byte]);
            data.copy_within(to..at(count), to + STEP);
            data[to..to + STEP].copy_from_slice(&step);
            at(count + 1)
        }
        _ if count < room => {
            let new = 1 + random.below((room - count).min(STEPS_MAX));
            // Often after the last step, where the state of the sensor is what the steps have reached.
            let to = match random.below(2) {
                0 => count,
                _ => random.below(count + 1),
            };
            data.copy_within(at(to)..at(count), at(to + new));
            data[at(to)..at(to + new)].fill_with(|| random.next() as u8);
            at(count + new)
        }
        // Full.
        _ => {
            let step = at(random.below(count));
            data[step..step + STEP].fill_with(|| random.next() as u8);
            at(count)
        }
    }
}

/// Joins the first steps of `one` and the last steps of `other` in `joined`; returns the size.
pub fn cross_over<const STEP: usize>(
    one: &[u8],
    other: &[u8],
    joined: &mut [u8],
    seed: u32,
) -> usize {
    let mut random = Random(seed.into());
    let [from_one, from_other] = [one, other].map(|input| input.len().saturating_sub(1) / STEP);
    if one.is_empty() || joined.len() <= STEP {
        return 0;
    }
    let room = 1 + (joined.len() - 1) / STEP * STEP;
    let head = (1 + random.below(from_one + 1) * STEP).min(room);
    let end = 1 + from_other * STEP;
    let start = end - random.below(from_other + 1) * STEP;
    let tail = (end - start).min(room - head);
    joined[..head].copy_from_slice(&one[..head]);
    joined[head..head + tail].copy_from_slice(other.get(start..start + tail).unwrap_or_default());
    head + tail
}
