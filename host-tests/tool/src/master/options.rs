//! The options of the command line with the address of a sensor, one for each protocol.

use super::{PROTOCOLS, Protocol, Target};
use crate::error::{Error, RequestError};
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};

/// The addresses in the options, each with its protocol.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Addresses(Vec<(&'static Protocol, String)>);

impl Addresses {
    /// One address.
    pub fn one(protocol: &'static Protocol, address: &str) -> Self {
        Self(vec![(protocol, address.to_owned())])
    }

    /// The protocol of an option without hyphens; None: it has no address.
    pub fn protocol(option: &str) -> Option<&'static Protocol> {
        let mut all = PROTOCOLS.into_iter();
        all.find(|protocol| protocol.argument() == option)
    }

    /// The first address.
    pub fn first(&self) -> Option<(&'static Protocol, &str)> {
        let first = self.0.first();
        first.map(|(protocol, address)| (*protocol, &**address))
    }

    /// The sensor at the address; None: the options do not say it.
    ///
    /// # Errors
    /// More than one address is given, or one is out of its range.
    pub fn target(&self) -> Result<Option<Target>, Error> {
        match &self.0[..] {
            [] => Ok(None),
            [(protocol, address)] => (protocol.target)(address).map(Some),
            _ => Err(RequestError::TooManyAddresses.into()),
        }
    }
}

impl FromArgMatches for Addresses {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = PROTOCOLS.into_iter().filter_map(|protocol| {
            let address = matches.get_one::<String>(protocol.argument())?;
            Some((protocol, address.clone()))
        });
        Ok(Self(given.collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for Addresses {
    fn augment_args(command: Command) -> Command {
        command.args(PROTOCOLS.map(|protocol| {
            let name = protocol.argument();
            let arg = Arg::new(name).long(name).global(true);
            arg.value_name(protocol.value).help(protocol.help)
        }))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}
