//! The parameters of a product that its protocol needs: bit rate and addresses.

use super::{Protocol, Target};
use crate::error::Error;
use plumbline::can::BitRate;
use plumbline::model::catalog::{PRODUCTS, Product};
use plumbline::param::ParameterId;

/// The raw numbers of bit rates; None: automatic detection.
pub type Codes = Vec<(u32, Option<BitRate>)>;

/// What stores a change in the sensor.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Storing {
    /// A command.
    Command,
    /// The sensor itself, after each change.
    Itself,
    /// The tool does not know it.
    Unknown,
}

/// The parameters of a product with a role in its protocol.
#[derive(Clone, Debug)]
pub struct Roles {
    /// The parameter of the bit rate, and its numbers.
    pub rate: Option<(ParameterId, Codes)>,
    /// The parameter of the address.
    pub address: ParameterId,
    /// The sensor with this number in the parameter of the address.
    pub target: fn(u32) -> Result<Target, Error>,
    /// Further identifiers of the sensor.
    pub identifiers: Vec<ParameterId>,
    /// That of them which several sensors on a bus can have.
    pub shared: Option<ParameterId>,
    /// The sensor has another address as soon as it is written. Otherwise it acts after a restart, as the identifiers.
    pub moves_at_once: bool,
    /// What stores a change.
    pub storing: Storing,
}

impl Roles {
    /// The roles of a product in its protocol.
    pub fn of(product: &Product) -> Option<Self> {
        (Protocol::of(product).roles)(product)
    }

    /// Whether a parameter is the bit rate.
    pub fn is_rate(&self, id: ParameterId) -> bool {
        self.rate.as_ref().is_some_and(|(own, _)| *own == id)
    }

    /// Whether a parameter is an address or an identifier.
    pub fn is_address(&self, id: ParameterId) -> bool {
        self.address == id || self.identifiers.contains(&id)
    }
}

/// The number of a parameter as delivered; None: a data sheet does not say it.
pub(crate) fn factory(product: &Product, id: ParameterId) -> Option<u32> {
    let parameter = product.parameters.get(usize::from(id.0))?;
    Some(parameter.factory)
}

/// The address of a product as delivered; None: a data sheet does not say it.
pub fn factory_target(product: &Product) -> Option<Target> {
    let roles = Roles::of(product)?;
    (roles.target)(factory(product, roles.address)?).ok()
}

/// The bit rate of a product as delivered; None: a data sheet does not say it, or the product detects the bit rate.
pub fn factory_rate(product: &Product) -> Option<BitRate> {
    let (id, codes) = Roles::of(product)?.rate?;
    let raw = factory(product, id)?;
    let (_, rate) = codes.into_iter().find(|(code, _)| *code == raw)?;
    rate
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
