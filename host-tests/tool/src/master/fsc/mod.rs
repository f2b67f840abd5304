//! GEMAC function select codes.

mod angles;
pub mod boot_up;
mod decode;
mod identify;
mod raw;
pub mod request;
mod rows;
mod session;
mod signs;

use super::{Condition, Master, Program, Protocol, Roles, Storing, Target};
use crate::cyclic::{Source, Started};
use crate::error::{Error, RequestError, What};
use crate::identify::Found;
use crate::link::Link;
use crate::master::canopen::sdo::Server;
use crate::master::fsc::request::{self as fsc, Sensor};
use crate::number::identifier;
use crate::number::shown;
use crate::ops::identity::Values;
use crate::ops::report::Done;
use crate::output::Terminal;
use crate::sample::{Poller, Sampler};
use crate::session::Session;
use crate::session::unexpected;
use crate::sheet::Entry;
use angles::Angles;
use plumbline::application::Faults;
use plumbline::can::CanId;
use plumbline::diagnosis;
use plumbline::fsc::table::Operation;
use plumbline::fsc::{Condition as Bit, StatusBit};
use plumbline::model::catalog::{self, PRODUCTS, Product};
use plumbline::model::listing::fsc::Tables;
use plumbline::param::{ParameterId, number};
use plumbline::time::Duration;

/// The protocol.
pub const PROTOCOL: Protocol = Protocol {
    name: "fsc",
    option: "--id",
    help: "The Set-Parameter-ID of a GEMAC sensor, hexadecimal: 300, or 8 digits for 29 bits",
    value: "HEX",
    kind: "identifier",
    range: 0..=0,
    lacks: RequestError::NoIdentifier,
    command: None,
    target,
    roles,
    rows: rows::add,
    is_searched: false,
    announced_nodes: None,
    unaddressed: None,
    decoder: decode::decoder,
    check: None,
    data_sheet: None,
    signs: signs::SIGNS,
};

/// The tables of a product; None: it has another protocol.
pub fn tables(product: &Product) -> Option<&Tables> {
    match &product.protocol {
        catalog::Protocol::Fsc(tables) => Some(tables),
        _ => None,
    }
}

/// The sensor with this Set-Parameter-ID.
fn sensor(request: CanId) -> Target {
    Target::Fsc(Sensor {
        request,
        reply: None,
    })
}

fn target(id: &str) -> Result<Target, Error> {
    let bits = identifier(id).map_err(|why| RequestError::BadId(id.to_owned(), Box::new(why)))?;
    Ok(sensor(CanId::from_bits(bits)))
}

fn roles(product: &Product) -> Option<Roles> {
    let roles = &tables(product)?.roles;
    let rates = (0..).zip(roles.bit_rates.iter().copied());
    Some(Roles {
        rate: Some((roles.bit_rate, rates.collect())),
        address: roles.set_id,
        target: |bits| Ok(sensor(CanId::from_bits(bits))),
        identifiers: vec![roles.reply_id, roles.sync_id],
        shared: Some(roles.sync_id),
        moves_at_once: false,
        storing: Storing::Command,
    })
}

/// The number of a parameter as delivered.
fn factory(product: &Product, id: ParameterId) -> Option<u32> {
    let parameter = product.parameters.get(usize::from(id.0))?;
    Some(parameter.factory)
}

/// The Set-Parameter-ID as delivered of the products whose Reply-Parameter-ID as delivered is this one.
pub fn factory_reply(reply: CanId) -> Option<CanId> {
    PRODUCTS.iter().find_map(|product| {
        let roles = &tables(product)?.roles;
        let is_own = factory(product, roles.reply_id)? == reply.bits();
        is_own.then_some(CanId::from_bits(factory(product, roles.set_id)?))
    })
}

impl Master for Sensor {
    fn protocol(&self) -> &'static Protocol {
        &PROTOCOL
    }

    fn address(&self) -> String {
        shown(self.request).trim_end_matches('h').to_owned()
    }

    fn named(&self) -> String {
        format!("identifier {}h", self.address())
    }

    fn identifiers(&self) -> Vec<CanId> {
        vec![self.request]
    }

    fn is_reserved(&self) -> bool {
        boot_up::RESERVED.contains(&self.request)
    }

    fn reply(&self) -> Option<CanId> {
        self.reply
    }

    fn writes_together(&self) -> bool {
        true
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

    fn write_values(&self, session: &mut Session, values: &[(Entry, u32)]) -> Result<(), Error> {
        self.write_together(session, values)
    }

    fn serial(&self, session: &mut Session) -> Result<Option<u32>, Error> {
        self.serial_in(session)
    }

    fn save(&self, session: &mut Session) -> Result<Done, Error> {
        self.signed(session, Operation::Save)?;
        Ok(Done::Stored)
    }

    fn load(&self, session: &mut Session) -> Result<Done, Error> {
        self.signed(session, Operation::Load)?;
        Ok(Done::FactoryStored)
    }

    fn restart(&self, session: &mut Session) -> Result<(), Error> {
        self.restart_in(session)
    }

    fn conditions(&self, product: &Product, status: u8) -> Vec<Condition> {
        let bits = tables(product).map_or(&[][..], |tables| &tables.status);
        let active = bits.iter().enumerate();
        let active = active.filter(|(place, bit)| status >> place & 1 != 0 && !bit.name.is_empty());
        let condition = |(_, bit): (_, &StatusBit)| Condition {
            name: bit.name,
            is_error: !matches!(
                bit.condition,
                Bit::Never | Bit::DefaultParam | Bit::AutobaudDetection
            ),
            spoils_angle: matches!(bit.condition, Bit::Fault(Faults::X | Faults::Y)),
        };
        active.map(condition).collect()
    }

    fn program(&self, session: &mut Session) -> Result<Option<Program>, Error> {
        self.program_in(session)
    }

    fn diagnosis(
        &self,
        link: &mut Link,
        product: &Product,
        value: u8,
    ) -> Result<Option<u32>, Error> {
        let reply = fsc::ask(link, *self, diagnosis::CODE, &[value], fsc::ANSWER)?;
        let data = reply.map(|reply| reply.data).unwrap_or_default();
        if let [own, ref bytes @ ..] = data[..]
            && own == value
            && bytes.len() == 4
        {
            return Ok(Some(number(bytes)));
        }
        // The refusal stays in the status until it is read.
        if let Some(tables) = tables(product) {
            fsc::earlier(link, *self, tables)?;
        }
        Ok(None)
    }

    fn enter_bootloader(&self, session: &mut Session) -> Result<(), Error> {
        self.enter_bootloader_in(session)
    }

    fn waits(&self, link: &mut Link, time: Duration) -> Result<bool, Error> {
        let reply = session::bootloader_reply_within(link, self.request, time)?;
        Ok(reply.is_some())
    }

    fn bootloader(&self, link: &mut Link) -> Result<Option<Server>, Error> {
        let reply = match self.reply {
            None => session::bootloader_reply(link, self.request)?,
            reply => reply,
        };
        Ok(reply.map(|reply| Server::bootloader(self.request, reply)))
    }

    fn identity(&self, session: &mut Session) -> Result<Values, Error> {
        self.read_identity(session)
    }

    fn stream(
        &self,
        session: &mut Session,
        sampler: &mut Sampler,
        every: u32,
        _terminal: &mut Terminal,
    ) -> Result<Started, Error> {
        let angles = Angles::of(*self, sampler.entries());
        let angles = angles.ok_or_else(|| unexpected(What::TheAngles))?;
        angles.start(session, every)
    }

    fn source(&self, _session: &mut Session, sampler: &Sampler) -> Result<Option<Source>, Error> {
        Ok(Angles::of(*self, sampler.entries()).map(Angles::source))
    }

    fn poller(&self) -> Option<Box<dyn Poller>> {
        Some(Box::new(angles::Polled(*self)))
    }

    fn raw(&self, link: &mut Link, request: &str) -> Result<Vec<u8>, Error> {
        raw::send(link, *self, request)
    }
}
