//! `plumbline image`: the image file of an update from the ELF file of a program.

use crate::rig::{Rig, tilted};
use crate::sensor::{document, plumbline};
use bench::{BusRate, Flash};
use ihex::Record;
use plumbline::can::BitRate;
use plumbline::model::catalog::find;
use plumbline::update::Header;
use plumbline::update::header::{SIZE, body_parts, crc};
use std::fs;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use stm32_sim::Microcontroller;
use stm32_sim::board::Board;
use stm32_sim::elf::Image;
use stm32_sim::firmware::{build, build_behind_bootloader};

/// A path in the folder of the tests.
fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// The ELF file of the is2 behind the bootloader.
fn program_for_an_update() -> PathBuf {
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

/// A new board is flashed with the HEX file by a probe. The program is that of the image file, and the bootloader starts it.
fn hex_file_starts(board: Board) {
    let name = board.facts().name;
    let mut built = build(board, &["bootloader"]).expect("it builds");
    built.extend(build_behind_bootloader(board, &["jn2101"]).expect("it builds"));
    let (elf, bootloader) = (built["jn2101"].display(), built["bootloader"].display());
    let [image, hex] = ["plu", "hex"].map(|kind| path(&format!("first-{name}.{kind}")));
    let (image, hex) = (image.display(), hex.display());
    let line = format!("--json --yes=overwrite image {elf} -o {image}");
    let line = format!("{line} --bootloader {bootloader} --hex {hex}");
    assert_eq!(document(&plumbline("", &line))["hex"], hex.to_string());
    let text = fs::read_to_string(hex.to_string()).unwrap();
    let mut parts: Vec<(u32, Vec<u8>)> = Vec::new();
    let mut upper = 0;
    for record in ihex::Reader::new(&text) {
        match record.expect("a record") {
            Record::ExtendedLinearAddress(own) => upper = u32::from(own) << 16,
            Record::Data { offset, value } => parts.push((upper + u32::from(offset), value)),
            other => assert_eq!(other, Record::EndOfFile),
        }
    }
    let flash = Image::of_flash(board, parts).expect("the flash");
    let memory = Flash::blank(board.chip().facts().geometry);
    let sensor = Microcontroller::new("jn2101", Rc::new(flash), 7, memory, tilted());
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
    rig.rate = Some("125");
    rig.attach_sensor(sensor.quiet());
    rig.run(300);
    let line = format!("--node 10 update {image} --no-backup");
    assert_eq!(
        rig.json(&line)["loaded"],
        false,
        "{name}: it has the program"
    );
}

#[test]
fn hex_file_with_bootloader_and_program_starts_on_the_bluepill() {
    hex_file_starts(Board::BluePill);
}

#[test]
#[ignore = "other boards: `.ci/long ignored`"]
fn hex_file_with_bootloader_and_program_starts_on_the_nucleos() {
    hex_file_starts(Board::NucleoF103);
    hex_file_starts(Board::NucleoF446);
}

#[test]
fn hex_file_needs_the_bootloader_of_the_board() {
    let elf = program_for_an_update();
    let [output, hex] = ["none.plu", "none.hex"].map(path);
    for left in [&output, &hex] {
        // Of a run before. Fails if it does not exist.
        let _ = fs::remove_file(left);
    }
    let line = format!("image {} -o {}", elf.display(), output.display());
    for bootloader in [&elf, &build(Board::BluePill, &["is2"]).unwrap()["is2"]] {
        let both = format!(
            "--bootloader {} --hex {}",
            bootloader.display(),
            hex.display()
        );
        let refused = plumbline("", &format!("{line} {both}"));
        let text = String::from_utf8_lossy(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{text}");
        assert!(
            text.contains("is not a bootloader for the board bluepill"),
            "{text}"
        );
        assert!(!output.exists() && !hex.exists());
    }
}
