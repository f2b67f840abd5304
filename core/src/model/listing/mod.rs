//! The data of a product for programs on a PC: names, tables and the start of a node.
//!
//! Each product has a constant `LISTING`. The [`catalog`](super::catalog) is the list of those in this crate; a program can use a
//! product of another crate in the same way.

pub mod canopen;
pub mod devicenet;
pub mod fsc;
mod guide;
pub mod j1939;
#[cfg(not(target_os = "none"))]
mod start;

#[cfg(not(target_os = "none"))]
pub use start::PowerUp;

pub use guide::{Adjustment, Guide, Offset, Resolution, Switch, Written};

use crate::application::Application;
use crate::heater;
use crate::mistake::Mistake;
use crate::node::{Boot, ProductNode};
use crate::param::{Constraint, Parameter, Quantity, Table};
use crate::store::{Buffer, ImageId, Owner};
use crate::time::Instant;
use crate::walk::each;
use core::any::TypeId;

/// The parameters of the product of node `N`.
type TableOf<N> = <<N as ProductNode>::Application as Application>::Table;

/// A product as data, for programs on a PC.
#[derive(Clone, Copy, Debug)]
pub struct Product {
    /// Its short name, for example `is2`: a to z, 0 to 9, `-` and `_`. It is used on command lines and is the name of the firmware image.
    pub name: &'static str,
    /// The manufacturer of the original sensor.
    pub maker: &'static str,
    /// The vendor of this sensor. It is a replacement of the original, unless the vendor is its manufacturer.
    pub vendor: &'static str,
    /// Its protocol, with the tables.
    pub protocol: Protocol,
    /// The parameters, in the order of their ids.
    pub parameters: &'static [Parameter],
    /// The constraints between the parameters.
    pub constraints: &'static [Constraint],
    /// The published quantities, in the order of their ids.
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
    /// Short names, units, zero point and teach-in for tools.
    pub guide: &'static Guide,
    /// The type of its node. Products with the same type differ by constants only.
    pub node: TypeId,
    /// Starts a node: see [`start`](Self::start).
    #[cfg(not(target_os = "none"))]
    pub power_up: PowerUp,
}

impl Product {
    /// A product with a description of its protocol only. It cannot be started.
    pub const fn described(name: &'static str, maker: &'static str, protocol: Protocol) -> Self {
        Self {
            name,
            maker,
            vendor: "Plumbline",
            protocol,
            parameters: &[],
            constraints: &[],
            quantities: &[],
            heater: None,
            has_gyroscope: false,
            image: ImageId::new(0x7FFF),
            layout: 0,
            store_buffer: 0,
            guide: &Guide::NONE,
            node: TypeId::of::<()>(),
            #[cfg(not(target_os = "none"))]
            power_up: |_, _| None,
        }
    }

    /// A product with node `N`, which is not started.
    #[track_caller]
    const fn of<N: ProductNode>(
        name: &'static str,
        maker: &'static str,
        protocol: Protocol,
        image: ImageId,
    ) -> Self {
        each!(letter in name.as_bytes() => {
            Mistake::item("name").unless(
                matches!(*letter, b'a'..=b'z' | b'0'..=b'9' | b'-' | b'_'),
                "a short name has the characters a to z, 0 to 9, `-` and `_`",
            );
        });
        Mistake::item("name").unless(!name.is_empty(), "the product has no short name");
        check_line("maker", maker);
        Self {
            parameters: TableOf::<N>::PARAMETERS,
            constraints: TableOf::<N>::CONSTRAINTS,
            quantities: N::Application::QUANTITIES,
            heater: N::Application::HEATER,
            has_gyroscope: N::Application::HAS_GYROSCOPE,
            image,
            layout: TableOf::<N>::LAYOUT,
            store_buffer: <TableOf<N> as Table>::Buffer::SIZE,
            node: TypeId::of::<N>(),
            ..Self::described(name, maker, protocol)
        }
    }

    /// Sets the guide for tools. An id in it that the tables do not have is a compile error.
    #[track_caller]
    pub const fn guided(self, guide: &'static Guide) -> Self {
        guide.check(self.parameters, self.quantities);
        Self { guide, ..self }
    }

    /// Sets the vendor. The vendor of an original sensor is its manufacturer.
    #[track_caller]
    pub const fn sold_by(self, vendor: &'static str) -> Self {
        check_line("vendor", vendor);
        Self { vendor, ..self }
    }

    /// Whether it replaces the sensor of another manufacturer.
    pub fn is_replacement(&self) -> bool {
        self.vendor != self.maker
    }

    /// Its articles. The first one is the default.
    pub fn articles(&self) -> impl Iterator<Item = Article> {
        (0..).map_while(|place| match &self.protocol {
            Protocol::Fsc(tables) => tables.article(place),
            Protocol::Canopen(tables) => tables.article(place),
            Protocol::Devicenet(tables) => tables.article(place),
            Protocol::J1939(tables) => tables.article(place),
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

/// Checks that a name fits into a line of a data sheet.
#[track_caller]
const fn check_line(item: &str, name: &str) {
    Mistake::item(item).unless(!name.is_empty(), "the name is empty");
    each!(letter in name.as_bytes() => {
        Mistake::item(item).unless(
            !letter.is_ascii_control(),
            "the name has a line break or another control character",
        );
    });
}

/// Checks the names of the only article of a product.
#[track_caller]
const fn check_article(article: &Article) {
    check_line("article, name", article.name);
    check_line("article, number", article.number);
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
    /// GEMAC's function select codes (FSC).
    Fsc(fsc::Tables),
    /// CANopen (CiA 301), also with J1939 as a second protocol.
    Canopen(canopen::Tables),
    /// DeviceNet, as a Group 2 Only server.
    Devicenet(devicenet::Tables),
    /// SAE J1939 without another protocol.
    J1939(j1939::Tables),
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
