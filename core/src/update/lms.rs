//! LMS signatures with SHA-256 (RFC 8554): a tree of height `H` over one-time keys whose digits have `W` bits.
//!
//! A signature is checked with hashes only, so it needs little code. Each leaf of the tree signs once: who signs keeps a list
//! of the used ones. The firmware has the [parameters](PublicKey) LMS_SHA256_M32_H10 and LMOTS_SHA256_N32_W4.
//!
//! ```text
//!  signature
//!  byte 0       4             8             40            40 + 32 p     44 + 32 p
//!       +-------+-------------+-------------+-------------+-------------+-----------+
//!       | leaf  | type of the | randomizer  | p chains of | type of the | path of H |
//!       | u32   | one-time key| 32 bytes    | 32 bytes    | tree        | nodes     |
//!       +-------+-------------+-------------+-------------+-------------+-----------+
//! ```

use sha2::block_api::compress256;

/// A SHA-256.
pub type Hash = [u8; 32];
/// A hash and the checksum of its digits.
pub type Checked = [u8; 34];
/// The identifier of a key, which is in each of its hashes.
pub type Identifier = [u8; 16];

// What a hash is of (RFC 8554, 7.1).
const KEY: [u8; 2] = [0x80; 2];
const MESSAGE: [u8; 2] = [0x81; 2];
const LEAF: [u8; 2] = [0x82; 2];
const NODE: [u8; 2] = [0x83; 2];

/// The SHA-256 of these parts.
pub fn sha256(parts: &[&[u8]]) -> Hash {
    let mut sha = Sha256::new();
    parts.iter().for_each(|part| sha.update(part));
    sha.finish()
}

/// A SHA-256 (FIPS 180-4) in parts. That of the crate sha2 has the same compression, and more code than a bootloader has place for.
struct Sha256 {
    state: [u32; 8],
    block: [u8; 64],
    length: usize,
}

impl Sha256 {
    #[inline(never)] // called in several places
    fn new() -> Self {
        Self {
            state: [
                0x6A09_E667,
                0xBB67_AE85,
                0x3C6E_F372,
                0xA54F_F53A,
                0x510E_527F,
                0x9B05_688C,
                0x1F83_D9AB,
                0x5BE0_CD19,
            ],
            block: [0; 64],
            length: 0,
        }
    }

    /// The begin of each hash of a key: what it is of, in a leaf or a node with this number.
    #[inline(never)] // called in several places
    fn begin(id: &Identifier, number: u32, kind: [u8; 2]) -> Self {
        let mut sha = Self::new();
        sha.update(id);
        sha.update(&number.to_be_bytes());
        sha.update(&kind);
        sha
    }

    #[inline(never)] // called in several places
    fn update(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if let Some(place) = self.block.get_mut(self.length % 64) {
                *place = *byte;
            }
            self.length += 1;
            if self.length.is_multiple_of(64) {
                compress256(&mut self.state, &[self.block]);
            }
        }
    }

    #[inline(never)] // called in several places
    fn finish(&mut self) -> Hash {
        let bits = (self.length as u64 * 8).to_be_bytes();
        self.update(&[0x80]);
        while self.length % 64 != 56 {
            self.update(&[0]);
        }
        self.update(&bits);
        let mut hash = [0; 32];
        for (to, word) in hash.as_chunks_mut().0.iter_mut().zip(self.state) {
            *to = word.to_be_bytes();
        }
        hash
    }
}

/// A hash of a key over two parts.
#[inline(never)] // called in several places
fn hash(id: &Identifier, number: u32, kind: [u8; 2], first: &[u8], second: &[u8]) -> Hash {
    let mut sha = Sha256::begin(id, number, kind);
    sha.update(first);
    sha.update(second);
    sha.finish()
}

/// The trees of height `H` over one-time keys with digits of `W` bits; `W` is 1, 2, 4 or 8, and `H` a multiple of 5.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Lms<const H: u32, const W: u32>;

impl<const H: u32, const W: u32> Lms<H, W> {
    /// The number of leaves.
    pub const LEAVES: u32 = 1 << H;
    /// The number of hash chains of a one-time key: the digits of a SHA-256 and of its checksum.
    pub const CHAINS: usize = (256 / W + Self::CHECK_DIGITS) as usize;
    /// The length of a signature in bytes.
    pub const SIGNATURE: usize = 44 + 32 * (Self::CHAINS + H as usize);
    /// The numbers of the tree and of its one-time keys (RFC 8554, 8).
    pub const TYPES: [[u8; 4]; 2] = [
        (H / 5 + 4).to_be_bytes(),
        (W.trailing_zeros() + 1).to_be_bytes(),
    ];
    /// The highest digit: the number of hashes of a whole chain.
    const STEPS: u8 = ((1_u32 << W) - 1) as u8;
    /// The digits of the checksum.
    const CHECK_DIGITS: u32 = (((1 << W) - 1) * (256 / W)).ilog2() / W + 1;

    /// The hash of a message with its checksum.
    pub fn checked(hash: &Hash) -> Checked {
        let mut checked = [0; 34];
        if let Some(start) = checked.first_chunk_mut() {
            *start = *hash;
        }
        let mut sum = 0;
        for number in 0..256 / W {
            sum += u16::from(Self::STEPS - Self::digit(&checked, number as u16));
        }
        let sum = sum << (16 - Self::CHECK_DIGITS * W);
        if let Some(check) = checked.last_chunk_mut() {
            *check = sum.to_be_bytes();
        }
        checked
    }

    /// The digit with this number: the number of hashes of its chain in a signature.
    #[inline(never)] // called in several places
    pub fn digit(checked: &Checked, number: u16) -> u8 {
        let bit = u32::from(number) * W;
        let byte = checked.get((bit / 8) as usize).copied().unwrap_or(0);
        byte >> (8 - W - bit % 8) & Self::STEPS
    }

    /// The hash of a message that the one-time key of a leaf signs.
    pub fn message(id: &Identifier, leaf: u32, randomizer: &Hash, message: &[u8]) -> Hash {
        hash(id, leaf, MESSAGE, randomizer, message)
    }

    /// The value of a chain of a one-time key after `to` hashes. It is `value` after `from` hashes.
    pub fn chain(
        id: &Identifier,
        leaf: u32,
        number: u16,
        (from, to): (u8, u8),
        value: Hash,
    ) -> Hash {
        let step = |value: Hash, step| hash(id, leaf, number.to_be_bytes(), &[step], &value);
        (from..to).fold(value, step)
    }

    /// The leaf of a one-time key, from the ends of its chains.
    pub fn leaf(id: &Identifier, leaf: u32, ends: impl Iterator<Item = Hash>) -> Hash {
        let mut key = Sha256::begin(id, leaf, KEY);
        ends.for_each(|end| key.update(&end));
        hash(id, Self::LEAVES + leaf, LEAF, &key.finish(), &[])
    }

    /// The node with this number over two others.
    pub fn node(id: &Identifier, number: u32, left: &Hash, right: &Hash) -> Hash {
        hash(id, number, NODE, left, right)
    }

    /// The root of the tree with which this is a signature of the message. None: it is no signature of this type.
    pub fn root(id: &Identifier, message: &[u8], signature: &[u8]) -> Option<Hash> {
        if signature.len() != Self::SIGNATURE {
            return None;
        }
        let (leaf, rest) = signature.split_first_chunk()?;
        let (one_time, rest) = rest.split_first_chunk()?;
        let (randomizer, rest) = rest.split_first_chunk()?;
        let (chains, rest) = rest.split_at_checked(Self::CHAINS * 32)?;
        let (tree, path) = rest.split_first_chunk()?;
        let leaf = u32::from_be_bytes(*leaf);
        if [*tree, *one_time] != Self::TYPES || leaf >= Self::LEAVES {
            return None;
        }
        let digits = Self::checked(&Self::message(id, leaf, randomizer, message));
        let ends = (0..).zip(chains.as_chunks().0).map(|(number, start)| {
            let digit = Self::digit(&digits, number);
            Self::chain(id, leaf, number, (digit, Self::STEPS), *start)
        });
        let mut node = Self::leaf(id, leaf, ends);
        let mut number = Self::LEAVES + leaf;
        for other in path.as_chunks().0 {
            let is_right = number % 2 == 1;
            number /= 2;
            node = match is_right {
                true => Self::node(id, number, other, &node),
                false => Self::node(id, number, &node, other),
            };
        }
        Some(node)
    }
}

/// The signatures of image files.
pub type Signature = Lms<10, 4>;

/// The public key of image files. It has the form of RFC 8554, 5.3: the numbers of tree and one-time keys, the identifier, the root.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(transparent)]
pub struct PublicKey([u8; 56]);

impl PublicKey {
    /// The length in bytes.
    pub const SIZE: usize = 56;

    /// The key with this identifier and this root.
    pub fn new(id: &Identifier, root: &Hash) -> Self {
        let mut bytes = [0; Self::SIZE];
        let [tree, one_time] = Signature::TYPES;
        let content = [&tree[..], &one_time, id, root];
        for (to, from) in bytes.iter_mut().zip(content.into_iter().flatten()) {
            *to = *from;
        }
        Self(bytes)
    }

    /// Whether its place in the flash is erased: there is no key. Other bytes are a key, also if no signature is correct with it.
    pub fn is_erased(&self) -> bool {
        self.0.iter().all(|byte| *byte == 0xFF)
    }

    /// The key with these bytes.
    pub const fn from_bytes(bytes: [u8; Self::SIZE]) -> Self {
        Self(bytes)
    }

    /// Its bytes.
    pub const fn bytes(&self) -> &[u8; Self::SIZE] {
        &self.0
    }

    /// Its number in the header of an image: the first two bytes of its identifier.
    pub fn number(&self) -> u16 {
        let start = self.0.get(8..).and_then(<[u8]>::first_chunk);
        start.map_or(0, |start| u16::from_le_bytes(*start))
    }

    /// Whether this is its signature of the message.
    pub fn verifies(&self, message: &[u8], signature: &[u8]) -> bool {
        let id = self.0.get(8..).and_then(<[u8]>::first_chunk);
        let root = id.and_then(|id| Signature::root(id, message, signature));
        root.is_some_and(|root| self.0.ends_with(&root))
    }
}

#[cfg(test)]
mod tests;
