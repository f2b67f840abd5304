//! Parameters records of another firmware version together with the calibration record of the unit, with power cuts and flipped
//! bits.

use crate::saves::*;
use bench::{Flash, PAGE_SIZE};
use crc::{CRC_32_ISO_HDLC, Crc};
use plumbline::measure::Calibration;
use plumbline::measure::calibration::{ACCELEROMETER_SIZE, Part, SIZE};
use plumbline::store::{Owner, buffer_size};

/// Stored parameters of the newer firmware: four more bytes.
const NEWER_PAYLOAD: usize = PAYLOAD + 4;

type NewerStore = plumbline::store::Store<Flash, [u8; buffer_size(NEWER_PAYLOAD, true)]>;

/// A record of a firmware version without calibration records: the parameters, then the calibration.
fn old_record(sequence: u32, parameters: &[u8]) -> Vec<u8> {
    let calibration = &calibration().encode()[..ACCELEROMETER_SIZE];
    record_of(
        OWNER.image.number(),
        sequence,
        &[parameters, calibration].concat(),
    )
}

fn record_of(kind: u16, sequence: u32, payload: &[u8]) -> Vec<u8> {
    let mut record = vec![b'P', 1];
    record.extend(kind.to_le_bytes());
    record.extend(sequence.to_le_bytes());
    record.extend((payload.len() as u16).to_le_bytes());
    record.extend(payload);
    record.resize(record.len().next_multiple_of(4), 0);
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&record);
    record.extend(crc.to_le_bytes());
    record
}

/// A memory of the old firmware with this many records, in the order in which it wrote them.
fn old_memory(count: usize) -> Flash {
    let mut bytes = vec![0xFF; 2 * PAGE_SIZE];
    let size = old_record(0, &payload(0)).len();
    let places = PAGE_SIZE / size;
    for number in 0..count {
        let page = number / places % 2;
        let place = number % places;
        if place == 0 {
            bytes[page * PAGE_SIZE..][..PAGE_SIZE].fill(0xFF);
        }
        let record = old_record(number as u32 + 1, &payload(number));
        bytes[page * PAGE_SIZE + place * size..][..size].copy_from_slice(&record);
    }
    Flash::new(bytes)
}

fn newer_parameters() -> [u8; NEWER_PAYLOAD] {
    std::array::from_fn(|index| 0xA5 ^ index as u8)
}

/// The newer firmware starts and saves.
fn save_newer(flash: Flash) -> (bool, Flash) {
    let mut store = NewerStore::open(flash, OWNER);
    store.prepare();
    store.save(|buffer| {
        buffer
            .get_mut(..NEWER_PAYLOAD)?
            .copy_from_slice(&newer_parameters());
        Some(NEWER_PAYLOAD)
    });
    let mut result = None;
    while store.busy() {
        result = store.step();
    }
    (result == Some(Ok(())), store.into_memory())
}

fn found_by_newer(flash: &Flash) -> Found {
    let mut store = NewerStore::open(copy(flash), OWNER);
    let boot = store.boot();
    Found {
        parameters: boot.parameters.map(<[u8]>::to_vec),
        calibration: boot.calibration,
        unit: boot.unit,
        damaged: boot.damaged,
    }
}

#[test]
fn power_cut_at_every_operation_of_the_first_save_after_an_update_loses_nothing() {
    for count in 1..=25 {
        let before = found_by_newer(&old_memory(count));
        let old = Some(payload(count - 1).to_vec());
        assert_eq!(before.parameters, old, "{count} old records");
        assert_eq!(before.calibration, calibration());
        assert!(!before.damaged);
        let new = Some(newer_parameters().to_vec());
        let mut operation = 0;
        loop {
            let mut flash = old_memory(count);
            flash.cut_in_operation_after(operation, operation.wrapping_mul(0x9E37_79B9));
            let (saved, flash) = save_newer(flash);
            let after = found_by_newer(&flash);
            let what = format!("{count} old records, operation {operation}: {after:?}");
            assert_eq!(after.calibration, calibration(), "{what}");
            if !flash.is_cut() {
                assert!(saved && after.parameters == new && !after.damaged, "{what}");
                break;
            }
            assert!(!saved, "{what}");
            assert!(after.parameters == old || after.parameters == new, "{what}");
            // The next start saves without a loss.
            let mut flash = flash;
            flash.power_on();
            let (saved, flash) = save_newer(flash);
            let next = found_by_newer(&flash);
            assert!(saved && next.parameters == new && !next.damaged, "{what}");
            assert_eq!(next.calibration, calibration(), "{what}");
            operation += 1;
        }
        // The half-words of both records.
        assert!(operation >= (56 + 44) / 2, "{operation} operations");
    }
}

#[test]
fn older_firmware_keeps_the_calibration_and_the_parameters_it_knows() {
    let (saved, flash) = save_newer(old_memory(3));
    assert!(saved);
    let after = found_by(OWNER, &flash);
    // Its buffer holds the parameters that it knows, which are the first ones of the record.
    let parameters = after.parameters.expect("parameters");
    assert!(newer_parameters().starts_with(&parameters[..PAYLOAD]));
    assert_eq!(after.calibration, calibration());
}

#[test]
fn calibration_without_zero_rate_is_read_without_a_report_and_kept() {
    is_read_and_kept(ACCELEROMETER_SIZE);
}

/// It belongs to an ISM330DHCX: there was no other part.
#[test]
fn calibration_without_a_part_is_read_without_a_report_and_kept() {
    is_read_and_kept(SIZE - 1);
}

/// The first `length` bytes of a calibration, as an older firmware has written them.
fn is_read_and_kept(length: usize) {
    let bytes = &calibration().encode()[..length];
    let owner = [&[1][..], &OWNER.serial.to_le_bytes()].concat();
    let checked = &bytes[..ACCELEROMETER_SIZE];
    let check = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(checked) as u8;
    let mut memory = record_of(0, 1, &[&owner, bytes].concat());
    let parameters = [&[OWNER.layout, check.max(1)], &payload(7)[..]].concat();
    memory.extend(record_of(0x8000 | OWNER.image.number(), 1, &parameters));
    memory.resize(2 * PAGE_SIZE, 0xFF);
    let mut store = Store::open(Flash::new(memory), OWNER);
    for number in [7, 8, 9] {
        let found = found(&mut store);
        assert_eq!(found.calibration, calibration());
        assert_eq!(found.calibration.zero_rate(), ([0; 3], [0; 3]));
        assert_eq!(found.calibration.part(), Part::Ism330dhcx);
        assert!(!found.damaged);
        assert_eq!(found.parameters, Some(payload(number).to_vec()));
        assert_eq!(save(&mut store, number + 1), Ok(()));
        store = Store::open(store.into_memory(), OWNER);
    }
}

#[test]
fn power_cut_at_any_operation_keeps_the_calibration() {
    power_cut_in_a_save_keeps_everything(&calibrated());
}

#[test]
fn power_cut_while_the_calibration_is_written_keeps_the_old_or_the_new_calibration() {
    let newer = Calibration::new([1, 2, 3], [[4; 3]; 3], [5; 3]).unwrap();
    for saves in 0..=2 * PLACES {
        let mut store = boot(calibrated());
        for number in 0..saves {
            assert_eq!(save(&mut store, number), Ok(()));
        }
        let new = Found {
            calibration: newer,
            ..found(&mut store)
        };
        let write = |store: &mut Store| store.calibrate(&newer);
        power_cut_keeps_the_old_or_the_new(store.memory(), write, &new);
    }
}

/// Memories with a calibration: fresh, after some saves, and after another calibration.
fn calibrated_memories() -> Vec<Flash> {
    let older = Calibration::new([5; 3], [[6; 3]; 3], [7; 3]).unwrap();
    let mut memories = Vec::new();
    // With the last number, the home page is more than half full and the other page is not erased.
    for saves in [0, 1, PLACES, 2 * PLACES, PLACES + 15] {
        for is_recalibrated in [false, true] {
            let mut store = boot(Flash::default());
            if is_recalibrated {
                store.calibrate(&older);
                assert_eq!(finish(&mut store), Ok(()));
                for number in 0..saves {
                    assert_eq!(save(&mut store, number), Ok(()));
                }
            }
            let mut store = Store::open(store.into_memory(), OWNER);
            store.calibrate(&calibration());
            assert_eq!(finish(&mut store), Ok(()));
            for number in 0..saves {
                assert_eq!(save(&mut store, number), Ok(()));
            }
            assert_eq!(found(&mut store).calibration, calibration());
            memories.push(store.into_memory());
        }
    }
    memories
}

#[test]
fn one_flipped_bit_never_changes_the_calibration_without_a_report() {
    for (number, memory) in calibrated_memories().into_iter().enumerate() {
        for bit in (0..memory.bytes().len() * 8).step_by(stride()) {
            let mut flash = copy(&memory);
            flash.flip_bit(bit).unwrap();
            // As the firmware starts: it erases ahead, then it reads.
            let mut store = boot(flash);
            let (calibration_of_boot, is_damaged) = {
                let boot = store.boot();
                (boot.calibration, boot.damaged)
            };
            let kept = calibration_of_boot == calibration();
            assert!(kept || is_damaged, "memory {number}, bit {bit}");
            // Neither a power cycle nor a save changes it.
            assert_eq!(found(&mut store).calibration, calibration_of_boot);
            assert_eq!(save(&mut store, 9), Ok(()), "memory {number}, bit {bit}");
            let after = found(&mut store);
            assert_eq!(
                after.calibration, calibration_of_boot,
                "memory {number}, bit {bit}"
            );
            assert!(!after.damaged, "memory {number}, bit {bit}");
        }
    }
}

#[test]
fn newest_calibration_is_used_after_any_number_of_calibrations() {
    let of = |number: i32| Calibration::new([number; 3], [[1; 3]; 3], [2; 3]).unwrap();
    for saves in [0, 1] {
        let mut flash = Flash::default();
        for number in 1..100 {
            let mut store = Store::open(flash, OWNER);
            store.prepare();
            store.calibrate(&of(number));
            assert_eq!(finish(&mut store), Ok(()), "calibration {number}");
            for _ in 0..saves {
                assert_eq!(save(&mut store, 3), Ok(()));
            }
            assert_eq!(
                found(&mut store).calibration,
                of(number),
                "after {saves} saves"
            );
            flash = store.into_memory();
        }
    }
}

#[test]
fn calibration_of_another_unit_is_ignored() {
    let other = Owner {
        serial: OWNER.serial + 1,
        ..OWNER
    };
    let after = found_by(other, &calibrated());
    assert_eq!(after.calibration, Calibration::IDENTITY);

    // The parameters are read, and the loss of the calibration is reported until the next save.
    let mut store = boot(calibrated());
    assert_eq!(save(&mut store, 7), Ok(()));
    let after = found_by(other, store.memory());
    assert_eq!(after.parameters, loaded(Some(7), false).parameters);
    assert_eq!(after.calibration, Calibration::IDENTITY);
    assert!(after.damaged);
    let mut store = Store::open(store.into_memory(), other);
    assert_eq!(save(&mut store, 8), Ok(()));
    assert_eq!(found_by(other, store.memory()), loaded(Some(8), false));
}

#[test]
fn worn_bit_never_loses_the_calibration() {
    for bit in (0..2 * PAGE_SIZE * 8).step_by(11 * stride()) {
        let mut flash = calibrated();
        flash.wear_out(bit);
        let mut store = boot(flash);
        for number in 0..3 * PLACES {
            // The worn bit is in the calibration record itself.
            if found(&mut store).calibration != calibration() {
                assert!(bit < CALIBRATION_RECORD * 8, "bit {bit}, save {number}");
                break;
            }
            if save(&mut store, number).is_err() {
                assert_eq!(save(&mut store, number), Ok(()), "bit {bit}, save {number}");
            }
        }
    }
}
