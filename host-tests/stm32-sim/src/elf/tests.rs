use super::*;
use crate::image::Size;

/// Section header types and flags, symbol types (ELF specification).
const PROGBITS: u32 = 1;
const SYMTAB: u32 = 2;
const STRTAB: u32 = 3;
const NOBITS: u32 = 8;
const WRITE: u32 = 1;
const ALLOC: u32 = 2;
const EXECUTE: u32 = 4;
const OBJECT: u8 = 1;
const FUNCTION: u8 = 2;

#[derive(Default)]
struct Strings(Vec<u8>);

impl Strings {
    fn add(&mut self, name: &str) -> u32 {
        if self.0.is_empty() {
            self.0.push(0);
        }
        let at = self.0.len() as u32;
        self.0.extend(name.bytes().chain([0]));
        at
    }
}

fn words(values: &[u32]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect()
}

/// Name, type, flags, address, load address, size.
type SectionOf = (&'static str, u32, u32, u32, u32, u32);

/// Name, address, size, type, section.
type SymbolOf = (&'static str, u32, u32, u8, u16);

/// The initial stack pointer and the reset vector, in Thumb state.
const VECTORS: [u32; 2] = [0x2000_5000, 0x0800_0131];

/// The position of a field of the file header or of the first program header, as `build` writes them.
const MACHINE: usize = 18;
const OFFSET: usize = 52 + 4;
const LOAD_ADDRESS: usize = 52 + 12;
const IN_FILE: usize = 52 + 16;

/// An ELF file for ARM. Each section is a segment; its bytes are the low bytes of their offset, after vectors at the start of
/// flash.
fn build(sections: &[SectionOf], symbols: &[SymbolOf]) -> Vec<u8> {
    build_for("bluepill", sections, symbols)
}

/// As [`build`], with this name of the board.
fn build_for(board: &str, sections: &[SectionOf], symbols: &[SymbolOf]) -> Vec<u8> {
    let mut names = Strings::default();
    let mut symbol_names = Strings::default();
    let (mut headers, mut segments, mut content) = (vec![0; 40], Vec::new(), Vec::new());
    let start = 52 + 32 * sections.len() as u32;
    for &(name, kind, flags, address, load_address, size) in sections {
        let offset = start + content.len() as u32;
        let in_file = if kind == NOBITS { 0 } else { size };
        let vectors = match address {
            0x0800_0000 => words(&VECTORS),
            _ => Vec::new(),
        };
        let rest = vectors.len() as u32..in_file;
        content.extend(vectors);
        content.extend(rest.map(|at| at as u8));
        headers.extend(words(&[
            names.add(name),
            kind,
            flags,
            address,
            offset,
            size,
            0,
            0,
            1,
            0,
        ]));
        segments.extend(words(&[
            PT_LOAD.0,
            offset,
            address,
            load_address,
            in_file,
            size,
            4,
            1,
        ]));
    }
    let mut table = vec![0; 16];
    for &(name, address, size, kind, section) in symbols {
        table.extend(words(&[symbol_names.add(name), address, size]));
        table.extend([kind, 0]);
        table.extend(section.to_le_bytes());
    }
    let strings = sections.len() as u32 + 2;
    let name = [".symtab", ".strtab", BOARD, ".shstrtab"].map(|name| names.add(name));
    let extra = [
        (SYMTAB, table, strings, 16),
        (STRTAB, symbol_names.0, 0, 0),
        (PROGBITS, board.as_bytes().to_vec(), 0, 0),
        (STRTAB, names.0, 0, 0),
    ];
    for (name, (kind, bytes, link, entry)) in name.into_iter().zip(extra) {
        let offset = start + content.len() as u32;
        let size = bytes.len() as u32;
        headers.extend(words(&[name, kind, 0, 0, offset, size, link, 1, 1, entry]));
        content.extend(bytes);
    }
    let headers_at = start + content.len() as u32;
    let mut file = vec![0x7F, b'E', b'L', b'F', 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    // An executable for ARM, version 1.
    file.extend(words(&[2 | 40 << 16, 1, 0x0800_0131, 52, headers_at, 0]));
    for half in [
        52,
        32,
        sections.len() as u16,
        40,
        sections.len() as u16 + 5,
        sections.len() as u16 + 4,
    ] {
        file.extend(half.to_le_bytes());
    }
    file.extend(segments);
    file.extend(content);
    file.extend(headers);
    file
}

fn sample() -> Vec<u8> {
    build(
        &[
            (
                ".vector_table",
                PROGBITS,
                ALLOC,
                0x0800_0000,
                0x0800_0000,
                0x130,
            ),
            (
                ".text",
                PROGBITS,
                ALLOC | EXECUTE,
                0x0800_0130,
                0x0800_0130,
                100,
            ),
            (".rodata", PROGBITS, ALLOC, 0x0800_0194, 0x0800_0194, 30),
            (
                ".data",
                PROGBITS,
                ALLOC | WRITE,
                0x2000_0000,
                0x0800_01B2,
                8,
            ),
            (".bss", NOBITS, ALLOC | WRITE, 0x2000_0008, 0x2000_0008, 24),
        ],
        &[
            ("__INTERRUPTS", 0x0800_0040, 0xF0, OBJECT, 1),
            // Odd addresses: Thumb.
            (
                "_ZN9plumbline4node4Node4poll17h3d50da7199befd8bE",
                0x0800_0131,
                40,
                FUNCTION,
                2,
            ),
            (
                "_ZN14firmware_stm323app3run17he60dfc9dce0f6916E",
                0x0800_0159,
                30,
                FUNCTION,
                2,
            ),
            (
                "_ZN14firmware_stm323app3run28_$u7b$$u7b$closure$u7d$$u7d$17he60dfc9dce0f6917E",
                0x0800_0177,
                10,
                FUNCTION,
                2,
            ),
            ("$t", 0x0800_0130, 0, 0, 2),
            // A copy of the same code under two names; no symbol covers the last 4 bytes of the section.
            ("__aeabi_memclr", 0x0800_0181, 16, FUNCTION, 2),
            ("__aeabi_memclr4", 0x0800_0181, 10, FUNCTION, 2),
            (
                "_ZN9plumbline5angle4ATAN17h1de8939ed26cf98eE",
                0x0800_0194,
                20,
                OBJECT,
                3,
            ),
            (
                "_ZN5bxcan5STATE17h1de8939ed26cf98eE",
                0x2000_0000,
                8,
                OBJECT,
                4,
            ),
            (
                "_ZN14firmware_stm325clock6MILLIS17h875abdda2dc79549E.0",
                0x2000_0008,
                8,
                OBJECT,
                5,
            ),
        ],
    )
}

#[test]
fn segments_have_load_addresses() {
    let image = Image::parse(&sample()).unwrap();
    let places: Vec<_> = image
        .segments()
        .iter()
        .map(|it| (it.load_address, it.address, it.bytes.len()))
        .collect();
    assert_eq!(
        places,
        [
            (0x0800_0000, 0x0800_0000, 0x130),
            (0x0800_0130, 0x0800_0130, 100),
            (0x0800_0194, 0x0800_0194, 30),
            (0x0800_01B2, 0x2000_0000, 8),
        ]
    );
    assert_eq!(image.segments()[1].bytes[..3], [0, 1, 2]);
}

/// The error for the sample with these bytes changed.
fn error_with(place: usize, bytes: &[u8]) -> ImageError {
    let mut elf = sample();
    elf[place..place + bytes.len()].copy_from_slice(bytes);
    Image::parse(&elf).unwrap_err()
}

#[test]
fn other_files_are_refused() {
    for garbage in [&b""[..], b"no ELF", &sample()[..40], &[0; 1000]] {
        let error = Image::parse(garbage).unwrap_err();
        assert!(matches!(error, ImageError::Elf(_)), "{error}");
    }
    // 62: x86-64; the type stays that of an executable.
    assert_eq!(error_with(MACHINE, &[62, 0]), ImageError::Machine(62));
    assert_eq!(
        error_with(OFFSET, &0x10_0000_u32.to_le_bytes()),
        ImageError::Truncated(0x0800_0000)
    );
    assert_eq!(
        error_with(IN_FILE, &u32::MAX.to_le_bytes()),
        ImageError::Truncated(0x0800_0000)
    );
    let unlinked = build(&[(".bss", NOBITS, ALLOC | WRITE, 0x2000_0000, 0, 8)], &[]);
    assert_eq!(Image::parse(&unlinked).unwrap_err(), ImageError::Empty);
}

#[test]
fn segments_outside_program_flash_are_refused() {
    // RAM, below flash, beyond the end of the address space, and with the last bytes in the parameter pages.
    for address in [0x2000_0000, 0, 0xFFFF_FFF0, 0x0800_F6D1_u32] {
        assert_eq!(
            error_with(LOAD_ADDRESS, &address.to_le_bytes()),
            ImageError::Place(address, Board::BluePill)
        );
    }
    // It fits to the last byte, but the vectors are missing.
    assert_eq!(
        error_with(LOAD_ADDRESS, &0x0800_F6D0_u32.to_le_bytes()),
        ImageError::Vectors
    );
}

#[test]
fn name_in_the_file_determines_the_board() {
    let vectors = 52 + 32 * 2;
    let elf = |board: &str, start: u32, stack: u32| {
        let sections = [
            (".vectors", PROGBITS, ALLOC, 0x0800_0000, 0x0800_0000, 0x1C4),
            (".text", PROGBITS, ALLOC | EXECUTE, start, start, 0x40),
        ];
        let mut elf = build_for(board, &sections, &[]);
        elf[vectors..vectors + 8].copy_from_slice(&words(&[stack, start | 1]));
        Image::parse(&elf).map(|image| image.board())
    };
    let [bluepill, f103, f446] = Board::ALL.map(|board| board.facts().name);
    for (board, start, stack, expected) in [
        (f446, 0x0801_0000, 0x2002_0000, Ok(Board::NucleoF446)),
        (f446, 0x0807_FFC0, 0x2000_0400, Ok(Board::NucleoF446)),
        (bluepill, 0x0800_0200, 0x2000_5000, Ok(Board::BluePill)),
        (f103, 0x0800_0200, 0x2000_5000, Ok(Board::NucleoF103)),
        (f103, 0x0801_F7C0, 0x2000_5000, Ok(Board::NucleoF103)),
        (f446, 0x0801_0000, 0x2002_0004, Err(ImageError::Vectors)),
        (f103, 0x0800_0200, 0x2002_0000, Err(ImageError::Vectors)),
        (
            bluepill,
            0x0800_F800,
            0x2000_5000,
            Err(ImageError::Place(0x0800_F800, Board::BluePill)),
        ),
        (
            f103,
            0x0801_F800,
            0x2000_5000,
            Err(ImageError::Place(0x0801_F800, Board::NucleoF103)),
        ),
        (
            f446,
            0x0800_8000,
            0x2002_0000,
            Err(ImageError::Place(0x0800_8000, Board::NucleoF446)),
        ),
    ] {
        assert_eq!(elf(board, start, stack), expected, "{board} {start:#x}");
    }
    let text = ImageError::Place(0x0800_8000, Board::NucleoF446).to_string();
    assert_eq!(
        text,
        "the segment at 0x08008000 is outside the flash of the program, 0x08000000 to 0x08007fff and 0x08010000 to 0x0807ffff"
    );
    let unknown = elf("discovery", 0x0800_0200, 0x2000_5000).unwrap_err();
    assert_eq!(
        unknown.to_string(),
        "it is for the board discovery, which is not known; the boards are bluepill, nucleo-f103rb, nucleo-f446re"
    );
}

#[test]
fn file_without_the_name_of_a_board_is_refused() {
    let mut elf = sample();
    let name = elf
        .windows(BOARD.len())
        .position(|it| it == BOARD.as_bytes());
    elf[name.expect("the name of the section")] = b'-';
    assert_eq!(Image::parse(&elf).unwrap_err(), ImageError::NoBoard);
}

#[test]
fn missing_vector_table_is_refused() {
    let vectors = 52 + 32 * 5;
    for stack in [
        0,
        0x2000_0000,
        0x2000_5004,
        0x2000_0FFE,
        0x0800_1000,
        !0_u32,
    ] {
        assert_eq!(
            error_with(vectors, &stack.to_le_bytes()),
            ImageError::Vectors
        );
    }
    for reset in [0, 0x0800_0130, 0x0800_F801, 0x2000_0001, !0_u32] {
        assert_eq!(
            error_with(vectors + 4, &reset.to_le_bytes()),
            ImageError::Vectors
        );
    }
}

#[test]
fn damaged_file_does_not_panic() {
    let elf = sample();
    for length in 0..elf.len() {
        // Any result is accepted.
        let _ = Image::parse(&elf[..length]);
    }
    for place in 0..elf.len() {
        let mut damaged = elf.clone();
        damaged[place] ^= 0xFF;
        if let Ok(image) = Image::parse(&damaged) {
            image.end_of_statics();
            image.name_of(0x0800_0140);
        }
    }
}

#[test]
fn program_name_is_that_of_main_function() {
    let of = |names: &[&'static str]| {
        let symbols: Vec<SymbolOf> = names
            .iter()
            .map(|name| (*name, 0x0800_0040, 4, OBJECT, 1))
            .collect();
        let section = (".vectors", PROGBITS, ALLOC, 0x0800_0000, 0x0800_0000, 0x130);
        let image = Image::parse(&build(&[section], &symbols)).unwrap();
        image.program().map(str::to_owned)
    };
    let main = "_ZN4is2d18__cortex_m_rt_main17h3d50da7199befd8bE";
    let poll = "_ZN9plumbline4node4Node4poll17h3d50da7199befd8bE";
    assert_eq!(of(&[poll, main]), Some("is2d".to_owned()));
    assert_eq!(of(&[poll]), None);
}

#[test]
fn name_of_finds_symbol_and_offset() {
    let image = Image::parse(&sample()).unwrap();
    for (address, name) in [
        (0x0800_0130, Some(("plumbline::node::Node::poll", 0))),
        (0x0800_0157, Some(("plumbline::node::Node::poll", 39))),
        (0x0800_0158, Some(("firmware_stm32::app::run", 0))),
        (0x0800_018E, Some(("__aeabi_memclr", 14))),
        (0x0800_0190, None),
        (0x2000_0009, Some(("firmware_stm32::clock::MILLIS.0", 1))),
        (0x2000_0010, None),
        (0, None),
    ] {
        assert_eq!(image.name_of(address), name, "{address:08X}h");
    }
}

#[test]
fn address_of_finds_shortest_name() {
    let image = Image::parse(&sample()).unwrap();
    assert_eq!(image.address_of("app::run"), Some(0x0800_0158));
    assert_eq!(image.address_of("run::{{closure}}"), Some(0x0800_0176));
    assert_eq!(image.address_of("nothing"), None);
}

#[test]
fn shares_add_up_to_size_of_image() {
    let elf = sample();
    let shares = Image::parse(&elf).unwrap().shares();
    let flash = Part::ALL.map(|part| shares.flash(part));
    // Core, driver, libraries, runtime, vectors, constants, padding
    assert_eq!(flash, [40 + 20, 30 + 10, 8, 16, 0x130, 10, 4]);
    let ram = Part::ALL.map(|part| shares.ram(part));
    assert_eq!(ram, [0, 8, 8, 0, 0, 0, 16]);
    let size = Size::of(&elf).unwrap();
    assert_eq!(
        (flash.iter().sum(), ram.iter().sum()),
        (size.flash, size.ram)
    );
}

#[test]
fn scan_names_an_unsafe_instruction_and_refuses_a_file_without_marks() {
    let text = [(
        ".text",
        PROGBITS,
        ALLOC | EXECUTE,
        0x0800_0000,
        0x0800_0000,
        0x200,
    )];
    let mut elf = build(&text, &[("$t", 0x0800_0130, 0, 0, 1)]);
    assert_eq!(scan::unsafe_instructions(&elf), Ok(Vec::new()));
    // LDRD R0, R1, [R0], behind the header of the file and that of its segment.
    let at = 52 + 32 + 0x140;
    elf[at..at + 4].copy_from_slice(&[0xD0, 0xE9, 0x00, 0x01]);
    let found = scan::unsafe_instructions(&elf);
    assert_eq!(found, Ok(vec!["0x08000140 in ?".to_owned()]));
    let found = scan::unsafe_instructions(&build(&text, &[]));
    assert_eq!(found, Err(ImageError::Marks(".text".to_owned())));
}
