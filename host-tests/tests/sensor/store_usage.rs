//! The usage of a device in its store: kept while it runs, with power cuts, beside the saves.

use crate::saves::*;
use bench::{Flash, PAGE_SIZE};
use host_tests::effort;
use plumbline::store::Usage;

/// The usage of step `number`, without saves and erases.
fn usage(number: u32) -> Usage {
    Usage {
        minutes: 60 * number,
        starts: number / 3 + 1,
        coldest: -(number as i16),
        warmest: 2000 + number as i16,
        shock: 1000 + number as u16,
        ..Usage::NONE
    }
}

/// Keeps the usage of this step; false if it was not kept.
fn keep(store: &mut Store, number: u32) -> bool {
    store.keep(&usage(number), 0) && finish(store).is_ok()
}

/// The usage that the device finds, without saves and erases.
fn kept(flash: &Flash) -> Usage {
    let usage = Store::open(copy(flash), OWNER).boot().usage;
    Usage {
        saves: 0,
        erases: 0,
        ..usage
    }
}

/// Keeps the usage again and again, with starts between. Calls `check` after each step with the number of the last usage that was kept.
fn run(flash: Flash, steps: u32, mut check: impl FnMut(&mut Store, u32) -> bool) -> (Flash, u32) {
    let mut store = boot(flash);
    let mut last = 0;
    for number in 1..=steps {
        if number % 3 == 0 {
            store = boot(store.into_memory());
        }
        if keep(&mut store, number) {
            last = number;
        }
        if !check(&mut store, last) {
            break;
        }
    }
    (store.into_memory(), last)
}

/// A memory with calibration, identity and parameters.
fn commissioned() -> Flash {
    let mut store = boot(calibrated());
    store.identify(&unit());
    assert_eq!(finish(&mut store), Ok(()));
    let mut store = boot(store.into_memory());
    assert_eq!(save(&mut store, 5), Ok(()));
    store.into_memory()
}

fn memories() -> [Flash; 3] {
    let mut store = boot(Flash::default());
    assert_eq!(save(&mut store, 5), Ok(()));
    [Flash::default(), store.into_memory(), commissioned()]
}

#[test]
fn usage_is_found_after_a_start_with_its_saves_and_erases() {
    let mut store = boot(commissioned());
    assert_eq!(save(&mut store, 6), Ok(()));
    assert!(keep(&mut store, 7));
    let usage = Usage {
        saves: 1,
        erases: 0,
        ..usage(7)
    };
    let mut store = boot(store.into_memory());
    assert_eq!(store.boot().usage, usage);
    // It is that of another chip.
    let other = plumbline::store::Owner { serial: 1, ..OWNER };
    let mut store = Store::open(store.into_memory(), other);
    assert_eq!(store.boot().usage, Usage::NONE);
}

#[test]
fn usage_stays_the_same_when_saves_fill_both_slots() {
    for memory in memories() {
        let mut store = boot(memory);
        assert!(keep(&mut store, 9));
        for number in 0..5 * PLACES {
            assert_eq!(save(&mut store, number), Ok(()));
            assert_eq!(kept(store.memory()), usage(9), "save {number}");
        }
    }
}

/// Neither the newest parameters nor the other records change, and there is no memory error.
#[test]
fn usage_is_kept_over_hundreds_of_starts_and_changes_no_other_record() {
    for memory in memories() {
        let before = found_by(OWNER, &memory);
        let mut kept_steps = 0;
        let mut erased = 0;
        let (flash, last) = run(memory, 1000, |store, last| {
            assert_eq!(found(store), before, "step {last}");
            assert_eq!(kept(store.memory()), usage(last));
            kept_steps += 1;
            erased = store.memory().erased();
            true
        });
        assert_eq!(kept_steps, 1000);
        // Three in a start are always kept.
        assert_eq!(last, 1000);
        // A slot is erased when it was filled, and only at a start.
        let most = 1000 * USAGE_RECORD as u64 / (PAGE_SIZE as u64 / 2);
        assert!(erased <= most, "{erased} erases, at most {most}");
        assert_eq!(found_by(OWNER, &flash), before);
    }
}

#[test]
fn keeping_erases_no_slot_and_leaves_half_a_slot_for_saves() {
    for memory in memories() {
        let mut store = boot(memory);
        let erased = store.memory().erased();
        let count = (1..1000)
            .take_while(|number| keep(&mut store, *number))
            .count();
        assert!(count >= 8, "{count}");
        for number in 0..PAGE_SIZE / 2 / RECORD - 6 {
            assert_eq!(save(&mut store, number), Ok(()));
        }
        assert_eq!(store.memory().erased(), erased);
    }
}

/// With little room, the usage is kept after 1, 2, 4, 8 and so on hours only.
#[test]
fn long_run_is_kept_less_often_when_the_room_is_scarce() {
    let mut store = boot(commissioned());
    let mut hours = Vec::new();
    for hour in 1..5000 {
        if store.keep(&usage(hour), hour) {
            assert_eq!(finish(&mut store), Ok(()));
            hours.push(hour);
        }
    }
    let scarce = hours.iter().position(|hour| *hour == 16).unwrap();
    assert!(
        hours[..scarce]
            .iter()
            .zip(1..)
            .all(|(hour, number)| *hour == number)
    );
    let powers: Vec<u32> = (4..13).map(|power| 1 << power).collect();
    assert_eq!(hours[scarce..], powers);
}

#[test]
fn power_cut_at_every_operation_of_keeping_costs_only_the_newest_usage() {
    const STEPS: u32 = 90;
    for memory in memories() {
        let before = found_by(OWNER, &memory);
        let mut operation = 0;
        loop {
            let mut flash = copy(&memory);
            flash.cut_in_operation_after(operation, operation.wrapping_mul(0x9E37_79B9));
            let (mut flash, last) = run(flash, STEPS, |store, _| !store.memory().is_cut());
            let what = format!("operation {operation}, after step {last}");
            if !flash.is_cut() {
                assert_eq!(last, STEPS);
                break;
            }
            let after = found_by(OWNER, &flash);
            assert_eq!(after, before, "{what}");
            let allowed = [last, last + 1].map(|number| match number {
                0 => Usage::NONE,
                number => usage(number),
            });
            let now = kept(&flash);
            assert!(allowed.contains(&now), "{what}: {now:?}");
            // The next start keeps it, and the next save succeeds.
            flash.power_on();
            let mut store = boot(flash);
            assert_eq!(found(&mut store), before, "{what}");
            assert!(keep(&mut store, 77), "{what}");
            assert_eq!(save(&mut store, 40), Ok(()), "{what}");
            let flash = store.into_memory();
            assert_eq!(kept(&flash), usage(77), "{what}");
            let end = found_by(OWNER, &flash);
            assert_eq!(end.parameters, Some(payload(40).to_vec()), "{what}");
            assert_eq!(
                (end.calibration, end.unit),
                (before.calibration, before.unit)
            );
            assert!(!end.damaged, "{what}");
            operation += effort::choose(5, 1);
        }
        assert!(operation > u64::from(STEPS) * USAGE_RECORD as u64 / 4);
    }
}

/// A save aborts the usage that is being written, after any number of its steps. A power cut at any operation of this save costs only this
/// save.
#[test]
fn power_cut_in_a_save_that_aborts_a_usage_loses_no_stored_record() {
    for memory in memories() {
        for steps in (0..=USAGE_RECORD / 4).step_by(effort::choose(3, 1)) {
            let mut operation: u64 = 0;
            loop {
                let mut store = boot(copy(&memory));
                let before = found(&mut store);
                assert!(store.keep(&usage(3), 0));
                for _ in 0..steps {
                    assert_eq!(store.step(), None);
                }
                let seed = operation.wrapping_mul(0x9E37_79B9);
                store.memory().cut_in_operation_after(operation, seed);
                let saved = save(&mut store, 40).is_ok();
                let mut flash = store.into_memory();
                let is_cut = flash.is_cut();
                flash.power_on();
                let what = format!("{steps} steps, operation {operation}");
                let after = found_by(OWNER, &flash);
                let new = Some(payload(40).to_vec());
                assert!(
                    after.parameters == new || !saved && after.parameters == before.parameters,
                    "{what}"
                );
                assert_eq!(
                    (&after.calibration, &after.unit),
                    (&before.calibration, &before.unit),
                    "{what}"
                );
                let mut store = boot(flash);
                assert_eq!(save(&mut store, 41), Ok(()), "{what}");
                let end = found(&mut store);
                assert_eq!(end.parameters, Some(payload(41).to_vec()), "{what}");
                assert!(!end.damaged, "{what}");
                if !is_cut {
                    assert!(saved, "{what}");
                    break;
                }
                operation += 1;
            }
        }
    }
}

/// An incomplete save is a memory error, also beside records of the usage.
#[test]
fn power_cut_in_a_save_is_reported_beside_records_of_the_usage() {
    for memory in memories() {
        let mut store = boot(memory);
        assert!(keep(&mut store, 1));
        let before = store.into_memory();
        let mut operation = 1;
        loop {
            let mut flash = copy(&before);
            flash.cut_in_operation_after(operation, operation.wrapping_mul(0x9E37_79B9));
            let mut store = boot(flash);
            let saved = save(&mut store, 6).is_ok();
            let after = found(&mut store);
            if saved {
                break;
            }
            let complete = after.parameters == Some(payload(6).to_vec());
            assert!(after.damaged || complete, "operation {operation}");
            assert_eq!(kept(store.memory()), usage(1));
            operation += 1;
        }
    }
}

/// The bits of all records, those of the usage and of its copies included.
#[test]
fn one_flipped_bit_beside_a_usage_changes_no_other_record_without_a_report() {
    for steps in [1, 5, 20, 33, 47] {
        let (memory, _) = run(commissioned(), steps, |_, _| true);
        let before = found_by(OWNER, &memory);
        for bit in (0..memory.bytes().len() * 8).step_by(effort::choose(3, 1)) {
            let mut flash = copy(&memory);
            flash.flip_bit(bit).unwrap();
            let mut store = boot(flash);
            let after = found(&mut store);
            let what = format!("{steps} steps, bit {bit}");
            assert!(after == before || after.damaged, "{what}: {after:?}");
            // The damage is over with the next save.
            assert_eq!(save(&mut store, 40), Ok(()), "{what}");
            assert!(!found(&mut store).damaged, "{what}");
        }
    }
}
