//! The addresses of products as delivered.

use crate::client::devicenet::Slave;
use crate::client::fsc::Sensor;
use crate::session::Target;
use plumbline::can::{BitRate, CanId};
use plumbline::model::catalog::{PRODUCTS, Product, Protocol};
use plumbline::param::ParameterId;

/// The address of a product as delivered; None: a data sheet does not say it.
pub fn factory_target(product: &Product) -> Option<Target> {
    let factory = |id: ParameterId| {
        let parameter = product.parameters.get(usize::from(id.0))?;
        Some(parameter.factory)
    };
    Some(match &product.protocol {
        Protocol::Fsc(tables) => Target::Fsc(Sensor {
            request: CanId::from_bits(factory(tables.roles.set_id)?),
            reply: None,
        }),
        Protocol::Canopen(tables) => Target::Canopen(factory(tables.node_id)? as u8),
        Protocol::Devicenet(tables) => Target::Devicenet(Slave {
            mac: factory(tables.roles.mac_id)? as u8,
        }),
        Protocol::J1939(tables) => Target::J1939(factory(tables.j1939.address)? as u8),
    })
}

/// The bit rate of a CANopen product as delivered; None: a data sheet does not say it, or the product has another protocol.
pub fn factory_rate(product: &Product) -> Option<BitRate> {
    let Protocol::Canopen(tables) = &product.protocol else {
        return None;
    };
    let raw = product
        .parameters
        .get(usize::from(tables.bit_rate.0))?
        .factory;
    let mut rates = tables.bit_rates.iter();
    let (_, rate) = rates.find(|(code, _)| *code == raw)?;
    Some(*rate)
}

/// The addresses of all products as delivered, each once.
pub fn factory_targets() -> Vec<Target> {
    let mut targets = Vec::new();
    for target in PRODUCTS.iter().filter_map(factory_target) {
        if !targets.contains(&target) {
            targets.push(target);
        }
    }
    targets
}

/// The Set-Parameter-ID as delivered of the products whose Reply-Parameter-ID as delivered is this one.
pub fn factory_reply(reply: CanId) -> Option<CanId> {
    let mut products = PRODUCTS.iter();
    products.find_map(|product| {
        let Protocol::Fsc(tables) = &product.protocol else {
            return None;
        };
        let own = product
            .parameters
            .get(usize::from(tables.roles.reply_id.0))?;
        match factory_target(product) {
            Some(Target::Fsc(sensor)) if own.factory == reply.bits() => Some(sensor.request),
            _ => None,
        }
    })
}
