//! The catalogue entry of a CANopen product.

use super::j1939::J1939Tables;
use super::{Article, Product, Protocol, check_article};
use crate::can::BitRate;
use crate::canopen::dictionary::Object;
use crate::canopen::emcy::FaultBit;
use crate::canopen::{self, Canopen, CanopenNode, LedTable};
use crate::mistake::Mistake;
use crate::model::dual::{Both, DualNode};
use crate::param::ParameterId;
use crate::walk::each;

/// The tables of a product with the CANopen protocol.
#[derive(Clone, Copy, Debug)]
pub struct Tables {
    /// The only article of the product.
    pub article: Article,
    /// The object dictionary, sorted by index and sub-index.
    pub objects: &'static [Object],
    /// The status byte in the manufacturer-specific field of emergency messages, from bit 0 on.
    pub faults: [FaultBit; 8],
    /// Momentary faults without a bit in the status byte.
    pub events: &'static [FaultBit],
    /// The LED patterns in each NMT state.
    pub leds: LedTable,
    /// The parameter that contains the node-ID.
    pub node_id: ParameterId,
    /// The parameter that contains the bit rate, as one of `bit_rates`.
    pub bit_rate: ParameterId,
    /// The values of the bit rate parameter and their bit rates.
    pub bit_rates: &'static [(u32, BitRate)],
    /// Whether it supports layer setting services (CiA 305).
    pub lss: bool,
    /// The status bits of a defective measuring element; None: only the errors (1001h, 1003h) show it.
    pub defect: Option<Defect>,
    /// The variants with other factory values.
    pub variants: &'static [Variant],
    /// The tables of J1939, the other protocol; None without it.
    pub j1939: Option<J1939Tables>,
}

/// Bits of an object, of which at least one is set while the measuring element is defective.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Defect {
    /// The index of the object.
    pub index: u16,
    /// Its sub-index.
    pub sub: u8,
    /// The bits.
    pub bits: u32,
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

impl Tables {
    const fn of<P: canopen::Product>(article: Article, j1939: Option<J1939Tables>) -> Self {
        Self {
            article,
            objects: P::OBJECTS,
            faults: P::FAULTS,
            events: P::EVENTS,
            leds: P::LEDS,
            node_id: P::NODE_ID,
            bit_rate: P::BIT_RATE,
            bit_rates: P::BIT_RATES,
            lss: Canopen::<P>::LSS,
            defect: None,
            variants: &[],
            j1939,
        }
    }

    pub(super) fn article(&self, place: usize) -> Option<Article> {
        (place == 0).then_some(self.article)
    }
}

impl Product {
    /// The product `P` with a single article, compatible with that of this maker.
    #[track_caller]
    pub const fn canopen<P: canopen::Product>(
        name: &'static str,
        maker: &'static str,
        article: Article,
    ) -> Self {
        check_article(&article);
        let protocol = Protocol::Canopen(Tables::of::<P>(article, None));
        Self {
            #[cfg(not(target_os = "none"))]
            power_up: super::start::sole::<CanopenNode<P>>,
            ..Self::of::<CanopenNode<P>>(name, maker, protocol, P::IMAGE)
        }
    }

    /// The product `P` with the protocols CANopen and J1939.
    ///
    /// `selector`: the parameter that selects the protocol at a restart, and its value for CANopen.
    #[track_caller]
    pub const fn with_j1939<P: Both>(
        name: &'static str,
        maker: &'static str,
        article: Article,
        selector: (ParameterId, u32),
    ) -> Self {
        check_article(&article);
        let j1939 = J1939Tables::of::<P>(Some(selector));
        let protocol = Protocol::Canopen(Tables::of::<P>(article, Some(j1939)));
        let image = <P as canopen::Product>::IMAGE;
        Self {
            #[cfg(not(target_os = "none"))]
            power_up: super::start::sole::<DualNode<P>>,
            ..Self::of::<DualNode<P>>(name, maker, protocol, image)
        }
    }

    /// Sets the variants. A product without CANopen is a compile error.
    #[track_caller]
    pub const fn with_variants(self, variants: &'static [Variant]) -> Self {
        let Protocol::Canopen(tables) = self.protocol else {
            Mistake::item("with_variants")
                .text("only a product with CANopen has variants")
                .fail();
        };
        let protocol = Protocol::Canopen(Tables { variants, ..tables });
        Self { protocol, ..self }
    }

    /// Sets the status bits of a defective measuring element. A product without CANopen, or without the object, is a compile error.
    #[track_caller]
    pub const fn with_defect(self, defect: Defect) -> Self {
        let mistake = Mistake::item("with_defect");
        let Protocol::Canopen(tables) = self.protocol else {
            mistake
                .text("only a product with CANopen has objects")
                .fail();
        };
        let mut exists = false;
        each!(object in tables.objects => {
            exists |= object.index == defect.index && object.sub == defect.sub;
        });
        mistake.unless(exists, "the object does not exist");
        let defect = Some(defect);
        let protocol = Protocol::Canopen(Tables { defect, ..tables });
        Self { protocol, ..self }
    }
}
