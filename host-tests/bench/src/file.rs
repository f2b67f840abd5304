//! Files that users give to the programs of the PC: only regular ones, up to a length, and texts in the encodings of the usual editors.

use std::fmt::{self, Display, Formatter};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The length of the longest text in bytes, for files that people write.
pub const LONGEST_TEXT: u64 = 1 << 20;

/// Why a file was not read.
#[derive(Debug)]
pub enum Unread {
    /// It cannot be opened or read.
    Failed(io::Error),
    /// What it is not, or why it is not taken.
    Unfit(Unfit),
}

/// Why a file that can be read is not taken.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unfit {
    /// A folder, a pipe or a device.
    NotRegular,
    /// It has more bytes than it may have.
    TooLong,
    /// It is neither UTF-8 nor UTF-16.
    NoText,
}

impl Display for Unfit {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotRegular => "it is not a regular file",
            Self::TooLong => "it is too long",
            Self::NoText => "it is not a text in UTF-8 or UTF-16",
        })
    }
}

impl From<io::Error> for Unread {
    fn from(error: io::Error) -> Self {
        Self::Failed(error)
    }
}

impl From<Unread> for io::Error {
    fn from(unread: Unread) -> Self {
        match unread {
            Unread::Failed(error) => error,
            Unread::Unfit(why) => Self::new(io::ErrorKind::InvalidInput, why.to_string()),
        }
    }
}

impl Display for Unread {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Failed(error) => error.fmt(f),
            Self::Unfit(why) => why.fmt(f),
        }
    }
}

/// Opens a regular file. A device can have no end, and the opening of a pipe can wait without end, so both are refused before they are
/// opened.
///
/// # Errors
/// The file cannot be opened, or is not a regular file.
pub fn open(path: &Path) -> Result<File, Unread> {
    const NOT_REGULAR: Unread = Unread::Unfit(Unfit::NotRegular);
    if !std::fs::metadata(path)?.is_file() {
        return Err(NOT_REGULAR);
    }
    let file = File::open(path)?;
    match file.metadata()?.is_file() {
        true => Ok(file),
        false => Err(NOT_REGULAR),
    }
}

/// Reads a regular file of at most this number of bytes.
///
/// # Errors
/// See [`open`]; or the file cannot be read, or is longer.
pub fn read(path: &Path, longest: u64) -> Result<Vec<u8>, Unread> {
    let mut bytes = Vec::new();
    // The length of a file in /proc is 0, and a file can grow meanwhile.
    open(path)?.take(longest + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > longest {
        true => Err(Unread::Unfit(Unfit::TooLong)),
        false => Ok(bytes),
    }
}

/// Reads a regular file with a text of at most 1 MiB.
///
/// # Errors
/// See [`read`]; or it is no text.
pub fn read_text(path: &Path) -> Result<String, Unread> {
    let text = decoded(&read(path, LONGEST_TEXT)?);
    match text.is_exact {
        true => Ok(text.text),
        false => Err(Unread::Unfit(Unfit::NoText)),
    }
}

/// The text of a file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Text {
    /// The text without byte order marks, which a joined file also has in the middle.
    pub text: String,
    /// It is valid UTF-8 or UTF-16. Otherwise the text is read as Latin-1, or has replacement characters.
    pub is_exact: bool,
}

/// The text of these bytes. UTF-16 has a byte order mark, or a letter of ASCII at its beginning.
pub fn decoded(bytes: &[u8]) -> Text {
    /// The byte order mark in UTF-8 whose bytes were read as Latin-1.
    const LATIN_MARK: &str = "\u{EF}\u{BB}\u{BF}";
    let unit: fn([u8; 2]) -> u16 = match bytes {
        [0xFF, 0xFE, ..] | [1..=0x7F, 0, ..] => u16::from_le_bytes,
        [0xFE, 0xFF, ..] | [0, 1..=0x7F, ..] => u16::from_be_bytes,
        _ => {
            let utf8 = str::from_utf8(bytes).map(str::to_owned);
            let is_exact = utf8.is_ok();
            let latin = || bytes.iter().copied().map(char::from).collect::<String>();
            let text = utf8.unwrap_or_else(|_| latin());
            let text = text.replace('\u{FEFF}', "").replace(LATIN_MARK, "");
            return Text { text, is_exact };
        }
    };
    let (pairs, rest) = bytes.as_chunks();
    let letters = char::decode_utf16(pairs.iter().map(|pair| unit(*pair)));
    let mut is_exact = rest.is_empty();
    let mut text = String::new();
    for letter in letters {
        is_exact &= letter.is_ok();
        text.push(letter.unwrap_or(char::REPLACEMENT_CHARACTER));
    }
    let text = text.replace('\u{FEFF}', "");
    Text { text, is_exact }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A text in an encoding.
    fn encoded(text: &str, unit: fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(unit).collect()
    }

    #[test]
    fn text_is_the_same_in_each_encoding() {
        let text = "t_s,ax_g # 20 \u{B0}C, \u{1F600}\r\n0,1";
        let marked = format!("\u{FEFF}{text}");
        for bytes in [
            text.as_bytes().to_vec(),
            marked.as_bytes().to_vec(),
            encoded(&marked, u16::to_le_bytes),
            encoded(&marked, u16::to_be_bytes),
            encoded(text, u16::to_le_bytes),
            encoded(text, u16::to_be_bytes),
            format!("{}\u{FEFF}{}", &text[..9], &text[9..]).into_bytes(),
        ] {
            let expected = Text {
                text: text.to_owned(),
                is_exact: true,
            };
            assert_eq!(decoded(&bytes), expected, "{bytes:02X?}");
        }
    }

    #[test]
    fn text_that_is_not_exact_is_told() {
        for (bytes, text) in [
            (&b"20 \xB0C"[..], "20 \u{B0}C"),
            (b"\xEF\xBB\xBFa\xB0", "a\u{B0}"),
            (b"\xFF\xFEa\0b", "a"),
            (b"a\0\x00\xD8b\0", "a\u{FFFD}b"),
        ] {
            let expected = Text {
                text: text.to_owned(),
                is_exact: false,
            };
            assert_eq!(decoded(bytes), expected, "{bytes:02X?}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn file_that_is_not_regular_or_too_long_is_refused_before_it_fills_the_memory() {
        let folder = std::env::temp_dir().join(format!("bench-{}-special", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        let (pipe, long) = (folder.join("pipe"), folder.join("long"));
        // Nobody writes to the pipe, so the opening would wait without end.
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        for path in [
            Path::new("/dev/zero"),
            Path::new("/dev/null"),
            &pipe,
            &folder,
        ] {
            for unread in [read(path, 10).unwrap_err(), read_text(path).unwrap_err()] {
                assert_eq!(unread.to_string(), "it is not a regular file", "{path:?}");
            }
        }
        std::fs::write(&long, [b' '; 11]).unwrap();
        assert_eq!(read(&long, 10).unwrap_err().to_string(), "it is too long");
        assert_eq!(read(&long, 11).unwrap(), [b' '; 11]);
        // The length of a file in /proc is 0.
        if Path::new("/proc/self/status").exists() {
            let unread = read(Path::new("/proc/self/status"), 10).unwrap_err();
            assert_eq!(unread.to_string(), "it is too long");
        }
        std::fs::remove_dir_all(folder).unwrap();
    }
}
