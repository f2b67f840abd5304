//! Programs for updates: random bytes with a correct header. All of them run the same node.

use crate::random::Random;
use plumbline::model::catalog::Product;
use plumbline::update::header::{PAGE, PLACE, SIZE};
use plumbline::update::layout::BLUEPILL;
use plumbline::update::{Contents, Element, Header};
use plumbline_tool::image::ImageFile;

/// The largest number of words of a program behind its first page.
const WORDS: u32 = 1500;

/// The image file of a random program for a product.
///
/// # Panics
/// The header that it gets is wrong.
pub fn any(random: &mut Random, product: &Product) -> ImageFile {
    let length = PAGE + 4 * random.below(WORDS) as usize;
    let mut body: Vec<u8> = random.by_ref().take(length).collect();
    body[PLACE..PLACE + SIZE].fill(0xFF);
    let contents = Contents {
        product: product.image.number(),
        element: Element::Ism330dhcx,
        board: BLUEPILL.board,
        layout: BLUEPILL.number,
        key: 0,
        version: random.number() >> 8,
        hash: [0; 32],
    };
    let header = Header::new(&contents, &body).expect("a body with its first page");
    let file = [header.bytes(), &body[..]].concat();
    ImageFile::parse(file).unwrap_or_else(|fault| panic!("{fault}"))
}
