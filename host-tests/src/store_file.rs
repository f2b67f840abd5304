//! The store file of a unit: the nonvolatile memory of the Blue Pill, of the Nucleo, or a new one.

use bench::{Flash, Geometry, STORE_BUFFER, file};
use plumbline::measure::Calibration;
use plumbline::model::catalog::Product;
use plumbline::store::{Owner, Store, Unit, crc32};
use std::path::Path;

/// The length of the longest store in bytes.
const LONGEST: u64 = 1 << 20;

/// The store of a unit in a file.
type FileStore = Store<Flash, [u8; STORE_BUFFER]>;

/// Writes the calibration of a unit into its store file. Parameters and identity in it do not change.
///
/// # Errors
/// The file cannot be read or written.
pub fn calibrate(owner: Owner, calibration: &Calibration, path: &Path) -> Result<(), String> {
    change(owner, path, |store| store.calibrate(calibration))
}

/// Writes the identity of a unit of this product into its store file. Parameters and calibration in it do not change.
///
/// # Errors
/// The file cannot be read or written.
pub fn identify(product: &Product, unit: &Unit, path: &Path) -> Result<(), String> {
    // An identity belongs to no chip, but the calibration beside it does.
    let bytes = file::read(path, LONGEST).ok();
    let chip = bytes.and_then(|bytes| chip(&bytes));
    let owner = product.owner(chip.unwrap_or(0));
    change(owner, path, |store| store.identify(unit))
}

/// Opens the store in a file, performs a save, and writes it.
fn change(owner: Owner, path: &Path, save: impl FnOnce(&mut FileStore)) -> Result<(), String> {
    let text = |error| format!("cannot use the store {}: {error}", path.display());
    let length = path.metadata().map_or(0, |file| file.len());
    // The memory of the Blue Pill refuses a file that is too long for each board.
    let geometry = Geometry::of_file(length).unwrap_or(Geometry::STM32F103);
    let flash = Flash::in_file(geometry, path).map_err(text)?;
    let mut store = FileStore::open(flash, owner);
    save(&mut store);
    loop {
        if let Some(result) = store.step() {
            let unwritten = store.memory().unwritten();
            let broken = || format!("cannot write the store {}", path.display());
            return result.map_err(|_| unwritten.map_or_else(broken, str::to_owned));
        }
    }
}

/// The serial number of the chip in the newest calibration record of a memory; None: there is none.
fn chip(memory: &[u8]) -> Option<u32> {
    /// The size of a header.
    const HEADER: usize = 10;
    let records = (0..memory.len()).step_by(4).filter_map(|at| {
        let record = &memory[at..];
        let header: &[u8; HEADER] = record.first_chunk()?;
        let &[b'P', 1, 0, 0, s0, s1, s2, s3, l0, l1] = header else {
            return None;
        };
        let length = usize::from(u16::from_le_bytes([l0, l1]));
        let end = (HEADER + length).next_multiple_of(4);
        let crc = record.get(end..)?.first_chunk()?;
        if crc32(0, &record[..end]) != u32::from_le_bytes(*crc) {
            return None;
        }
        // The layout of a calibration, then the serial number.
        let [1, serial @ ..] = record[HEADER..].first_chunk::<5>()? else {
            return None;
        };
        let sequence = u32::from_le_bytes([s0, s1, s2, s3]);
        Some((sequence, u32::from_le_bytes(*serial)))
    });
    records.max().map(|(_, serial)| serial)
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::model::catalog::find;
    use plumbline::store::Name;

    fn path(name: &str) -> std::path::PathBuf {
        std::env::temp_dir().join(format!("store-{}-{name}.bin", std::process::id()))
    }

    fn finish(store: &mut FileStore) {
        while store.step().is_none() {}
    }

    #[test]
    fn file_of_either_board_takes_calibration_and_identity_and_keeps_its_parameters() {
        let product = find("is2").unwrap();
        let owner = product.owner(0x1234_5678);
        let calibration = Calibration::new([5, 6, 7], [[8; 3]; 3], [9; 3]).unwrap();
        let unit = Unit {
            serial: Some(5),
            name: Name::new("old"),
            ..Unit::NONE
        };
        for geometry in [Geometry::STM32F103, Geometry::STM32F446] {
            for identity_first in [false, true] {
                let path = path(&format!("{}-{identity_first}", geometry.size()));
                let open = || Store::open(Flash::in_file(geometry, &path).unwrap(), owner);
                let mut store = open();
                store.save(|buffer| {
                    buffer[..4].copy_from_slice(&[1, 2, 3, 4]);
                    Some(4)
                });
                finish(&mut store);
                drop(store);
                for is_identity in [identity_first, !identity_first, identity_first] {
                    if is_identity {
                        identify(product, &unit, &path).unwrap();
                    } else {
                        calibrate(owner, &calibration, &path).unwrap();
                    }
                }
                assert_eq!(path.metadata().unwrap().len(), geometry.size() as u64);
                let mut store = open();
                let boot = store.boot();
                assert_eq!(boot.parameters, Some(&[1, 2, 3, 4][..]));
                assert_eq!((boot.calibration, boot.unit), (calibration, unit));
                assert!(!boot.damaged);
                std::fs::remove_file(&path).unwrap();
            }
        }
    }

    #[test]
    fn file_that_cannot_be_written_is_named_with_the_reason() {
        let product = find("is2").unwrap();
        let path = path("no-folder").join("such");
        let error = identify(product, &Unit::NONE, &path).unwrap_err();
        let reason = error.strip_prefix(&format!("cannot write the store {}: ", path.display()));
        let missing = std::fs::read(&path).unwrap_err().to_string();
        assert_eq!(reason, Some(&missing[..]), "{error}");
    }

    #[test]
    fn file_that_is_too_long_for_a_store_is_refused() {
        let product = find("is2").unwrap();
        let path = path("long");
        let long = vec![0xFF; Geometry::STM32F446.size() + 1];
        std::fs::write(&path, &long).unwrap();
        let calibrated = calibrate(product.owner(1), &Calibration::IDENTITY, &path);
        for error in [calibrated, identify(product, &Unit::NONE, &path)] {
            let error = error.unwrap_err();
            let expected = format!(
                "cannot use the store {}: the file is longer",
                path.display()
            );
            assert!(error.starts_with(&expected), "{error}");
        }
        assert_eq!(std::fs::read(&path).unwrap(), long);
        std::fs::remove_file(&path).unwrap();
    }
}
