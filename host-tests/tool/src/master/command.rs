//! The commands that change the address of a sensor: each protocol says whether it has one.

use super::{PROTOCOLS, Protocol};
use crate::error::Error;
use crate::ops::Report;
use crate::session::Session;
use clap::{Arg, ArgMatches, Command, FromArgMatches, Subcommand, value_parser};
use serde_json::Value;

/// The command of a protocol that changes the address.
#[derive(Debug)]
pub struct AddressCommand {
    /// Its name.
    pub name: &'static str,
    /// Its help.
    pub help: &'static str,
    /// The help of the new number.
    pub number: &'static str,
    /// It shows the address if no number is given.
    pub shows: bool,
    /// Changes or shows the address.
    pub perform: fn(&mut Session, Option<u8>) -> Result<Report, Error>,
}

/// A new address by the command of a protocol; None: shows the address.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct NewAddress {
    /// The protocol.
    pub protocol: &'static Protocol,
    /// The number.
    pub new: Option<u8>,
}

/// The name of the argument.
const NEW: &str = "new";

impl NewAddress {
    /// All such commands.
    fn all() -> impl Iterator<Item = (&'static Protocol, &'static AddressCommand)> {
        let all = PROTOCOLS.into_iter();
        all.filter_map(|protocol| Some((protocol, protocol.command.as_ref()?)))
    }

    /// The command with this name.
    pub(super) fn named(name: &str) -> Option<(&'static Protocol, &'static AddressCommand)> {
        Self::all().find(|(_, command)| command.name == name)
    }

    /// A request of the page, for example `{"node-id": {"new": 11}}`; None: it is another one. A number that is not valid is an error.
    pub fn of(request: &Value) -> Option<Result<Self, &'static str>> {
        let (name, fields) = request
            .as_object()
            .filter(|own| own.len() == 1)?
            .iter()
            .next()?;
        let (protocol, command) = Self::named(name)?;
        let fields = fields
            .as_object()
            .map(|fields| (fields.get(NEW), fields.len()));
        let new = match fields {
            Some((Some(new), 1)) if !new.is_null() => new
                .as_u64()
                .and_then(|new| u8::try_from(new).ok())
                .map(Some),
            Some((Some(_), 1) | (None, 0)) if command.shows => Some(None),
            _ => None,
        };
        Some(new.map(|new| Self { protocol, new }).ok_or(command.number))
    }

    /// The name of the command.
    pub fn name(&self) -> &'static str {
        self.protocol.command.as_ref().map_or("", |own| own.name)
    }

    /// Performs it.
    ///
    /// # Errors
    /// The sensor has no such address, refuses it, nobody answers, or the adapter fails.
    pub fn perform(&self, session: &mut Session) -> Result<Report, Error> {
        match &self.protocol.command {
            Some(command) => (command.perform)(session, self.new),
            None => Err(crate::ops::address::not_here(session, self.protocol)),
        }
    }
}

impl FromArgMatches for NewAddress {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let named = matches.subcommand();
        let named = named.and_then(|(name, own)| Some((Self::named(name)?, own)));
        let ((protocol, _), own) =
            named.ok_or_else(|| clap::Error::new(clap::error::ErrorKind::InvalidSubcommand))?;
        let new = own.get_one::<u8>(NEW).copied();
        Ok(Self { protocol, new })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Subcommand for NewAddress {
    fn augment_subcommands(command: Command) -> Command {
        command.subcommands(Self::all().map(|(_, own)| {
            let new = Arg::new(NEW).help(own.number).required(!own.shows);
            let new = new.value_name("NEW").value_parser(value_parser!(u8));
            Command::new(own.name).about(own.help).arg(new)
        }))
    }

    fn augment_subcommands_for_update(command: Command) -> Command {
        Self::augment_subcommands(command)
    }

    fn has_subcommand(name: &str) -> bool {
        Self::named(name).is_some()
    }
}
