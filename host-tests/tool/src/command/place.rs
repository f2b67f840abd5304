//! Where the sensor is after a command that can move it: the command line that finds it.

use crate::cli::Options;
use crate::identify::Found;
use crate::master::Target;
use crate::note::Note;
use crate::ops::{Request, rate};
use crate::serve::line;
use crate::session::Session;
use plumbline::can::BitRate;

/// The bit rate and the address of a sensor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub rate: Option<BitRate>,
    pub target: Target,
    /// It is there only after a restart, which the command does not do.
    after_restart: bool,
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

    /// The same when the command has restarted the sensor.
    pub fn restarted(self) -> Self {
        Self {
            after_restart: false,
            ..self
        }
    }

    /// The command line.
    pub fn told(&self, options: &Options, session: &Session, found: &Found) -> Note {
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

/// Whether an operation can move the sensor.
pub(super) fn moves(request: &Request) -> bool {
    matches!(
        request,
        Request::Restart
            | Request::NodeId { .. }
            | Request::Mac { .. }
            | Request::Address { new: Some(_) }
            | Request::Rate { .. }
    )
}
