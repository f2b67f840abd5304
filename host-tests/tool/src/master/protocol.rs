//! What the tool knows of a protocol without a sensor.

use super::{AddressCommand, NewAddress, PROTOCOLS, Roles, Target};
use crate::decode::{Decoder, Known};
use crate::eds::Format;
use crate::error::{Error, RequestError};
use crate::link::Link;
use crate::scan::listen::Frames;
use crate::scan::row::Heard;
use crate::scan::signs::Signs;
use crate::sheet::rows::Builder;
use plumbline::model::catalog::Product;
use plumbline::time::Duration;
use std::ops::RangeInclusive;

/// What the tool knows of a protocol without a sensor.
#[derive(Debug)]
pub struct Protocol {
    /// The name in documents.
    pub name: &'static str,
    /// The option of the command line with an address.
    pub option: &'static str,
    /// The help of this option.
    pub help: &'static str,
    /// The value of this option, in its help.
    pub value: &'static str,
    /// What an address is, for people.
    pub kind: &'static str,
    /// The numbers that are addresses.
    pub range: RangeInclusive<u8>,
    /// The error of a product without such an address, with the commands that can be meant.
    pub lacks: fn(&'static str, String) -> RequestError,
    /// The command that changes the address.
    pub command: Option<AddressCommand>,
    /// The sensor at the address of this option.
    pub target: fn(&str) -> Result<Target, Error>,
    /// The parameters of a product with a role in this protocol; None: the product does not have this protocol.
    pub roles: fn(&Product) -> Option<Roles>,
    /// Adds the rows of the tables of a product to its sheet.
    pub(crate) rows: fn(&mut Builder),
    /// A search asks at all numbers.
    pub is_searched: bool,
    /// Finds the nodes that report their addresses after one request to all.
    pub(crate) announced_nodes: Option<Find>,
    /// Finds a node without an address. The frames are those that were heard before.
    pub(crate) unaddressed: Option<Unaddressed>,
    /// What the messages of these products mean.
    pub(crate) decoder: fn(Known) -> Box<dyn Decoder>,
    /// The longest time in which a new node checks its address before it answers, if another node acknowledges the check; None: it answers
    /// at once.
    pub(crate) check: Option<Duration>,
    /// The format of its data sheets.
    pub(crate) data_sheet: Option<Format>,
    /// How the frames of a bus show its nodes.
    pub(crate) signs: Signs,
}

type Find = fn(&mut Link) -> Result<Vec<Target>, Error>;
type Unaddressed = fn(&mut Link, &Frames) -> Result<Option<Heard>, Error>;

impl Eq for Protocol {}

impl PartialEq for Protocol {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Protocol {
    /// The protocol with this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        PROTOCOLS.into_iter().find(|protocol| protocol.name == name)
    }

    /// The name of the option without hyphens.
    pub(super) fn argument(&self) -> &'static str {
        self.option.trim_start_matches('-')
    }

    /// Whether the command with this name is not one of another protocol.
    pub(crate) fn permits(&self, command: &str) -> bool {
        NewAddress::named(command).is_none_or(|(protocol, _)| protocol == self)
    }

    /// The protocol of a product; of two, the first one of [`PROTOCOLS`].
    pub fn of(product: &Product) -> &'static Self {
        let mut all = PROTOCOLS.into_iter();
        let own = all.find(|protocol| protocol.is_of(product));
        own.unwrap_or(PROTOCOLS[0])
    }

    /// The addresses that a search asks.
    pub(crate) fn searched(&self) -> Vec<Target> {
        let numbers = self.range.clone().filter(|_| self.is_searched);
        let targets = numbers.map(|number| (self.target)(&number.to_string()));
        targets.filter_map(Result::ok).collect()
    }

    /// Whether a product can have this protocol.
    pub fn is_of(&self, product: &Product) -> bool {
        (self.roles)(product).is_some()
    }
}

/// The address of an option of the command line, which is a number.
pub(super) fn number(protocol: &Protocol, text: &str) -> Result<u8, Error> {
    let number = text.parse().ok();
    let number = number.filter(|number| protocol.range.contains(number));
    let (low, high) = protocol.range.clone().into_inner();
    let wrong =
        || RequestError::AddressRange(protocol.option, text.to_owned(), protocol.kind, low, high);
    Ok(number.ok_or_else(wrong)?)
}
