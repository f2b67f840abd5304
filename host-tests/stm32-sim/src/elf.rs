//! A firmware image: the segments of its ELF file, its symbols, and the size of each part of the project.

mod behind;
pub mod scan;
mod shares;
#[cfg(test)]
mod tests;

use super::board::Board;
use object::elf::{EM_ARM, FileHeader32, PT_LOAD};
use object::read::elf::{ElfFile32, FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};
use plumbline::update::About;
use rustc_demangle::demangle;
pub use shares::{Part, Shares};
use std::collections::BTreeSet;
use std::ops::Range;
use thiserror::Error;

/// The start of flash, with the vector table.
const FLASH_START: u32 = 0x0800_0000;

/// The first function of each program, after the name of the program (cortex-m-rt).
const MAIN: &str = "::__cortex_m_rt_main";

/// The reason why a file is not an image for this microcontroller.
#[derive(Clone, PartialEq, Eq, Debug, Error)]
pub enum ImageError {
    /// It is not an ELF file of 32 bits, or a table in it is damaged.
    #[error("it is not an ELF file of 32 bits, or it is damaged: {0}")]
    Elf(#[from] object::Error),
    /// It is for another processor, with this number in the header.
    #[error("it is a program for another processor, not for ARM (machine {0})")]
    Machine(u16),
    /// It is not linked: it has no segments to load.
    #[error("it has no segments to load")]
    Empty,
    /// The file ends before the end of a segment.
    #[error("the segment at {0:#010x} is not completely in the file")]
    Truncated(u32),
    /// It does not contain the name of a board.
    #[error("it does not say for which board it is: the section {BOARD} is missing")]
    NoBoard,
    /// It is for a board of this name, which the simulator does not have.
    #[error("it is for the board {0}, which is not known; the boards are {names}", names = names())]
    Board(String),
    /// A segment is at this address, which is not in the flash of the program of this board.
    #[error("the segment at {0:#010x} is outside the flash of the program, {places}", places = places(*.1))]
    Place(u32, Board),
    /// A part of the program has no marks that tell its instructions from its data: its symbols are removed.
    #[error("the section {0} has no symbols that tell instructions from data")]
    Marks(String),
    /// There is no vector table at the start of flash.
    #[error(
        "there is no valid vector table at 0x08000000: it needs a stack in RAM and a start in flash"
    )]
    Vectors,
}

/// The section with the name of the board.
const BOARD: &str = ".plumbline.board";

/// The section of a bootloader that checks signatures.
const SIGNATURE: &str = ".plumbline.signature";

/// The section with product and version.
const PROGRAM: &str = ".plumbline.program";

/// The start of RAM.
const RAM_START: u32 = 0x2000_0000;

/// A part of the image that a probe writes to flash.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Segment {
    /// The address at which they are programmed: the physical address.
    pub load_address: u32,
    /// The address at run time: the same for flash, in RAM for initial values, which the startup code copies there.
    pub address: u32,
    /// The bytes from its address on.
    pub bytes: Vec<u8>,
}

/// A function or a static.
#[derive(Clone, PartialEq, Eq, Debug)]
struct Symbol {
    address: u32,
    /// In bytes; 0 when the file does not specify it.
    size: u32,
    name: String,
}

/// A section that occupies memory.
#[derive(Clone, PartialEq, Eq, Debug)]
struct Section {
    address: u32,
    size: u32,
    kind: SectionKind,
    name: String,
}

impl Section {
    fn is_ram(&self) -> bool {
        let kinds = [SectionKind::Data, SectionKind::UninitializedData];
        kinds.contains(&self.kind)
    }
}

/// A firmware image: its segments, symbols and chip.
#[derive(Clone, Debug)]
pub struct Image {
    board: Board,
    segments: Vec<Segment>,
    sections: Vec<Section>,
    /// By rising address; the larger first if several have the same address.
    symbols: Vec<Symbol>,
    /// The pages that a bootloader can change.
    slot: Range<u32>,
    /// Its product and version, if it names them.
    about: Option<About>,
    /// It is a bootloader that checks signatures.
    checks_signatures: bool,
}

impl Image {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// [`ImageError`].
    pub fn parse(elf: &[u8]) -> Result<Self, ImageError> {
        let segments = segments(elf)?;
        let file: ElfFile32 = ElfFile32::parse(elf)?;
        let board = board_of(&file)?;
        check_places(board, &segments)?;
        check_vectors(board, &segments)?;
        let mut symbols: Vec<Symbol> = file.symbols().filter_map(symbol).collect();
        symbols.sort_by_key(|symbol| (symbol.address, std::cmp::Reverse(symbol.size)));
        let about = file.section_by_name(PROGRAM);
        let about = about.and_then(|section| About::parse(section.data().ok()?));
        let sections = file
            .sections()
            .map(|section| {
                Ok(Section {
                    address: section.address() as u32,
                    size: section.size() as u32,
                    kind: section.kind(),
                    name: section.name()?.to_owned(),
                })
            })
            .collect::<Result<_, object::Error>>()?;
        Ok(Self {
            board,
            segments,
            sections,
            symbols,
            slot: 0..0,
            about,
            checks_signatures: file.section_by_name(SIGNATURE).is_some(),
        })
    }

    /// The board of the image, which its ELF file names.
    pub fn board(&self) -> Board {
        self.board
    }

    /// The segments, which a probe writes to flash.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The demangled name of the function or static at an address, and the offset in it.
    pub fn name_of(&self, address: u32) -> Option<(&str, u32)> {
        let end = self
            .symbols
            .partition_point(|symbol| symbol.address <= address);
        let last = self.symbols[..end].last()?;
        // The largest symbol that begins there.
        let first = self.symbols[..end]
            .iter()
            .rev()
            .take_while(|symbol| symbol.address == last.address)
            .last()?;
        let offset = address - first.address;
        (first.size == 0 || offset < first.size).then_some((&first.name, offset))
    }

    /// The address of the function or static whose name contains `part`; if there are several, the one with the shortest name, so
    /// that a function is found before its closures.
    pub fn address_of(&self, part: &str) -> Option<u32> {
        self.symbols
            .iter()
            .filter(|symbol| symbol.name.contains(part))
            .min_by_key(|symbol| symbol.name.len())
            .map(|symbol| symbol.address)
    }

    /// The name of the program, which is that of the product; None when the symbols are stripped.
    pub fn program(&self) -> Option<&str> {
        let mut symbols = self.symbols.iter();
        symbols.find_map(|symbol| symbol.name.strip_suffix(MAIN))
    }

    /// The lowest address that the stack may reach: the end of the static variables, or the start of RAM if the stack is below them.
    pub fn stack_limit(&self) -> u32 {
        let top = self.segments.iter().find_map(|segment| {
            let word = segment.bytes.first_chunk()?;
            (segment.load_address == FLASH_START).then(|| u32::from_le_bytes(*word))
        });
        match top {
            Some(top) if top <= self.statics().start => RAM_START,
            _ => self.end_of_statics(),
        }
    }

    /// The addresses of the static variables.
    pub fn statics(&self) -> Range<u32> {
        let in_ram = self.sections.iter().filter(|section| section.is_ram());
        let start = in_ram.map(|section| section.address).min();
        start.unwrap_or_default()..self.end_of_statics()
    }

    /// The first address after the static variables.
    pub fn end_of_statics(&self) -> u32 {
        let in_ram = self.sections.iter().filter(|section| section.is_ram());
        let ends = in_ram.map(|section| section.address.saturating_add(section.size));
        ends.max().unwrap_or_default()
    }

    /// The bytes of flash and RAM of each part of the project; their sum is [`Size::of`](crate::image::Size::of).
    pub fn shares(&self) -> Shares {
        Shares::of(self)
    }

    /// Bytes of the functions and constants of a module, given by its path with `::` at the end. A symbol belongs to the first
    /// module of plumbline in its name, so implementations of core's traits for types of another module are not included.
    pub fn flash_of(&self, module: &str) -> u64 {
        let mut bytes = BTreeSet::new();
        for symbol in &self.symbols {
            let path = symbol.name.find("plumbline::");
            if path.is_some_and(|path| symbol.name[path..].starts_with(module)) {
                bytes.extend(symbol.address..symbol.address.saturating_add(symbol.size));
            }
        }
        let in_flash = |address: &&u32| {
            let mut segments = self.segments.iter();
            segments.any(|segment| {
                let offset = address.checked_sub(segment.address);
                offset.is_some_and(|offset| (offset as usize) < segment.bytes.len())
            })
        };
        bytes.iter().filter(in_flash).count() as u64
    }
}

fn segments(elf: &[u8]) -> Result<Vec<Segment>, ImageError> {
    let header = FileHeader32::<Endianness>::parse(elf)?;
    let endian = header.endian()?;
    let machine = header.e_machine(endian);
    if machine != EM_ARM {
        return Err(ImageError::Machine(machine.0));
    }
    let mut segments = Vec::new();
    for segment in header.program_headers(endian, elf)? {
        let load_address = segment.p_paddr(endian);
        if segment.p_type(endian) != PT_LOAD || segment.p_filesz(endian) == 0 {
            continue;
        }
        let bytes = segment
            .data(endian, elf)
            .map_err(|()| ImageError::Truncated(load_address))?;
        segments.push(Segment {
            load_address,
            address: segment.p_vaddr(endian),
            bytes: bytes.to_vec(),
        });
    }
    if segments.is_empty() {
        return Err(ImageError::Empty);
    }
    Ok(segments)
}

/// The first two vectors, at the start of flash or behind a bootloader: the initial stack pointer and the start of the program.
fn vectors(board: Board, segments: &[Segment]) -> Option<[u32; 2]> {
    let is_start = |address| address == FLASH_START || address == board.facts().slot.start;
    let mut segments = segments.iter();
    let first = segments.find(|segment| is_start(segment.load_address))?;
    let vector = |at: usize| {
        let bytes = first.bytes.get(4 * at..)?.first_chunk()?;
        Some(u32::from_le_bytes(*bytes))
    };
    Some([vector(0)?, vector(1)?])
}

/// The board that the file names.
fn board_of(file: &ElfFile32) -> Result<Board, ImageError> {
    let section = file.section_by_name(BOARD).ok_or(ImageError::NoBoard)?;
    let name = String::from_utf8_lossy(section.data()?);
    Board::find(&name).ok_or_else(|| ImageError::Board(name.into_owned()))
}

/// The names of all boards as text.
fn names() -> String {
    Board::ALL.map(|board| board.facts().name).join(", ")
}

/// The address ranges of the program as text.
fn places(board: Board) -> String {
    let parts = board.facts().program.iter();
    let parts = parts.map(|part| format!("{:#010x} to {:#010x}", part.start, part.end - 1));
    parts.collect::<Vec<_>>().join(" and ")
}

fn in_program(board: Board, address: u32) -> bool {
    let mut parts = board.facts().program.iter();
    parts.any(|part| part.contains(&address))
}

/// Checks that everything to load is in the flash of the program.
fn check_places(board: Board, segments: &[Segment]) -> Result<(), ImageError> {
    let fits = |segment: &Segment| {
        let start = u64::from(segment.load_address);
        let end = start + segment.bytes.len() as u64;
        let mut parts = board.facts().program.iter();
        parts.any(|part| u64::from(part.start) <= start && end <= u64::from(part.end))
    };
    match segments.iter().find(|segment| !fits(segment)) {
        Some(segment) => Err(ImageError::Place(segment.load_address, board)),
        None => Ok(()),
    }
}

/// Checks the first two vectors: the stack, which grows down from its top, must be in RAM and word-aligned, the program in flash
/// and in Thumb state (PM0056, sections 2.1.3 and 2.3.4).
fn check_vectors(board: Board, segments: &[Segment]) -> Result<(), ImageError> {
    let Some([stack, reset]) = vectors(board, segments) else {
        return Err(ImageError::Vectors);
    };
    let ram: Range<u32> = board.chip().ram();
    let has_stack = ram.start < stack && stack <= ram.end && stack % 4 == 0;
    let has_start = in_program(board, reset) && reset % 2 == 1;
    if has_stack && has_start {
        Ok(())
    } else {
        Err(ImageError::Vectors)
    }
}

/// A function or static with an address; None for sections, files and the marks between code and data.
fn symbol<'data>(symbol: impl ObjectSymbol<'data>) -> Option<Symbol> {
    let name = symbol.name().ok()?;
    let is_mark = name.is_empty() || name.starts_with('$');
    // Bit 0 of a function address selects Thumb state.
    let address = match symbol.kind() {
        SymbolKind::Text => symbol.address() as u32 & !1,
        SymbolKind::Data => symbol.address() as u32,
        // Symbols of the linker script have no type and no size; constants of the compiler have no type but a size.
        SymbolKind::Unknown if symbol.size() > 0 => symbol.address() as u32,
        _ => return None,
    };
    (!is_mark && !symbol.is_undefined()).then(|| Symbol {
        address,
        size: symbol.size() as u32,
        name: readable(name),
    })
}

/// The name without its hash. The compiler appends the name of a function to those of its tables.
fn readable(name: &str) -> String {
    let mangled = ["_ZN", "_R"]
        .iter()
        .find_map(|start| name.find(start))
        .unwrap_or_default();
    let (before, mangled) = name.split_at(mangled);
    format!("{before}{:#}", demangle(mangled))
}
