//! One application, with one table of parameters, under FSC and under CANopen: the same acceleration gives the same angle and the
//! same fault, and a zero offset acts in the same way. A value that contradicts another parameter is refused by both protocols.

use crate::tester::Tester;
use crate::tester::canopen::{frame, in_g};
use plumbline::can::BitRate;
use plumbline::canopen::emcy::{CIA_301, Cause, FaultBit, fault};
use plumbline::canopen::{self, CanopenNode, ErrorHistory, Object, Text, TpdoArray, profile};
use plumbline::fsc::table::{Access, Field, Function, LedTable, Operation, Roles, Source};
use plumbline::fsc::{self, Article, Condition, FscNode, StatusBit};
use plumbline::model::gemac::is2::BP_CL;
use plumbline::node::{Context, Pattern};
use plumbline::param::{Constraint, Permitted};
use plumbline::prelude::*;

mod id {
    use plumbline::param::ParameterId;

    pub const SET_ID: ParameterId = ParameterId(0);
    pub const REPLY_ID: ParameterId = ParameterId(1);
    pub const SYNC_ID: ParameterId = ParameterId(2);
    pub const BIT_RATE: ParameterId = ParameterId(3);
    pub const RECOVERY: ParameterId = ParameterId(4);
    pub const CYCLIC_TIME: ParameterId = ParameterId(5);
    pub const CYCLIC_MODE: ParameterId = ParameterId(6);
    pub const NODE_ID: ParameterId = ParameterId(7);
    pub const ZERO: ParameterId = ParameterId(8);
    pub const LIMIT: ParameterId = ParameterId(9);
    pub const TPDO: ParameterId = ParameterId(10);
}

const SLOPE: ValueId = ValueId(0);

/// What has the parameters and speaks both protocols.
struct Both;

const fn identifier(id: ParameterId, name: &'static str, factory: i32) -> Parameter {
    Parameter::new(id, name, DataType::U32).within(1, 0x7FF, factory)
}

impl Table for Both {
    const PARAMETERS: &'static [Parameter] = plumbline::parameters![
        [
            identifier(id::SET_ID, "Set-Parameter-ID", 0x300),
            identifier(id::REPLY_ID, "Reply-Parameter-ID", 0x301),
            identifier(id::SYNC_ID, "Sync-ID", 0x100),
            Parameter {
                permitted: Permitted::OneOf(&[0, 1]),
                ..Parameter::new(id::BIT_RATE, "Bit rate", DataType::U8)
            },
            Parameter::new(id::RECOVERY, "Automatic Bus-Off Recovery", DataType::U8)
                .within(0, 1, 1),
            Parameter::new(id::CYCLIC_TIME, "Cyclic Time", DataType::U16).within(1, 1000, 100),
            Parameter::new(id::CYCLIC_MODE, "Cyclic Mode", DataType::U8).within(0, 1, 0),
            profile::node_id(id::NODE_ID, 20),
            Parameter::new(id::ZERO, "Zero Offset", DataType::I16).in_unit("deg", 2),
            Parameter::new(id::LIMIT, "Limit", DataType::U16).within(1, 1000, 500),
        ],
        profile::tpdo_communication(id::TPDO, 0x180),
    ];
    const CONSTRAINTS: &'static [Constraint] = &[
        Constraint::different(id::SET_ID, id::REPLY_ID),
        Constraint::different(id::LIMIT, id::NODE_ID),
    ];
    plumbline::project!(parameters);
}

/// The application; it names no protocol.
struct Level {
    zero: i32,
    values: Published<1>,
}

impl Application for Level {
    type Table = Both;
    type Values = Published<1>;

    const QUANTITIES: &'static [Quantity] =
        &[Quantity::new(SLOPE, "Slope", DataType::I16).in_unit("deg", 2)];
    const INITIAL: Self = Self {
        zero: 0,
        values: Published::INITIAL,
    };

    fn start(&mut self, _calibration: Calibration) {}

    fn apply(&mut self, _now: Instant, parameters: &Parameters<Both>) -> Published<1> {
        self.zero = i32::from(parameters.get(id::ZERO) as i16);
        self.values
    }

    fn sample(&mut self, _now: Instant, reading: &Reading) -> Published<1> {
        let slope = definition::perpendicular(reading.acceleration)
            .x
            .centidegrees();
        let beyond = Faults::X.when(slope.abs() > 45_00);
        self.values = Published::new([slope + self.zero], beyond);
        self.values
    }

    fn stale(&mut self) -> Published<1> {
        Published::new(self.values.numbers, Faults::X)
    }
}

impl fsc::Product for Both {
    type Application = Level;

    const ROLES: Roles = Roles {
        set_id: id::SET_ID,
        reply_id: id::REPLY_ID,
        sync_id: id::SYNC_ID,
        bit_rate: id::BIT_RATE,
        bit_rates: &[Some(BitRate::K250), None],
        bus_off_recovery: id::RECOVERY,
        cyclic_time: id::CYCLIC_TIME,
        cyclic_mode: id::CYCLIC_MODE,
    };
    const ACCESS: &'static [Access] = &[
        Access::new(0x18, 0x28, "", &[id::ZERO]),
        Access::new(0x19, 0x29, "", &[id::LIMIT]),
    ];
    const FUNCTIONS: &'static [Function] = &[
        Function::new(0x00, "", Operation::Inclination)
            .replying(&[Field::described(Source::Value(SLOPE))]),
        Function::new(0x40, "", Operation::Load).signed(b"LOAD"),
        Function::new(0x50, "", Operation::Save).signed(b"SAVE"),
        Function::new(0x60, "", Operation::Own),
        Function::new(0xFF, "", Operation::Alive).signed(b"RESET"),
    ];
    const OWN: &'static [fsc::Own<Level>] = &[fsc::Own {
        code: 0x60,
        serve: show,
    }];
    const STATUS: [StatusBit; 8] = [
        StatusBit::new("DefaultParam", Condition::DefaultParam),
        StatusBit::new("AutobaudDetection", Condition::AutobaudDetection),
        StatusBit::new("EEPROMError", Condition::EepromError),
        StatusBit::new("CmdParamError", Condition::CmdParamError),
        StatusBit::new("SensorError", Condition::Fault(Faults::X)),
        StatusBit::new("", Condition::Never),
        StatusBit::new("", Condition::Never),
        StatusBit::new("", Condition::Never),
    ];
    const LEDS: LedTable = LedTable {
        detecting: Pattern::Flickering,
        normal: Pattern::On,
        error: canopen::LedTable::CIA_303_3.error,
    };
    plumbline::project!(functions);

    fn set_article(_application: &mut Level, _article: &Article) {}
}

impl canopen::Product for Both {
    type Application = Level;
    type Tpdos = TpdoArray<1, 1>;
    type History = ErrorHistory<4>;
    type Text = Text<0>;
    type Lss = canopen::Absent;
    type Consumers = canopen::Absent;
    type Block = canopen::Absent;
    type State = ();

    const OBJECTS: &'static [Object] = plumbline::objects![
        [profile::device_type(0x0001_019A), profile::error_register()],
        profile::error_history(4),
        profile::identity(0, 0, 0),
        profile::tpdo(0, "Slope", id::TPDO),
        profile::mapping::<2>(0, "Mapping", &[("Slope", 0x6010_0010)]),
        [Object::parameter(0x2000, 0, id::NODE_ID)],
        [Object::parameter(0x2100, 0, id::ZERO)],
        [Object::parameter(0x2101, 0, id::LIMIT)],
        [Object::value(0x6010, 0, SLOPE)],
    ];
    const FAULTS: [FaultBit; 8] = {
        let mut faults = CIA_301;
        faults[0] = fault("slope", Cause::Application(Faults::X), 0x9000, 0);
        faults
    };
    const NODE_ID: ParameterId = id::NODE_ID;
    const BIT_RATE: ParameterId = id::BIT_RATE;
    const BIT_RATES: &'static [(u32, BitRate)] = &[(0, BitRate::K250), (1, BitRate::K250)];
    const IMAGE: ImageId = ImageId::new(0x7002);
    plumbline::project!(objects);
}

/// 60h: sets the zero offset so that the slope is the number in the request. Replies with the new and the previous offset.
fn show(node: &mut Context<Level>, data: &[u8]) -> Option<Text<6>> {
    let wanted = i16::from_le_bytes(*data.first_chunk()?);
    let before = node.parameters.get(id::ZERO) as u16;
    let shown = node.values.number(SLOPE) as u16;
    let offset = before.wrapping_add(wanted as u16).wrapping_sub(shown);
    node.write(id::ZERO, offset.into()).ok()?;
    node.apply();
    let [a, b] = offset.to_le_bytes();
    let [c, d] = before.to_le_bytes();
    Text::from_slice(&[a, b, c, d]).ok()
}

#[test]
fn own_function_select_code_calls_its_function() {
    let start = |now, boot: &Boot| FscNode::<Both>::new(&BP_CL, now, boot);
    let mut tester = Tester::power_up(Boot::default(), start);
    tester.sent();
    assert_eq!(tester.ask(&[0x60, 100, 0]), [0x60, 0x00, 100, 0, 0, 0]);
    tester.sample();
    assert_eq!(tester.ask(&[0x60, 50, 0]), [0x60, 0x00, 50, 0, 100, 0]);
    assert_eq!(tester.ask(&[0x18])[2..], [50, 0]);
    // Without a number it is refused: CmdParamError.
    assert_eq!(tester.ask(&[0x60, 1]), [0x60, 0x08]);
    assert_eq!(tester.ask(&[0x18])[2..], [50, 0]);
}

/// What one reading and a zero offset look like to a client: the angle in 0.01 deg, and whether the fault is active.
type Seen = (i16, bool);

fn under_fsc(force: [f64; 3], zero: i16) -> Seen {
    let start = |now, boot: &Boot| FscNode::<Both>::new(&BP_CL, now, boot);
    let mut tester = Tester::power_up(Boot::default(), start);
    tester.sent();
    let [low, high] = zero.to_le_bytes();
    assert_eq!(tester.ask(&[0x28, low, high])[0], 0x28);
    tester.hold(in_g(force), 1);
    let reply = tester.ask(&[0x00]);
    (
        i16::from_le_bytes([reply[2], reply[3]]),
        reply[1] & 0x10 != 0,
    )
}

fn under_canopen(force: [f64; 3], zero: i16) -> Seen {
    let mut tester = Tester::power_up(Boot::default(), CanopenNode::<Both>::new);
    tester.node_id = 20;
    assert_eq!(tester.sent_text(), ["714#00"]);
    tester.write(0x2100, 0, 2, u32::from(zero as u16)).unwrap();
    tester.hold(in_g(force), 1);
    tester.send("000#0114");
    tester.sent();
    let error = tester.read(0x1001, 0).unwrap();
    tester.receive(frame("080#"));
    let sent = tester.sent();
    assert_eq!(sent.len(), 1, "{sent:?}");
    assert_eq!(format!("{:?}", sent[0])[..4], *"194#");
    (
        i16::from_le_bytes(sent[0].bytes().try_into().unwrap()),
        error != 0,
    )
}

#[test]
fn application_is_the_same_under_fsc_and_under_canopen() {
    let force = |degrees: f64| {
        let angle = degrees.to_radians();
        [-angle.sin(), 0.0, angle.cos()]
    };
    for (degrees, zero, expected) in [
        (0.0, 0, (0, false)),
        (12.34, 0, (1234, false)),
        (-30.0, 500, (-2500, false)),
        (45.1, -10, (4500, true)),
    ] {
        assert_eq!(
            under_fsc(force(degrees), zero),
            expected,
            "FSC, {degrees} deg"
        );
        assert_eq!(
            under_canopen(force(degrees), zero),
            expected,
            "CANopen, {degrees} deg"
        );
    }
}

#[test]
fn value_that_contradicts_another_parameter_is_refused_under_both_protocols() {
    let start = |now, boot: &Boot| FscNode::<Both>::new(&BP_CL, now, boot);
    let mut tester = Tester::power_up(Boot::default(), start);
    tester.sent();
    // The limit must not be the node-ID, 20.
    let refused = tester.ask(&[0x29, 20, 0]);
    assert_eq!((refused.len(), refused[1] & 0x08), (2, 0x08));
    assert_eq!(tester.ask(&[0x19])[2..], [0xF4, 0x01]);
    assert_eq!(
        tester.ask(&[0x29, 21, 0])[1] & 0x08,
        0x08,
        "until the status is read"
    );
    assert_eq!(tester.ask(&[0x19])[2..], [21, 0]);

    let mut tester = Tester::power_up(Boot::default(), CanopenNode::<Both>::new);
    tester.node_id = 20;
    assert_eq!(tester.sent_text(), ["714#00"]);
    assert_eq!(tester.write(0x2101, 0, 2, 20), Err(0x0609_0030));
    assert_eq!(tester.read(0x2101, 0), Ok(500));
    assert_eq!(tester.write(0x2101, 0, 2, 21), Ok(()));
    assert_eq!(tester.read(0x2101, 0), Ok(21));
}
