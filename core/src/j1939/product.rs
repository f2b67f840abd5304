//! The description of a product with the J1939 protocol.

use super::diagnostics::{CODES, Code};
use super::groups::COUNT;
use super::signal::Motion;
use crate::application::Application;
use crate::canopen;
use crate::param::{ParameterId, Parameters};
use crate::store::unit::NAME;

/// The published values of product `P`.
pub(super) type ValuesOf<P> = <<P as canopen::Product>::Application as Application>::Values;

/// The parameters of product `P`.
pub(super) type ParametersOf<P> =
    Parameters<<<P as canopen::Product>::Application as Application>::Table>;

/// Faults of the node itself.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Conditions {
    /// An access to the nonvolatile memory failed.
    pub memory: bool,
    /// The CAN controller is error passive, or received frames were lost.
    pub network: bool,
}

/// A product with the protocols CANopen and J1939, one of which is on the bus
/// ([`HOSTED`](canopen::Product::HOSTED)).
pub trait Product: canopen::Product {
    /// The parameter with the preferred address, 0 to 253.
    const ADDRESS: ParameterId;
    /// The parameters with the transmission rate of each of the [groups](super::groups::GROUPS) in ms; 0: only on request.
    const RATES: [ParameterId; COUNT];
    /// The parameters with the priority of each group.
    const PRIORITIES: [ParameterId; COUNT];
    /// The parameters with the fields of the NAME, as for [`Name::new`](super::name::Name::new).
    const NAME: [ParameterId; 8];
    /// The make in the identification.
    const MAKE: &'static str;
    /// The type of the device in the identification.
    const TYPE: &'static str;
    /// The diagnostic trouble codes, at most [`CODES`].
    const TROUBLES: &'static [Code];

    /// The values of the groups.
    fn motion(values: &ValuesOf<Self>, parameters: &ParametersOf<Self>) -> Motion;

    /// The active trouble codes, a bit for each.
    fn active(
        values: &ValuesOf<Self>,
        parameters: &ParametersOf<Self>,
        conditions: Conditions,
    ) -> u16;
}

/// Checks that the description of a product is consistent. An error is a compile error.
pub(super) const fn check<P: Product>() {
    assert!(P::TROUBLES.len() <= CODES, "too many trouble codes");
    assert!(P::HOSTED.is_some(), "no parameter selects the protocol");
    assert!(
        model::<P>().len() <= NAME,
        "the model is longer than a name"
    );
    let texts = P::MAKE.len() + P::TYPE.len() + NAME;
    // The separators, and a serial number of 32 bits.
    assert!(
        texts + 5 + 10 <= super::transport::MESSAGE,
        "the identification is longer than a message"
    );
    // With the number of fields and the separator it fills a frame.
    assert!(
        version::<P>().len() == 6,
        "the software version must have 6 characters"
    );
}

/// The name of the model: the manufacturer device name (1008h).
pub(super) const fn model<P: canopen::Product>() -> &'static str {
    canopen::dictionary::text_at(P::OBJECTS, 0x1008, 0)
}

/// The software version (100Ah).
pub(super) const fn version<P: canopen::Product>() -> &'static str {
    canopen::dictionary::text_at(P::OBJECTS, 0x100A, 0)
}
