//! `plumbline image`.

use super::replaced;
use crate::error::{Error, FileError};
use crate::image::ImageFile;
use crate::output::Terminal;
use serde_json::json;
use std::path::Path;

/// The longest ELF file that is read, with its debug information.
const LONGEST: u64 = 64 << 20;

/// Makes the image file of a program.
///
/// # Errors
/// A file cannot be read or written, or is not a program behind a bootloader.
pub(super) fn make(elf: &Path, output: &Path, terminal: &mut Terminal) -> Result<(), Error> {
    let name = elf.display().to_string();
    let bytes = bench::file::read(elf, LONGEST)
        .map_err(|error| FileError::ProgramUnread(name.clone(), error.to_string()))?;
    let image = ImageFile::of(&bytes).map_err(|why| FileError::Program(name, why))?;
    replaced(output, terminal)?;
    let written = output.display().to_string();
    std::fs::write(output, &image.bytes)
        .map_err(|error| FileError::Unwritten(written.clone(), error.to_string()))?;
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
    }))
}
