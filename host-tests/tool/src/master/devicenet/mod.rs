//! DeviceNet.

mod connection;
mod cyclic;
mod decode;
mod eds;
pub mod explicit;
mod identify;
mod identity;
mod rows;
mod signs;

pub(crate) use connection::Connection;

use super::{AddressCommand, Master, Program, Protocol, Roles, Storing, Target};
use crate::cyclic::Started;
use crate::error::{Error, RequestError, What};
use crate::identify::Found;
use crate::link::Link;
use crate::master::canopen::{
    self,
    sdo::{self, Server},
};
use crate::master::devicenet::explicit::{Path, Response, Slave};
use crate::ops::address::change;
use crate::ops::identity::Values;
use crate::ops::raw::{bad, bytes};
use crate::ops::report::Done;
use crate::output::Terminal;
use crate::sample::Sampler;
use crate::scan::listen::Frames;
use crate::session::Session;
use crate::session::unexpected;
use crate::sheet::Entry;
use plumbline::can::{CanId, Frame};
use plumbline::devicenet::identifiers::{group_2, group_2_id};
use plumbline::devicenet::service;
use plumbline::diagnosis;
use plumbline::model::catalog::{self, Product};
use plumbline::model::listing::devicenet::Tables;
use plumbline::param::number;
use plumbline::time::{Duration, millis};

/// The protocol.
pub const PROTOCOL: Protocol = Protocol {
    name: "devicenet",
    option: "--mac",
    help: "The MAC ID of a DeviceNet sensor",
    value: "N",
    kind: "MAC ID",
    range: 0..=63,
    lacks: RequestError::NoMacId,
    command: Some(AddressCommand {
        name: "mac",
        help: "Change the MAC ID of a DeviceNet sensor and check it",
        number: "The new MAC ID, 0 to 63",
        shows: false,
        perform: |session, new| change(session, &PROTOCOL, new),
    }),
    target,
    roles,
    rows: rows::add,
    is_searched: true,
    announced_nodes: None,
    unaddressed: None,
    decoder: decode::decoder,
    check: Some(millis(2500)),
    data_sheet: Some(eds::FORMAT),
    signs: signs::SIGNS,
};

/// How long a node is asked that has just been heard: it answers after its duplicate MAC ID check of two seconds.
const CHECK: Duration = millis(3000);

/// The tables of a product; None: it has another protocol.
pub fn tables(product: &Product) -> Option<&Tables> {
    match &product.protocol {
        catalog::Protocol::Devicenet(tables) => Some(tables),
        _ => None,
    }
}

fn target(mac: &str) -> Result<Target, Error> {
    let mac = super::protocol::number(&PROTOCOL, mac)?;
    Ok(Target::Devicenet(Slave { mac }))
}

fn roles(product: &Product) -> Option<Roles> {
    let roles = &tables(product)?.roles;
    let rates = (0..).zip(roles.bit_rates.iter().copied().map(Some));
    Some(Roles {
        rate: Some((roles.baud_rate, rates.collect())),
        address: roles.mac_id,
        target: |mac| Ok(Target::Devicenet(Slave { mac: mac as u8 })),
        identifiers: Vec::new(),
        shared: None,
        moves_at_once: true,
        storing: Storing::Itself,
    })
}

impl Master for Slave {
    fn protocol(&self) -> &'static Protocol {
        &PROTOCOL
    }

    fn address(&self) -> String {
        self.mac.to_string()
    }

    fn identify(&self, link: &mut Link, time: Duration) -> Result<Option<Found>, Error> {
        identify::ask(link, *self, time)
    }

    fn read(&self, session: &mut Session, entry: &Entry) -> Result<Vec<u8>, Error> {
        self.read_in(session, entry)
    }

    fn write(&self, session: &mut Session, entry: &Entry, bytes: &[u8]) -> Result<(), Error> {
        self.write_in(session, entry, bytes)
    }

    fn can_be_owned(&self) -> bool {
        true
    }

    fn owned(&self, frames: &Frames) -> Option<Found> {
        let ids = self.io();
        let is_own = |frame: &Frame| ids.contains(&frame.can_id()) && !frame.is_remote();
        let mut frames = frames.iter();
        let sends = frames.any(|(_, frame)| is_own(frame));
        sends.then(|| identify::owned(*self))
    }

    fn is_connected(&self, session: &mut Session) -> Result<bool, Error> {
        let is_checked = session.expected.is_some();
        if is_checked {
            self.freshen(session)?;
        }
        Ok(is_checked)
    }

    fn save(&self, _session: &mut Session) -> Result<Done, Error> {
        Ok(Done::StoresItself)
    }

    fn load(&self, session: &mut Session) -> Result<Done, Error> {
        self.reset(session, 1)?;
        Ok(Done::FactoryRestarts)
    }

    fn restart(&self, session: &mut Session) -> Result<(), Error> {
        self.reset(session, 0)
    }

    fn program(&self, session: &mut Session) -> Result<Option<Program>, Error> {
        self.program_in(session)
    }

    fn diagnosis(
        &self,
        link: &mut Link,
        _product: &Product,
        value: u8,
    ) -> Result<Option<u32>, Error> {
        self.allocate(link)?;
        let path = Path {
            class: diagnosis::CLASS,
            instance: 1,
        };
        let response = self.explicit(link, service::GET, path, &[value]);
        Slave::release(*self, link)?;
        Ok(match response? {
            Response::Done(bytes) => (bytes.len() == 4).then(|| number(&bytes)),
            Response::Refused(..) | Response::Silent => None,
        })
    }

    fn enter_bootloader(&self, session: &mut Session) -> Result<(), Error> {
        self.enter_bootloader_in(session)
    }

    fn waits(&self, link: &mut Link, time: Duration) -> Result<bool, Error> {
        let Some(server) = self.bootloader(link)? else {
            return Ok(false);
        };
        canopen::is_stopped(link, Server { time, ..server })
    }

    fn bootloader(&self, _link: &mut Link) -> Result<Option<Server>, Error> {
        let id = |message| CanId::standard(group_2_id(self.mac, message));
        Ok(Some(Server::bootloader(
            id(group_2::REQUEST),
            id(group_2::RESPONSE),
        )))
    }

    fn identity(&self, session: &mut Session) -> Result<Values, Error> {
        identity::read(session, *self)
    }

    fn reports_defect(&self, session: &mut Session) -> Result<bool, Error> {
        self.reports_defect_in(session)
    }

    fn stream(
        &self,
        session: &mut Session,
        sampler: &mut Sampler,
        every: u32,
        terminal: &mut Terminal,
    ) -> Result<Started, Error> {
        let tables = tables(session.sheet.product).ok_or_else(|| unexpected(What::Assembly))?;
        cyclic::start(session, (*self, tables), sampler, every, terminal)
    }

    fn raw(&self, link: &mut Link, request: &str) -> Result<Vec<u8>, Error> {
        let bytes = bytes(request)?;
        let [service, class, instance, ref data @ ..] = bytes[..] else {
            return Err(bad(request));
        };
        self.allocate(link)?;
        let path = Path { class, instance };
        let response = self.explicit(link, service, path, data);
        link.end();
        Slave::release(*self, link)?;
        response?.must(self.mac, What::Request)
    }

    fn release(&self, session: &mut Session) -> Result<(), Error> {
        match std::mem::take(&mut session.connection.is_allocated) {
            true => Slave::release(*self, &mut session.link),
            false => Ok(()),
        }
    }

    fn identifiers(&self) -> Vec<CanId> {
        // Also the messages of a master that owns it.
        let messages = [
            group_2::REQUEST,
            group_2::UNCONNECTED,
            group_2::RESPONSE,
            group_2::POLL,
            group_2::ACKNOWLEDGE,
        ];
        let ids = messages.map(|message| CanId::standard(group_2_id(self.mac, message)));
        ids.to_vec()
    }

    fn patience(&self) -> Duration {
        CHECK
    }

    fn is_used(&self, link: &mut Link) -> Result<bool, Error> {
        let mut messages = [CanId::standard(0); 8];
        for (message, id) in (0..).zip(&mut messages) {
            *id = CanId::standard(group_2_id(self.mac, message));
        }
        super::is_there(link, &messages, |link| {
            let answer = crate::identify::ask(link, Target::Devicenet(*self), sdo::ANSWER)?;
            Ok(answer.is_some())
        })
    }
}
