//! Makes the image file of an update from the ELF file of a program behind a bootloader ([`plumbline::update::header`]).

use crate::error::{Error, Fault, FileError};
use crate::signing::KeyFile;
use object::elf::{EM_ARM, FileHeader32, PT_LOAD};
use object::read::elf::{ElfFile32, FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSection};
use plumbline::model::catalog::PRODUCTS;
use plumbline::update::header::{PAGE, PLACE, SIZE, body_parts, crc, first_page_parts};
use plumbline::update::layout::LAYOUTS;
use plumbline::update::lms::sha256;
use plumbline::update::{About, Contents, Header};

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
    /// The image file of a program.
    ///
    /// # Errors
    /// The file is not an ELF file of a program behind a bootloader.
    pub fn of(elf: &[u8]) -> Result<Self, Fault> {
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
        let about = about.ok_or(Fault::NoFirmware)?;
        let mut body = Vec::new();
        for part in header.program_headers(endian, elf).map_err(told)? {
            let data = part.data(endian, elf).map_err(|()| Fault::NoFirmware)?;
            if part.p_type(endian) != PT_LOAD || data.is_empty() {
                continue;
            }
            let place = part.p_paddr(endian).checked_sub(board.start);
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
        let board = board.ok_or(Fault::OtherBoard(header.board()))?.name;
        Ok(Self {
            header,
            board,
            bytes,
        })
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

/// A version, for example `1.2.3`.
pub(crate) fn version(number: u32) -> String {
    let [patch, minor, a, b] = number.to_le_bytes();
    format!("{}.{minor}.{patch}", u16::from_le_bytes([a, b]))
}
