//! Shared by the tests of the store: payloads, saves, and the records found at power-up.

use bench::{Flash, PAGE_SIZE};
use host_tests::effort;
use plumbline::measure::Calibration;
use plumbline::store::{ImageId, Name, Owner, StoreError, Unit, buffer_size};

/// Bytes of stored parameters, as many as is2 has; a record of them has 40 bytes.
pub const PAYLOAD: usize = 24;
pub const RECORD: usize = 40;

/// The size of a calibration record, which is before the first parameters record of a page.
pub const CALIBRATION_RECORD: usize = 56;

/// The size of the longest record of an identity in these tests.
pub const UNIT_RECORD: usize = 72;

/// The size of a record of the usage.
pub const USAGE_RECORD: usize = 44;

/// Number of parameters records that fit into a page without a calibration record.
pub const PLACES: usize = PAGE_SIZE / RECORD;

pub const OWNER: Owner = Owner {
    image: ImageId::new(0x1234),
    layout: 1,
    serial: 0x0102_0304,
};

pub type Store = plumbline::store::Store<Flash, [u8; buffer_size(PAYLOAD, true)]>;

/// The records found at power-up.
#[derive(Clone, PartialEq, Debug)]
pub struct Found {
    pub parameters: Option<Vec<u8>>,
    pub calibration: Calibration,
    pub unit: Unit,
    pub damaged: bool,
}

/// The parameters of save `number`. No two of them have a byte in common at the same place, so a mixture is detected.
pub fn payload(number: usize) -> [u8; PAYLOAD] {
    std::array::from_fn(|index| (number as u8).wrapping_mul(3) ^ index as u8)
}

/// A calibration that is not the identity.
pub fn calibration() -> Calibration {
    Calibration::new([100_000, -200_000, 300_000], [[500; 3]; 3], [30, -20, 10]).unwrap()
}

/// The identity of a unit with a vendor and a serial number.
pub fn unit() -> Unit {
    Unit {
        vendor: Some(354),
        serial: Some(0x00A1_B2C3),
        name: Name::new("INCLINOMETER 08"),
        ..Unit::NONE
    }
}

/// The step of sweeps over bits: in the normal run, each bit of a byte and each byte of a record has its turn in one of the records.
pub fn stride() -> usize {
    effort::choose(27, 1)
}

/// Power-up: looks for records and erases ahead.
pub fn boot(flash: Flash) -> Store {
    let mut store = Store::open(flash, OWNER);
    store.prepare();
    store
}

/// The records that the device `owner` finds at power-up; does not change the memory.
pub fn found_by(owner: Owner, flash: &Flash) -> Found {
    let mut store = Store::open(copy(flash), owner);
    let boot = store.boot();
    Found {
        parameters: boot.parameters.map(<[u8]>::to_vec),
        calibration: boot.calibration,
        unit: boot.unit,
        damaged: boot.damaged,
    }
}

/// The records that the device finds at power-up; does not change the memory.
pub fn found(store: &mut Store) -> Found {
    found_by(OWNER, store.memory())
}

/// Another memory with the same content.
pub fn copy(flash: &Flash) -> Flash {
    Flash::new(flash.bytes().to_vec())
}

/// The parameters of save `number` or none, neither calibration nor identity, and whether a newer record is damaged.
pub fn loaded(number: Option<usize>, damaged: bool) -> Found {
    Found {
        parameters: number.map(|number| payload(number).to_vec()),
        calibration: Calibration::IDENTITY,
        unit: Unit::NONE,
        damaged,
    }
}

pub fn finish(store: &mut Store) -> Result<(), StoreError> {
    // An erase, all records in steps of four bytes, the verification, and a margin.
    for _ in 0..(CALIBRATION_RECORD + UNIT_RECORD + USAGE_RECORD + RECORD) / 4 + 5 {
        if let Some(result) = store.step() {
            assert!(!store.busy());
            return result;
        }
        assert!(store.busy());
    }
    panic!("the save has not ended");
}

pub fn begin(store: &mut Store, parameters: &[u8]) {
    store.save(|buffer| {
        buffer
            .get_mut(..parameters.len())?
            .copy_from_slice(parameters);
        Some(parameters.len())
    });
}

pub fn save(store: &mut Store, number: usize) -> Result<(), StoreError> {
    begin(store, &payload(number));
    finish(store)
}

/// A memory with a calibration and nothing else.
pub fn calibrated() -> Flash {
    let mut store = boot(Flash::default());
    store.calibrate(&calibration());
    assert_eq!(finish(&mut store), Ok(()));
    store.into_memory()
}

/// Switches the power off in each operation of many saves in turn. Calibration and identity stay. The parameters are those of the last save
/// or of the interrupted one. All further saves succeed.
pub fn power_cut_in_a_save_keeps_everything(memory: &Flash) {
    // The calibration and the identity are copied into each page before the first parameters record.
    const SAVES: usize = 3 * PLACES;
    let old = found_by(OWNER, memory);
    let mut operation = 0;
    loop {
        let mut flash = copy(memory);
        flash.cut_in_operation_after(operation, operation.wrapping_mul(0x9E37_79B9));
        let mut store = boot(flash);
        let mut saved = None;
        for number in 0..SAVES {
            if number % 7 == 6 {
                store = boot(store.into_memory());
            }
            if save(&mut store, number).is_err() {
                break;
            }
            saved = Some(number);
        }
        let mut flash = store.into_memory();
        let after = found_by(OWNER, &flash);
        let what = format!("operation {operation}: {after:?}");
        assert_eq!(after.calibration, old.calibration, "{what}");
        assert_eq!(after.unit, old.unit, "{what}");
        let [last, next] = [saved, Some(saved.map_or(0, |number| number + 1))]
            .map(|number| number.map(|number| payload(number).to_vec()));
        assert!([last, next].contains(&after.parameters), "{what}");
        if !flash.is_cut() {
            assert_eq!(saved, Some(SAVES - 1));
            break;
        }
        flash.power_on();
        let mut store = boot(flash);
        for number in 100..100 + 2 * PLACES {
            assert_eq!(save(&mut store, number), Ok(()), "{what}");
            let after = found(&mut store);
            assert_eq!(after.calibration, old.calibration, "{what}");
            assert_eq!(after.unit, old.unit, "{what}");
        }
        operation += effort::choose(7, 1);
    }
}

/// Switches the power off in each operation that writes `new`, in turn. The parameters stay. Calibration and identity are the old or the
/// new ones.
pub fn power_cut_keeps_the_old_or_the_new(memory: &Flash, write: impl Fn(&mut Store), new: &Found) {
    let old = found_by(OWNER, memory);
    let mut operation = 0;
    loop {
        let mut store = Store::open(copy(memory), OWNER);
        store.memory().cut_in_operation_after(operation, operation);
        write(&mut store);
        let result = finish(&mut store);
        let flash = store.into_memory();
        let after = found_by(OWNER, &flash);
        let what = format!("operation {operation}: {after:?}");
        if !flash.is_cut() {
            assert_eq!((result, &after), (Ok(()), new), "{what}");
            break;
        }
        assert_eq!(after.parameters, old.parameters, "{what}");
        let [old, new] = [&old, new].map(|found| (found.calibration, found.unit));
        assert!(
            [old, new].contains(&(after.calibration, after.unit)),
            "{what}"
        );
        operation += 1;
    }
}
