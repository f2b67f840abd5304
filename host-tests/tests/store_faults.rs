//! The store on the simulated flash of the STM32F103 with flipped bits and broken memory.

mod saves;

use bench::{Flash, PAGE_SIZE};
use plumbline::store::{ImageId, Store, StoreError};
use saves::*;

/// Memories to damage: the newest image first, last and in the middle of a page, with and without older ones.
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
fn one_flipped_bit_anywhere_costs_at_most_the_newest_image() {
    for (memory, newest) in memories() {
        let older = newest.checked_sub(1);
        for bit in 0..memory.bytes().len() * 8 {
            let mut flash = copy(&memory);
            flash.flip_bit(bit).unwrap();
            let after = found(&flash);
            let kept = after.payload == loaded(Some(newest), false).payload;
            assert!(
                kept || after == loaded(older, true),
                "{newest}, bit {bit}: {after:?}"
            );
            // The device goes on with what it has found.
            let mut store = boot(flash);
            assert_eq!(save(&mut store, 99), Ok(()), "{newest}, bit {bit}");
            let next = found(store.memory());
            assert_eq!(next, loaded(Some(99), false), "{newest}, bit {bit}");
        }
    }
}

#[test]
fn the_flipped_bits_that_cost_the_newest_image_are_its_own() {
    for (memory, newest) in memories() {
        let lost = (0..memory.bytes().len() * 8)
            .filter(|bit| {
                let mut flash = copy(&memory);
                flash.flip_bit(*bit).unwrap();
                found(&flash).payload != loaded(Some(newest), false).payload
            })
            .count();
        assert_eq!(lost, IMAGE * 8, "{newest}");
    }
}

#[test]
fn a_blank_memory_is_not_damaged_and_is_left_alone() {
    let (mut store, after) = Store::open(Flash::default(), ID, PAYLOAD);
    assert_eq!(after, loaded(None, false));
    store.prepare();
    let flash = store.into_memory();
    assert_eq!((flash.programmed(), flash.erased()), (0, 0));
}

#[test]
fn with_the_newest_image_damaged_the_older_one_is_loaded() {
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
        assert_eq!(found(&original), loaded(Some(number - 1), true), "{number}");
        store = boot(flash);
    }
}

#[test]
fn another_models_image_is_damage_to_this_one() {
    let mut store = boot(Flash::default());
    assert_eq!(save(&mut store, 1), Ok(()));
    let flash = store.into_memory();
    let other = ImageId(0x1235);
    let (mut store, after) = Store::open(flash, other, PAYLOAD);
    assert_eq!(after, loaded(None, true));
    // And this one's images replace it.
    store.prepare();
    for number in 0..3 * PLACES {
        assert_eq!(save(&mut store, number), Ok(()));
        let (_, after) = Store::open(copy(store.memory()), other, PAYLOAD);
        assert_eq!(after, loaded(Some(number), false));
    }
    // The same model with another payload is another model.
    let mut flash = Flash::default();
    let mut store = boot(copy(&flash));
    assert_eq!(save(&mut store, 1), Ok(()));
    flash = store.into_memory();
    assert_eq!(Store::open(flash, ID, PAYLOAD - 1).1, loaded(None, true));
}

#[test]
fn memory_that_cannot_be_programmed_keeps_the_image() {
    for count in 1..2 * PLACES + 2 {
        let mut store = boot(Flash::default());
        for number in 0..count {
            assert_eq!(save(&mut store, number), Ok(()));
        }
        store.memory().fail_writes(true);
        for number in 0..3 * PLACES {
            assert_eq!(save(&mut store, 50), Err(StoreError));
            let after = found(store.memory()).payload;
            let kept = loaded(Some(count - 1), false).payload;
            assert_eq!(after, kept, "after {number} failures");
        }
        store.memory().fail_writes(false);
        assert_eq!(save(&mut store, 51), Ok(()));
        assert_eq!(
            found(store.memory()).payload,
            loaded(Some(51), false).payload
        );
    }
}

#[test]
fn memory_that_cannot_be_erased_keeps_the_image() {
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
                assert_eq!(found(store.memory()), loaded(Some(2 * PLACES - 1), false));
            }
            // As soon as the memory can be erased again, a save succeeds.
            store.memory().fail_erases(false);
            assert_eq!(save(&mut store, 51), Ok(()), "after {failures} failures");
            assert_eq!(found(store.memory()), loaded(Some(51), false));
        }
    }
}

#[test]
fn a_worn_bit_is_noticed_and_the_next_save_goes_elsewhere() {
    for bit in (0..2 * PAGE_SIZE * 8).step_by(7) {
        let mut flash = Flash::default();
        flash.wear_out(bit);
        let mut store = boot(flash);
        let mut saved = None;
        for number in 0..2 * PLACES {
            if save(&mut store, number).is_ok() {
                saved = Some(number);
            } else {
                let after = found(store.memory());
                assert_eq!(after, loaded(saved, true), "bit {bit}, save {number}");
                assert_eq!(save(&mut store, number), Ok(()), "bit {bit}, save {number}");
                saved = Some(number);
            }
            assert_eq!(found(store.memory()).payload, loaded(saved, false).payload);
        }
    }
}

#[test]
fn a_page_that_is_worn_out_everywhere_never_costs_the_image() {
    for page in [0, 1] {
        let mut store = boot(Flash::default());
        for place in 0..PLACES {
            // A bit that is 0 in every image: the lowest of the letter P.
            let byte = page * PAGE_SIZE + place * IMAGE;
            store.memory().wear_out(8 * byte);
        }
        let mut saved = None;
        for number in 0..5 * PLACES {
            store.save(&payload(number));
            // Wherever the power would be cut, the image is there.
            while store.busy() {
                let result = store.step();
                let after = found(store.memory()).payload;
                let new = after == loaded(Some(number), false).payload;
                let old = after == loaded(saved, false).payload;
                assert!(old || new, "save {number}: {after:?}");
                if result == Some(Ok(())) {
                    saved = Some(number);
                }
            }
        }
        assert!(saved.is_some(), "the other page is good");
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
fn a_save_that_is_given_up_does_not_spoil_the_next() {
    // In the middle of a page, at the start of a blank one, and where a page must be erased first.
    for count in [1, PLACES, 2 * PLACES] {
        for steps in 0..IMAGE / 4 + 1 {
            let mut store = boot(Flash::default());
            for number in 0..count {
                assert_eq!(save(&mut store, number), Ok(()));
            }
            store.save(&payload(98));
            for _ in 0..steps {
                assert_eq!(store.step(), None);
            }
            let what = format!("{count} saves and {steps} steps");
            assert_eq!(save(&mut store, 99), Ok(()), "{what}");
            let last = loaded(Some(99), false).payload;
            assert_eq!(found(store.memory()).payload, last, "{what}");
        }
    }
}

#[test]
fn a_payload_of_the_wrong_size_is_refused() {
    let mut store = boot(Flash::default());
    assert_eq!(save(&mut store, 1), Ok(()));
    store.save(&[0; PAYLOAD - 1]);
    assert_eq!(finish(&mut store), Err(StoreError));
    assert_eq!(found(store.memory()), loaded(Some(1), false));
    assert_eq!(save(&mut store, 2), Ok(()));
}
