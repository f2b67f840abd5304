//! The simulated flash: the rules of the STM32F103's memory, the fuse, the faults, the memory in a file.

use bench::{Flash, FlashError, Geometry, PAGE_SIZE};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

fn read(flash: &mut Flash, at: u32) -> [u8; 4] {
    let mut bytes = [0; 4];
    flash.read(at, &mut bytes).unwrap();
    bytes
}

#[test]
fn half_word_is_programmed_once_and_then_only_to_zero() {
    let mut flash = Flash::default();
    assert_eq!(read(&mut flash, 8), [0xFF; 4]);
    flash.write(8, &[1, 2, 3, 4]).unwrap();
    assert_eq!(flash.write(10, &[3, 4]), Err(FlashError::NotErased));
    assert_eq!(flash.write(8, &[0, 2]), Err(FlashError::NotErased));
    flash.write(8, &[0, 0]).unwrap();
    assert_eq!(read(&mut flash, 8), [0, 0, 3, 4]);
    // The half-words before the rejected one are programmed.
    assert_eq!(flash.write(6, &[5, 6, 7, 8]), Err(FlashError::NotErased));
    assert_eq!(read(&mut flash, 6), [5, 6, 0, 0]);
    flash.erase(0, PAGE_SIZE as u32).unwrap();
    assert_eq!(read(&mut flash, 8), [0xFF; 4]);
    flash.write(8, &[3, 4]).unwrap();
    assert_eq!((flash.programmed(), flash.erased()), (10, 1));
}

#[test]
fn addresses_are_checked() {
    let mut flash = Flash::default();
    let refused = |result| matches!(result, Err(FlashError::Address(_)));
    assert!(refused(flash.write(1, &[0, 0])));
    assert!(refused(flash.write(0, &[0])));
    assert!(refused(flash.write(2 * PAGE_SIZE as u32, &[0, 0])));
    assert!(refused(flash.erase(0, 512)));
    assert!(refused(flash.erase(0, 3 * PAGE_SIZE as u32)));
    assert!(refused(flash.read(2 * PAGE_SIZE as u32 - 1, &mut [0; 2])));
    assert_eq!(flash.bytes(), [0xFF; 2 * PAGE_SIZE]);
}

#[test]
fn byte_fuse_leaves_byte_half_programmed_and_memory_off() {
    let mut flash = Flash::default();
    flash.cut_in_byte_after(3);
    assert_eq!(flash.write(0, &[0x11; 6]), Err(FlashError::PowerCut));
    assert_eq!(flash.bytes()[..3], [0x11; 3]);
    // Bits change from 1 to 0 only, and only the requested ones.
    assert_eq!(flash.bytes()[3] & 0x11, 0x11);
    assert_eq!(flash.bytes()[4..6], [0xFF; 2]);
    assert!(flash.is_cut());
    assert_eq!(flash.read(0, &mut [0]), Err(FlashError::PowerCut));
    assert_eq!(flash.write(4, &[1, 1]), Err(FlashError::PowerCut));
    assert_eq!(flash.erase(0, 1024), Err(FlashError::PowerCut));
    flash.power_on();
    flash.write(4, &[1, 1]).unwrap();
}

#[test]
fn erase_fuse_leaves_page_in_different_erase_states() {
    let mut seen = std::collections::BTreeSet::new();
    for seed in 0..50 {
        let mut flash = Flash::new(vec![0; 2 * PAGE_SIZE]);
        flash.cut_in_erase_after(1, seed);
        let all = 2 * PAGE_SIZE as u32;
        assert_eq!(flash.erase(0, all), Err(FlashError::PowerCut));
        let (first, second) = flash.bytes().split_at(PAGE_SIZE);
        assert!(first.iter().all(|byte| *byte == 0xFF));
        seen.insert(second.iter().map(|byte| byte.count_ones()).sum::<u32>());
    }
    let all_bits = 8 * PAGE_SIZE as u32;
    assert!(seen.contains(&0) && seen.contains(&all_bits));
    assert!(seen.len() > 20, "{}", seen.len());
}

#[test]
fn faulty_memory_does_not_change() {
    let mut flash = Flash::default();
    flash.write(0, &[1, 2]).unwrap();
    flash.fail_writes(true);
    flash.fail_erases(true);
    assert_eq!(flash.write(2, &[1, 2]), Err(FlashError::Broken));
    assert_eq!(flash.erase(0, 1024), Err(FlashError::Broken));
    assert_eq!(read(&mut flash, 0), [1, 2, 0xFF, 0xFF]);
    flash.fail_writes(false);
    flash.wear_out(16);
    flash.write(2, &[0x10, 2]).unwrap();
    assert_eq!(read(&mut flash, 0), [1, 2, 0x11, 2]);
}

/// The name of a file or folder for one test; it is removed at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let name = format!("plumbline-{name}-{}", std::process::id());
        Self(std::env::temp_dir().join(name))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // One of them fails: it is a file or a folder, or it does not exist.
        let _ = fs::remove_file(&self.0);
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn file_keeps_memory() {
    let scratch = Scratch::new("keeps");
    let mut flash = Flash::in_file(Geometry::STM32F103, &scratch.0).unwrap();
    assert_eq!(flash.bytes(), [0xFF; 2 * PAGE_SIZE]);
    assert!(!scratch.0.exists(), "nothing has changed yet");
    flash.write(1000, &[1, 2, 3, 4]).unwrap();
    flash.flip_bit(0).unwrap();
    let bytes = flash.bytes().to_vec();
    assert_eq!(fs::read(&scratch.0).unwrap(), bytes);
    drop(flash);
    // The next start reads it; a power cut also reaches the file.
    let mut flash = Flash::in_file(Geometry::STM32F103, &scratch.0).unwrap();
    assert_eq!(flash.bytes(), bytes);
    flash.cut_in_erase_after(0, 2);
    assert!(flash.erase(0, 1024).is_err());
    assert_eq!(fs::read(&scratch.0).unwrap(), flash.bytes());
}

#[test]
fn unwritable_file_is_faulty_memory() {
    let folder = Scratch::new("folder");
    let path = folder.0.join("memory");
    let mut flash = Flash::in_file(Geometry::STM32F103, &path).unwrap();
    assert_eq!(flash.unwritten(), None);
    assert_eq!(flash.write(0, &[1, 2]), Err(FlashError::Broken));
    assert_eq!(flash.erase(0, 1024), Err(FlashError::Broken));
    assert_eq!(read(&mut flash, 0), [0xFF; 4]);
    let missing = fs::read(&path).unwrap_err();
    let why = format!("cannot write the store {}: {missing}", path.display());
    assert_eq!(flash.unwritten(), Some(&why[..]));
    assert_eq!(flash.unwritten_operations(), 2);
    assert_eq!((flash.programmed(), flash.erased()), (0, 0));
    // It works again when the file can be written.
    fs::create_dir(&folder.0).unwrap();
    flash.write(0, &[1, 2]).unwrap();
    assert_eq!((flash.unwritten(), flash.unwritten_operations()), (None, 2));
    assert_eq!(fs::read(&path).unwrap(), flash.bytes());
}

#[test]
fn file_larger_than_memory_is_not_changed() {
    let scratch = Scratch::new("notes");
    fs::write(&scratch.0, [b'x'; 2049]).unwrap();
    let error = Flash::in_file(Geometry::STM32F103, &scratch.0).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidData);
    assert!(error.to_string().contains("2048 bytes"), "{error}");
    let why = "too long".to_owned();
    let mut flash = Flash::unusable(Geometry::STM32F103, &scratch.0, why);
    assert_eq!(flash.bytes(), [b'x'; 2048]);
    assert_eq!(flash.write(0, &[0, 0]), Err(FlashError::Broken));
    assert_eq!(flash.erase(0, 1024), Err(FlashError::Broken));
    assert_eq!(
        (flash.unwritten(), flash.unwritten_operations()),
        (Some("too long"), 2)
    );
    assert_eq!(fs::read(&scratch.0).unwrap(), [b'x'; 2049]);
    fs::write(&scratch.0, "").unwrap();
    assert!(
        Flash::in_file(Geometry::STM32F103, &scratch.0).is_ok(),
        "an empty file is new"
    );
}

#[test]
fn file_of_a_running_sensor_is_refused() {
    let scratch = Scratch::new("shared");
    fs::write(&scratch.0, b"P").unwrap();
    let flash = Flash::in_file(Geometry::STM32F103, &scratch.0).unwrap();
    let error = Flash::in_file(Geometry::STM32F103, &scratch.0).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::ResourceBusy);
    drop(flash);
    assert!(Flash::in_file(Geometry::STM32F103, &scratch.0).is_ok());
}

#[cfg(unix)]
#[test]
fn endless_file_is_refused() {
    let error = Flash::in_file(Geometry::STM32F103, Path::new("/dev/zero")).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidInput);
}

#[test]
fn missing_bytes_of_truncated_file_read_as_erased() {
    let scratch = Scratch::new("cut");
    fs::write(&scratch.0, [b'P', 1]).unwrap();
    let mut flash = Flash::in_file(Geometry::STM32F103, &scratch.0).unwrap();
    assert_eq!(read(&mut flash, 0), [b'P', 1, 0xFF, 0xFF]);
    flash.write(4, &[3, 4]).unwrap();
    assert_eq!(fs::read(&scratch.0).unwrap(), flash.bytes());
}

/// A text that is shorter than a memory. A file with the length of a memory can begin with anything, after a power cut.
#[test]
fn file_with_another_purpose_is_refused() {
    let scratch = Scratch::new("purpose");
    for text in ["[sensor]\n", "Plan", "P\u{2}"] {
        fs::write(&scratch.0, text).unwrap();
        for geometry in [Geometry::STM32F103, Geometry::STM32F446] {
            let error = Flash::in_file(geometry, &scratch.0).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::InvalidData, "{text}");
        }
    }
    fs::write(&scratch.0, [b'x'; 2 * PAGE_SIZE]).unwrap();
    assert!(Flash::in_file(Geometry::STM32F446, &scratch.0).is_ok());
}
