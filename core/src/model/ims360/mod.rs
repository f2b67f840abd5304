//! SIKO IMS360: one axis 0 to 360 deg or two axes +-90 deg, CANopen with the device profile for inclination sensors (CiA 410),
//! or SAE J1939.
//!
//! Section numbers refer to the user manual "IMS360 CANopen", change status 088/25.
//!
#![doc = include_str!("README.md")]

mod application;
mod groups;
mod j1939;
mod measuring;
mod objects;
mod own;
mod parameters;
mod range;
mod variant;

pub use application::{Ims360Application, Inclination, value};
pub use parameters::id;

use crate::application::Faults;
use crate::can::BitRate;
use crate::canopen::dictionary::Object;
use crate::canopen::emcy::{self, Cause, FaultBit, fault};
use crate::canopen::nmt;
use crate::canopen::{self, Block, DynamicTpdos, Lss, Present, Scope, Taken, Triggers};
use crate::model::dual::DualNode;
use crate::model::listing::{self, Adjustment, Article, Guide, Offset, Written};
use crate::param::{ParameterId, Parameters};
use crate::store::ImageId;
use crate::store::unit::NAME;

/// The product: its tables for both protocols.
pub struct Ims360Product;

/// The node: what a driver or a test starts.
pub type Ims360 = DualNode<Ims360Product>;

/// The entry in [`PRODUCTS`](crate::model::catalog::PRODUCTS).
pub const LISTING: listing::Product = listing::Product::with_j1939::<Ims360Product>(
    "ims360",
    "SIKO",
    Article {
        name: "IMS360",
        number: "IMS360",
    },
    parameters::SELECTOR,
)
.with_variants(&[parameters::ONE_AXIS])
.with_defect(own::DEFECT)
.guided(&GUIDE);

const GUIDE: Guide = Guide {
    short_names: &[
        (id::CUT_OFF, "cut-off"),
        (id::FILTER_TYPE, "filter-type"),
        (id::ZERO_X, "zero-x"),
        (id::ZERO_Y, "zero-y"),
    ],
    groups: &[("filter", &[id::CUT_OFF, id::FILTER_TYPE])],
    angles: &[value::X, value::Y],
    zero: &[
        Adjustment::new(
            "x",
            &[(id::AUTO_ZERO, Written::Number(application::ZERO_X))],
        )
        .with_offset(Offset {
            angle: value::X,
            parameter: id::ZERO_X,
            switch: None,
        }),
        Adjustment {
            absent_if: Some((id::DEVICE_TYPE, parameters::ONE_AXIS_TYPE)),
            ..Adjustment::new(
                "y",
                &[(id::AUTO_ZERO, Written::Number(application::ZERO_Y))],
            )
            .with_offset(Offset {
                angle: value::Y,
                parameter: id::ZERO_Y,
                switch: None,
            })
        },
    ],
    ..Guide::NONE
};

/// The number of errors in the history (1003h).
const HISTORY: usize = 8;

/// Bit 7 of the error register: manufacturer-specific, an error of the sensor (7.2.2).
const SENSOR: u8 = 1 << 7;

impl canopen::Product for Ims360Product {
    type Application = Ims360Application;
    type Tpdos = DynamicTpdos<4, 8>;
    type History = canopen::ErrorHistory<HISTORY>;
    type Text = canopen::Text<NAME>;
    type Lss = Present<Lss>;
    type Consumers = canopen::Absent;
    type Block = Present<Block>;

    type State = own::State;

    const OBJECTS: &'static [Object] = objects::OBJECTS;
    const OWN: &'static [canopen::Own<Self>] = &own::FUNCTIONS;
    /// The emergency codes of table 8 that last.
    const FAULTS: [FaultBit; 8] = [
        fault(
            "supply voltage",
            Cause::Application(Faults::SUPPLY),
            0x3100,
            0,
        ),
        fault(
            "longitudinal value out of range",
            Cause::Application(Faults::X),
            0x5010,
            SENSOR,
        ),
        fault(
            "lateral value out of range",
            Cause::Application(Faults::Y),
            0x5020,
            SENSOR,
        ),
        fault("parameter memory", Cause::Memory, 0xFF00, SENSOR),
        fault(
            "longitudinal sensor defective",
            Cause::Application(Faults::X_DEFECTIVE),
            0xFF01,
            SENSOR,
        ),
        fault(
            "lateral sensor defective",
            Cause::Application(Faults::Y_DEFECTIVE),
            0xFF02,
            SENSOR,
        ),
        emcy::PASSIVE,
        FaultBit::RESERVED,
    ];
    /// The emergency codes of table 8 for events.
    const EVENTS: &'static [FaultBit] = &[
        emcy::OVERRUN,
        FaultBit {
            code: 0xFF14,
            ..emcy::BUS_OFF
        },
    ];
    const TRIGGERS: Triggers = Triggers {
        changes: true,
        restarts_timer: true,
    };
    const NODE_ID: ParameterId = id::NODE_ID;
    const BIT_RATE: ParameterId = id::BIT_RATE;
    /// The object (2001h) has the bit rate in bit/s.
    const BIT_RATES: &'static [(u32, BitRate)] = &[
        (125_000, BitRate::K125),
        (250_000, BitRate::K250),
        (500_000, BitRate::K500),
        (800_000, BitRate::K800),
        (1_000_000, BitRate::M1),
    ];
    const RECOVERS: Option<fn(&Parameters<Self>) -> bool> = Some(parameters::recovers);
    const HOSTED: Option<fn(&Parameters<Self>) -> bool> =
        Some(|parameters| parameters.get(parameters::SELECTOR.0) != parameters::SELECTOR.1);
    const IMAGE: ImageId = ImageId::new(0x3600);
    crate::project!(objects);

    /// 6.2.1: "Manufacturer-specific error field (not used)".
    fn additional(_: u8) -> u8 {
        0
    }

    /// 7.2.3: only the code.
    fn logged(message: u32) -> u32 {
        message & 0xFFFF
    }

    fn is_writable(index: u16, state: nmt::State) -> bool {
        !matches!(index, 0x1005 | 0x1014) || state == nmt::State::PreOperational
    }

    fn adapt(mut taken: Taken<'_, Self>, starts: bool) {
        groups::take_factory_values(&mut taken, starts);
        variant::adapt(&mut taken.state.variant, taken.parameters, starts);
    }

    fn settled(scope: &mut Scope<'_, Self>) {
        groups::use_up_request(scope);
    }
}
