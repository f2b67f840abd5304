//! The data of a product for programs on a PC: names, tables and the start of a node.
//!
//! Each product has a constant `LISTING`. The [`catalog`](super::catalog) is the list of these constants.

pub mod canopen;
pub mod devicenet;
pub mod fsc;
mod guide;

pub use guide::{Adjustment, Guide, Resolution, Written};

use crate::heater;
use crate::node::{Boot, Node};
use crate::param::{Constraint, Parameter, Quantity};
use crate::store::{ImageId, Owner};
use crate::time::Instant;

/// A product, as data.
#[derive(Clone, Copy, Debug)]
pub struct Product {
    /// Its short name, for example `is2`. It is used on command lines and is the name of the firmware image.
    pub name: &'static str,
    /// The manufacturer of the original sensor.
    pub maker: &'static str,
    /// Its protocol, with the tables.
    pub protocol: Protocol,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// The constraints between the parameters.
    pub constraints: &'static [Constraint],
    /// The published values.
    pub quantities: &'static [Quantity],
    /// The heater of its measuring cell, if it has one.
    pub heater: Option<&'static heater::Settings>,
    /// Whether it has a gyroscope.
    pub has_gyroscope: bool,
    /// The identification of its stored parameters.
    pub image: ImageId,
    /// The version of the layout of the stored parameters.
    pub layout: u8,
    /// The size, in bytes, of the buffer of a [`Store`](crate::store::Store) for it.
    pub store_buffer: usize,
    /// A guide for tools.
    pub guide: &'static Guide,
}

impl Product {
    /// Its articles. The first one is the default.
    pub fn articles(&self) -> impl Iterator<Item = Article> {
        (0..).map_while(|place| match &self.protocol {
            Protocol::Fsc(tables) => tables.article(place),
            Protocol::Canopen(tables) => tables.article(place),
            Protocol::Devicenet(tables) => tables.article(place),
        })
    }

    /// The owner of the records in the store of a device with this serial number.
    pub const fn owner(&self, serial: u32) -> Owner {
        Owner {
            image: self.image,
            layout: self.layout,
            serial,
        }
    }
}

/// An article of a product.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Article {
    /// The type name, for example `IS2BP090-C-CL`.
    pub name: &'static str,
    /// The order number, for example `PR-23054-30`.
    pub number: &'static str,
}

impl Article {
    /// Whether `wanted` is its type name or order number, without regard to case.
    pub fn is(&self, wanted: &str) -> bool {
        let names = [self.name, self.number];
        names.iter().any(|name| name.eq_ignore_ascii_case(wanted))
    }
}

/// The protocol of a product, with its tables.
#[derive(Clone, Copy, Debug)]
pub enum Protocol {
    /// GEMAC function select codes.
    Fsc(fsc::Tables),
    /// CANopen.
    Canopen(canopen::Tables),
    /// DeviceNet.
    Devicenet(devicenet::Tables),
}

/// The settings for the start of a node.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'a> {
    /// The type name or order number of the article; None: the first one.
    pub article: Option<&'a str>,
    /// The time of the start.
    pub now: Instant,
    /// The contents of the memory.
    pub boot: Boot<'a>,
}

impl Default for Settings<'_> {
    /// The first article with a blank memory at time 0.
    fn default() -> Self {
        Self {
            article: None,
            now: Instant::from_ticks(0),
            boot: Boot::default(),
        }
    }
}

/// A function that takes a started node of any type.
pub trait Start {
    /// The result of the function.
    type Output;

    /// Takes the started node.
    fn start<N: Node + 'static>(self, node: N) -> Self::Output;
}
