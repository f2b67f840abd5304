//! `watch`: the samples, one line for each.

use crate::error::Error;
use crate::ops::watch::{Request, Watched, watch};
use crate::output::Terminal;
use crate::session::Session;

/// Shows the samples.
///
/// # Errors
/// A name is wrong, the output cannot be written, or a request of the session fails.
pub(super) fn show(
    session: &mut Session,
    wanted: &Request,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let watched = watch(
        session,
        wanted,
        terminal,
        &mut |terminal, session, sampler, sample| {
            terminal.line(sampler.line(session, sample))?;
            terminal.document(&sampler.json(session, sample))
        },
    )?;
    tell(&watched, terminal)
}

/// Tells what the user must know of the samples.
///
/// # Errors
/// The sensor does not answer any more.
pub(super) fn tell(watched: &Watched, terminal: &mut Terminal) -> Result<(), Error> {
    for note in &watched.notes {
        terminal.note(note);
    }
    watched.check()
}
