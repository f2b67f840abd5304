//! What a program on a PC knows of a product: its names, its tables as data, and how a node of it is started.
//!
//! Each product has a constant `LISTING`; the [`catalog`](super::catalog) is the list of them.

pub mod canopen;
pub mod fsc;

use crate::heater;
use crate::node::{Boot, Node};
use crate::param::{Constraint, Parameter, Quantity};
use crate::store::{ImageId, Owner};
use crate::time::Instant;

/// A product, as data.
#[derive(Clone, Copy, Debug)]
pub struct Product {
    /// Its short name, for example `is2`: on command lines, and of its firmware image.
    pub name: &'static str,
    /// Who makes the sensor that it is compatible with.
    pub maker: &'static str,
    /// What it speaks, with the tables.
    pub protocol: Protocol,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// What they must fulfil together.
    pub constraints: &'static [Constraint],
    /// The values that it publishes.
    pub quantities: &'static [Quantity],
    /// The heater of its measuring cell, if it has one.
    pub heater: Option<&'static heater::Settings>,
    /// Marks its stored parameters.
    pub image: ImageId,
    /// The version of their layout.
    pub layout: u8,
    /// The size of the buffer that a [`Store`](crate::store::Store) for it needs.
    pub store_buffer: usize,
}

impl Product {
    /// Its articles. The first one is started when none is asked for.
    pub fn articles(&self) -> impl Iterator<Item = Article> {
        (0..).map_while(|place| match &self.protocol {
            Protocol::Fsc(tables) => tables.article(place),
            Protocol::Canopen(tables) => tables.article(place),
        })
    }

    /// Whose records the store of a unit with this serial number holds.
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
    /// Whether it is meant by this type name or order number.
    pub fn is(&self, wanted: &str) -> bool {
        [self.name, self.number].contains(&wanted)
    }
}

/// What a product speaks, with its tables.
#[derive(Clone, Copy, Debug)]
pub enum Protocol {
    /// GEMAC's function select codes.
    Fsc(fsc::Tables),
    /// CANopen.
    Canopen(canopen::Tables),
}

/// What a node is started with.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'a> {
    /// The type name or order number of the article; None: the first one.
    pub article: Option<&'a str>,
    /// The time of the start.
    pub now: Instant,
    /// What the memory held.
    pub boot: Boot<'a>,
}

impl Default for Settings<'_> {
    /// The first article with a blank memory, at the beginning of time.
    fn default() -> Self {
        Self {
            article: None,
            now: Instant::from_ticks(0),
            boot: Boot::default(),
        }
    }
}

/// Takes a node that was started, whatever its type.
pub trait Start {
    /// What becomes of it.
    type Output;

    /// Takes the node over.
    fn start<N: Node + 'static>(self, node: N) -> Self::Output;
}
