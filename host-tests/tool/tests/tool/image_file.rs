//! `plumbline image`: the image file of an update from the ELF file of a program.

use crate::process::sensor::{document, plumbline};
use plumbline::model::catalog::find;
use plumbline::update::Header;
use plumbline::update::header::{SIZE, body_parts, crc};
use std::fs;
use std::path::{Path, PathBuf};
use stm32_sim::board::Board;
use stm32_sim::elf::Image;
use stm32_sim::firmware::{build, build_behind_bootloader};

/// A path in the folder of the tests.
fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// The ELF file of the is2 behind the bootloader.
pub fn program_for_an_update() -> PathBuf {
    let mut built = build_behind_bootloader(Board::BluePill, &["is2"]).expect("it builds");
    built.remove("is2").expect("the program")
}

#[track_caller]
fn is_refused(elf: &Path, reason: &str) {
    let output = path("refused.plu");
    let line = format!("image {} --output {}", elf.display(), output.display());
    let refused = plumbline("", &line);
    let text = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{text}");
    assert!(text.contains(reason), "{text}");
    assert!(!output.exists());
}

#[test]
fn image_file_has_the_header_and_the_flash_of_the_program() {
    let elf = program_for_an_update();
    let output = path("is2.plu");
    let line = format!(
        "--json --yes=overwrite image {} -o {}",
        elf.display(),
        output.display()
    );
    let told = document(&plumbline("", &line));
    let file = fs::read(&output).unwrap();
    let (header, body) = file.split_at(SIZE);
    let header = Header::parse(header.try_into().unwrap()).unwrap();
    assert_eq!(header.product(), find("is2").unwrap().image.number());
    assert_eq!((header.board(), header.layout()), (1, 1));
    assert_eq!(header.length(), body.len());
    assert_eq!(header.body(), crc(&body_parts(body)));
    for segment in Image::parse(&fs::read(elf).unwrap()).unwrap().segments() {
        let place = (segment.load_address - 0x0800_2000) as usize;
        assert_eq!(body[place..][..segment.bytes.len()], segment.bytes);
    }
    assert_eq!(told["product"], "is2");
    assert_eq!(told["board"], "bluepill");
    assert_eq!(told["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(told["bytes"], body.len());
}

#[test]
fn file_that_is_no_program_behind_a_bootloader_is_refused_with_its_reason() {
    let garbage = path("garbage.elf");
    fs::write(&garbage, b"no program").unwrap();
    is_refused(&garbage, "it is not an ELF file of 32 bits");
    let alone = &build(Board::BluePill, &["is2"]).unwrap()["is2"];
    is_refused(alone, "it is not built with --features behind-bootloader");
    let bytes = fs::read(alone).unwrap();
    // The machine is at byte 18 of the header; 62 is x86-64.
    let other = path("machine.elf");
    fs::write(&other, [&bytes[..18], &[62, 0], &bytes[20..]].concat()).unwrap();
    is_refused(&other, "it is for another processor");
}
