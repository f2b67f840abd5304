//! Image files for tests.

use plumbline::model::catalog::Product;
use plumbline::update::header::{SIZE, body_parts};
use plumbline::update::layout::BLUEPILL;
use plumbline::update::lms::{Identifier, Signature, sha256};
use plumbline::update::{Contents, Element, Header, PublicKey};

/// An image file of 2 KiB for this product, with this version and for the Blue Pill. Its program cannot be started.
pub fn small(product: &Product, version: u32) -> Option<Vec<u8>> {
    let contents = Contents {
        product: product.image.number(),
        element: Element::Ism330dhcx,
        board: BLUEPILL.board,
        layout: BLUEPILL.number,
        key: 0,
        version,
        hash: [0; 32],
    };
    let body: Vec<u8> = (0..2048_u32).map(|place| (place * 7) as u8).collect();
    let header = Header::new(&contents, &body)?;
    Some([header.bytes(), &body[..]].concat())
}

/// An image file with a signature, and its key, which has this identifier. A private key is a million hashes; each signature is also that of
/// some key, which the check of it finds. None: it is not an image file without a signature.
pub fn sign(file: &[u8], id: &Identifier) -> Option<(Vec<u8>, PublicKey)> {
    let (header, body) = file.split_first_chunk::<SIZE>()?;
    let header = Header::parse(header).filter(|header| header.key() == 0)?;
    let contents = Contents {
        product: header.product(),
        element: header.element(),
        board: header.board(),
        layout: header.layout(),
        key: u16::from_le_bytes(*id.first_chunk()?),
        version: header.version(),
        hash: sha256(&body_parts(body)),
    };
    let header = Header::new(&contents, body)?;
    let mut signature = vec![0x5A; Signature::SIGNATURE];
    let [tree, one_time] = Signature::TYPES;
    signature[..8].copy_from_slice(&[[0; 4], one_time].concat());
    signature[40 + 32 * Signature::CHAINS..][..4].copy_from_slice(&tree);
    let root = Signature::root(id, header.bytes(), &signature)?;
    let file = [header.bytes(), &signature[..], body].concat();
    Some((file, PublicKey::new(id, &root)))
}
