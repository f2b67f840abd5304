//! The operations on a sensor: each takes a session and a request, and returns a report. The command line and the page call the same ones.

pub(crate) mod address;
pub(crate) mod adjust;
pub(crate) mod align;
pub(crate) mod backup;
pub mod bridge;
pub mod calibrate;
pub(crate) mod commission;
pub mod diff;
pub(crate) mod doctor;
mod factory;
pub(crate) mod get;
pub mod identity;
pub(crate) mod label;
pub(crate) mod rate;
pub(crate) mod raw;
pub mod replace;
pub(crate) mod replay;
pub mod report;
pub mod request;
mod rest;
pub(crate) mod restore;
pub(crate) mod set;
pub(crate) mod transmit;
pub mod update;
pub mod watch;

use crate::error::Error;
use crate::identify::{self, Found};
use crate::labels::Labels;
use crate::output::Terminal;
use crate::session::Session;
pub use rate::NewRate;
pub use report::{Done, Report};
pub use request::Request;

/// Performs an operation. `labels` are the names of sensors, which only [`Request::Label`] needs. `checks`: the session is not new, so the
/// operation begins with the question whether this is still the same sensor.
///
/// # Errors
/// The operation is not possible, another sensor answers, it refuses, nobody answers, or the adapter fails.
pub fn perform(
    request: &Request,
    session: &mut Session,
    found: &Found,
    (labels, checks): (&mut Labels, bool),
    terminal: &mut Terminal,
) -> Result<Report, Error> {
    // What is not read twice is not read before other operations: they wait, restart, or use other services.
    let is_one_piece = matches!(
        request,
        Request::Get { .. }
            | Request::Set { .. }
            | Request::Save
            | Request::Zero { .. }
            | Request::Teach { .. }
    );
    session.remember(is_one_piece);
    let result = performed(request, session, found, (labels, checks), terminal);
    session.remember(false);
    for note in session.notes.drain(..) {
        terminal.note(&note);
    }
    result
}

fn performed(
    request: &Request,
    session: &mut Session,
    found: &Found,
    (labels, checks): (&mut Labels, bool),
    terminal: &mut Terminal,
) -> Result<Report, Error> {
    if session.sheet.data_sheet.is_some() {
        request.check_described()?;
    }
    // A read changes nothing, as the samples.
    if checks && !matches!(request, Request::Label { .. } | Request::Get { .. }) {
        identify::same(session, found)?;
    }
    match request {
        Request::Get { names } => get::get(session, names).map(Report::Values),
        Request::Set {
            assignments, save, ..
        } => set::set(session, assignments, *save, terminal),
        Request::Save => session.save().map(Report::from),
        Request::LoadFactory => factory::load(session, found, terminal),
        Request::Zero { axis, save } => {
            let axis = axis.map(|axis| axis.name());
            adjust::adjust(session, found, adjust::What::Zero, (axis, *save), terminal)
        }
        Request::Teach { save } => {
            adjust::adjust(session, found, adjust::What::Teach, (None, *save), terminal)
        }
        Request::Restart => {
            session.restart()?;
            Ok(Done::Restarts.into())
        }
        Request::Address(new) => new.perform(session),
        Request::Rate { new } => rate::rate(session, found, *new, terminal),
        Request::Label { name, remove } => {
            let change = match (name, remove) {
                (Some(name), _) => label::Change::Give(name),
                (None, true) => label::Change::Remove,
                (None, false) => label::Change::Show,
            };
            label::label(labels, found, change, terminal)
        }
        Request::Raw { request } => {
            session.release()?;
            let report = raw::send(&mut session.link, session.target, request);
            session.link.set_ending(false);
            report
        }
        Request::Identity => {
            let identity = identity::read(session, terminal)?;
            Ok(Report::Identity(Box::new(identity)))
        }
    }
}
