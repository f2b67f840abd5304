//! The description of a product with the CANopen protocol.

use super::dictionary::{Object, Service, Target, object_at};
use super::emcy::{CIA_301, FaultBit, History};
use super::feature::Feature;
use super::groups::Kept;
use super::lss::{Lss, UNCONFIGURED};
use super::pdo::{Tpdos, Triggers};
use super::profile;
use super::row::Row;
use super::sdo::{Block, Buffer};
use super::setting::TpdoSettings;
use super::variant::Variant;
use crate::application::Application;
use crate::can::BitRate;
use crate::node::{ErrorPatterns, Pattern};
use crate::param::{Parameter, ParameterId, Parameters, Permitted, Quantity, Refused, Table};
use crate::store::ImageId;
use crate::store::unit::NAME;

/// Run and error LED patterns.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LedTable {
    /// Run LED in pre-operational.
    pub pre_operational: Pattern,
    /// Run LED in operational.
    pub operational: Pattern,
    /// Run LED in stopped.
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

/// A text of up to `N` bytes.
pub type Text<const N: usize> = heapless::Vec<u8, N>;

/// The parameters of product `P`.
pub(super) type ParametersOf<P> = Parameters<TableOf<P>>;

/// The parameter table of product `P`.
pub(super) type TableOf<P> = <<P as Product>::Application as Application>::Table;

/// The published values of product `P`.
pub(super) type ValuesOf<P> = <<P as Product>::Application as Application>::Values;

/// A product with the CANopen protocol.
///
/// [`project_objects!`](crate::project_objects) derives the last three constants from the description.
pub trait Product: 'static {
    /// Its measurement and actions.
    type Application: Application;
    /// Its TPDOs, for example `TpdoArray<2, 4>`: two with up to four mapped objects. The numbers must be those of the dictionary.
    type Tpdos: Tpdos;
    /// The history in 1003h, for example `ErrorHistory<8>`. The capacity must be that of the dictionary.
    type History: History;
    /// A buffer for the longest text, for example `Text<32>`. 1008h, 1009h and 100Ah need [`NAME`] bytes.
    type Text: Buffer;
    /// The length of the longest text that can be written, in bytes.
    const WRITABLE: usize = Self::Text::CAPACITY;
    /// Layer setting services (CiA 305): [`Absent`](super::Absent) or `Present<Lss>`. With LSS, the dictionary has 1018h with its
    /// four numbers, and [`NODE_ID`](Self::NODE_ID) permits 255 ([`profile::lss_node_id`]).
    type Lss: Feature<Lss>;
    /// SDO block transfer: [`Absent`](super::Absent) or `Present<Block>`. With block transfer, [`Text`](Self::Text) has at least 4
    /// bytes.
    type Block: Feature<Block>;

    /// The object dictionary, sorted by index and sub-index.
    const OBJECTS: &'static [Object];
    /// The status byte in the manufacturer-specific field of emergency messages, from bit 0 on.
    const FAULTS: [FaultBit; 8] = CIA_301;
    /// The LED patterns.
    const LEDS: LedTable = LedTable::CIA_303_3;
    /// Momentary faults without a bit in the status byte: [`Cause::Overrun`](super::emcy::Cause::Overrun) or
    /// [`Cause::BusOff`](super::emcy::Cause::BusOff).
    const EVENTS: &'static [FaultBit] = &[];
    /// Whether emergency messages and the history contain the status byte. Otherwise, its place is 0.
    const REPORTS_STATUS: bool = true;
    /// The triggers of transmission types 254 and 255.
    const TRIGGERS: Triggers = Triggers::TIMER;
    /// Whether the COB-IDs of the SYNC and of the EMCY can be written in pre-operational only.
    const BINDS_COB_IDS: bool = false;
    /// The parameter with the node-ID, 1 to 127.
    const NODE_ID: ParameterId;
    /// The parameter with the bit rate.
    const BIT_RATE: ParameterId;
    /// The values of the bit rate parameter and their bit rates.
    const BIT_RATES: &'static [(u16, BitRate)] = profile::BIT_RATES;
    /// A number in [`BIT_RATES`](Self::BIT_RATES) multiplied by this is the value of the bit rate parameter; at least 1.
    const BIT_RATE_UNIT: u32 = 1;
    /// The parameter that is not 0 while the node leaves bus-off automatically; None: it always does.
    const BUS_OFF_RECOVERY: Option<ParameterId> = None;
    /// The hidden parameters of a product with groups of stored parameters and a stored history.
    const KEPT: Option<Kept> = None;
    /// The variants with other factory values.
    const VARIANTS: &'static [Variant] = &[];
    /// The parameter that selects the protocol at a restart, and its value for CANopen; None: there is no other protocol. With another
    /// value, the node is not on the bus as a CANopen node, and another protocol accesses its objects.
    const SELECTOR: Option<(ParameterId, u32)> = None;
    /// The identification of the stored parameters of this product.
    const IMAGE: ImageId;

    /// The dictionary in the form that the device uses.
    const ROWS: &'static [Row];
    /// The parameters in the text of the object with [`Service::Text`].
    const TEXT_PARAMETERS: &'static [ParameterId] = &[];
    /// The constant texts.
    const TEXTS: &'static [&'static str];
    /// The communication parameters of the TPDOs.
    const TPDO_SETTINGS: &'static [TpdoSettings];

    /// The number in the object with [`Service::Status`].
    fn status(values: &ValuesOf<Self>, parameters: &ParametersOf<Self>) -> u32
    where
        Self: Sized,
    {
        let _ = (values, parameters);
        0
    }

    /// The text of the object with [`Service::Text`].
    fn text(parameters: &ParametersOf<Self>) -> Self::Text
    where
        Self: Sized,
    {
        let _ = parameters;
        Self::Text::EMPTY
    }

    /// Writes the text of that object: changes [`TEXT_PARAMETERS`](Self::TEXT_PARAMETERS). The parameters are discarded on an error.
    fn write_text(text: &[u8], parameters: &mut ParametersOf<Self>) -> Result<(), Refused>
    where
        Self: Sized,
    {
        let _ = (text, parameters);
        Err(Refused::NotPermitted)
    }
}

/// Checks that the description of a product is consistent. Evaluated at compile time, so an error is a compile error:
///
/// - the numbers of TPDOs and of errors in the history are those of the dictionary, and each TPDO has both of its objects;
/// - mapped objects exist, can be mapped, have the mapped length, and fit into a frame;
/// - constant texts, and the names of a unit that replace them, fit into the buffer, which has at most 255 bytes;
/// - with LSS: the identity object has its four numbers, and the node-ID 255 is permitted;
/// - with block transfer: the buffer for texts takes each number;
/// - the default COB-ID of the SYNC is permitted, and those of the TPDOs and of the EMCY are above 080h with each node-ID.
pub(super) const fn check<P: Product>() {
    let parameters = <TableOf<P> as Table>::PARAMETERS;
    let quantities = <P::Application as Application>::QUANTITIES;
    check_tpdos::<P::Tpdos>(P::OBJECTS, parameters, quantities);
    check_rows(
        P::OBJECTS,
        P::History::CAPACITY,
        P::Text::CAPACITY,
        parameters,
    );
    assert!(
        P::Text::CAPACITY >= 4 || !P::Block::PRESENT,
        "block transfer needs a buffer for texts with at least 4 bytes"
    );
    assert!(P::BIT_RATE_UNIT > 0, "the unit of the bit rate is 0");
    if P::Lss::PRESENT {
        check_lss(P::OBJECTS, parameters, P::NODE_ID);
    }
}

#[allow(clippy::indexing_slicing, clippy::panic)] // evaluated at compile time only
const fn check_lss(objects: &[Object], parameters: &[Parameter], node_id: ParameterId) {
    let mut sub = 1;
    while sub <= 4 {
        assert!(
            object_at(objects, 0x1018, sub).is_some(),
            "a product with LSS needs all numbers of the identity object"
        );
        sub += 1;
    }
    let permitted = match parameters[node_id.0 as usize].permitted {
        Permitted::Ranges(ranges) => ranges.contain(UNCONFIGURED as u32),
        _ => false,
    };
    assert!(permitted, "a product with LSS permits the node-ID 255");
}

#[allow(clippy::indexing_slicing, clippy::panic)] // evaluated at compile time only
const fn check_rows(objects: &[Object], history: usize, text: usize, parameters: &[Parameter]) {
    assert!(
        text <= u8::MAX as usize,
        "the buffer for texts has more than 255 bytes"
    );
    let mut row = 0;
    while row < objects.len() {
        match objects[row].target {
            Target::Text(constant) => {
                assert!(constant.len() <= text, "a text is longer than its buffer");
                assert!(
                    text >= NAME || !super::objects::is_name(objects[row].index),
                    "the name of a unit is longer than the buffer"
                );
            }
            Target::Service(Service::ErrorHistory) => {
                assert!(
                    objects[row].count as usize == history,
                    "the capacity of the error history is not that of the dictionary"
                );
            }
            Target::Parameter(id) if objects[row].index == 0x1005 => {
                assert!(
                    super::cob_id::SYNC.contain(parameters[id.0 as usize].factory),
                    "the default COB-ID of the SYNC is not free"
                );
            }
            Target::CobId(id) | Target::FreeCobId(id) => {
                let base = parameters[id.0 as usize].factory & 0x7FF;
                let mut node_id = 1;
                while node_id <= 127 {
                    assert!(
                        super::cob_id::in_use(base + node_id).is_some(),
                        "the default COB-ID is not free"
                    );
                    node_id += 1;
                }
            }
            _ => {}
        }
        row += 1;
    }
}

#[allow(clippy::panic)] // evaluated at compile time only
const fn check_tpdos<T: Tpdos>(
    objects: &[Object],
    parameters: &[Parameter],
    quantities: &[Quantity],
) {
    let mut number = 0;
    while number < 512 {
        let communication = object_at(objects, 0x1800 + number, 1).is_some();
        let mapping = object_at(objects, 0x1A00 + number, 0).is_some();
        let has = (number as usize) < T::COUNT;
        assert!(
            communication == has && mapping == has,
            "the number of TPDOs is not that of the dictionary"
        );
        if has && T::DYNAMIC {
            super::mapping::check_dynamic(objects, number, T::ENTRIES, parameters, quantities);
        } else if has {
            check_mapping::<T>(objects, number, parameters, quantities);
        }
        number += 1;
    }
}

#[allow(clippy::panic)] // evaluated at compile time only
const fn check_mapping<T: Tpdos>(
    objects: &[Object],
    number: u16,
    parameters: &[Parameter],
    quantities: &[Quantity],
) {
    let (mut bits, mut sub) = (0, 1);
    while let Some(entry) = object_at(objects, 0x1A00 + number, sub) {
        let Target::Constant(entry) = entry.target else {
            panic!("a mapping entry must be a constant");
        };
        check_entry(objects, entry, parameters, quantities);
        assert!(
            is_value(objects, entry),
            "a fixed mapping must consist of published values"
        );
        bits += entry & 0xFF;
        sub += 1;
    }
    assert!(bits <= 64, "the mapped objects do not fit into a frame");
    assert!(
        sub as usize <= T::ENTRIES + 1,
        "more objects are mapped than the TPDO takes"
    );
}

/// Whether a mapping entry maps a published value.
const fn is_value(objects: &[Object], entry: u32) -> bool {
    let mapped = object_at(objects, (entry >> 16) as u16, (entry >> 8) as u8);
    matches!(
        mapped,
        Some(Object {
            target: Target::Value(_),
            ..
        })
    )
}

/// Checks a mapping entry: the object exists, can be mapped, and has the mapped length.
#[allow(clippy::panic)] // evaluated at compile time only
pub(super) const fn check_entry(
    objects: &[Object],
    entry: u32,
    parameters: &[Parameter],
    quantities: &[Quantity],
) {
    let Some(mapped) = object_at(objects, (entry >> 16) as u16, (entry >> 8) as u8) else {
        panic!("a mapped object does not exist");
    };
    assert!(mapped.mappable, "a mapped object cannot be mapped");
    let size = mapped.data_type(parameters, quantities).size() as u32;
    assert!(
        8 * size == entry & 0xFF,
        "a mapped object has another length"
    );
}

#[cfg(test)]
mod tests;
