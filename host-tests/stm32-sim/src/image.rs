//! The size of a firmware image: the flash and RAM of its ELF file.

use object::elf::{FileHeader32, PT_LOAD};
use object::read::elf::{ElfFile32, FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSection, SectionKind};
use std::fmt;

/// Bytes of flash and RAM.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Size {
    /// Everything that is programmed: vectors, code, constants, initial values.
    pub flash: u64,
    /// Static RAM, without the stack.
    pub ram: u64,
}

impl Size {
    /// The size of the image in `elf`.
    pub fn of(elf: &[u8]) -> object::Result<Self> {
        let header = FileHeader32::<Endianness>::parse(elf)?;
        let endian = header.endian()?;
        let segments = header.program_headers(endian, elf)?;
        let loaded = segments
            .iter()
            .filter(|segment| segment.p_type(endian) == PT_LOAD);
        let flash = loaded
            .map(|segment| u64::from(segment.p_filesz(endian)))
            .sum();
        let file: ElfFile32 = ElfFile32::parse(elf)?;
        let in_ram = |kind| matches!(kind, SectionKind::Data | SectionKind::UninitializedData);
        let ram = file
            .sections()
            .filter(|section| in_ram(section.kind()))
            .map(|section| section.size())
            .sum();
        Ok(Self { flash, ram })
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "flash {:6} B, RAM {:5} B", self.flash, self.ram)
    }
}
