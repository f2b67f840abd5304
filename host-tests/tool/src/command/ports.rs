//! `plumbline ports`.

use crate::error::Error;
use crate::note::Note;
use crate::output::Terminal;
use adapter::ports::ports;
use serde_json::json;

/// Lists the ports of this computer.
///
/// # Errors
/// The output is closed.
pub(super) fn list(terminal: &mut Terminal) -> Result<(), Error> {
    let ports = ports();
    if ports.is_empty() {
        terminal.note(&Note::NoAdapter);
    }
    for listed in &ports {
        terminal.line(format!("{:24} {}", listed.port, listed.kind))?;
    }
    terminal.document(&json!(ports))
}
