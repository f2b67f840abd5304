//! DeviceNet.

use super::{Master, Protocol, Roles, Storing, Target};
use crate::client::devicenet::Slave;
use crate::client::{Link, sdo};
use crate::error::Error;
use crate::identify;
use plumbline::can::CanId;
use plumbline::devicenet::identifiers::group_2_id;
use plumbline::model::catalog::{self, Product};
use plumbline::model::listing::devicenet::Tables;

/// The protocol.
pub const PROTOCOL: Protocol = Protocol {
    name: "devicenet",
    option: "--mac",
    target,
    roles,
};

/// The tables of a product; None: it has another protocol.
pub fn tables(product: &Product) -> Option<&Tables> {
    match &product.protocol {
        catalog::Protocol::Devicenet(tables) => Some(tables),
        _ => None,
    }
}

fn target(mac: &str) -> Result<Target, Error> {
    let mac = super::number("--mac", mac, 0..=63, "a MAC ID is 0 to 63")?;
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

    fn named(&self) -> String {
        format!("MAC ID {}", self.mac)
    }

    fn is_used(&self, link: &mut Link) -> Result<bool, Error> {
        let mut messages = [CanId::standard(0); 8];
        for (message, id) in (0..).zip(&mut messages) {
            *id = CanId::standard(group_2_id(self.mac, message));
        }
        super::is_there(link, &messages, |link| {
            let answer = identify::ask(link, Target::Devicenet(*self), sdo::ANSWER)?;
            Ok(answer.is_some())
        })
    }
}
