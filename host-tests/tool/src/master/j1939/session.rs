//! Commands in a session.

use super::Ca;
use crate::error::{Error, RequestError, What};
use crate::master::canopen;
use crate::master::canopen::sdo::Server;
use crate::session::{Session, unexpected};
use plumbline::canopen::dictionary::Starts;

impl Ca {
    /// The server of the objects.
    pub(super) fn server(self) -> Server {
        Server::j1939(self.0)
    }

    /// Refuses a command of a product that has only J1939, which has no such command; a product has its own ones.
    pub(super) fn must_have(self, session: &Session, error: RequestError) -> Result<Server, Error> {
        match canopen::tables(session.sheet.product) {
            Some(_) => Ok(self.server()),
            None => Err(error.into()),
        }
    }

    pub(super) fn restart_in(self, session: &mut Session) -> Result<(), Error> {
        let mut commands = canopen::commands(canopen::own(session)?, Starts::Reset);
        let object = commands.next().ok_or_else(|| unexpected(What::Restart))?;
        canopen::object(session, self.server(), object, &[1], What::Restart)
    }
}
