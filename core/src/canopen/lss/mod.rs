//! Layer setting services (CiA 305): a master sets the node-ID and the bit rate of a node that it addresses by the four numbers
//! of the identity object (1018h).
//!
//! ```text
//!  7E5h  master to node, 7E4h node to master, always 8 bytes, unused bytes are 0
//!  byte 0          1                                             8
//!       +----------+---------------------------------------------+
//!       | command  | data, numbers are little-endian             |
//!       +----------+---------------------------------------------+
//!
//!  04h       switch state global         1: 0 waiting, 1 configuration                       no answer
//!  40h..43h  switch state selective      1..4: a number of the identity                      44h after a complete match
//!  11h       configure node-ID           1: 1..127, or 255                                   11h, error
//!  13h       configure bit timing        1: table, 2: index of the bit rate                  13h, error
//!  15h       activate bit timing         1..2: delay in ms                                   no answer
//!  17h       store configuration                                                             17h, error
//!  46h..4Bh  identify remote slave       1..4: a number or a limit of the identity           4Fh after a complete match
//!  4Ch       identify non-configured                                                         50h
//!  51h       fastscan                    1..4: number, 5: bit, 6: its place, 7: next place   4Fh on a match
//!  5Ah..5Dh  inquire a number of the identity                                                5Ah..5Dh, 1..4: the number
//!  5Eh       inquire node-ID                                                                 5Eh, 1: the node-ID in force
//! ```
//!
//! The parameters of the product with the node-ID and the bit rate are the pending values of LSS. They act after reset
//! communication. A node with the node-ID [`UNCONFIGURED`] sends no boot-up message and only serves LSS.
//!
//! - [`Slave`]: the state machine of the services, for each type that implements [`Device`];
//! - [`Lss`]: its state in a node, with the times of activate bit timing and of the LEDs.

mod activation;
mod flicker;
mod service;
mod slave;

pub use slave::{BEGIN_SCAN, BIT_RATES, Device, Outcome, Slave, answer, command};

use super::feature::Initial;
use crate::can::BitRate;
use crate::mistake::{Mistake, Origin};
use crate::time::Deadline;
use crate::walk::{each, put};
use activation::Activation;
use flicker::Flicker;

/// The node-ID of a node without a valid node-ID.
pub const UNCONFIGURED: u8 = 255;

/// The bit rates of a table selector of configure bit timing.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LssTable {
    /// The table selector, from 128 on.
    pub selector: u8,
    /// The bit rates by their indices.
    pub rates: &'static [Option<BitRate>],
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

/// A table selector and its bit rates, in the form that the device uses.
pub type LssRates = (u8, &'static [Option<BitRate>]);

impl LssTable {
    /// The table with this selector.
    #[track_caller]
    pub const fn new(selector: u8, rates: &'static [Option<BitRate>]) -> Self {
        Self {
            selector,
            rates,
            origin: Origin::here(),
        }
    }

    /// The selectors and the bit rates of these tables.
    pub const fn rates<const N: usize>(tables: &[Self]) -> [LssRates; N] {
        let mut rates: [LssRates; N] = [(0, &[]); N];
        each!(place, table in tables => { put(&mut rates, place, (table.selector, table.rates)) });
        rates
    }

    /// A mistake in the table at this place.
    pub(super) const fn mistake(&self, place: usize) -> Mistake<'_> {
        Mistake::row("LSS_TABLES", place).at(self.origin)
    }
}

/// The progress of store configuration.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Store {
    Idle,
    /// Another save is running. The save of the configuration begins after it.
    Waiting,
    /// The save of the configuration is running. The answer follows.
    Running,
}

/// The layer setting services in a node.
#[derive(Clone, Debug)]
pub struct Lss {
    slave: Slave,
    store: Store,
    activation: Activation,
    flicker: Flicker,
}

impl Initial for Lss {
    const INITIAL: Self = Self {
        slave: Slave::WAITING,
        store: Store::Idle,
        activation: Activation::IDLE,
        flicker: Flicker::OFF,
    };
}

impl Lss {
    /// Whether activate bit timing is in progress: the node neither sends nor receives.
    pub(super) fn is_silent(&self) -> bool {
        self.activation.is_running()
    }

    /// The next time at which the services must be polled.
    pub(super) fn consider(&self, earliest: &mut Deadline) {
        earliest.consider(self.activation.deadline());
        earliest.consider(self.flicker.deadline());
    }
}
