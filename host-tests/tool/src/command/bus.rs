//! The bus of the options of a command: its adapter, and a session with its sensor.

use super::Connect;
use super::place::Place;
use crate::cli::Options;
use crate::connect::{self, Wanted};
use crate::eds;
use crate::error::{Error, RequestError};
use crate::identify::{self, Found};
use crate::labels::Labels;
use crate::output::Terminal;
use crate::scan;
use crate::session::Session;
use adapter::Adapter;
use adapter::unread::Unread;

/// The bus of the options.
pub(super) struct Bus<'a> {
    pub options: &'a Options,
    pub connect: Connect<'a>,
    /// A DeviceNet slave of another master is listened to.
    pub listens: bool,
    /// What the adapter says and the tool cannot read.
    pub unread: Unread,
    /// Where the sensor is after the command.
    pub place: Option<Place>,
    /// A sensor has answered, or a request was sent to it.
    pub is_found: bool,
    /// The bit rate of the options is not that of the last command.
    pub is_rate_given: bool,
}

impl Bus<'_> {
    pub fn adapter(&mut self) -> Result<Box<dyn Adapter>, Error> {
        let port = self.options.port.as_deref();
        let adapter = (self.connect)(port.ok_or(RequestError::NoPort)?)?;
        self.unread = adapter.unread().unwrap_or_default();
        Ok(adapter)
    }

    /// The names of sensors. Without them every command works.
    pub fn labels(&self, terminal: &mut Terminal) -> Labels {
        let labels = Labels::open(self.options.config.as_deref());
        labels.unwrap_or_else(|failure| {
            terminal.note(&failure);
            Labels::default()
        })
    }

    pub fn wanted(&self, terminal: &mut Terminal) -> Result<Wanted, Error> {
        let options = self.options;
        let sheet = options.eds.as_deref().map(eds::read).transpose()?;
        let product = match (&sheet, &options.product) {
            (Some(sheet), _) => Some(sheet.product),
            (None, Some(name)) => Some(identify::product(name)?),
            (None, None) => None,
        };
        Ok(Wanted {
            rate: options.rate,
            is_remembered: options.rate.is_some() && !self.is_rate_given,
            target: options.sensor.target()?,
            product,
            sheet,
            labels: self.labels(terminal),
            listens: self.listens,
            memory: scan::Memory::default(),
        })
    }

    pub fn session(&mut self, terminal: &mut Terminal) -> Result<(Session, Found), Error> {
        let wanted = self.wanted(terminal)?;
        connect::session(self.adapter()?, &wanted, terminal)
    }

    /// Runs something in a session, which ends in every case.
    pub fn with<T>(
        &mut self,
        terminal: &mut Terminal,
        run: impl FnOnce(&mut Session, &mut Terminal) -> Result<T, Error>,
    ) -> Result<T, Error> {
        self.with_found(terminal, |session, _, terminal| run(session, terminal))
    }

    /// The same with what the sensor has told.
    pub fn with_found<T>(
        &mut self,
        terminal: &mut Terminal,
        run: impl FnOnce(&mut Session, &Found, &mut Terminal) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let (mut session, found) = self.session(terminal)?;
        self.is_found = true;
        let result = run(&mut session, &found, terminal);
        session.link.end();
        let released = session.release();
        session.link.close();
        for note in session.notes.drain(..) {
            terminal.note(&note);
        }
        let value = result?;
        released?;
        self.place = Some(Place::now(&session));
        Ok(value)
    }
}
