//! `plumbline image`.

use super::{distinct, replaced};
use crate::error::{Error, FileError};
use crate::image::ImageFile;
use crate::output::Terminal;
use serde_json::json;
use std::path::Path;

/// The longest ELF file that is read, with its debug information.
const LONGEST: u64 = 64 << 20;

/// Makes the image file of a program, and with a bootloader the HEX file of both.
///
/// # Errors
/// A file cannot be read or written, or is not a program behind a bootloader, or not its bootloader.
pub(super) fn make(
    elf: &Path,
    output: &Path,
    bootloader: Option<(&Path, &Path)>,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let hex = bootloader.map(|(_, hex)| hex);
    for read in [elf].into_iter().chain(bootloader.map(|(own, _)| own)) {
        let written = [output].into_iter().chain(hex);
        distinct(&[read].into_iter().chain(written).collect::<Vec<_>>())?;
    }
    let image = ImageFile::of(&read(elf)?);
    let image = image.map_err(|why| FileError::Program(elf.display().to_string(), why))?;
    let hex = match bootloader {
        Some((bootloader, hex)) => {
            let text = image.hex_behind(&read(bootloader)?);
            let name = bootloader.display().to_string();
            let text = text.map_err(|why| FileError::Bootloader(name, why))?;
            Some((hex, text))
        }
        None => None,
    };
    write(output, &image.bytes, terminal)?;
    if let Some((path, text)) = &hex {
        write(path, text.as_bytes(), terminal)?;
    }
    let written = output.display().to_string();
    let (product, version) = (image.product(), image.version());
    let length = image.header.length();
    terminal.line(format!(
        "{written}: {product} {version} for {}, {length} bytes",
        image.board
    ))?;
    terminal.document(&json!({
        "file": written,
        "product": product,
        "version": version,
        "board": image.board,
        "bytes": length,
        "crc": image.header.body(),
        "hex": hex.map(|(path, _)| path.display().to_string()),
    }))
}

/// Reads an ELF file.
fn read(path: &Path) -> Result<Vec<u8>, Error> {
    let unread = |error: bench::file::Unread| {
        FileError::ProgramUnread(path.display().to_string(), error.to_string())
    };
    Ok(bench::file::read(path, LONGEST).map_err(unread)?)
}

fn write(path: &Path, bytes: &[u8], terminal: &mut Terminal) -> Result<(), Error> {
    replaced(path, terminal)?;
    let unwritten =
        |error: std::io::Error| FileError::Unwritten(path.display().to_string(), error.to_string());
    Ok(std::fs::write(path, bytes).map_err(unwritten)?)
}
