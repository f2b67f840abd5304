//! The private key of image files, and its file: LMS (RFC 8554, [`plumbline::update::lms`]).
//!
//! Each leaf of the tree may sign once. So the file has a line for each signature, which is written and synchronised before the signature is
//! calculated. Its number of lines is the next leaf. A second process waits for the lock of the file.

use crate::error::{Error, Fault, FileError, PageError};
use plumbline::update::PublicKey;
use plumbline::update::lms::{Hash, Identifier, Signature, sha256};
use std::fmt::Write as _;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::path::Path;

/// The first line of the file.
const TITLE: &str = "Plumbline private key, LMS_SHA256_M32_H10, LMOTS_SHA256_N32_W4 (RFC 8554). Keep it secret. Never use an older copy of this file.";
/// The line before those of the signatures.
const SIGNATURES: &str = "signatures:";

/// A private key.
pub struct PrivateKey {
    id: Identifier,
    seed: Hash,
    /// The nodes of the tree by their numbers. The root is number 1.
    nodes: Vec<Hash>,
}

impl PrivateKey {
    /// The key with this identifier and this seed. It calculates a million hashes.
    pub fn new(id: Identifier, seed: Hash) -> Self {
        let leaves = Signature::LEAVES as usize;
        let mut key = Self {
            id,
            seed,
            nodes: vec![[0; 32]; 2 * leaves],
        };
        for leaf in 0..Signature::LEAVES {
            let ends = (0..Signature::CHAINS as u16).map(|number| key.chain(leaf, number, 15));
            key.nodes[leaves + leaf as usize] = Signature::leaf(&id, leaf, ends);
        }
        for number in (1..leaves).rev() {
            let (left, right) = (&key.nodes[2 * number], &key.nodes[2 * number + 1]);
            key.nodes[number] = Signature::node(&id, number as u32, left, right);
        }
        key
    }

    /// The value of a chain after some hashes. Its start is that of RFC 8554, appendix A.
    fn chain(&self, leaf: u32, number: u16, steps: u8) -> Hash {
        let (q, i) = (leaf.to_be_bytes(), number.to_be_bytes());
        let start = sha256(&[&self.id, &q, &i, &[0xFF], &self.seed]);
        Signature::chain(&self.id, leaf, number, (0, steps), start)
    }

    /// The public key.
    pub fn public(&self) -> PublicKey {
        PublicKey::new(&self.id, &self.nodes[1])
    }

    /// The signature of a message by a leaf, which must never sign another message.
    pub fn sign(&self, leaf: u32, randomizer: &Hash, message: &[u8]) -> Vec<u8> {
        let [tree, one_time] = Signature::TYPES;
        let mut signature = [&leaf.to_be_bytes()[..], &one_time, randomizer].concat();
        let digits = Signature::message(&self.id, leaf, randomizer, message);
        let digits = Signature::checked(&digits);
        for number in 0..Signature::CHAINS as u16 {
            let digit = Signature::digit(&digits, number);
            signature.extend(self.chain(leaf, number, digit));
        }
        signature.extend(tree);
        let mut number = (Signature::LEAVES + leaf) as usize;
        while number > 1 {
            signature.extend(self.nodes[number ^ 1]);
            number /= 2;
        }
        signature
    }
}

/// The file of a private key, locked.
pub struct KeyFile {
    file: File,
    name: String,
    id: Identifier,
    seed: Hash,
    root: Hash,
    /// The number of leaves that have signed.
    used: u32,
    /// The power was cut while the last line was written.
    is_torn: bool,
}

impl KeyFile {
    /// Makes a new key and its file.
    ///
    /// # Errors
    /// The file exists or cannot be written.
    pub fn create(path: &Path) -> Result<Self, Error> {
        let name = path.display().to_string();
        let mut options = OpenOptions::new();
        options.create_new(true).read(true).append(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let mut file = options.open(path).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => FileError::KeyExists(name.clone()),
            _ => unwritten(&name, &error),
        })?;
        let (mut id, seed) = (random()?, random()?);
        // The first two bytes are the number of the key; 0 means no signature.
        id[0] = 1.max(id[0]);
        let key = PrivateKey::new(id, seed);
        let [id_text, seed_text, root] = [&id[..], &seed, &key.nodes[1]].map(hex);
        let text =
            format!("{TITLE}\nidentifier {id_text}\nseed {seed_text}\nroot {root}\n{SIGNATURES}\n");
        let written = file.write_all(text.as_bytes());
        written
            .and_then(|()| file.sync_all())
            .map_err(|error| unwritten(&name, &error))?;
        Ok(Self {
            file,
            name,
            id,
            seed,
            root: key.nodes[1],
            used: 0,
            is_torn: false,
        })
    }

    /// Reads the file of a key and locks it. Waits for another process that has locked it.
    ///
    /// # Errors
    /// The file cannot be read or locked, or is not that of a key.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let name = path.display().to_string();
        let unread = |error: std::io::Error| FileError::KeyUnread(name.clone(), error.to_string());
        // The first read of a pipe would wait without end.
        bench::file::open(path).map_err(|error| unread(error.into()))?;
        let mut options = OpenOptions::new();
        let mut file = options.read(true).append(true).open(path).map_err(unread)?;
        file.lock().map_err(unread)?;
        let mut text = String::new();
        let length = 1 << 20;
        (&mut file)
            .take(length)
            .read_to_string(&mut text)
            .map_err(unread)?;
        let wrong = || FileError::Key(name.clone(), Fault::NoKey);
        let mut lines = text.lines();
        let mut field = |name: &str| {
            let line = lines.next()?;
            line.strip_prefix(name).map(str::trim)
        };
        let fields = (|| {
            field(TITLE).filter(|rest| rest.is_empty())?;
            let id = bytes(field("identifier ")?)?;
            let seed = bytes(field("seed ")?)?;
            let root = bytes(field("root ")?)?;
            field(SIGNATURES).filter(|rest| rest.is_empty())?;
            Some((id, seed, root))
        })();
        let (id, seed, root) = fields.ok_or_else(wrong)?;
        let used = lines.count() as u32;
        let is_torn = !text.ends_with('\n');
        Ok(Self {
            file,
            name,
            id,
            seed,
            root,
            used,
            is_torn,
        })
    }

    /// The public key.
    pub fn public(&self) -> PublicKey {
        PublicKey::new(&self.id, &self.root)
    }

    /// The number of signatures that are left.
    pub fn left(&self) -> u32 {
        Signature::LEAVES.saturating_sub(self.used)
    }

    /// Signs a message with the next leaf. `what` is written beside it in the file. Before the signature is calculated, the file says that
    /// the leaf is used.
    ///
    /// # Errors
    /// All leaves are used, the file cannot be written, or it is damaged.
    pub fn sign(&mut self, what: &str, message: &[u8]) -> Result<Vec<u8>, Error> {
        if self.left() == 0 {
            return Err(FileError::KeyUsedUp(self.name.clone()).into());
        }
        let key = PrivateKey::new(self.id, self.seed);
        if key.nodes[1] != self.root {
            return Err(FileError::Key(self.name.clone(), Fault::DamagedKey).into());
        }
        let leaf = self.used;
        let start = if self.is_torn { "\n" } else { "" };
        let line = format!("{start}{leaf} {what}\n");
        let written = self.file.write_all(line.as_bytes());
        written
            .and_then(|()| self.file.sync_all())
            .map_err(|error| unwritten(&self.name, &error))?;
        (self.used, self.is_torn) = (leaf + 1, false);
        Ok(key.sign(leaf, &random()?, message))
    }
}

fn unwritten(name: &str, error: &std::io::Error) -> FileError {
    FileError::Unwritten(name.to_owned(), error.to_string())
}

fn random<const N: usize>() -> Result<[u8; N], Error> {
    let mut bytes = [0; N];
    getrandom::fill(&mut bytes).map_err(|error| PageError::NoRandom(error.to_string()))?;
    Ok(bytes)
}

fn hex(bytes: &[u8]) -> String {
    let mut text = String::new();
    for byte in bytes {
        let _ = write!(text, "{byte:02x}");
    }
    text
}

/// The bytes of a text of hexadecimal digits.
fn bytes<const N: usize>(text: &str) -> Option<[u8; N]> {
    let mut bytes = [0; N];
    let is_hex = text.len() == 2 * N && text.bytes().all(|digit| digit.is_ascii_hexdigit());
    for (number, byte) in bytes.iter_mut().enumerate().filter(|_| is_hex) {
        *byte = u8::from_str_radix(text.get(2 * number..2 * number + 2)?, 16).ok()?;
    }
    is_hex.then_some(bytes)
}
