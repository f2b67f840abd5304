//! A slot and image files for tests.

use super::element::Element;
use super::header::{Contents, Device, Header, PLACE, SIZE, body_parts};
use super::lms::{PublicKey, Signature, sha256};
use super::slot::{Program, Slot, SlotError};
use std::vec::Vec;

pub const DEVICE: Device = Device {
    product: Some(3),
    board: 1,
    layout: 1,
};

const PAGE: usize = 1024;
const PAGES: usize = 8;

/// A slot of 8 pages. Like the flash of an STM32F103, it refuses to program a half-word that is not erased, but for 0000h.
#[derive(Clone, Debug)]
pub struct Flash {
    pub bytes: Vec<u8>,
    /// The number of half-words and pages until the power is cut; that one is done by halves.
    pub power: Option<usize>,
    /// The operations so far.
    pub operations: usize,
    pub erases: usize,
    /// The key of signatures.
    pub key: Option<PublicKey>,
    /// The program in another slot.
    pub other: Program,
}

impl Flash {
    pub fn blank() -> Self {
        Self {
            bytes: vec![0xFF; PAGE * PAGES],
            power: None,
            operations: 0,
            erases: 0,
            key: None,
            other: Program::None,
        }
    }

    /// Counts an operation: whether it is complete, or done by halves; then there is no power.
    fn is_complete(&mut self) -> Result<bool, SlotError> {
        self.operations += 1;
        match &mut self.power {
            None => Ok(true),
            Some(0) => Err(SlotError),
            Some(left) => {
                *left -= 1;
                Ok(*left > 0)
            }
        }
    }
}

impl Slot for Flash {
    const PAGE: usize = PAGE;
    const SIZE: usize = PAGE * PAGES;
    const SIGNATURES: bool = true;

    fn key(&self) -> Option<&PublicKey> {
        self.key.as_ref()
    }

    fn other(&self) -> Program {
        self.other
    }

    fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn erase(&mut self, page: usize) -> Result<(), SlotError> {
        self.erases += 1;
        let is_complete = self.is_complete()?;
        let bytes = &mut self.bytes[page * PAGE..][..PAGE];
        for (place, byte) in bytes.iter_mut().enumerate() {
            if is_complete || place % 3 == 0 {
                *byte = 0xFF;
            }
        }
        is_complete.then_some(()).ok_or(SlotError)
    }

    fn program(&mut self, place: usize, bytes: &[u8]) -> Result<(), SlotError> {
        assert!(place.is_multiple_of(2) && bytes.len().is_multiple_of(2));
        for (place, &[low, high]) in (place..).step_by(2).zip(bytes.as_chunks().0) {
            let present = &self.bytes[place..place + 2];
            if [low, high] == [0xFF; 2] && present == [0xFF; 2] {
                continue;
            }
            if present != [0xFF; 2] && [low, high] != [0; 2] {
                return Err(SlotError);
            }
            let is_complete = self.is_complete()?;
            let to = &mut self.bytes[place..place + 2];
            if is_complete {
                to.copy_from_slice(&[low, high]);
            } else {
                // Half of the bits are programmed.
                to[0] &= low | 0x55;
                to[1] &= high | 0x55;
                return Err(SlotError);
            }
        }
        Ok(())
    }
}

/// An image file for [`DEVICE`] with a body of this length that differs by `seed`.
pub fn file(version: u32, length: usize, seed: u8) -> Vec<u8> {
    let bytes = (0..length).map(|place| (place as u8).wrapping_mul(31) ^ (place >> 8) as u8 ^ seed);
    let mut body: Vec<u8> = bytes.collect();
    body[PLACE..PLACE + SIZE].fill(0xFF);
    seal(body, version)
}

/// The file with this body.
pub fn seal(mut body: Vec<u8>, version: u32) -> Vec<u8> {
    let contents = Contents {
        product: 3,
        element: Element::Ism330dhcx,
        board: 1,
        layout: 1,
        key: 0,
        version,
        hash: [0; 32],
    };
    let header = Header::new(&contents, &body).unwrap();
    let mut file = header.bytes().to_vec();
    file.append(&mut body);
    file
}

/// The file with a signature, and a key with which it is correct: each signature is that of some key.
pub fn sign(file: &[u8]) -> (Vec<u8>, PublicKey) {
    let (header, body) = file.split_at(SIZE);
    let contents = Contents {
        product: 3,
        element: Element::Ism330dhcx,
        board: 1,
        layout: 1,
        key: 0x0101,
        version: Header::parse(header.try_into().unwrap()).unwrap().version(),
        hash: sha256(&body_parts(body)),
    };
    let header = Header::new(&contents, body).unwrap();
    let id = [1; 16];
    let mut signature = [0x5A; Signature::SIGNATURE];
    let [tree, one_time] = Signature::TYPES;
    signature[..8].copy_from_slice(&[[0; 4], one_time].concat());
    signature[40 + 32 * Signature::CHAINS..][..4].copy_from_slice(&tree);
    let root = Signature::root(&id, header.bytes(), &signature).unwrap();
    let file = [header.bytes(), &signature[..], body].concat();
    (file, PublicKey::new(&id, &root))
}
