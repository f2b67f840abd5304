//! `plumbline key`.

use super::update::read;
use super::{distinct, replaced};
use crate::cli::KeyCommand;
use crate::error::{Error, FileError};
use crate::output::Terminal;
use crate::signing::KeyFile;
use serde_json::json;
use std::path::Path;

/// Makes, shows or uses a private key.
///
/// # Errors
/// A file cannot be read or written, or has the wrong content; or the key has no signatures left.
pub(super) fn key(command: &KeyCommand, terminal: &mut Terminal) -> Result<(), Error> {
    match command {
        KeyCommand::New { file } => show(file, &KeyFile::create(file)?, terminal),
        KeyCommand::Show { file, output } => {
            let key = KeyFile::open(file)?;
            if let Some(output) = output {
                distinct(&[file, output])?;
                replaced(output, terminal)?;
                write(output, key.public().bytes())?;
            }
            show(file, &key, terminal)
        }
        KeyCommand::Sign { file, key, output } => sign(file, key, output, terminal),
    }
}

fn show(file: &Path, key: &KeyFile, terminal: &mut Terminal) -> Result<(), Error> {
    let (file, number, left) = (
        file.display().to_string(),
        key.public().number(),
        key.left(),
    );
    terminal.line(format!("{file}: key {number:04X}h, {left} signatures left"))?;
    terminal.document(&json!({"file": file, "key": number, "left": left}))
}

fn sign(image: &Path, key: &Path, output: &Path, terminal: &mut Terminal) -> Result<(), Error> {
    distinct(&[key, output])?;
    let image = read(image)?;
    replaced(output, terminal)?;
    let mut key = KeyFile::open(key)?;
    let image = image.signed(&mut key)?;
    write(output, &image.bytes)?;
    let (output, left) = (output.display().to_string(), key.left());
    let number = image.header.key();
    terminal.line(format!(
        "{output}: {} {}, signed with key {number:04X}h, which has {left} signatures left",
        image.product(),
        image.version()
    ))?;
    terminal.document(&json!({"file": output, "key": number, "left": left}))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let written = std::fs::write(path, bytes);
    let unwritten =
        |error: std::io::Error| FileError::Unwritten(path.display().to_string(), error.to_string());
    Ok(written.map_err(unwritten)?)
}
