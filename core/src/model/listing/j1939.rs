//! The catalogue entry of a product with J1939: alone, or beside CANopen.

use super::{Article, Product, Protocol, check_article};
use crate::j1939::diagnostics::Code;
use crate::j1939::signal::Group;
use crate::j1939::{self, J1939Node};
use crate::param::{ParameterId, Setting};

/// The tables of a product with J1939 only.
#[derive(Clone, Copy, Debug)]
pub struct Tables {
    /// The only article of the product.
    pub article: Article,
    /// The tables of the protocol.
    pub j1939: J1939Tables,
}

/// The tables of the J1939 protocol.
#[derive(Clone, Copy, Debug)]
pub struct J1939Tables {
    /// The parameter that selects the protocol, and its value for CANopen; None: there is no other protocol, or nothing selects it.
    pub selector: Option<(ParameterId, u32)>,
    /// The groups with process data.
    pub groups: &'static [Group],
    /// The transmission rate in ms and the priority of a group; None after the last one.
    pub settings: fn(usize) -> Option<(Setting, Setting)>,
    /// The parameter with the preferred address.
    pub address: ParameterId,
    /// The fields of the NAME, from the arbitrary address capable bit on.
    pub name: [Setting; 8],
    /// The diagnostic trouble codes that DM1 can contain.
    pub troubles: &'static [Code],
}

impl J1939Tables {
    pub(super) const fn of<P: j1939::Product>(selector: Option<(ParameterId, u32)>) -> Self {
        Self {
            selector,
            groups: P::GROUPS,
            settings: |place| {
                let sent = P::SENT.get(place)?;
                Some((sent.rate, sent.priority))
            },
            address: P::ADDRESS,
            name: P::NAME,
            troubles: P::TROUBLE_CODES,
        }
    }
}

impl Tables {
    pub(super) fn article(&self, place: usize) -> Option<Article> {
        (place == 0).then_some(self.article)
    }
}

impl Product {
    /// The product `P` with J1939 only and a single article, compatible with that of this maker.
    #[track_caller]
    pub const fn j1939<P: j1939::Product>(
        name: &'static str,
        maker: &'static str,
        article: Article,
    ) -> Self {
        check_article(&article);
        let protocol = Protocol::J1939(Tables {
            article,
            j1939: J1939Tables::of::<P>(None),
        });
        Self {
            #[cfg(not(target_os = "none"))]
            power_up: super::start::sole::<J1939Node<P>>,
            ..Self::of::<J1939Node<P>>(name, maker, protocol, P::IMAGE)
        }
    }
}
