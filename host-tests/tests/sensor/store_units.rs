//! The identity of the unit in the store, beside its calibration: other firmware, power cuts and flipped bits.

use crate::saves::*;
use bench::{Flash, PAGE_SIZE};
use host_tests::effort;
use plumbline::measure::Calibration;
use plumbline::store::{ImageId, Name, Owner, Unit};

/// Another identity: longer than [`unit`].
fn other_unit() -> Unit {
    Unit {
        product_code: Some(8),
        name: Name::new("another name of 32 characters..."),
        ..unit()
    }
}

fn identify(store: &mut Store, unit: &Unit) {
    store.identify(unit);
    assert_eq!(finish(store), Ok(()));
}

/// A memory with a calibration, an identity, and this number of saves.
fn identified(saves: usize) -> Flash {
    let mut store = Store::open(calibrated(), OWNER);
    identify(&mut store, &unit());
    let mut store = boot(store.into_memory());
    for number in 0..saves {
        assert_eq!(save(&mut store, number), Ok(()));
    }
    store.into_memory()
}

/// The identity, the calibration, and the parameters of the last save.
fn expected(saves: usize) -> Found {
    Found {
        calibration: calibration(),
        unit: unit(),
        ..loaded(saves.checked_sub(1), false)
    }
}

#[test]
fn identity_is_found_beside_calibration_and_parameters() {
    for saves in 0..3 * PLACES {
        assert_eq!(found_by(OWNER, &identified(saves)), expected(saves));
    }
    // Without a calibration.
    let mut store = boot(Flash::default());
    for number in 0..2 * PLACES {
        identify(&mut store, &unit());
        assert_eq!(save(&mut store, number), Ok(()));
        let only = Found {
            unit: unit(),
            ..loaded(Some(number), false)
        };
        assert_eq!(found(&mut store), only);
        store = boot(store.into_memory());
    }
}

#[test]
fn identity_and_calibration_are_kept_when_the_other_one_is_written() {
    let newer = Calibration::new([1, 2, 3], [[4; 3]; 3], [5; 3]).unwrap();
    for saves in [0, 1, PLACES, 2 * PLACES] {
        let mut store = Store::open(identified(saves), OWNER);
        store.calibrate(&newer);
        assert_eq!(finish(&mut store), Ok(()));
        let calibrated = Found {
            calibration: newer,
            ..expected(saves)
        };
        assert_eq!(found(&mut store), calibrated);
        let mut store = Store::open(store.into_memory(), OWNER);
        identify(&mut store, &other_unit());
        let identified = Found {
            unit: other_unit(),
            ..calibrated
        };
        assert_eq!(found(&mut store), identified);
        // An identity that gives nothing ends the old one.
        let mut store = Store::open(store.into_memory(), OWNER);
        identify(&mut store, &Unit::NONE);
        let plain = Found {
            unit: Unit::NONE,
            ..identified
        };
        assert_eq!(found(&mut store), plain);
    }
}

#[test]
fn identity_belongs_to_the_product_and_not_to_the_chip() {
    let flash = identified(3);
    let other_chip = Owner {
        serial: OWNER.serial + 1,
        ..OWNER
    };
    let after = found_by(other_chip, &flash);
    assert_eq!(after.unit, unit());
    assert_eq!(after.calibration, Calibration::IDENTITY);
    let other_product = Owner {
        image: ImageId::new(0x1235),
        ..OWNER
    };
    let after = found_by(other_product, &flash);
    assert_eq!(after.unit, Unit::NONE);
    assert_eq!(after.calibration, calibration());
    // Another layout of the stored parameters is the same product.
    let newer = Owner { layout: 2, ..OWNER };
    assert_eq!(found_by(newer, &flash).unit, unit());
}

#[test]
fn power_cut_at_any_operation_keeps_identity_and_calibration() {
    power_cut_in_a_save_keeps_everything(&identified(0));
}

#[test]
fn power_cut_while_the_identity_is_written_keeps_the_old_or_the_new_identity() {
    for saves in (0..=2 * PLACES).step_by(effort::choose(3, 1)) {
        let new = Found {
            unit: other_unit(),
            ..expected(saves)
        };
        let write = |store: &mut Store| store.identify(&other_unit());
        power_cut_keeps_the_old_or_the_new(&identified(saves), write, &new);
    }
}

#[test]
fn one_flipped_bit_never_changes_the_identity_without_a_report() {
    for saves in [1, PLACES, PLACES + 15] {
        let memory = identified(saves);
        for bit in (0..2 * PAGE_SIZE * 8).step_by(stride()) {
            let mut flash = copy(&memory);
            flash.flip_bit(bit).unwrap();
            let mut store = boot(flash);
            let after = found(&mut store);
            let what = format!("{saves} saves, bit {bit}: {after:?}");
            assert!(after.unit == unit() || after.damaged, "{what}");
            // Neither a power cycle nor a save changes it.
            assert_eq!(save(&mut store, 9), Ok(()), "{what}");
            let next = found(&mut store);
            assert_eq!((next.unit, next.damaged), (after.unit, false), "{what}");
        }
    }
}
