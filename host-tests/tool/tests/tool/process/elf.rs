//! The ELF file of a program behind the bootloader of the Blue Pill, with what `plumbline image` reads of it. It cannot be started.

use plumbline::model::catalog::find;
use plumbline::update::Element;
use plumbline::update::header::{PAGE, PLACE, SIZE, version};
use plumbline::update::layout::BLUEPILL;

/// The sizes of the headers: of the file, of a segment, of a section.
const FILE: usize = 52;
const SEGMENT: usize = 32;
const SECTION: usize = 40;

/// The kinds of a section: contents of the program, and strings.
const CONTENTS: u32 = 1;
const STRINGS: u32 = 3;

/// An ELF file of a program of the is2 with two pages.
pub fn program_behind_a_bootloader() -> Vec<u8> {
    let product = find("is2").expect("a product").image.number();
    let number = Element::Ism330dhcx.with(product).to_le_bytes();
    let about = [&number[..], &version(1, 2, 3).to_le_bytes()].concat();
    let mut program = vec![0x5A; 2 * PAGE];
    program[PLACE..][..SIZE].fill(0xFF);
    let mut names = vec![0];
    let mut contents = program.clone();
    // The first section is empty.
    let mut sections = vec![0; SECTION];
    for (name, kind, bytes) in [
        (".plumbline.board", CONTENTS, BLUEPILL.name.as_bytes()),
        (".plumbline.program", CONTENTS, &about),
        (".shstrtab", STRINGS, &[]),
    ] {
        let place = FILE + SEGMENT + contents.len();
        let name_at = names.len() as u32;
        names.extend([name.as_bytes(), &[0]].concat());
        let bytes = if kind == STRINGS { &names } else { bytes };
        contents.extend(bytes);
        let (place, length) = (place as u32, bytes.len() as u32);
        words(
            &mut sections,
            &[name_at, kind, 0, 0, place, length, 0, 0, 1, 0],
        );
    }
    contents.resize(contents.len().next_multiple_of(4), 0);
    let at = (FILE + SEGMENT + contents.len()) as u32;
    // 32 bits, little endian, version 1; an executable file for Arm (40).
    let mut elf = b"\x7FELF\x01\x01\x01".to_vec();
    elf.resize(16, 0);
    half_words(&mut elf, &[2, 40]);
    words(&mut elf, &[1, BLUEPILL.start, FILE as u32, at, 0]);
    half_words(&mut elf, &[FILE, SEGMENT, 1, SECTION, 4, 3]);
    let (start, length) = (BLUEPILL.start, program.len() as u32);
    let place = (FILE + SEGMENT) as u32;
    words(&mut elf, &[1, place, start, start, length, length, 5, 4]);
    [elf, contents, sections].concat()
}

fn half_words(elf: &mut Vec<u8>, values: &[usize]) {
    elf.extend(
        values
            .iter()
            .flat_map(|value| (*value as u16).to_le_bytes()),
    );
}

fn words(elf: &mut Vec<u8>, values: &[u32]) {
    elf.extend(values.iter().flat_map(|value| value.to_le_bytes()));
}
