//! A firmware image: what its ELF file puts where, its symbols, and how much of it each part of the project takes.

mod shares;
#[cfg(test)]
mod tests;

use object::elf::{EM_ARM, FileHeader32, PT_LOAD};
use object::read::elf::{ElfFile32, FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};
use rustc_demangle::demangle;
pub use shares::{Part, Shares};
use std::collections::BTreeSet;
use std::ops::Range;
use thiserror::Error;

/// The flash that is the program's. The two pages behind it hold the parameters.
const PROGRAM: Range<u32> = 0x0800_0000..0x0800_F800;

/// The RAM of the STM32F103x8 (DS5319, figure 11).
const RAM: Range<u32> = 0x2000_0000..0x2000_5000;

/// The function that each program starts with, below its own name (cortex-m-rt).
const MAIN: &str = "::__cortex_m_rt_main";

/// Why a file is no image for this microcontroller.
#[derive(Clone, PartialEq, Eq, Debug, Error)]
pub enum ImageError {
    /// It is not an ELF file of 32 bits, or a table in it is damaged.
    #[error("it is not an ELF file of 32 bits, or it is damaged: {0}")]
    Elf(#[from] object::Error),
    /// It is for another processor, of this number in the header.
    #[error("it is a program for another processor than an ARM (machine {0})")]
    Machine(u16),
    /// It is not linked: nothing is to be loaded.
    #[error("nothing in it is to be loaded")]
    Empty,
    /// The file ends before what is to be loaded.
    #[error("what belongs at {0:#010x} is not in the file")]
    Truncated(u32),
    /// It has something to load at this address, which is not the program's.
    #[error(
        "it is to be loaded at {0:#010x}, which is outside of the program's flash, 0x08000000 to 0x0800f7ff"
    )]
    Place(u32),
    /// There is no vector table at the start of flash.
    #[error("there is no vector table at 0x08000000: a stack in RAM, and a start in flash")]
    Vectors,
}

/// Bytes to load.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Segment {
    /// Where they are programmed: the physical address.
    pub load_address: u32,
    /// Where the program finds them: the same in flash, in RAM for initial values, which the startup code copies there.
    pub address: u32,
    /// What they are.
    pub bytes: Vec<u8>,
}

/// A function or a static.
#[derive(Clone, PartialEq, Eq, Debug)]
struct Symbol {
    address: u32,
    /// In bytes; 0 when the file does not say.
    size: u32,
    /// As people read it.
    name: String,
}

/// A section that takes memory.
#[derive(Clone, PartialEq, Eq, Debug)]
struct Section {
    address: u32,
    size: u32,
    kind: SectionKind,
    name: String,
}

impl Section {
    /// True for variables.
    fn is_ram(&self) -> bool {
        let kinds = [SectionKind::Data, SectionKind::UninitializedData];
        kinds.contains(&self.kind)
    }
}

/// A firmware image.
#[derive(Clone, Debug)]
pub struct Image {
    segments: Vec<Segment>,
    sections: Vec<Section>,
    /// By rising address; the larger first where several share one.
    symbols: Vec<Symbol>,
}

impl Image {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// [`ImageError`].
    pub fn parse(elf: &[u8]) -> Result<Self, ImageError> {
        let segments = segments(elf)?;
        check_places(&segments)?;
        check_vectors(&segments)?;
        let file: ElfFile32 = ElfFile32::parse(elf)?;
        let mut symbols: Vec<Symbol> = file.symbols().filter_map(symbol).collect();
        symbols.sort_by_key(|symbol| (symbol.address, std::cmp::Reverse(symbol.size)));
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
            segments,
            sections,
            symbols,
        })
    }

    /// What is to be loaded.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The function or static at an address, as people read its name, and the offset in it.
    pub fn name_of(&self, address: u32) -> Option<(&str, u32)> {
        let end = self
            .symbols
            .partition_point(|symbol| symbol.address <= address);
        let last = self.symbols[..end].last()?;
        // The largest of those that begin there.
        let first = self.symbols[..end]
            .iter()
            .rev()
            .take_while(|symbol| symbol.address == last.address)
            .last()?;
        let offset = address - first.address;
        (first.size == 0 || offset < first.size).then_some((&first.name, offset))
    }

    /// The address of the function or static whose name has `part` in it; of several the one with the shortest name, so that a
    /// function goes before its closures.
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

    /// The first address behind the static variables, below which the stack must not get.
    pub fn end_of_statics(&self) -> u32 {
        let in_ram = self.sections.iter().filter(|section| section.is_ram());
        let ends = in_ram.map(|section| section.address.saturating_add(section.size));
        ends.max().unwrap_or_default()
    }

    /// How many bytes of flash and RAM each part of the project takes; together what [`Size::of`](crate::image::Size::of) says.
    pub fn shares(&self) -> Shares {
        Shares::of(self)
    }

    /// Bytes of the functions and constants of a module, which is named by its path with `::` at the end. What core's traits do for
    /// another module's types does not count: a symbol belongs to the first of plumbline's modules in its name.
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
    Ok(segments)
}

/// There is something to load, and all of it belongs into the program's flash.
fn check_places(segments: &[Segment]) -> Result<(), ImageError> {
    if segments.is_empty() {
        return Err(ImageError::Empty);
    }
    let fits = |segment: &Segment| {
        let end = u64::from(segment.load_address) + segment.bytes.len() as u64;
        PROGRAM.contains(&segment.load_address) && end <= u64::from(PROGRAM.end)
    };
    match segments.iter().find(|segment| !fits(segment)) {
        Some(segment) => Err(ImageError::Place(segment.load_address)),
        None => Ok(()),
    }
}

/// The first two vectors are such that the processor can start: the stack, which grows down from its top, in RAM and aligned to
/// words, the program in flash and in Thumb state (PM0056, sections 2.1.3 and 2.3.4).
fn check_vectors(segments: &[Segment]) -> Result<(), ImageError> {
    let first = segments
        .iter()
        .find(|segment| segment.load_address == PROGRAM.start);
    let vector = |at: usize| {
        let bytes = first?.bytes.get(4 * at..)?.first_chunk()?;
        Some(u32::from_le_bytes(*bytes))
    };
    let (Some(stack), Some(reset)) = (vector(0), vector(1)) else {
        return Err(ImageError::Vectors);
    };
    let has_stack = RAM.start < stack && stack <= RAM.end && stack % 4 == 0;
    let has_start = PROGRAM.contains(&reset) && reset % 2 == 1;
    if has_stack && has_start {
        Ok(())
    } else {
        Err(ImageError::Vectors)
    }
}

/// A function or a static that has a place; None for sections, files and the marks between code and data.
fn symbol<'data>(symbol: impl ObjectSymbol<'data>) -> Option<Symbol> {
    let name = symbol.name().ok()?;
    let is_mark = name.is_empty() || name.starts_with('$');
    // Bit 0 of a function's address says Thumb.
    let address = match symbol.kind() {
        SymbolKind::Text => symbol.address() as u32 & !1,
        SymbolKind::Data => symbol.address() as u32,
        // The limits that the linker script makes have no type; so have the constants of the compiler, but those have a size.
        SymbolKind::Unknown if symbol.size() > 0 => symbol.address() as u32,
        _ => return None,
    };
    (!is_mark && !symbol.is_undefined()).then(|| Symbol {
        address,
        size: symbol.size() as u32,
        name: readable(name),
    })
}

/// The name without its hash. The compiler puts the name of a function behind those of the tables that belong to it.
fn readable(name: &str) -> String {
    let mangled = ["_ZN", "_R"]
        .iter()
        .find_map(|start| name.find(start))
        .unwrap_or_default();
    let (before, mangled) = name.split_at(mangled);
    format!("{before}{:#}", demangle(mangled))
}
