//! CANopen.

use super::{Master, Protocol, Roles, Storing, Target};
use crate::client::Link;
use crate::client::sdo::{Answer, Server};
use crate::error::Error;
use plumbline::can::CanId;
use plumbline::canopen::cob_id::{EMCY, ERROR_CONTROL, SDO_REPLY};
use plumbline::canopen::dictionary::Service;
use plumbline::canopen::lss::UNCONFIGURED;
use plumbline::model::catalog::{self, Product};
use plumbline::model::listing::canopen::Tables;

/// The protocol.
pub const PROTOCOL: Protocol = Protocol {
    name: "canopen",
    option: "--node",
    target,
    roles,
};

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
    let node = super::number("--node", node, 1..=127, "a node-ID is 1 to 127")?;
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
        let message = "the node-ID is 255 after the restart, so the tool cannot read from the sensor: give it one with `plumbline node-id`";
        return Err(Error::usage("no-address", message));
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

    fn named(&self) -> String {
        format!("node-ID {}", self.0)
    }

    fn server(&self) -> Option<Server> {
        Some(Server::of(self.0))
    }

    fn is_used(&self, link: &mut Link) -> Result<bool, Error> {
        let messages = [ERROR_CONTROL, SDO_REPLY, EMCY];
        let messages = messages.map(|base| CanId::standard(base + u16::from(self.0)));
        super::is_there(link, &messages, |link| {
            Ok(Server::of(self.0).read(link, 0x1000, 0)? != Answer::Silent)
        })
    }
}
