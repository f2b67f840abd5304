//! The ELF file of a program behind the bootloader of the Blue Pill, with what `plumbline image` reads of it. It cannot be started.

use plumbline::model::catalog::find;
use plumbline::update::header::{PAGE, PLACE, SIZE};
use plumbline::update::layout::BLUEPILL;

/// The sizes of the headers: of the file, of a segment, of a section.
const FILE: usize = 52;
const SEGMENT: usize = 32;
const SECTION: usize = 40;

/// The names of the sections, each with a zero at its end.
const NAMES: &[u8] = b"\0.plumbline.board\0.plumbline.program\0.shstrtab\0";

/// An ELF file of a program of the is2 with two pages.
pub fn program_behind_a_bootloader() -> Vec<u8> {
    let product = find("is2").expect("a product").image;
    // Version 1.2.3, for the ISM330DHCX.
    let about = [product.number().to_le_bytes(), [3, 2], [1, 0]].concat();
    let mut program = vec![0x5A; 2 * PAGE];
    program[PLACE..][..SIZE].fill(0xFF);
    let parts = [&program[..], BLUEPILL.name.as_bytes(), &about, NAMES];
    let mut place = FILE + SEGMENT;
    let places = parts.map(|part| {
        let own = place;
        place += part.len();
        own
    });
    let sections = place.next_multiple_of(4);
    // 32 bits, little endian, version 1; an executable file for Arm (40).
    let mut elf = b"\x7FELF\x01\x01\x01".to_vec();
    elf.resize(16, 0);
    half_words(&mut elf, &[2, 40]);
    words(
        &mut elf,
        &[1, BLUEPILL.start, FILE as u32, sections as u32, 0],
    );
    half_words(&mut elf, &[FILE, SEGMENT, 1, SECTION, 4, 3]);
    let length = program.len() as u32;
    let (start, place) = (BLUEPILL.start, places[0] as u32);
    words(&mut elf, &[1, place, start, start, length, length, 5, 4]);
    elf.extend(parts.concat());
    elf.resize(sections, 0);
    words(&mut elf, &[0; SECTION / 4]);
    // Contents of the program (1), or strings (3).
    for (part, kind) in [(1, 1), (2, 1), (3, 3)] {
        let name = NAMES
            .iter()
            .enumerate()
            .filter(|(_, byte)| **byte == 0)
            .nth(part - 1)
            .map_or(0, |(end, _)| end + 1);
        let [name, place, length] =
            [name, places[part], parts[part].len()].map(|number| number as u32);
        words(&mut elf, &[name, kind, 0, 0, place, length, 0, 0, 1, 0]);
    }
    elf
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
