//! Where the sensor is after a command that can move it: the command line that finds it.

use crate::cli::Options;
use crate::identify::Found;
use crate::master::NewAddress;
use crate::master::{Target, factory_rate, factory_target};
use crate::note::Note;
use crate::ops::report::Done;
use crate::ops::{Report, Request, rate, set};
use crate::resolve;
use crate::serve::line;
use crate::session::Session;
use plumbline::can::BitRate;

/// The bit rate and the address of a sensor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub rate: Option<BitRate>,
    pub target: Target,
    /// It is there only after a restart, which the command does not do.
    pub after_restart: bool,
}

impl Place {
    /// Where the sensor is now.
    pub fn now(session: &Session) -> Self {
        Self {
            rate: session.link.rate(),
            target: session.target,
            after_restart: false,
        }
    }

    /// Where the sensor is after its next restart. What it does not tell stays as it is.
    pub fn next(session: &mut Session) -> Self {
        let now = Self::now(session);
        let rate = rate::next_rate(session).unwrap_or(now.rate);
        let target = rate::next_target(session).unwrap_or(now.target);
        let is_moved = rate != now.rate || target.address() != now.target.address();
        Self {
            rate,
            target,
            after_restart: is_moved,
        }
    }

    /// Where the sensor is after an operation. `next`: where it would be after a restart, before the operation.
    pub fn after(
        request: &Request,
        report: &Report,
        session: &mut Session,
        next: Option<Self>,
    ) -> Self {
        let product = session.sheet.product;
        match (request, report) {
            (Request::Restart, _) => next.map_or_else(|| Self::now(session), Self::restarted),
            (
                _,
                Report::Done {
                    done: Done::FactoryRestarts | Done::FactoryRestartsAt,
                },
            ) => Self {
                rate: factory_rate(product).or(session.link.rate()),
                target: factory_target(product).unwrap_or(session.target),
                after_restart: false,
            },
            (Request::LoadFactory, _) => Self::next(session),
            (Request::Set { assignments, .. }, Report::Written { stored, .. })
                if (stored.is_some() || !set::is_saved_on_command(product))
                    && moving(session, assignments) =>
            {
                Self::next(session)
            }
            _ => Self::now(session),
        }
    }

    /// The same when the command has restarted the sensor.
    pub fn restarted(self) -> Self {
        Self {
            after_restart: false,
            ..self
        }
    }

    /// The command line, if an operation can have moved the sensor.
    pub fn note_after(
        &self,
        request: &Request,
        options: &Options,
        session: &Session,
        found: &Found,
    ) -> Option<Note> {
        let is_moved = self.after_restart || self.target != found.target;
        (moves(request) || is_moved).then(|| self.note(options, session, found))
    }

    /// The command line.
    pub fn note(&self, options: &Options, session: &Session, found: &Found) -> Note {
        let found = Found {
            target: self.target,
            ..found.clone()
        };
        let port = options.port.as_deref().unwrap_or_default();
        let eds = options.eds.as_ref().map(|path| path.display().to_string());
        let eds = eds.map(|path| format!("--eds={path}"));
        let product = session.sheet.product.name;
        let mut words = line::selecting(port, self.rate, &found, product, eds);
        words.push("get".to_owned());
        let line = line::shown(&words);
        match self.after_restart {
            true => Note::FoundAfterRestart(line),
            false => Note::FoundNow(line),
        }
    }
}

/// Whether a parameter of assignments moves the sensor at its next restart.
fn moving(session: &Session, assignments: &[String]) -> bool {
    let sheet = &session.sheet;
    let entries = assignments
        .iter()
        .filter_map(|own| resolve::assignments(sheet, own).ok());
    let mut entries = entries.flatten();
    entries.any(|(entry, _)| set::acts_later(sheet.product, entry))
}

/// Whether an operation can move the sensor.
fn moves(request: &Request) -> bool {
    matches!(
        request,
        Request::Restart
            | Request::LoadFactory
            | Request::Address(NewAddress { new: Some(_), .. })
            | Request::Rate { .. }
    )
}
