//! The store on the simulated flash of the STM32F103: power cuts, flipped bits, broken memory.

use host_tests::bench::{Flash, PAGE_SIZE};
use plumbline::store::{ImageId, Loaded, Store, StoreError};

const ID: ImageId = ImageId(0x1234);

/// A payload of this size makes images of 76 bytes.
const PAYLOAD: usize = 60;
const IMAGE: usize = 76;

/// So many of them fit a page.
const PLACES: usize = PAGE_SIZE / IMAGE;

/// The payload of save `number`; no two of them have a byte in common at the same place, so that a mix shows.
fn payload(number: usize) -> [u8; PAYLOAD] {
    std::array::from_fn(|index| (number as u8).wrapping_mul(3) ^ index as u8)
}

/// Power-up: looks for images and erases ahead.
fn boot(flash: Flash) -> Store<Flash> {
    let mut store = Store::open(flash, ID, PAYLOAD).0;
    store.prepare();
    store
}

/// What a device would find that lost its power now; the memory is left alone.
fn found(flash: &Flash) -> Loaded {
    Store::open(copy(flash), ID, PAYLOAD).1
}

/// Another memory with the same content.
fn copy(flash: &Flash) -> Flash {
    Flash::new(flash.bytes().to_vec())
}

/// The image of save `number`, or none, and whether something newer is damaged.
fn loaded(number: Option<usize>, damaged: bool) -> Loaded {
    Loaded {
        payload: number.map(|number| payload(number).as_slice().try_into().unwrap()),
        damaged,
    }
}

fn finish(store: &mut Store<Flash>) -> Result<(), StoreError> {
    // An erase, the image in steps of four bytes, the verification, with some to spare.
    for _ in 0..IMAGE / 4 + 5 {
        if let Some(result) = store.step() {
            assert!(!store.busy());
            return result;
        }
        assert!(store.busy());
    }
    panic!("the save does not come to an end");
}

fn save(store: &mut Store<Flash>, number: usize) -> Result<(), StoreError> {
    store.save(&payload(number));
    finish(store)
}

/// Where a series of saves was cut off.
struct Cut {
    flash: Flash,
    /// What had been saved before, if anything.
    saved: Option<usize>,
    /// What was being saved; None: the cut came while erasing ahead.
    saving: Option<usize>,
    /// The cut has changed something.
    changed: bool,
}

/// Makes the saves 0 to `count` - 1 with a restart before each that `restart` picks, until the power is cut. None when it was
/// not.
fn run(flash: Flash, count: usize, restart: fn(usize) -> bool) -> Option<Cut> {
    let mut store = boot(flash);
    let mut saved = None;
    for number in 0..count {
        if restart(number) {
            store = boot(store.into_memory());
        }
        let before = store.memory().bytes().to_vec();
        let mut saving = None;
        if !store.memory().is_cut() {
            let result = save(&mut store, number);
            saving = Some(number);
            assert_eq!(result.is_err(), store.memory().is_cut(), "save {number}");
        }
        if store.memory().is_cut() {
            let flash = store.into_memory();
            return Some(Cut {
                changed: flash.bytes() != before,
                flash,
                saved,
                saving,
            });
        }
        saved = Some(number);
    }
    None
}

/// The restarts that are tried: none, before each save, and now and then.
const RESTARTS: [fn(usize) -> bool; 3] = [|_| false, |_| true, |number| number % 5 == 3];

/// After a cut the old image is there or the new one (before the very first one, none), and saving goes on as if nothing had
/// happened, all around the memory.
fn survives(cut: Cut, what: &str) {
    let after = found(&cut.flash);
    let old = after.payload == loaded(cut.saved, false).payload;
    let new = cut.saving.is_some() && after.payload == loaded(cut.saving, false).payload;
    assert!(old || new, "{what}: {after:?}");
    if new {
        assert!(!after.damaged, "{what}: the new image is whole");
    }
    let mut flash = cut.flash;
    flash.power_on();
    let mut store = boot(flash);
    assert_eq!(
        found(store.memory()).payload,
        after.payload,
        "{what}: erasing ahead takes away the image"
    );
    for number in 100..100 + 2 * PLACES + 2 {
        assert_eq!(save(&mut store, number), Ok(()), "{what}: save {number}");
        if number < 103 {
            let next = found(store.memory());
            assert_eq!(next, loaded(Some(number), false), "{what}");
        }
    }
    let last = loaded(Some(101 + 2 * PLACES), false).payload;
    assert_eq!(found(store.memory()).payload, last, "{what}");
}

#[test]
fn a_power_cut_in_any_programmed_byte_leaves_the_old_image_or_the_new_one() {
    const SAVES: usize = 2 * PLACES + 3;
    for restart in RESTARTS {
        for byte in 0..SAVES * IMAGE {
            let mut flash = Flash::default();
            flash.cut_in_byte_after(byte as u64);
            let cut = run(flash, SAVES, restart).expect("the fuse blows");
            assert_eq!(cut.saving, Some(byte / IMAGE));
            let after = found(&cut.flash);
            if after.payload == loaded(cut.saved, false).payload {
                assert_eq!(
                    after.damaged, cut.changed,
                    "byte {byte}: the newest image is lost"
                );
            }
            survives(cut, &format!("byte {byte}"));
        }
        let mut flash = Flash::default();
        flash.cut_in_byte_after((SAVES * IMAGE) as u64);
        assert!(run(flash, SAVES, restart).is_none(), "all bytes were tried");
    }
}

#[test]
fn a_power_cut_in_any_erase_leaves_the_old_image_or_the_new_one() {
    const SAVES: usize = 6 * PLACES;
    for restart in RESTARTS {
        let mut erases = 0;
        loop {
            let mut blown = 0;
            for seed in 0..100 {
                let mut flash = Flash::default();
                flash.cut_in_erase_after(erases, seed);
                if let Some(cut) = run(flash, SAVES, restart) {
                    blown += 1;
                    assert!(cut.saved.is_some());
                    survives(cut, &format!("erase {erases}, seed {seed}"));
                }
            }
            if blown == 0 {
                break;
            }
            assert_eq!(blown, 100);
            erases += 1;
        }
        assert!(erases >= 3, "only {erases} erases in {SAVES} saves");
    }
}

#[test]
fn power_cuts_one_after_the_other_never_lose_the_image() {
    let mut flash = Flash::default();
    let mut random = 12345_u64;
    let mut next = || {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random >> 33) as usize
    };
    let mut saved = None;
    let mut cuts = 0;
    for number in 0..5000 {
        flash.power_on();
        match next() % 3 {
            0 => flash.cut_in_byte_after((next() % (2 * IMAGE)) as u64),
            1 => flash.cut_in_erase_after((next() % 2) as u64, next() as u64),
            _ => {}
        }
        let mut store = boot(flash);
        let result = save(&mut store, number % 60);
        flash = store.into_memory();
        cuts += usize::from(flash.is_cut());
        let after = found(&flash).payload;
        let new = loaded(Some(number % 60), false).payload;
        if result.is_ok() {
            assert_eq!(after, new, "{number}");
        } else {
            assert!(after == new || after == saved, "{number}: {after:?}");
        }
        saved = after;
    }
    assert!(cuts > 500, "{cuts}");
}

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
fn debris_of_long_ago_is_not_damage() {
    // A cut in save 3, then on and on without a restart.
    let mut flash = Flash::default();
    flash.cut_in_byte_after((3 * IMAGE + 20) as u64);
    let cut = run(flash, 10, RESTARTS[0]).unwrap();
    let mut flash = cut.flash;
    flash.power_on();
    let mut store = boot(flash);
    for number in 100..100 + 6 * PLACES {
        assert_eq!(save(&mut store, number), Ok(()));
        let after = found(store.memory());
        assert_eq!(after, loaded(Some(number), false), "save {number}");
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
