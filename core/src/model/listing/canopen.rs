//! The catalogue entry of a CANopen product.

use super::{Article, Guide, Product, Protocol, Settings, Start};
use crate::application::Application;
use crate::can::BitRate;
use crate::canopen::dictionary::Object;
use crate::canopen::emcy::FaultBit;
use crate::canopen::{self, Canopen, CanopenNode, LedTable, Variant};
use crate::param::{ParameterId, Table};
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
    pub bit_rates: &'static [(u16, BitRate)],
    /// The bit rate parameter has these values times this number.
    pub bit_rate_unit: u32,
    /// Whether it supports layer setting services (CiA 305).
    pub lss: bool,
    /// The variants with other factory values.
    pub variants: &'static [Variant],
}

impl Tables {
    pub(super) fn article(&self, place: usize) -> Option<Article> {
        (place == 0).then_some(self.article)
    }
}

/// A catalogue entry: the tables of `P` with a single article.
pub struct Listing<P> {
    /// The short name.
    pub name: &'static str,
    maker: &'static str,
    article: Article,
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
            guide: &Guide::NONE,
            product: PhantomData,
        }
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
                bit_rate_unit: P::BIT_RATE_UNIT,
                lss: Canopen::<P>::LSS,
                variants: P::VARIANTS,
            }),
            parameters: <P::Application as Application>::Table::PARAMETERS,
            constraints: <P::Application as Application>::Table::CONSTRAINTS,
            quantities: <P::Application as Application>::QUANTITIES,
            heater: <P::Application as Application>::HEATER,
            image: P::IMAGE,
            layout: <P::Application as Application>::Table::LAYOUT,
            store_buffer: CanopenNode::<P>::STORE_BUFFER,
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
        let node = CanopenNode::<P>::new(settings.now, &settings.boot);
        Some(start.start(node))
    }
}
