//! The catalogue entry of a CANopen product.

use super::{Article, Guide, Product, Protocol, Settings, Start};
use crate::application::Application;
use crate::can::BitRate;
use crate::canopen::dictionary::Object;
use crate::canopen::emcy::FaultBit;
use crate::canopen::{self, Canopen, CanopenNode, LedTable};
use crate::j1939::diagnostics::Code;
use crate::j1939::signal::Group;
use crate::j1939::{self, DualNode, groups};
use crate::node::{Boot, Node};
use crate::param::{ParameterId, Table};
use crate::time::Instant;
use core::marker::PhantomData;

/// The tables of a product with the CANopen protocol.
#[derive(Clone, Copy, Debug)]
pub struct Tables {
    /// Its only article.
    pub article: Article,
    /// The object dictionary.
    pub objects: &'static [Object],
    /// The status byte in the manufacturer-specific field of emergency messages, from bit 0 on.
    pub faults: [FaultBit; 8],
    /// Momentary faults without a bit in the status byte.
    pub events: &'static [FaultBit],
    /// The LED patterns.
    pub leds: LedTable,
    /// The parameter with the node-ID.
    pub node_id: ParameterId,
    /// The parameter with the bit rate.
    pub bit_rate: ParameterId,
    /// The values of the bit rate parameter and their bit rates.
    pub bit_rates: &'static [(u32, BitRate)],
    /// Whether it supports layer setting services (CiA 305).
    pub lss: bool,
    /// The variants with other factory values.
    pub variants: &'static [Variant],
    /// The tables of J1939, the other protocol; None without it.
    pub j1939: Option<J1939Tables>,
}

/// A variant of a product that a parameter selects, with other factory values. The factory values of the table are those of the
/// variant without an entry in [`Tables::variants`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Variant {
    /// A short name, for example for the name of a file.
    pub name: &'static str,
    /// The parameter that selects the variant, and its value. It acts after a restart with stored parameters.
    pub selector: (ParameterId, u32),
    /// The read-only parameter that shows the variant in force, and its value.
    pub mark: (ParameterId, u32),
    /// The factory values of the parameters that follow the variant.
    pub defaults: &'static [(ParameterId, u32)],
}

/// The tables of a product that also has the J1939 protocol.
#[derive(Clone, Copy, Debug)]
pub struct J1939Tables {
    /// The parameter that selects the protocol, and its value for CANopen.
    pub selector: Option<(ParameterId, u32)>,
    /// The groups with process data.
    pub groups: &'static [Group],
    /// The parameters with their transmission rates.
    pub rates: [ParameterId; groups::COUNT],
    /// The parameters with their priorities.
    pub priorities: [ParameterId; groups::COUNT],
    /// The parameter with the preferred address.
    pub address: ParameterId,
    /// The parameters with the fields of the NAME.
    pub name: [ParameterId; 8],
    /// The diagnostic trouble codes.
    pub troubles: &'static [Code],
}

impl Tables {
    pub(super) fn article(&self, place: usize) -> Option<Article> {
        (place == 0).then_some(self.article)
    }
}

/// A catalogue entry: the tables of `P` with a single article, and its node `N`.
pub struct Listing<P: canopen::Product, N = CanopenNode<P>> {
    /// The short name.
    pub name: &'static str,
    maker: &'static str,
    article: Article,
    power_up: fn(Instant, &Boot) -> N,
    store_buffer: usize,
    j1939: Option<J1939Tables>,
    variants: &'static [Variant],
    guide: &'static Guide,
    product: PhantomData<P>,
}

impl<P: canopen::Product> Listing<P> {
    /// The catalogue entry of product `P`.
    pub const fn new(name: &'static str, maker: &'static str, article: Article) -> Self {
        Self {
            name,
            maker,
            article,
            power_up: CanopenNode::<P>::new,
            store_buffer: CanopenNode::<P>::STORE_BUFFER,
            j1939: None,
            variants: &[],
            guide: &Guide::NONE,
            product: PhantomData,
        }
    }
}

impl<P: j1939::Product> Listing<P, DualNode<P>> {
    /// The catalogue entry of product `P` with the protocols CANopen and J1939.
    /// `selector`: the parameter that selects the protocol at a restart, and its value for CANopen.
    pub const fn with_j1939(
        name: &'static str,
        maker: &'static str,
        article: Article,
        selector: (ParameterId, u32),
    ) -> Self {
        Self {
            name,
            maker,
            article,
            power_up: DualNode::<P>::new,
            store_buffer: DualNode::<P>::STORE_BUFFER,
            j1939: Some(J1939Tables {
                selector: Some(selector),
                groups: &groups::GROUPS,
                rates: P::RATES,
                priorities: P::PRIORITIES,
                address: P::ADDRESS,
                name: P::NAME,
                troubles: P::TROUBLES,
            }),
            variants: &[],
            guide: &Guide::NONE,
            product: PhantomData,
        }
    }
}

impl<P: canopen::Product, N: Node + 'static> Listing<P, N> {
    /// The same with these variants.
    pub const fn with_variants(self, variants: &'static [Variant]) -> Self {
        Self { variants, ..self }
    }

    /// The same with a guide for tools.
    pub const fn guided(self, guide: &'static Guide) -> Self {
        Self { guide, ..self }
    }

    /// The product as data.
    pub const fn product(&self) -> Product {
        Product {
            name: self.name,
            maker: self.maker,
            protocol: Protocol::Canopen(Tables {
                article: self.article,
                objects: P::OBJECTS,
                faults: P::FAULTS,
                events: P::EVENTS,
                leds: P::LEDS,
                node_id: P::NODE_ID,
                bit_rate: P::BIT_RATE,
                bit_rates: P::BIT_RATES,
                lss: Canopen::<P>::LSS,
                variants: self.variants,
                j1939: self.j1939,
            }),
            parameters: <P::Application as Application>::Table::PARAMETERS,
            constraints: <P::Application as Application>::Table::CONSTRAINTS,
            quantities: <P::Application as Application>::QUANTITIES,
            heater: <P::Application as Application>::HEATER,
            has_gyroscope: <P::Application as Application>::HAS_GYROSCOPE,
            image: P::IMAGE,
            layout: <P::Application as Application>::Table::LAYOUT,
            store_buffer: self.store_buffer,
            guide: self.guide,
        }
    }

    /// Starts a node; None if the settings select another article.
    pub fn start<S: Start>(&self, settings: &Settings, start: S) -> Option<S::Output> {
        if settings
            .article
            .is_some_and(|wanted| !self.article.is(wanted))
        {
            return None;
        }
        let node = (self.power_up)(settings.now, &settings.boot);
        Some(start.start(node))
    }
}
