//! Makes the image file of an update from the ELF file of a program behind a bootloader ([`plumbline::update::header`]).

use crate::error::{Error, Fault, FileError};
use crate::signing::KeyFile;
use ihex::Record;
use object::elf::{EM_ARM, FileHeader32, PT_LOAD};
use object::read::elf::{ElfFile32, FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSection};
use plumbline::model::catalog::PRODUCTS;
use plumbline::update::header::{PAGE, PLACE, SIZE, body_parts, crc, first_page_parts};
use plumbline::update::layout::LAYOUTS;
use plumbline::update::lms::{Signature, sha256};
use plumbline::update::{About, Contents, Hardware, Header, Layout};

/// An image file and what it is for.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ImageFile {
    /// The header.
    pub header: Header,
    /// The name of the board.
    pub board: &'static str,
    /// Header, signature if it has one, and body.
    pub bytes: Vec<u8>,
}

impl ImageFile {
    /// The length of the longest one in bytes: with a signature, for the largest slot.
    pub const LONGEST: usize = {
        let (mut size, mut number) = (0, 0);
        while number < LAYOUTS.len() {
            if LAYOUTS[number].size > size {
                size = LAYOUTS[number].size;
            }
            number += 1;
        }
        SIZE + Signature::SIGNATURE + size
    };

    /// The image file of a program.
    ///
    /// # Errors
    /// The file is not an ELF file of a program behind a bootloader.
    pub fn of(elf: &[u8]) -> Result<Self, Fault> {
        let Program {
            board,
            about,
            segments,
        } = Program::parse(elf)?;
        let about = about.ok_or(Fault::NoFirmware)?;
        let mut body = Vec::new();
        for (address, data) in segments {
            let place = address.checked_sub(board.start);
            let place = place.ok_or(Fault::NotBehindBootloader)? as usize;
            let end = place + data.len();
            if end > board.size {
                return Err(Fault::TooLargeForSlot(board.size));
            }
            body.resize(body.len().max(end.next_multiple_of(4)), 0xFF);
            body[place..end].copy_from_slice(data);
        }
        let is_free = |header: &[u8]| header.iter().all(|byte| *byte == 0xFF);
        if body.len() < PAGE || !is_free(&body[PLACE..PLACE + SIZE]) {
            return Err(Fault::NotBehindBootloader);
        }
        let contents = Contents {
            product: about.product(),
            element: about.element(),
            board: board.board,
            layout: board.number,
            key: 0,
            version: about.version(),
            hash: [0; 32],
        };
        let header = Header::new(&contents, &body).ok_or(Fault::NotBehindBootloader)?;
        let bytes = [header.bytes(), &body[..]].concat();
        let board = board.name;
        Ok(Self {
            header,
            board,
            bytes,
        })
    }

    /// An image file.
    ///
    /// # Errors
    /// It is not one, or it is damaged.
    pub fn parse(bytes: Vec<u8>) -> Result<Self, Fault> {
        let header = bytes.first_chunk().and_then(Header::parse);
        let header = header.ok_or(Fault::NoImage)?;
        let body = bytes.get(SIZE + header.signature()..).unwrap_or_default();
        let is_whole = body.len() == header.length()
            && crc(&body_parts(body)) == header.body()
            && body.first_chunk().is_some_and(|page| {
                let mut page: [u8; PAGE] = *page;
                page[PLACE..PLACE + SIZE].copy_from_slice(header.bytes());
                crc(&first_page_parts(&page)) == header.first_page()
            });
        if !is_whole {
            return Err(Fault::DamagedImage);
        }
        let mut boards = LAYOUTS.iter();
        let board = boards.find(|layout| layout.board == header.board());
        let board = board.ok_or(Fault::OtherBoard(header.board()))?;
        if header.length() > board.size {
            return Err(Fault::TooLargeForSlot(board.size));
        }
        Ok(Self {
            header,
            board: board.name,
            bytes,
        })
    }

    /// The Intel HEX file of the bootloader in an ELF file with this program behind it, as it is in the flash after an update.
    ///
    /// # Errors
    /// It is not an ELF file of the bootloader of this board.
    pub fn hex_behind(&self, bootloader: &[u8]) -> Result<String, Fault> {
        let Program {
            board,
            about,
            segments,
        } = Program::parse(bootloader)?;
        // A product names itself.
        if board.name != self.board || about.is_some() {
            return Err(Fault::OtherBootloader(self.board));
        }
        let mut body = self.bytes[SIZE + self.header.signature()..].to_vec();
        self.header.commit(&mut body);
        let parts = [&segments[..], &[(board.start, &body)]].concat();
        hex(&parts).map_err(|error| Fault::NoElf(error.to_string()))
    }

    /// The same with a signature of this key, in place of one that it has.
    ///
    /// # Errors
    /// See [`KeyFile::sign`].
    pub fn signed(&self, key: &mut KeyFile) -> Result<Self, Error> {
        let body = &self.bytes[SIZE + self.header.signature()..];
        let contents = Contents {
            product: self.header.product(),
            element: self.header.element(),
            board: self.header.board(),
            layout: self.header.layout(),
            key: key.public().number(),
            version: self.header.version(),
            hash: sha256(&body_parts(body)),
        };
        let header = Header::new(&contents, body).ok_or(FileError::Fault(Fault::DamagedImage))?;
        let what = format!("{} {} for {}", self.product(), self.version(), self.board);
        let signature = key.sign(&what, header.bytes())?;
        Ok(Self {
            header,
            board: self.board,
            bytes: [header.bytes(), &signature[..], body].concat(),
        })
    }

    /// The product: its name, or its number if it is not in the catalogue.
    pub fn product(&self) -> String {
        let number = self.header.product();
        let mut products = PRODUCTS.iter();
        let known = products.find(|product| product.image.number() == number);
        known.map_or_else(|| number.to_string(), |product| product.name.to_owned())
    }

    /// The version, for example `1.2.3`.
    pub fn version(&self) -> String {
        version(self.header.version())
    }
}

/// An ELF file of the firmware.
struct Program<'a> {
    board: &'static Layout,
    /// Its product; None: it is a bootloader.
    about: Option<About>,
    /// The address and the content of each part of the flash.
    segments: Vec<(u32, &'a [u8])>,
}

impl<'a> Program<'a> {
    fn parse(elf: &'a [u8]) -> Result<Self, Fault> {
        let told = |error: object::Error| Fault::NoElf(error.to_string());
        let header = FileHeader32::<Endianness>::parse(elf).map_err(told)?;
        let endian = header.endian().map_err(told)?;
        if header.e_machine(endian) != EM_ARM {
            return Err(Fault::OtherMachine);
        }
        let file: ElfFile32 = ElfFile32::parse(elf).map_err(told)?;
        let section = |name| file.section_by_name(name).and_then(|it| it.data().ok());
        let name = String::from_utf8_lossy(section(".plumbline.board").ok_or(Fault::NoFirmware)?);
        let board = LAYOUTS.iter().find(|board| board.name == name);
        let board = board.ok_or_else(|| Fault::NoBootloader(name.into_owned()))?;
        let about = section(".plumbline.program").and_then(About::parse);
        let mut segments = Vec::new();
        for part in header.program_headers(endian, elf).map_err(told)? {
            let data = part.data(endian, elf).map_err(|()| Fault::NoFirmware)?;
            if part.p_type(endian) == PT_LOAD && !data.is_empty() {
                segments.push((part.p_paddr(endian), data));
            }
        }
        Ok(Self {
            board,
            about,
            segments,
        })
    }
}

/// The Intel HEX file of these parts of the flash.
fn hex(parts: &[(u32, &[u8])]) -> Result<String, ihex::WriterError> {
    /// The bytes of a line. It begins at a multiple of them, so it does not cross 64 KiB.
    const LINE: usize = 16;
    let mut records = Vec::new();
    let mut upper = None;
    for &(mut address, mut data) in parts {
        while !data.is_empty() {
            let own = (address >> 16) as u16;
            if upper.replace(own) != Some(own) {
                records.push(Record::ExtendedLinearAddress(own));
            }
            let length = data.len().min(LINE - address as usize % LINE);
            let (line, rest) = data.split_at(length);
            let (offset, value) = (address as u16, line.to_vec());
            records.push(Record::Data { offset, value });
            (address, data) = (address + length as u32, rest);
        }
    }
    records.push(Record::EndOfFile);
    ihex::create_object_file_representation(&records)
}

/// The name of a board and that of a measuring element. The number of a board that is not known.
pub(crate) fn hardware(hardware: Hardware) -> String {
    let mut boards = LAYOUTS.iter();
    let board = boards.find(|layout| layout.board == hardware.board());
    let board = board.map_or_else(
        || hardware.board().to_string(),
        |board| board.name.to_owned(),
    );
    format!("{board}, {}", hardware.element().name())
}

/// A version, for example `1.2.3`.
pub(crate) fn version(number: u32) -> String {
    let [patch, minor, a, b] = number.to_le_bytes();
    format!("{}.{minor}.{patch}", u16::from_le_bytes([a, b]))
}
