//! Electronic Data Sheets (EDS) of devices that are not in the catalogue: CANopen (CiA 306) and DeviceNet (ODVA).
//!
//! A sheet is made from the file, so that all commands work with its names. Other people make the file: for any content, the result is a
//! sheet or a clear error. An entry that this tool cannot show, for example a floating-point number, is left out and counted.
//!
//! The tables of a product are constants of the core, so the texts of a file that become tables stay until the end of the program. The
//! sheets are kept: the same file is read again without new memory, a file that is refused leaves nothing, and a process takes at most
//! [`MOST_FILES`] different ones.

mod draft;
mod format;
pub mod identity;

pub(crate) use draft::{DECIMALS, Draft, Factor, GREATEST, Texts};
pub(crate) use format::{Format, Values, number};

use crate::backup::{Unread, read_file};
use crate::error::{Error, Fault, FileError, RequestError};
use crate::master;
use crate::note::Note;
use crate::output::Terminal;
use crate::question::{Doubt, Doubts, Question};
use crate::session::Session;
use crate::sheet::rows::{fact, named};
use crate::sheet::{Address, Entry, Origin, Sheet, kebab};
use bench::file::decoded;
use draft::Owner;
use plumbline::model::catalog::{Article, PRODUCTS, Product, Protocol};
use plumbline::param::{DataType, ParameterId};
use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use texts::shown;

/// The longest file that is read, in bytes.
const LONGEST: u64 = 8 << 20;

/// The maximum number of entries of a file.
pub(crate) const MOST: usize = 20_000;

/// The maximum number of different files of a process.
pub const MOST_FILES: usize = 32;

/// The sheets of the files that were read.
static KEPT: Mutex<Vec<Sheet>> = Mutex::new(Vec::new());

/// No parameter of the catalogue has this id: a data sheet does not say which of its entries is the node-ID.
pub(crate) const NO_PARAMETER: ParameterId = ParameterId(u8::MAX);

/// Its order number is not in a data sheet.
pub(crate) const NO_ARTICLE: Article = Article {
    name: "",
    number: "",
};

/// What a sheet has besides its entries, if it is from a file.
#[derive(Clone, Debug)]
pub struct DataSheet {
    /// The text of the file.
    pub text: Arc<str>,
    /// Vendor and product code in the file.
    pub identity: [Option<u32>; 2],
    /// The angles that `watch` shows without names (CiA 410).
    pub angles: Vec<Entry>,
    /// The entries that are left out.
    pub left_out: usize,
    /// The lines that are no part of a data sheet.
    pub ignored: Vec<usize>,
}

/// The parts of a sheet, from either format.
pub(crate) struct Parts {
    pub name: String,
    pub maker: String,
    pub protocol: Protocol,
    pub identity: [Option<u32>; 2],
    pub rows: Vec<Draft>,
    pub left_out: usize,
    pub ignored: Vec<usize>,
}

/// Reads a file.
///
/// # Errors
/// The file cannot be read, or is not a data sheet with parameters.
pub fn read(path: &Path) -> Result<Sheet, Error> {
    let shown = || path.display().to_string();
    let bytes = read_file(path, LONGEST).map_err(|unread| match unread {
        Unread::Failed(error) => FileError::EdsUnread(shown(), error.to_string()),
        Unread::Unfit(why) => FileError::Eds(shown(), why.into()),
    })?;
    parse(&bytes).map_err(|why| FileError::Eds(shown(), why).into())
}

/// The sheet of a file, in UTF-8, UTF-16 or Latin-1. The same bytes give the same product.
///
/// # Errors
/// One sentence: why it is none, or that the process has read too many different ones.
pub fn parse(bytes: &[u8]) -> Result<Sheet, Fault> {
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    parse_among(&mut kept, bytes)
}

/// The same with the sheets that are kept already.
fn parse_among(kept: &mut Vec<Sheet>, bytes: &[u8]) -> Result<Sheet, Fault> {
    let text = text_of(bytes);
    let is_same = |sheet: &&Sheet| {
        let own = sheet.data_sheet.as_ref();
        own.is_some_and(|own| *own.text == *text)
    };
    if let Some(sheet) = kept.iter().find(is_same) {
        return Ok(sheet.clone());
    }
    let parts = parts(&text)?;
    if kept.len() >= MOST_FILES {
        return Err(Fault::TooManyFiles(MOST_FILES));
    }
    let sheet = sheet(text, parts);
    kept.push(sheet.clone());
    Ok(sheet)
}

/// The text of a data sheet: many are in Latin-1.
fn text_of(bytes: &[u8]) -> String {
    decoded(bytes).text
}

/// The parts of a file with entries.
fn parts(text: &str) -> Result<Parts, Fault> {
    let (_, format) = format::of(text).ok_or(Fault::NoEntry)?;
    let parts = (format.parts)(text)?;
    match parts.rows.len() {
        0 => Err(Fault::NoEntry),
        count if count > MOST => Err(too_many()),
        _ => Ok(parts),
    }
}

/// The sheet of the parts. Its texts and its product stay until the end of the program.
fn sheet(text: String, parts: Parts) -> Sheet {
    let mut owner = Owner::default();
    let rows = parts.rows.into_iter().map(|Draft { mut row, texts }| {
        if let Some(texts) = texts {
            texts.give(&mut row.entry, &mut owner);
        }
        row
    });
    let mut entries = named(rows.collect(), |_| None);
    make_unique(&mut entries);
    let angles = angles(&entries);
    let name = owner.keep(&product_name(&parts.name));
    let maker = owner.keep(&shown(&parts.maker));
    let described = Product::described(name, maker, parts.protocol);
    let product: &'static Product = Box::leak(Box::new(described));
    Sheet {
        product,
        entries,
        data_sheet: Some(DataSheet {
            text: text.into(),
            identity: parts.identity,
            angles,
            left_out: parts.left_out,
            ignored: parts.ignored,
        }),
    }
}

/// A name that no product of the catalogue has.
fn product_name(name: &str) -> String {
    let name = kebab(&shown(name));
    match &name[..] {
        "" => "eds".to_owned(),
        own if PRODUCTS.iter().any(|product| product.name == own) => format!("{name}-eds"),
        _ => name,
    }
}

pub(crate) fn too_many() -> Fault {
    Fault::TooMany(MOST)
}

/// Gives every entry a unique name. Returns the number of names that were tried in addition to the names of the file: at most two for each
/// entry.
fn make_unique(entries: &mut [Entry]) -> usize {
    let mut seen = HashSet::new();
    // The next number of an address that several entries have.
    let mut numbers: HashMap<String, usize> = HashMap::new();
    let mut tried = 0;
    for entry in entries {
        if entry.name.is_empty() || seen.contains(&entry.name) {
            let address = match entry.address {
                Address::Object { index, sub } => format!("{index:04x}-{sub}"),
                Address::Attribute {
                    class,
                    instance,
                    attribute,
                } => format!("{class}-{instance}-{attribute}"),
                Address::Fsc { read, offset, .. } => format!("{read:02x}-{offset}"),
            };
            let next = numbers.entry(address.clone()).or_insert(1);
            loop {
                entry.name = match *next {
                    1 => format!("object-{address}"),
                    number => format!("object-{address}-{number}"),
                };
                *next += 1;
                tried += 1;
                if !seen.contains(&entry.name) {
                    break;
                }
            }
        }
        seen.insert(entry.name.clone());
    }
    tried
}

/// The slopes of the device profile for inclinometers (CiA 410): 32 bits if there are both, else 16 bits.
fn angles(entries: &[Entry]) -> Vec<Entry> {
    let at = |wanted: u16| {
        let mut entries = entries.iter();
        entries.find(|entry| {
            entry.readable
                && entry.data_type.is_signed()
                && entry.address
                    == Address::Object {
                        index: wanted,
                        sub: 0,
                    }
        })
    };
    for pair in [[0x6110, 0x6120], [0x6010, 0x6020]] {
        let found: Vec<Entry> = pair.into_iter().filter_map(at).cloned().collect();
        if !found.is_empty() {
            return found;
        }
    }
    Vec::new()
}

/// An entry of a file, before it has its name.
pub(crate) fn entry(title: &str, address: Address, data_type: DataType) -> Entry {
    Entry {
        origin: Origin::DataSheet,
        ..fact(&shown(title), address, data_type)
    }
}

/// Tells what of its data sheet is not in the sheet.
pub fn note_losses(sheet: &Sheet, terminal: &mut Terminal) {
    let Some(data_sheet) = &sheet.data_sheet else {
        return;
    };
    if data_sheet.left_out > 0 {
        terminal.note(&Note::EntriesNotShown(data_sheet.left_out.into()));
    }
    if let [first, more @ ..] = &data_sheet.ignored[..] {
        terminal.note(&match more.len() {
            0 => Note::LineIgnored(*first),
            more => Note::LinesIgnored(*first, more),
        });
    }
}

/// Compares the identity of the device with that in the file. If they differ, or the device does not let its identity be read, asks
/// whether to go on.
///
/// # Errors
/// The answer is no, nobody answers, or the adapter fails.
pub fn check(session: &mut Session, terminal: &mut Terminal) -> Result<(), Error> {
    let Some(data_sheet) = session.sheet.data_sheet.clone() else {
        return Ok(());
    };
    note_losses(&session.sheet, terminal);
    let mut doubts = Vec::new();
    for (entry, wanted) in identity(session).into_iter().zip(data_sheet.identity) {
        let what = &entry.title;
        let Some(wanted) = wanted else {
            terminal.note(&Note::NotCompared(what.clone()));
            continue;
        };
        let own = match session.read(&entry) {
            // A device does not need to have it.
            Err(Error::Refused(_)) => None,
            own => match own? {
                own if own == wanted => continue,
                own => Some(format!("{own:X}h")),
            },
        };
        doubts.push(Doubt {
            what: what.clone(),
            wanted: format!("{wanted:X}h"),
            own,
        });
    }
    if doubts.is_empty() {
        return Ok(());
    }
    let doubts = Doubts(doubts);
    let question = Question::DataSheet {
        doubts: doubts.clone(),
    };
    match terminal.ask(&question)? {
        true => Ok(()),
        false => Err(RequestError::DataSheet(doubts).into()),
    }
}

/// Vendor and product code of a device.
fn identity(session: &Session) -> Vec<Entry> {
    let format = master::Protocol::of(session.sheet.product)
        .data_sheet
        .as_ref();
    let places = format.map(|format| format.identity);
    let names = ["vendor", "product code"].into_iter();
    let places = names.zip(places.into_iter().flatten());
    places
        .map(|(what, (address, data_type))| entry(what, address, data_type))
        .collect()
}

#[cfg(test)]
mod tests;
