//! Tests of a download into a simulated flash.

use super::super::header::{body_parts, crc};
use super::super::simulated::{DEVICE, Flash, file};
use super::*;

mod signed;

const OLD: u32 = 0x0001_0000;
const NEW: u32 = 0x0001_0001;

/// Downloads a file in pieces of this size.
fn download(
    flash: &mut Flash,
    loader: &mut Loader,
    file: &[u8],
    size: usize,
) -> Result<(), Failure> {
    let mut program = Program::of(flash);
    loader.clear();
    for piece in file.chunks(size) {
        loader.take(flash, &DEVICE, &mut program, piece)?;
    }
    loader.finish(flash, &mut program)?;
    let present = program.header().map(Header::version);
    assert_eq!(present, version(flash));
    Ok(())
}

/// A flash with the program of this file.
fn loaded(file: &[u8]) -> Flash {
    let mut flash = Flash::blank();
    download(&mut flash, &mut Loader::new(), file, 7).unwrap();
    flash.erases = 0;
    flash
}

fn version(flash: &Flash) -> Option<u32> {
    Program::of(flash).header().map(Header::version)
}

#[test]
fn file_is_programmed_and_complete_in_pieces_of_any_size() {
    for length in [1024, 1028, 3000, 5120, 8192] {
        let file = file(NEW, length, 0);
        for size in [1, 7, 217, 889, 10_000] {
            let mut flash = Flash::blank();
            let result = download(&mut flash, &mut Loader::new(), &file, size);
            assert_eq!(result, Ok(()), "{length} bytes in pieces of {size}");
            assert_eq!(flash.bytes[..PLACE], file[SIZE..][..PLACE]);
            assert_eq!(flash.bytes[PLACE..][..SIZE - 2], file[..SIZE - 2]);
            assert_eq!(flash.bytes[PLACE + SIZE..length], file[2 * SIZE + PLACE..]);
            assert_eq!(version(&flash), Some(NEW));
        }
    }
}

#[test]
fn each_byte_of_the_first_page_is_checked_before_the_flash_changes() {
    let old = loaded(&file(OLD, 2048, 1));
    let new = file(NEW, 3000, 2);
    // FFh in the place of the header does not count; nor do the unused bytes and the commit of the header itself.
    let places = (0..60)
        .chain(SIZE..SIZE + PLACE)
        .chain(2 * SIZE + PLACE..SIZE + PAGE);
    for place in places {
        let mut wrong = new.clone();
        wrong[place] ^= 0x10;
        let mut flash = old.clone();
        let mut loader = Loader::new();
        let result = download(&mut flash, &mut loader, &wrong, 217);
        assert!(
            matches!(
                result,
                // With a key id, the file is shorter than signature and first page.
                Err(Failure::Format | Failure::Damaged | Failure::Length)
            ),
            "byte {place}: {result:?}"
        );
        assert_eq!(flash.bytes, old.bytes, "byte {place}");
        assert_ne!(loader.status(), Status::Good);
    }
}

#[test]
fn any_later_wrong_byte_is_never_started() {
    let old = loaded(&file(OLD, 2048, 1));
    let new = file(NEW, 3000, 2);
    for place in SIZE + PAGE..new.len() {
        let mut wrong = new.clone();
        wrong[place] ^= 0x10;
        let mut flash = old.clone();
        let mut loader = Loader::new();
        let result = download(&mut flash, &mut loader, &wrong, 217);
        assert_eq!(result, Err(Failure::Data), "byte {place}");
        assert_eq!(loader.status(), Status::Data);
        // Also not by the commit of the next start.
        assert_eq!(Program::of(&flash), Program::None, "byte {place}");
    }
}

#[test]
fn file_of_another_length_is_refused() {
    let file = file(NEW, 3000, 0);
    let mut longer = file.clone();
    longer.push(0);
    for wrong in [
        &file[..0],
        &file[..63],
        &file[..1000],
        &file[..2999],
        &longer,
    ] {
        let mut flash = Flash::blank();
        let result = download(&mut flash, &mut Loader::new(), wrong, 217);
        assert_eq!(result, Err(Failure::Length), "{} bytes", wrong.len());
        assert_eq!(version(&flash), None);
    }
}

#[test]
fn older_version_needs_a_permission_that_counts_once() {
    let mut flash = loaded(&file(NEW, 2048, 1));
    let old = file(OLD, 2048, 0);
    let mut loader = Loader::new();
    let refused = Err(Failure::Older);
    assert_eq!(download(&mut flash, &mut loader, &old, 217), refused);
    assert_eq!((loader.status(), flash.erases), (Status::Secured, 0));
    loader.permit_downgrade();
    assert_eq!(download(&mut flash, &mut loader, &old, 217), Ok(()));
    assert_eq!(version(&flash), Some(OLD));
    let new = file(NEW, 2048, 1);
    assert_eq!(download(&mut flash, &mut loader, &new, 217), Ok(()));
    assert_eq!(download(&mut flash, &mut loader, &old, 217), refused);
}

#[test]
fn download_without_clear_is_refused_and_a_second_clear_begins_anew() {
    let new = file(NEW, 2048, 1);
    let mut flash = Flash::blank();
    let mut loader = Loader::new();
    let mut program = Program::None;
    let result = loader.take(&mut flash, &DEVICE, &mut program, &new);
    assert_eq!(result, Err(Failure::NotCleared));
    assert_eq!(
        loader.finish(&mut flash, &mut program),
        Err(Failure::NotCleared)
    );
    assert_eq!(loader.status(), Status::NotCleared);
    loader.clear();
    loader
        .take(&mut flash, &DEVICE, &mut program, &new[..1500])
        .unwrap();
    assert_eq!(download(&mut flash, &mut loader, &new, 217), Ok(()));
}

/// Cuts the power at an operation of the update of `flash`, then at an operation of the repair, then repairs it.
fn cut(mut flash: Flash, new: &[u8], first: usize, second: Option<usize>) {
    for power in [Some(first), second] {
        let Some(power) = power else { continue };
        flash.power = Some(power);
        let result = download(&mut flash, &mut Loader::new(), new, 217);
        flash.power = None;
        let cut = std::format!("cut at {first}, {second:?}");
        let started = Program::of(&flash).committed(&mut flash);
        let version = started.header().map(Header::version);
        assert!(matches!(version, None | Some(OLD | NEW)), "{cut}");
        assert!(version.is_some() || result.is_err(), "{cut}");
        if let Some(header) = started.header() {
            let length = header.length();
            let body = crc(&body_parts(&flash.bytes[..length]));
            assert_eq!(body, header.body(), "{cut}: a mixture");
        }
    }
    let result = download(&mut flash, &mut Loader::new(), new, 217);
    assert_eq!(result, Ok(()));
    assert_eq!(version(&flash), Some(NEW));
}

#[test]
fn power_cut_at_any_operation_leaves_the_old_program_the_new_one_or_none_and_never_a_mixture() {
    let old = loaded(&file(OLD, 2048, 1));
    let new = file(NEW, 3072, 2);
    let mut whole = old.clone();
    whole.operations = 0;
    download(&mut whole, &mut Loader::new(), &new, 217).unwrap();
    let operations = whole.operations;
    assert!(operations > 1500, "{operations} operations");
    for first in 1..=operations {
        cut(old.clone(), &new, first, None);
    }
    // The repair, after a cut in each kind of place: invalidation, erase, a half-word in each page, the first page, the commit.
    let kinds = [
        1,
        2,
        3,
        4,
        300,
        515,
        516,
        900,
        1026,
        1027,
        operations - 1,
        operations,
    ];
    for first in kinds {
        for second in (1..=operations).step_by(7) {
            cut(old.clone(), &new, first, Some(second));
        }
    }
}
