//! A product with layer setting services and SDO block transfer: node-ID 50, five bit rates from 125 kbit/s on, one TPDO, and a writable text.

use super::Tester;
use plumbline::can::BitRate;
use plumbline::canopen::dictionary::{Access, Service};
use plumbline::canopen::{
    self, Abort, Block, CanopenNode, ErrorHistory, Lss, Object, Own, Present, Product, Scope, Then,
    TpdoArray, profile,
};
use plumbline::node::Context;
use plumbline::param::Permitted;
use plumbline::prelude::*;

const NODE_ID: ParameterId = ParameterId(0);
const BIT_RATE: ParameterId = ParameterId(1);
const LENGTH: ParameterId = ParameterId(2);
const HEARTBEAT: ParameterId = ParameterId(3);
const TPDO: ParameterId = ParameterId(4);
const GUARD_TIME: ParameterId = ParameterId(8);
const SLOPE: ValueId = ValueId(0);

/// The numbers of the identity object, except the serial number.
pub const IDENTITY: [u32; 3] = [0x0000_0195, 0x0001_869F, 0x0002_0001];

/// The longest text, in bytes.
pub const TEXT: usize = 250;

/// The tables of the product.
pub struct GaugeProduct;

pub type Gauge = CanopenNode<GaugeProduct>;

impl Table for GaugeProduct {
    const PARAMETERS: &'static [Parameter] = plumbline::parameters![
        [
            profile::lss_node_id(NODE_ID, 50),
            Parameter {
                permitted: Permitted::OneOf(&[125, 250, 500, 800, 1000]),
                ..profile::bit_rate(BIT_RATE, 125)
            },
            Parameter::new(LENGTH, "Length", DataType::U8).within(0, TEXT as i64, 24),
            profile::heartbeat_time(HEARTBEAT),
        ],
        profile::tpdo_communication(TPDO, 0x180),
        [profile::guard_time(GUARD_TIME)],
    ];
    plumbline::project!(parameters);
}

/// An application that publishes a constant.
pub struct Level;

const VALUES: Published<1> = Published::new([-2], Faults::NONE);

impl Application for Level {
    type Table = GaugeProduct;
    type Values = Published<1>;
    const QUANTITIES: &'static [Quantity] = &[Quantity::new(SLOPE, "Slope", DataType::I16)];
    const INITIAL: Self = Self;

    fn start(&mut self, _calibration: Calibration) {}

    fn apply(&mut self, _now: Instant, _parameters: &Parameters<GaugeProduct>) -> Published<1> {
        VALUES
    }

    fn sample(&mut self, _now: Instant, _reading: &Reading) -> Published<1> {
        VALUES
    }

    fn stale(&mut self) -> Published<1> {
        VALUES
    }
}

/// The text of `length` bytes in 2100h.
pub fn text(length: usize) -> Vec<u8> {
    (0..length).map(|place| (7 * place + 3) as u8).collect()
}

impl Product for GaugeProduct {
    type Application = Level;
    type Tpdos = TpdoArray<1, 1>;
    type History = ErrorHistory<2>;
    type Text = canopen::Text<TEXT>;
    type Lss = Present<Lss>;
    type Consumers = canopen::Absent;
    type Block = Present<Block>;
    type State = ();

    const OBJECTS: &'static [Object] = plumbline::objects![
        [profile::device_type(0x0001_019A), profile::error_register()],
        profile::error_history(2),
        [
            profile::text(0x1008, "Device name", "Gauge with LSS"),
            Object::parameter(0x100C, 0, GUARD_TIME),
            profile::highest(0x1010, "Store parameters", DataType::U8, 1),
            profile::service(
                0x1010,
                1,
                "Store all parameters",
                DataType::U32,
                Access::Rw,
                Service::Store,
            ),
            Object::parameter(0x1017, 0, HEARTBEAT),
        ],
        profile::identity(IDENTITY[0], IDENTITY[1], IDENTITY[2]),
        profile::tpdo(0, "TPDO", TPDO),
        profile::mapping::<2>(0, "Mapping", &[("Slope", 0x6010_0010)]),
        [
            Object::parameter(0x2001, 0, BIT_RATE),
            Object::parameter(0x2002, 0, NODE_ID),
            Object::own(0x2100, 0, "Text", DataType::Text, Access::Rw),
            Object::parameter(0x2101, 0, LENGTH),
            Object::value(0x6010, 0, SLOPE),
        ],
    ];
    const NODE_ID: ParameterId = NODE_ID;
    const BIT_RATE: ParameterId = BIT_RATE;
    const BIT_RATES: &'static [(u32, BitRate)] = &[
        (125, BitRate::K125),
        (250, BitRate::K250),
        (500, BitRate::K500),
        (800, BitRate::K800),
        (1000, BitRate::M1),
    ];
    const OWN: &'static [Own<Self>] = &[Own::text(0x2100, 0, read_text)
        .written(write_text)
        .after_save(stored_text)];
    const IMAGE: ImageId = ImageId::new(0x7005);
    plumbline::project!(objects);
}

fn read_text(_: &(), node: &Context<Level>) -> canopen::Text<TEXT> {
    let length = node.parameters.get(LENGTH) as usize;
    canopen::Text::from_slice(&text(length)).unwrap()
}

/// Stores the length of the text, which can be any one, and takes no other text.
fn write_text(scope: &mut Scope<GaugeProduct>, bytes: &[u8]) -> Result<Then, Abort> {
    if bytes != text(bytes.len()) {
        return Err(Abort::Value);
    }
    let length = bytes.len() as u32;
    if [scope.cx.parameters, *scope.stored].map(|set| set.get(LENGTH)) == [length; 2] {
        return Ok(Then::Reply);
    }
    let mut parameters = *scope.stored;
    parameters.set(LENGTH, length);
    scope.save(parameters)
}

/// The length is in force when it is stored.
fn stored_text(scope: &mut Scope<GaugeProduct>, succeeded: bool) {
    if succeeded {
        scope.cx.parameters.copy(scope.stored, [LENGTH]);
    }
}

/// A gauge with this serial number after power-up, with its node-ID for SDO requests.
pub fn power_up(serial: u32, parameters: Option<&[u8]>) -> Tester<Gauge> {
    let loaded = Boot {
        parameters,
        ..Boot::default()
    };
    let mut tester = Tester::power_up(loaded, move |now, boot| {
        Gauge::new(now, &Boot { serial, ..*boot })
    });
    tester.node_id = 50;
    tester
}

/// A gauge with factory values that has sent its boot-up message.
pub fn booted() -> Tester<Gauge> {
    let mut tester = power_up(super::SERIAL, None);
    assert_eq!(tester.sent_text(), ["732#00"]);
    tester
}
