//! A bootloader and a program behind it, in one flash.

use super::{FLASH_START, Image, ImageError, Segment, check_places, check_vectors};
use crate::board::Board;
use plumbline::update::layout::LAYOUTS;
use plumbline::update::{Contents, Header, Layout, PublicKey};

impl Image {
    /// This program behind a bootloader, in one flash. None: it is not linked for that, or the bootloader is for another board.
    ///
    /// The program is complete, as after an update.
    pub fn behind(&self, bootloader: &Self) -> Option<Self> {
        let begins = |image: &Self, start| {
            let mut segments = image.segments.iter();
            segments.any(|segment| segment.load_address == start)
        };
        let fits = self.board == bootloader.board
            && begins(bootloader, FLASH_START)
            && begins(self, self.board.facts().slot.start);
        let program = self.sealed().filter(|_| fits);
        program.map(|program| {
            let mut symbols = [&bootloader.symbols[..], &self.symbols].concat();
            symbols.sort_by_key(|symbol| (symbol.address, std::cmp::Reverse(symbol.size)));
            Self {
                board: self.board,
                segments: [&bootloader.segments[..], &[program]].concat(),
                sections: [&bootloader.sections[..], &self.sections].concat(),
                symbols,
                slot: self.board.facts().slot.clone(),
                about: self.about,
                checks_signatures: bootloader.checks_signatures,
            }
        })
    }

    /// What a probe writes into the flash of a board with a bootloader: the address and the content of each part.
    ///
    /// # Errors
    /// A part is outside of the flash, or there is no vector table.
    pub fn of_flash(board: Board, parts: Vec<(u32, Vec<u8>)>) -> Result<Self, ImageError> {
        let segments = parts.into_iter().map(|(address, bytes)| Segment {
            load_address: address,
            address,
            bytes,
        });
        let segments: Vec<Segment> = segments.collect();
        check_places(board, &segments)?;
        check_vectors(board, &segments)?;
        Ok(Self {
            board,
            segments,
            sections: Vec::new(),
            symbols: Vec::new(),
            slot: board.facts().slot.clone(),
            about: None,
            checks_signatures: false,
        })
    }

    /// Whether it is linked for a flash that begins with a bootloader.
    pub fn needs_bootloader(&self) -> bool {
        let mut segments = self.segments.iter();
        !segments.any(|segment| segment.load_address == FLASH_START)
    }

    /// The whole program as one segment, with its header and its commit.
    fn sealed(&self) -> Option<Segment> {
        let start = self.board.facts().slot.start;
        let mut body = Vec::new();
        for segment in &self.segments {
            let place = segment.load_address.checked_sub(start)? as usize;
            let end = place + segment.bytes.len();
            body.resize(body.len().max(end.next_multiple_of(4)), 0xFF);
            body[place..end].copy_from_slice(&segment.bytes);
        }
        let about = self.about?;
        let layout = self.layout()?;
        let contents = Contents {
            product: about.product(),
            element: about.element(),
            board: layout.board,
            layout: layout.number,
            key: 0,
            version: about.version(),
            hash: [0; 32],
        };
        let header = Header::new(&contents, &body)?;
        header.commit(&mut body);
        Some(Segment {
            load_address: start,
            address: start,
            bytes: body,
        })
    }

    /// The bootloader alone: without a program, it waits for one.
    pub fn as_bootloader(mut self) -> Self {
        self.slot = self.board.facts().slot.clone();
        self
    }

    /// The same with this public key in the flash of the bootloader. None: it does not check signatures.
    pub fn with_key(mut self, key: &PublicKey) -> Option<Self> {
        let layout = self.layout().filter(|_| self.checks_signatures)?;
        self.segments.push(Segment {
            load_address: layout.key,
            address: layout.key,
            bytes: key.bytes().to_vec(),
        });
        Some(self)
    }

    /// What is in the pages that the bootloader of this image can change; None: there is no bootloader.
    pub fn slot(&self) -> Option<Vec<u8>> {
        let mut content = vec![0xFF; self.slot.len()];
        for segment in &self.segments {
            let start = segment.load_address.checked_sub(self.slot.start);
            let place = start.and_then(|start| {
                content
                    .get_mut(start as usize..)?
                    .get_mut(..segment.bytes.len())
            });
            if let Some(place) = place {
                place.copy_from_slice(&segment.bytes);
            }
        }
        (!content.is_empty()).then_some(content)
    }

    /// The memory of its board behind a bootloader.
    fn layout(&self) -> Option<&'static Layout> {
        let name = self.board.facts().name;
        LAYOUTS.iter().find(|layout| layout.name == name)
    }
}
