//! The store on the simulated flash of the STM32F103 with power cuts.

use crate::saves::*;
use bench::Flash;
use host_tests::effort;

/// The state after a power cut in a series of saves.
struct Cut {
    flash: Flash,
    /// The last save before the cut, if any.
    saved: Option<usize>,
    /// The save during the cut; None: the cut was while erasing ahead.
    saving: Option<usize>,
    /// The interrupted operation has changed the memory.
    changed: bool,
}

/// Makes the saves 0 to `count` - 1 until the power is cut, with a restart before each save that `restart` selects. None: the
/// power was not cut.
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

/// The tested restarts: none, before each save, before every fifth save.
const RESTARTS: [fn(usize) -> bool; 3] = [|_| false, |_| true, |number| number % 5 == 3];

/// After a cut, the old or the new record is found (before the first save, none), and the following saves succeed in both pages.
fn survives(cut: Cut, what: &str) {
    let after = found_by(OWNER, &cut.flash);
    let old = after.parameters == loaded(cut.saved, false).parameters;
    let new = cut.saving.is_some() && after.parameters == loaded(cut.saving, false).parameters;
    assert!(old || new, "{what}: {after:?}");
    if new {
        assert!(!after.damaged, "{what}: the new record is complete");
    }
    let mut flash = cut.flash;
    flash.power_on();
    let mut store = boot(flash);
    assert_eq!(
        found(&mut store).parameters,
        after.parameters,
        "{what}: erasing ahead loses the record"
    );
    for number in 100..100 + 2 * PLACES + 2 {
        assert_eq!(save(&mut store, number), Ok(()), "{what}: save {number}");
        if number < 103 {
            let next = found(&mut store);
            assert_eq!(next, loaded(Some(number), false), "{what}");
        }
    }
    let last = loaded(Some(101 + 2 * PLACES), false).parameters;
    assert_eq!(found(&mut store).parameters, last, "{what}");
}

#[test]
fn power_cut_in_any_programmed_byte_keeps_the_old_record_or_the_new_one() {
    const SAVES: usize = 2 * PLACES + 3;
    // The number of bytes of a record has no factor in common with it.
    let step = effort::choose(13, 1);
    for (first, restart) in RESTARTS.into_iter().enumerate() {
        for byte in (first % step..SAVES * RECORD).step_by(step) {
            let mut flash = Flash::default();
            flash.cut_in_byte_after(byte as u64);
            let cut = run(flash, SAVES, restart).expect("the power is cut");
            assert_eq!(cut.saving, Some(byte / RECORD));
            let after = found_by(OWNER, &cut.flash);
            if after.parameters == loaded(cut.saved, false).parameters {
                assert_eq!(
                    after.damaged, cut.changed,
                    "byte {byte}: the newest record is damaged"
                );
            }
            // The damage is reported at each power-up until the next save.
            let mut flash = copy(&cut.flash);
            for _ in 0..3 {
                flash = boot(flash).into_memory();
                assert_eq!(found_by(OWNER, &flash), after, "byte {byte}");
            }
            survives(cut, &format!("byte {byte}"));
        }
        let mut flash = Flash::default();
        flash.cut_in_byte_after((SAVES * RECORD) as u64);
        assert!(run(flash, SAVES, restart).is_none(), "all bytes were tried");
    }
}

#[test]
fn power_cut_in_any_erase_keeps_the_old_record_or_the_new_one() {
    const SAVES: usize = 6 * PLACES;
    let seeds = effort::choose(10, 100);
    for restart in RESTARTS {
        let mut erases = 0;
        loop {
            let mut blown = 0;
            for seed in 0..seeds {
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
            assert_eq!(blown, seeds);
            erases += 1;
        }
        assert!(erases >= 3, "only {erases} erases in {SAVES} saves");
    }
}

#[test]
fn repeated_power_cuts_never_lose_the_record() {
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
            0 => flash.cut_in_byte_after((next() % (2 * RECORD)) as u64),
            1 => flash.cut_in_erase_after((next() % 2) as u64, next() as u64),
            _ => {}
        }
        let mut store = boot(flash);
        let result = save(&mut store, number % 60);
        flash = store.into_memory();
        cuts += usize::from(flash.is_cut());
        let after = found_by(OWNER, &flash).parameters;
        let new = loaded(Some(number % 60), false).parameters;
        if result.is_ok() {
            assert_eq!(after, new, "{number}");
        } else {
            assert!(after == new || after == saved, "{number}: {after:?}");
        }
        saved = after;
    }
    assert!(cuts > 500, "{cuts}");
}

#[test]
fn invalid_data_before_the_newest_record_is_not_reported() {
    // A cut in save 3, then on and on without a restart.
    let mut flash = Flash::default();
    flash.cut_in_byte_after((3 * RECORD + 20) as u64);
    let cut = run(flash, 10, RESTARTS[0]).unwrap();
    let mut flash = cut.flash;
    flash.power_on();
    let mut store = boot(flash);
    for number in 100..100 + 6 * PLACES {
        assert_eq!(save(&mut store, number), Ok(()));
        let after = found(&mut store);
        assert_eq!(after, loaded(Some(number), false), "save {number}");
    }
}
