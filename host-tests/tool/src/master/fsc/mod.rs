//! GEMAC function select codes.

use super::{Master, Protocol, Roles, Storing, Target};
use crate::client::fsc::{Sensor, shown};
use crate::error::Error;
use crate::number::identifier;
use plumbline::can::CanId;
use plumbline::model::catalog::{self, PRODUCTS, Product};
use plumbline::model::listing::fsc::Tables;

/// The protocol.
pub const PROTOCOL: Protocol = Protocol {
    name: "fsc",
    option: "--id",
    target,
    roles,
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
    let bits =
        identifier(id).map_err(|text| Error::usage("bad-value", format!("--id {id}: {text}")))?;
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
        moves_at_once: false,
        storing: Storing::Command,
    })
}

/// The Set-Parameter-ID as delivered of the products whose Reply-Parameter-ID as delivered is this one.
pub fn factory_reply(reply: CanId) -> Option<CanId> {
    let factory = |product: &Product, id: plumbline::param::ParameterId| {
        let parameter = product.parameters.get(usize::from(id.0))?;
        Some(parameter.factory)
    };
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
}
