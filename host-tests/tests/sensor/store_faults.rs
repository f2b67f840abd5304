//! The store on the simulated flash of the STM32F103 with flipped bits and broken memory.

use crate::saves::*;
use bench::{Flash, PAGE_SIZE};
use host_tests::effort;
use plumbline::store::{ImageId, Owner, StoreError};

/// Memories to damage: the newest record first, last and in the middle of a page, with and without older records.
fn memories() -> impl Iterator<Item = (Flash, usize)> {
    [1, 2, PLACES, PLACES + 1, PLACES + 5, 2 * PLACES + 1]
        .into_iter()
        .map(|count| {
            let mut store = boot(Flash::default());
            for number in 0..count {
                assert_eq!(save(&mut store, number), Ok(()));
            }
            (store.into_memory(), count - 1)
        })
}

#[test]
fn one_flipped_bit_loses_at_most_the_newest_record() {
    for (memory, newest) in memories() {
        let older = newest.checked_sub(1);
        for bit in (0..memory.bytes().len() * 8).step_by(stride()) {
            let mut flash = copy(&memory);
            flash.flip_bit(bit).unwrap();
            let after = found_by(OWNER, &flash);
            let kept = after.parameters == loaded(Some(newest), false).parameters;
            assert!(
                kept || after == loaded(older, true),
                "{newest}, bit {bit}: {after:?}"
            );
            // The next save succeeds.
            let mut store = boot(flash);
            assert_eq!(save(&mut store, 99), Ok(()), "{newest}, bit {bit}");
            let next = found(&mut store);
            assert_eq!(next, loaded(Some(99), false), "{newest}, bit {bit}");
        }
    }
}

#[test]
fn only_flipped_bits_of_the_newest_record_lose_it() {
    for (memory, newest) in memories() {
        // One bit of each byte, each bit in its turn.
        let bits = |byte: usize| {
            let turn = (byte + byte / 8) % 8;
            effort::choose(turn..turn + 1, 0..8).map(move |bit| 8 * byte + bit)
        };
        let loses = |bit| {
            let mut flash = copy(&memory);
            flash.flip_bit(bit).unwrap();
            found_by(OWNER, &flash).parameters != loaded(Some(newest), false).parameters
        };
        let lost = (0..memory.bytes().len())
            .flat_map(bits)
            .filter(|bit| loses(*bit))
            .count();
        assert_eq!(lost, RECORD * effort::choose(1, 8), "{newest}");
    }
}

#[test]
fn blank_memory_is_not_damaged_and_is_not_written() {
    let mut store = boot(Flash::default());
    assert_eq!(found(&mut store), loaded(None, false));
    let flash = store.into_memory();
    assert_eq!((flash.programmed(), flash.erased()), (0, 0));
}

#[test]
fn memory_without_any_record_is_reported_as_damage() {
    // Zeros, and bytes that no rule connects.
    let mut state = 20_210_730_u32;
    let random = std::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    });
    for memory in [vec![0; 2 * PAGE_SIZE], random.take(2 * PAGE_SIZE).collect()] {
        let flash = Flash::new(memory);
        assert_eq!(found_by(OWNER, &flash), loaded(None, true));
        let mut store = boot(flash);
        for number in 0..3 * PLACES {
            assert_eq!(save(&mut store, number), Ok(()));
            assert_eq!(found(&mut store), loaded(Some(number), false));
        }
    }
}

#[test]
fn older_record_is_loaded_when_the_newest_is_damaged() {
    let mut store = boot(Flash::default());
    assert_eq!(save(&mut store, 0), Ok(()));
    for number in 1..4 * PLACES {
        store = boot(store.into_memory());
        assert_eq!(save(&mut store, number), Ok(()));
        let mut flash = copy(store.memory());
        let before = flash.bytes().to_vec();
        assert!(!flash.corrupt_newest(), "a copy has programmed nothing");
        assert_eq!(flash.bytes(), before);
        let mut original = store.into_memory();
        assert!(original.corrupt_newest());
        assert_eq!(
            found_by(OWNER, &original),
            loaded(Some(number - 1), true),
            "{number}"
        );
        store = boot(flash);
    }
}

#[test]
fn record_of_another_product_is_reported_as_damage() {
    let mut store = boot(Flash::default());
    assert_eq!(save(&mut store, 1), Ok(()));
    let flash = store.into_memory();
    let other = Owner {
        image: ImageId::new(0x1235),
        ..OWNER
    };
    assert_eq!(found_by(other, &flash), loaded(None, true));
    // The records of this product replace it.
    let mut store = Store::open(flash, other);
    store.prepare();
    for number in 0..3 * PLACES {
        assert_eq!(save(&mut store, number), Ok(()));
        let after = found_by(other, store.memory());
        assert_eq!(after, loaded(Some(number), false));
    }
    // Another layout of the same product is not decoded either.
    let mut store = boot(Flash::default());
    assert_eq!(save(&mut store, 1), Ok(()));
    let newer = Owner { layout: 2, ..OWNER };
    assert_eq!(found_by(newer, store.memory()), loaded(None, true));
}

#[test]
fn memory_that_cannot_be_programmed_keeps_the_record() {
    for count in 1..2 * PLACES + 2 {
        let mut store = boot(Flash::default());
        for number in 0..count {
            assert_eq!(save(&mut store, number), Ok(()));
        }
        store.memory().fail_writes(true);
        for number in 0..3 * PLACES {
            assert_eq!(save(&mut store, 50), Err(StoreError));
            let after = found(&mut store).parameters;
            let kept = loaded(Some(count - 1), false).parameters;
            assert_eq!(after, kept, "after {number} failures");
        }
        store.memory().fail_writes(false);
        assert_eq!(save(&mut store, 51), Ok(()));
        assert_eq!(
            found(&mut store).parameters,
            loaded(Some(51), false).parameters
        );
    }
}

#[test]
fn memory_that_cannot_be_erased_keeps_the_record() {
    for failures in 1..=2 * PLACES {
        for restart in [false, true] {
            let mut store = boot(Flash::default());
            store.memory().fail_erases(true);
            for number in 0..2 * PLACES {
                assert_eq!(save(&mut store, number), Ok(()));
            }
            if restart {
                store = boot(store.into_memory());
            }
            for _ in 0..failures {
                assert_eq!(save(&mut store, 50), Err(StoreError));
                assert_eq!(found(&mut store), loaded(Some(2 * PLACES - 1), false));
            }
            // As soon as the memory can be erased again, a save succeeds.
            store.memory().fail_erases(false);
            assert_eq!(save(&mut store, 51), Ok(()), "after {failures} failures");
            assert_eq!(found(&mut store), loaded(Some(51), false));
        }
    }
}

#[test]
fn save_onto_a_worn_bit_fails_and_the_next_save_uses_another_place() {
    for bit in (0..2 * PAGE_SIZE * 8).step_by(7 * stride()) {
        let mut flash = Flash::default();
        flash.wear_out(bit);
        let mut store = boot(flash);
        let mut saved = None;
        for number in 0..2 * PLACES {
            if save(&mut store, number).is_ok() {
                saved = Some(number);
            } else {
                let after = found(&mut store);
                assert_eq!(after, loaded(saved, true), "bit {bit}, save {number}");
                assert_eq!(save(&mut store, number), Ok(()), "bit {bit}, save {number}");
                saved = Some(number);
            }
            assert_eq!(
                found(&mut store).parameters,
                loaded(saved, false).parameters
            );
        }
    }
}

#[test]
fn worn_out_page_does_not_lose_the_record() {
    for page in [0, 1] {
        let mut store = boot(Flash::default());
        for place in 0..PLACES {
            // A bit that is 0 in every record: the lowest bit of the letter P.
            let byte = page * PAGE_SIZE + place * RECORD;
            store.memory().wear_out(8 * byte);
        }
        let mut saved = None;
        for number in 0..5 * PLACES {
            begin(&mut store, &payload(number));
            // A power cut at any step keeps a record.
            while store.busy() {
                let result = store.step();
                let after = found(&mut store).parameters;
                let new = after == loaded(Some(number), false).parameters;
                let old = after == loaded(saved, false).parameters;
                assert!(old || new, "save {number}: {after:?}");
                if result == Some(Ok(())) {
                    saved = Some(number);
                }
            }
        }
        assert!(saved.is_some(), "the other page works");
    }
}

#[test]
fn half_a_page_of_saves_after_a_restart_never_erases() {
    for restart_after in 0..4 * PLACES {
        let mut store = boot(Flash::default());
        for number in 0..restart_after {
            assert_eq!(save(&mut store, number), Ok(()));
        }
        store = boot(store.into_memory());
        let erased = store.memory().erased();
        for number in 0..PLACES / 2 {
            assert_eq!(save(&mut store, number), Ok(()));
        }
        assert_eq!(store.memory().erased(), erased, "{restart_after} saves");
    }
}

#[test]
fn abandoned_save_does_not_affect_the_next() {
    // In the middle of a page, at the start of a blank one, and where a page must be erased first.
    for count in [1, PLACES, 2 * PLACES] {
        for steps in 0..RECORD / 4 + 1 {
            let mut store = boot(Flash::default());
            for number in 0..count {
                assert_eq!(save(&mut store, number), Ok(()));
            }
            begin(&mut store, &payload(98));
            for _ in 0..steps {
                assert_eq!(store.step(), None);
            }
            let what = format!("{count} saves and {steps} steps");
            assert_eq!(save(&mut store, 99), Ok(()), "{what}");
            let last = loaded(Some(99), false).parameters;
            assert_eq!(found(&mut store).parameters, last, "{what}");
        }
    }
}

#[test]
fn parameters_that_do_not_fit_the_buffer_fail_and_keep_the_record() {
    let mut store = boot(Flash::default());
    assert_eq!(save(&mut store, 1), Ok(()));
    begin(&mut store, &[0; PAGE_SIZE]);
    assert_eq!(finish(&mut store), Err(StoreError));
    assert_eq!(found(&mut store), loaded(Some(1), false));
    assert_eq!(save(&mut store, 2), Ok(()));
}
