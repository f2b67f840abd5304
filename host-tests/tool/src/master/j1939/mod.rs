//! J1939. The parameters of a sensor are the objects of its CANopen dictionary.

pub mod address;
mod cyclic;
mod decode;
pub mod groups;
mod identify;
mod identity;
mod raw;
mod session;
mod signs;
mod ssi2;

use super::{AddressCommand, Master, Program, Protocol, Roles, Storing, Target, canopen};
use crate::cyclic::{Source, Started};
use crate::error::{Error, RequestError};
use crate::identify::Found;
use crate::link::Link;
use crate::master::canopen::sdo::Server;
use crate::master::j1939::groups as j1939;
use crate::ops::identity::Values;
use crate::ops::report::Done;
use crate::output::Terminal;
use crate::sample::{Poller, Sampler};
use crate::session::Session;
use crate::sheet::Entry;
use plumbline::j1939::identifier::{Identifier, PROPRIETARY_A};
use plumbline::model::catalog::{self, Product};
use plumbline::model::listing::j1939::J1939Tables;
use plumbline::time::Duration;

/// The protocol.
pub const PROTOCOL: Protocol = Protocol {
    name: "j1939",
    option: "--address",
    help: "The address of a sensor in J1939",
    value: "N",
    kind: "J1939 address",
    range: 0..=253,
    lacks: RequestError::NoJ1939Address,
    command: Some(AddressCommand {
        name: "address",
        help: "Show the J1939 address and NAME, or change the address: commands it, checks, stores",
        number: "The new address, 0 to 253",
        shows: true,
        perform: address::address,
    }),
    target,
    roles,
    // Its parameters have no addresses that a tool knows.
    rows: |_| {},
    is_searched: false,
    announced_nodes: Some(announced_nodes),
    unaddressed: None,
    decoder: decode::decoder,
    check: None,
    data_sheet: None,
    signs: signs::SIGNS,
};

/// A controller application (CA), with its address.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Ca(pub u8);

/// The tables of J1939, if a product has it, also besides another protocol.
pub fn tables(product: &Product) -> Option<&J1939Tables> {
    match &product.protocol {
        catalog::Protocol::J1939(tables) => Some(&tables.j1939),
        _ => canopen::tables(product)?.j1939.as_ref(),
    }
}

fn announced_nodes(link: &mut Link) -> Result<Vec<Target>, Error> {
    let nodes = j1939::nodes(link)?.into_iter();
    Ok(nodes
        .map(|(address, _)| Target::J1939(Ca(address)))
        .collect())
}

fn target(address: &str) -> Result<Target, Error> {
    let address = super::protocol::number(&PROTOCOL, address)?;
    Ok(Target::J1939(Ca(address)))
}

fn roles(product: &Product) -> Option<Roles> {
    let tables = tables(product)?;
    let other = (canopen::PROTOCOL.roles)(product);
    Some(Roles {
        address: tables.address,
        target: |address| Ok(Target::J1939(Ca(address as u8))),
        rate: other.as_ref().and_then(|other| other.rate.clone()),
        identifiers: Vec::new(),
        shared: None,
        moves_at_once: false,
        storing: other.map_or(Storing::Unknown, |other| other.storing),
    })
}

impl Master for Ca {
    fn protocol(&self) -> &'static Protocol {
        &PROTOCOL
    }

    fn address(&self) -> String {
        self.0.to_string()
    }

    fn identify(&self, link: &mut Link, time: Duration) -> Result<Option<Found>, Error> {
        identify::ask(link, self.0, time)
    }

    fn read(&self, session: &mut Session, entry: &Entry) -> Result<Vec<u8>, Error> {
        canopen::read(session, self.server(), entry)
    }

    fn write(&self, session: &mut Session, entry: &Entry, bytes: &[u8]) -> Result<(), Error> {
        canopen::write(session, self.server(), entry, bytes)
    }

    fn save(&self, session: &mut Session) -> Result<Done, Error> {
        let server = self.must_have(session, RequestError::J1939Save)?;
        canopen::save(session, server)
    }

    fn loads_at_restart(&self, session: &Session) -> bool {
        canopen::loads_at_restart(session)
    }

    fn load(&self, session: &mut Session) -> Result<Done, Error> {
        let server = self.must_have(session, RequestError::J1939Load)?;
        canopen::load(session, server)
    }

    fn restart(&self, session: &mut Session) -> Result<(), Error> {
        self.restart_in(session)
    }

    fn program(&self, session: &mut Session) -> Result<Option<Program>, Error> {
        canopen::program(session, self.server())
    }

    fn diagnosis(
        &self,
        link: &mut Link,
        _product: &Product,
        number: u8,
    ) -> Result<Option<u32>, Error> {
        canopen::diagnosis(link, self.server(), number)
    }

    fn enter_bootloader(&self, session: &mut Session) -> Result<(), Error> {
        canopen::enter_bootloader(session, self.server())
    }

    fn bootloader(&self, link: &mut Link) -> Result<Option<Server>, Error> {
        let own = link.own_address()?;
        let id = |to, from| Identifier::new(PROPRIETARY_A, to, from).can_id();
        Ok(Some(Server::bootloader(id(self.0, own), id(own, self.0))))
    }

    fn identity(&self, session: &mut Session) -> Result<Values, Error> {
        identity::read(session, self.0)
    }

    fn stream(
        &self,
        session: &mut Session,
        _sampler: &mut Sampler,
        every: u32,
        _terminal: &mut Terminal,
    ) -> Result<Started, Error> {
        Ok(cyclic::Sender::new(self.0).start(session, every))
    }

    fn source(&self, _session: &mut Session, sampler: &Sampler) -> Result<Option<Source>, Error> {
        Ok(Some(cyclic::source(self.0, sampler.entries().len())))
    }

    fn poller(&self) -> Option<Box<dyn Poller>> {
        Some(Box::new(ssi2::Polled::new(self.0)))
    }

    fn raw(&self, link: &mut Link, request: &str) -> Result<Vec<u8>, Error> {
        raw::send(link, *self, request)
    }

    fn is_used(&self, link: &mut Link) -> Result<bool, Error> {
        // Each node has the same identifiers: they name sender and receiver.
        super::is_there(link, &[], |link| {
            Ok(j1939::name(link, self.0, j1939::ANSWER)?.is_some())
        })
    }
}
