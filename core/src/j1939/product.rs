//! The description of a product with the J1939 protocol.

use super::consistency::Checked;
use super::diagnostics::{Code, Trouble};
use super::identifier::Pgn;
use super::signal::Group;
use super::timers::Timers;
use crate::application::Application;
use crate::can::BitRate;
use crate::node::{Context, ErrorPatterns, Pattern};
use crate::param::{ParameterId, Parameters, Setting};
use crate::store::ImageId;

/// The part of the node of product `P` that the protocol can access.
pub(super) type ContextOf<P> = Context<<P as Product>::Application>;

pub(super) type ParametersOf<P> = Parameters<<<P as Product>::Application as Application>::Table>;

/// Faults of the node itself.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Conditions {
    /// An access to the nonvolatile memory failed.
    pub memory: bool,
    /// The CAN controller is error passive, or received frames were lost.
    pub network: bool,
}

/// A group of eight bytes that the node sends to all nodes: cyclically, and on request.
pub struct Sent<A: Application> {
    /// The parameter group number, F000h or more: such a group is sent to all nodes.
    pub pgn: Pgn,
    /// The transmission rate in ms; 0: only on request.
    pub rate: Setting,
    /// The priority, 0 (highest) to 7.
    pub priority: Setting,
    /// Returns the data of the message from the present values. Bits without a signal are 1. [`compose`](super::signal::compose) makes it
    /// from the values of an inclination sensor, [`data`](super::signal::data) from other numbers.
    pub data: fn(&Context<A>) -> [u8; 8],
}

/// A product with the J1939 protocol.
///
/// [`project!(groups)`](crate::project) checks the tables where they are written.
pub trait Product: Sized + Send + 'static {
    /// What the product measures, and what it does with the numbers that masters write.
    type Application: Application;
    /// A timer for each of its groups, for example `[Timer; 4]`.
    type Timers: Timers;

    /// The groups that it sends.
    const SENT: &'static [Sent<Self::Application>];
    /// The description of these groups in the same order, for documents and databases. The device does not use it.
    const GROUPS: &'static [Group];
    /// The parameter with the preferred address, 0 to 253. Commanded Address writes it.
    const ADDRESS: ParameterId;
    /// The fields of the NAME, as for [`Name::new`](super::name::Name::new): parameters or [constants](super::name::constants).
    const NAME: [Setting; 8];
    /// The make in the identification.
    const MAKE: &'static str;
    /// The model in the identification, unless the unit has a name.
    const MODEL: &'static str;
    /// The software version in the identification, unless the unit has another one.
    const VERSION: &'static str;
    /// The type of the device in the identification.
    const TYPE: &'static str;
    /// The diagnostic trouble codes, at most [`CODES`](super::diagnostics::CODES).
    const TROUBLES: &'static [Trouble] = &[];
    /// The error LED in each state of the bus.
    const ERROR_LED: ErrorPatterns = ErrorPatterns {
        working: Pattern::Off,
        warning: Pattern::SingleFlash,
        bus_off: Pattern::On,
    };
    /// The identification of the stored parameters of this product.
    const IMAGE: ImageId;
    /// The codes of [`TROUBLES`](Self::TROUBLES).
    const TROUBLE_CODES: &'static [Code];
    /// The proof that the tables were checked.
    const CHECKED: Checked;

    /// The bit rate after a start.
    fn bit_rate(parameters: &ParametersOf<Self>) -> BitRate {
        let _ = parameters;
        BitRate::K250
    }

    /// Whether the node leaves bus-off automatically.
    fn recovers(parameters: &ParametersOf<Self>) -> bool {
        let _ = parameters;
        true
    }

    /// The active trouble codes, a bit for each.
    fn active(node: &ContextOf<Self>, conditions: Conditions) -> u16 {
        let _ = (node, conditions);
        0
    }

    /// Handles a message of Proprietary A to this node. Returns the answer, a message of the same group to the sender. The function may
    /// write parameters ([`Context::write`], [`Context::apply`]) and begin a save ([`Context::save`]) while none is running.
    fn proprietary(node: &mut ContextOf<Self>, message: [u8; 8]) -> Option<[u8; 8]> {
        let _ = (node, message);
        None
    }

    /// Handles the end of a save that [`proprietary`](Self::proprietary) has begun. Returns a message to the node that has caused it.
    fn stored(node: &mut ContextOf<Self>, succeeded: bool) -> Option<[u8; 8]> {
        let _ = (node, succeeded);
        None
    }
}
