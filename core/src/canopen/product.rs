//! The description of a product with the CANopen protocol.

use super::consumer::Consumers;
use super::dictionary::Object;
use super::emcy::{CIA_301, FaultBit, History};
use super::feature::{Feature, Initial};
use super::group::Group;
use super::lss::{Lss, LssRates, LssTable};
use super::nmt::State;
use super::own::{Own, Scope, Taken};
use super::pdo::{Tpdos, Triggers};
use super::profile;
use super::row::Row;
use super::sdo::{Block, Buffer};
use super::setting::TpdoSettings;
use crate::application::Application;
use crate::can::BitRate;
use crate::node::{Context, ErrorPatterns, Pattern};
use crate::param::{ParameterId, Parameters};
use crate::store::ImageId;

/// Run and error LED patterns.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LedTable {
    /// Run LED while the node is pre-operational.
    pub pre_operational: Pattern,
    /// Run LED while the node is operational.
    pub operational: Pattern,
    /// Run LED while the node is stopped.
    pub stopped: Pattern,
    /// Error LED while life guarding has not timed out.
    pub error: ErrorPatterns,
    /// Error LED when life guarding has timed out.
    pub guarding: Pattern,
}

impl LedTable {
    /// The patterns of CiA 303-3.
    pub const CIA_303_3: Self = Self {
        pre_operational: Pattern::Blinking,
        operational: Pattern::On,
        stopped: Pattern::SingleFlash,
        error: ErrorPatterns {
            working: Pattern::Off,
            warning: Pattern::SingleFlash,
            bus_off: Pattern::On,
        },
        guarding: Pattern::DoubleFlash,
    };
}

/// A history of up to `N` errors.
pub type ErrorHistory<const N: usize> = heapless::Deque<u32, N>;

/// The part of the node of product `P` that the protocol can access.
pub(super) type ContextOf<P> = Context<<P as Product>::Application>;

/// The parameters of product `P`.
pub(super) type ParametersOf<P> = Parameters<TableOf<P>>;

/// The parameter table of product `P`.
pub(super) type TableOf<P> = <<P as Product>::Application as Application>::Table;

/// The published values of product `P`.
pub(super) type ValuesOf<P> = <<P as Product>::Application as Application>::Values;

/// A product with the CANopen protocol.
///
/// [`project!(objects)`](crate::project) derives the rows, texts and settings from the description, and checks it.
pub trait Product: Sized + Send + 'static {
    /// What the product measures, and what it does with the numbers that masters write.
    type Application: Application;
    /// Its TPDOs, for example `TpdoArray<2, 4>`: two with up to four mapped objects. The numbers must be those of the dictionary.
    type Tpdos: Tpdos;
    /// The history in 1003h, for example `ErrorHistory<8>`. The capacity must be that of the dictionary.
    type History: History;
    /// A buffer for the longest text, for example `Text<32>`. 1008h, 1009h and 100Ah need [`NAME`](crate::store::unit::NAME) bytes.
    type Text: Buffer;
    /// The length of the longest text that can be written, in bytes.
    const WRITABLE: usize = Self::Text::CAPACITY;
    /// Layer setting services (CiA 305): [`Absent`](super::Absent) or `Present<Lss>`. With LSS, the dictionary has 1018h with its
    /// four numbers, and [`NODE_ID`](Self::NODE_ID) permits 255 ([`profile::lss_node_id`]).
    type Lss: Feature<Lss>;
    /// The state of its own objects that is not a parameter; `()` if there is none. If all bits of the initial state are 0, it needs no
    /// flash.
    type State: Initial;
    /// SDO block transfer: [`Absent`](super::Absent) or `Present<Block>`. With block transfer, [`Text`](Self::Text) has at least 4
    /// bytes.
    type Block: Feature<Block>;

    /// The nodes whose heartbeat it monitors (1016h): [`Absent`](super::Absent), or for example `Heartbeats<4>`. The number must be that of
    /// the dictionary.
    type Consumers: Consumers;

    /// The object dictionary, sorted by index and sub-index.
    const OBJECTS: &'static [Object];
    /// The functions of its own objects, in the order of the dictionary.
    const OWN: &'static [Own<Self>] = &[];
    /// The status byte in the manufacturer-specific field of emergency messages, from bit 0 on.
    const FAULTS: [FaultBit; 8] = CIA_301;
    /// The LED patterns in each state, by default those of CiA 303-3.
    const LEDS: LedTable = LedTable::CIA_303_3;
    /// Momentary faults without a bit in the status byte: [`Cause::Overrun`](super::emcy::Cause::Overrun) or
    /// [`Cause::BusOff`](super::emcy::Cause::BusOff).
    const EVENTS: &'static [FaultBit] = &[];
    /// The triggers of transmission types 254 and 255.
    const TRIGGERS: Triggers = Triggers::TIMER;
    /// The parameter with the node-ID, 1 to 127.
    const NODE_ID: ParameterId;
    /// The parameter with the bit rate, as one of the values of [`BIT_RATES`](Self::BIT_RATES).
    const BIT_RATE: ParameterId;
    /// The values of the bit rate parameter and their bit rates.
    const BIT_RATES: &'static [(u32, BitRate)] = &profile::BIT_RATES;
    /// Whether the node leaves bus-off automatically; None: it always does. With this function, a reset of the node also ends bus-off.
    const RECOVERS: Option<fn(&ParametersOf<Self>) -> bool> = None;
    /// Whether another protocol is on the bus, which transports the SDOs, since a start with these parameters; None: there is no other
    /// protocol.
    const HOSTED: Option<fn(&ParametersOf<Self>) -> bool> = None;
    /// The manufacturer-specific groups of parameters. The sub-indices 4 and following of 1010h and 1011h store and restore them.
    const GROUPS: &'static [Group] = &[Group::new(0x2000, 0x5FFF)];
    /// The manufacturer-specific bit timing tables for LSS. The table of CiA 305, selector 0, is always there.
    /// [`BIT_RATES`](Self::BIT_RATES) says which bit rates are permitted.
    const LSS_TABLES: &'static [LssTable] = &[];
    /// The identification of the stored parameters of this product.
    const IMAGE: ImageId;

    /// The dictionary in the form that the device uses.
    const ROWS: &'static [Row];
    /// The constant texts of the dictionary.
    const TEXTS: &'static [&'static str];
    /// The communication parameters of the TPDOs.
    const TPDO_SETTINGS: &'static [TpdoSettings];
    /// The indices of [`GROUPS`](Self::GROUPS).
    const GROUP_INDICES: &'static [(u16, u16)];
    /// The selectors and the bit rates of [`LSS_TABLES`](Self::LSS_TABLES).
    const LSS_RATES: &'static [LssRates];

    /// The additional information in emergency messages: the status byte, or another number.
    fn additional(status: u8) -> u8 {
        status
    }

    /// An error in the history (1003h): the first four bytes of its emergency message, with the status byte, or some of them. Bits 0 to 15
    /// are its code.
    fn logged(message: u32) -> u32 {
        message
    }

    /// Whether an object of the communication profile can be written in this NMT state.
    fn is_writable(index: u16, state: State) -> bool {
        let _ = (index, state);
        true
    }

    /// Adapts parameters that were taken from the memory: all of them at a start (power-up, reset node), otherwise those of the
    /// communication profile (reset communication).
    fn adapt(taken: Taken<'_, Self>, starts: bool) {
        let _ = (taken, starts);
    }

    /// Begins a save that no master has requested ([`Scope::save`]), if the product has a reason. Called while no save is running: after
    /// a start, after each reset and after each save.
    fn settled(scope: &mut Scope<'_, Self>) {
        let _ = scope;
    }
}
