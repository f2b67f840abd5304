//! ifm JN2101: two axes, +-45 deg, CANopen with the device profile for inclination sensors (CiA 410).
//!
//! Section numbers refer to the device manual "JN2101 from firmware 2.2.0".
//!
#![doc = include_str!("README.md")]

mod application;
mod base64;
mod measuring;
mod objects;
mod own;
mod parameters;
mod programming_key;

pub use application::{Inclination, Jn2101Application, value};
pub use parameters::id;

use crate::application::Faults;
use crate::canopen::dictionary::Object;
use crate::canopen::emcy::{self, Cause, FaultBit, fault};
use crate::canopen::{self, CanopenNode, LedTable, TpdoArray};
use crate::model::listing;
use crate::model::listing::{Adjustment, Article, Guide, Resolution, Written};
use crate::node::Pattern;
use crate::param::ParameterId;
use crate::store::ImageId;
use crate::store::unit::NAME;

/// The product: its tables and rules.
pub struct Jn2101Product;

/// The node: what a driver or a test starts.
pub type Jn2101 = CanopenNode<Jn2101Product>;

/// The entry in [`PRODUCTS`](crate::model::catalog::PRODUCTS).
pub const LISTING: listing::Product = listing::Product::canopen::<Jn2101Product>(
    "jn2101",
    "ifm electronic",
    Article {
        name: "JN2101",
        number: "JN2101",
    },
)
.guided(&GUIDE);

const GUIDE: Guide = Guide {
    short_names: &[
        (id::FILTER, "filter"),
        (id::ZERO, "zero"),
        (id::TEACH, "teach"),
    ],
    angles: &[value::X32, value::Y32],
    resolution: Some(Resolution {
        parameter: id::RESOLUTION,
        parameters: &[],
        values: &[value::X16, value::Y16, value::X32, value::Y32],
    }),
    zero: &[Adjustment::new(
        "",
        &[(id::ZERO, Written::Number(parameters::RELATIVE))],
    )],
    teach: &[Adjustment::new(
        "",
        &[(id::TEACH, Written::Number(parameters::RELATIVE))],
    )],
    ..Guide::NONE
};

/// The number of errors in the history (1003h).
const HISTORY: usize = 50;

/// The longest text that can be written.
const KEY: usize = 24;

impl canopen::Product for Jn2101Product {
    type Application = Jn2101Application;
    type Tpdos = TpdoArray<2, 2>;
    type History = canopen::ErrorHistory<HISTORY>;
    type Text = canopen::Text<NAME>;
    type Lss = canopen::Absent;
    type Consumers = canopen::Absent;
    type Block = canopen::Absent;

    type State = own::State;

    const OBJECTS: &'static [Object] = objects::OBJECTS;
    const OWN: &'static [canopen::Own<Self>] = &own::FUNCTIONS;
    /// The emergency codes of 7.6.1 and 11.
    const FAULTS: [FaultBit; 8] = [
        fault("sensor", Cause::Application(Faults::SENSOR), 0x1000, 0),
        fault(
            "measuring range",
            Cause::Application(Faults::RANGE),
            0x9000,
            0,
        ),
        fault(
            "device temperature",
            Cause::Application(Faults::TEMPERATURE),
            0x4200,
            emcy::TEMPERATURE,
        ),
        fault("hardware", Cause::Memory, 0x1000, 0),
        fault(
            "supply voltage",
            Cause::Application(Faults::SUPPLY),
            0x3100,
            emcy::VOLTAGE,
        ),
        emcy::PASSIVE,
        emcy::GUARDING,
        emcy::BUS_OFF,
    ];
    const EVENTS: &'static [FaultBit] = &[emcy::OVERRUN];
    /// 11.3: unlike CiA 303-3, the run LED is on in pre-operational and blinks in operational.
    const LEDS: LedTable = LedTable {
        pre_operational: Pattern::On,
        operational: Pattern::Blinking,
        ..LedTable::CIA_303_3
    };
    const NODE_ID: ParameterId = id::NODE_ID;
    const BIT_RATE: ParameterId = id::BAUD_RATE;
    const WRITABLE: usize = KEY;
    const IMAGE: ImageId = ImageId::new(0x2101);
    crate::project!(objects);
}
