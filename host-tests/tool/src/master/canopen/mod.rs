//! CANopen.

pub(crate) mod cob_ids;
mod cyclic;
pub(super) mod decode;
mod defect;
pub mod eds;
pub(crate) mod error_register;
pub(crate) mod fit;
pub(crate) mod identify;
mod identity;
pub mod lss;
pub mod nmt;
pub(super) mod raw;
mod rows;
pub mod sdo;
mod session;
mod signs;

pub(super) use session::{
    commands, diagnosis, enter_bootloader, is_stopped, load, loads_at_restart, object, own,
    program, read, save, write,
};

use super::{AddressCommand, Master, Program, Protocol, Roles, Storing, Target};
use crate::cyclic::{Source, Started};
use crate::error::{Error, RequestError};
use crate::identify::Found;
use crate::link::Link;
use crate::master::canopen::sdo::{Answer, Server};
use crate::ops::address::change;
use crate::ops::identity::Values;
use crate::ops::report::Done;
use crate::output::Terminal;
use crate::sample::Sampler;
use crate::session::Session;
use crate::sheet::Entry;
use nmt::State;
use plumbline::can::{BitRate, CanId};
use plumbline::canopen::cob_id::{EMCY, ERROR_CONTROL, SDO_REPLY, SDO_REQUEST};
use plumbline::canopen::dictionary::Service;
use plumbline::canopen::lss::UNCONFIGURED;
use plumbline::model::catalog::{self, Product};
use plumbline::model::listing::canopen::Tables;
use plumbline::time::Duration;

/// The protocol.
pub const PROTOCOL: Protocol = Protocol {
    name: "canopen",
    option: "--node",
    help: "The node-ID of a CANopen sensor",
    value: "N",
    kind: "node-ID",
    range: 1..=127,
    lacks: RequestError::NoNodeId,
    command: Some(AddressCommand {
        name: "node-id",
        help: "Change the node-ID of a CANopen sensor: writes, stores, restarts, checks",
        number: "The new node-ID, 1 to 127",
        shows: false,
        perform: |session, new| change(session, &PROTOCOL, new),
    }),
    target,
    roles,
    rows: rows::add,
    is_searched: true,
    announced_nodes: None,
    unaddressed: Some(lss::unaddressed),
    decoder: decode::decoder,
    check: None,
    data_sheet: Some(eds::FORMAT),
    signs: signs::SIGNS,
};

/// The objects of CiA 302-3: program control, and the CRC of the program. The hardware of the program is not of CiA 302-3.
pub(crate) const CONTROL: (u16, u8) = (0x1F51, 1);
pub(crate) const PROGRAM: (u16, u8) = (0x1F56, 1);
const HARDWARE: (u16, u8) = (0x1F56, 2);

/// A node, with its node-ID.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Node(pub u8);

/// The tables of a product; None: it has another protocol.
pub fn tables(product: &Product) -> Option<&Tables> {
    match &product.protocol {
        catalog::Protocol::Canopen(tables) => Some(tables),
        _ => None,
    }
}

fn target(node: &str) -> Result<Target, Error> {
    let node = super::protocol::number(&PROTOCOL, node)?;
    Ok(Target::Canopen(Node(node)))
}

fn roles(product: &Product) -> Option<Roles> {
    let tables = tables(product)?;
    // A foreign device can have no command to store.
    let stores = tables.objects.iter().any(|object| {
        let service = object.service();
        matches!(service, Some(Service::Store | Service::StoreGroup))
    });
    let rates = tables.bit_rates.iter();
    let rates = rates.map(|(code, rate)| (*code, Some(*rate)));
    Some(Roles {
        rate: Some((tables.bit_rate, rates.collect())),
        address: tables.node_id,
        target: at,
        identifiers: Vec::new(),
        shared: None,
        moves_at_once: false,
        storing: match stores {
            true => Storing::Command,
            false => Storing::Unknown,
        },
    })
}

/// The node with this number in the parameter of the node-ID.
fn at(node: u32) -> Result<Target, Error> {
    if node == u32::from(UNCONFIGURED) {
        return Err(RequestError::NodeId255.into());
    }
    Ok(Target::Canopen(Node(node as u8)))
}

impl Master for Node {
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
        read(session, self.server(), entry)
    }

    fn write(&self, session: &mut Session, entry: &Entry, bytes: &[u8]) -> Result<(), Error> {
        write(session, self.server(), entry, bytes)
    }

    fn serial(&self, session: &mut Session) -> Result<Option<u32>, Error> {
        self.serial_in(session)
    }

    fn save(&self, session: &mut Session) -> Result<Done, Error> {
        save(session, self.server())
    }

    fn loads_at_restart(&self, session: &Session) -> bool {
        loads_at_restart(session)
    }

    fn load(&self, session: &mut Session) -> Result<Done, Error> {
        load(session, self.server())
    }

    fn restart(&self, session: &mut Session) -> Result<(), Error> {
        self.restart_in(session)
    }

    fn program(&self, session: &mut Session) -> Result<Option<Program>, Error> {
        program(session, self.server())
    }

    fn diagnosis(
        &self,
        link: &mut Link,
        _product: &Product,
        number: u8,
    ) -> Result<Option<u32>, Error> {
        diagnosis(link, self.server(), number)
    }

    fn enter_bootloader(&self, session: &mut Session) -> Result<(), Error> {
        enter_bootloader(session, self.server())
    }

    fn is_bootloader(&self, link: &mut Link) -> Result<bool, Error> {
        is_stopped(link, self.server())
    }

    fn bootloader(&self, _link: &mut Link) -> Result<Option<Server>, Error> {
        let id = |base| CanId::standard(base + u16::from(self.0));
        Ok(Some(Server::bootloader(id(SDO_REQUEST), id(SDO_REPLY))))
    }

    fn identity(&self, session: &mut Session) -> Result<Values, Error> {
        identity::read(session, self.server())
    }

    fn stream(
        &self,
        session: &mut Session,
        sampler: &mut Sampler,
        every: u32,
        terminal: &mut Terminal,
    ) -> Result<Started, Error> {
        cyclic::start(session, self.0, sampler, every, terminal)
    }

    fn source(&self, session: &mut Session, sampler: &Sampler) -> Result<Option<Source>, Error> {
        cyclic::source(session, self.0, sampler)
    }

    fn raw(&self, link: &mut Link, request: &str) -> Result<Vec<u8>, Error> {
        raw::send(link, self.server(), request)
    }

    fn store_rate(&self, session: &mut Session, rate: BitRate) -> Result<bool, Error> {
        self.store_by_lss(session, rate)
    }

    fn reports_defect(&self, session: &mut Session) -> Result<bool, Error> {
        self.reports_defect_in(session)
    }

    fn identifiers(&self) -> Vec<CanId> {
        let ids = [SDO_REQUEST, SDO_REPLY];
        ids.map(|base| CanId::standard(base + u16::from(self.0)))
            .to_vec()
    }

    fn node_id(&self) -> Option<u8> {
        Some(self.0)
    }

    fn suspend(&self, link: &mut Link) -> Result<bool, Error> {
        // Only a node that was Operational is started again.
        let is_operational = nmt::state(link, self.0)? == Some(State::Operational);
        if is_operational {
            nmt::send(link, nmt::ENTER_PRE_OPERATIONAL, self.0)?;
        }
        Ok(is_operational)
    }

    fn resume(&self, link: &mut Link) -> Result<(), Error> {
        nmt::send(link, nmt::START, self.0)
    }

    fn is_used(&self, link: &mut Link) -> Result<bool, Error> {
        let messages = [ERROR_CONTROL, SDO_REPLY, EMCY];
        let messages = messages.map(|base| CanId::standard(base + u16::from(self.0)));
        super::is_there(link, &messages, |link| {
            Ok(self.server().read(link, 0x1000, 0)? != Answer::Silent)
        })
    }
}
