//! A DeviceNet product for the tests of the protocol. MAC ID 63, 125 kbit/s, serial number 04030201h.
//!
//! | attribute of 65h/1 | contents                                                    | type | access |
//! |--------------------|-------------------------------------------------------------|------|--------|
//! | 01h                | 11                                                          | U16  | get    |
//! | 71h                | a parameter, 0 to 1000, factory value 10                    | U16  | set    |
//! | 72h                | X of the specific force in 0.001 g                          | I16  | get    |
//! | 73h                | a parameter, -100 to 100; 77 is refused in the present state | I16  | set    |
//! | 75h                | a parameter that is not stored                              | U8   | set    |
//! | 76h                | a parameter                                                 | U16  | get    |
//! | 78h                | X of the specific force in 0.000001 g                       | I32  | get    |
//! | 7Ah                | Y of the specific force in 0.001 g                          | I16  | get    |
//! | 81h, 82h           | the assemblies of poll and of COS/cyclic                    | U8   | set    |
//! | 88h                | the COS delta                                               | U8   | set    |
//!
//! The attributes of 66h/1 have functions of their own:
//!
//! | attribute of 66h/1 | contents                                                    | type | access |
//! |--------------------|-------------------------------------------------------------|------|--------|
//! | 01h                | the parameter of 71h, in tens                               | U8   | set    |
//! | 02h                | X of the specific force in 0.001 g, plus 1                  | I16  | get    |

use super::Tester;
use super::canopen::frame;
use plumbline::application::Effect;
use plumbline::can::BitRate;
use plumbline::devicenet::{
    Assembly, Attribute, DevicenetNode, Identity, Object, Own, Product, Roles, Source,
};
use plumbline::measure::ONE_G;
use plumbline::node::{Boot, Context};
use plumbline::param::{Coding, Persistence, Refused};
use plumbline::prelude::*;

const X: ValueId = ValueId(0);
const Y: ValueId = ValueId(1);
const FINE: ValueId = ValueId(2);

mod id {
    use plumbline::param::ParameterId;

    pub const MAC: ParameterId = ParameterId(0);
    pub const BAUD: ParameterId = ParameterId(1);
    pub const BOI: ParameterId = ParameterId(2);
    pub const POLLED: ParameterId = ParameterId(3);
    pub const CYCLIC: ParameterId = ParameterId(4);
    pub const DELTA: ParameterId = ParameterId(5);
    pub const NUMBER: ParameterId = ParameterId(6);
    pub const SIGNED: ParameterId = ParameterId(7);
    pub const VOLATILE: ParameterId = ParameterId(8);
    pub const HIDDEN: ParameterId = ParameterId(9);
}

/// The value of 73h that is refused in the present state of the device.
const CONFLICT: u32 = 77;

const BAUD_RATES: Coding<BitRate, 3> = Coding([
    (0, "125 kbit/s", BitRate::K125),
    (1, "250 kbit/s", BitRate::K250),
    (2, "500 kbit/s", BitRate::K500),
]);

pub struct Level;

const fn stored(parameter: Parameter) -> Parameter {
    Parameter {
        persistence: Persistence::AtOnce,
        ..parameter
    }
}

const fn byte(id: ParameterId, name: &'static str, low: i64, high: i64, factory: i32) -> Parameter {
    stored(Parameter::new(id, name, DataType::U8).within(low, high, factory))
}

impl Table for Level {
    const PARAMETERS: &'static [Parameter] = &[
        byte(id::MAC, "MAC ID", 0, 63, 63),
        Parameter {
            permitted: Permitted::Named,
            meanings: &BAUD_RATES.meanings(),
            ..stored(Parameter::new(id::BAUD, "Baud rate", DataType::U8))
        },
        byte(id::BOI, "Bus-off interrupt", 0, 1, 0),
        byte(id::POLLED, "Polled assembly", 101, 103, 103),
        byte(id::CYCLIC, "Cyclic assembly", 101, 103, 103),
        byte(id::DELTA, "COS delta", 0, 200, 0),
        stored(Parameter::new(id::NUMBER, "Number", DataType::U16).within(0, 1000, 10)),
        stored(Parameter::new(id::SIGNED, "Signed", DataType::I16).within(-100, 100, -3)),
        Parameter {
            persistence: Persistence::Volatile,
            ..Parameter::new(id::VOLATILE, "Volatile", DataType::U8)
        },
        stored(Parameter::new(id::HIDDEN, "Hidden", DataType::U16)),
    ];
    plumbline::project!(parameters);
}

pub struct Force(Published<3>);

impl Application for Force {
    type Table = Level;
    type Values = Published<3>;
    const QUANTITIES: &'static [Quantity] = &[
        Quantity::new(X, "X", DataType::I16),
        Quantity::new(Y, "Y", DataType::I16),
        Quantity::new(FINE, "Fine X", DataType::I32),
    ];
    const INITIAL: Self = Self(Published::INITIAL);
    fn start(&mut self, _: Calibration) {}
    fn apply(&mut self, _: Instant, _: &Parameters<Level>) -> Published<3> {
        self.0
    }
    fn sample(&mut self, _: Instant, reading: &Reading) -> Published<3> {
        let scaled =
            |force: i32, unit: i64| (i64::from(force) * unit).div_euclid(i64::from(ONE_G)) as i32;
        let force = reading.acceleration;
        let [x, y] = [force.x, force.y].map(|force| scaled(force, 1000));
        self.0 = Published::new([x, y, scaled(force.x, 1_000_000)], Faults::NONE);
        self.0
    }
    fn stale(&mut self) -> Published<3> {
        Published::new(self.0.numbers, Faults::SENSOR)
    }
    fn write(
        id: ParameterId,
        value: u32,
        _: &Published<3>,
        parameters: &mut Parameters<Level>,
    ) -> Result<Effect, Refused> {
        if id == id::SIGNED && value == CONFLICT {
            return Err(Refused::State);
        }
        parameters.set(id, value);
        Ok(Effect::None)
    }
}

const fn attribute(number: u8, source: Source, settable: bool) -> Attribute {
    Attribute {
        settable,
        ..Attribute::new(number, "attribute", source)
    }
}

const fn setting(number: u8, id: ParameterId) -> Attribute {
    attribute(number, Source::Parameter(id), true)
}

const ATTRIBUTES: &[Attribute] = &[
    attribute(
        0x01,
        Source::Constant(DataType::U16, ATTRIBUTE_COUNT),
        false,
    ),
    setting(0x71, id::NUMBER),
    attribute(0x72, Source::Value(X), false),
    setting(0x73, id::SIGNED),
    setting(0x75, id::VOLATILE),
    attribute(0x76, Source::Parameter(id::HIDDEN), false),
    attribute(0x78, Source::Value(FINE), false),
    attribute(0x7A, Source::Value(Y), false),
    setting(0x81, id::POLLED),
    setting(0x82, id::CYCLIC),
    setting(0x88, id::DELTA),
];

const ATTRIBUTE_COUNT: u32 = 11;

impl Product for Level {
    type Application = Force;
    const IDENTITY: Identity = Identity {
        vendor: 354,
        vendor_name: "FRABA Posital GmbH",
        device_type: 0,
        device_type_name: "Generic Device",
        product_code: 7,
        revision: (1, 2),
        name: "INCLINOMETER 080 degree",
        catalog: "LEVEL",
    };
    const ROLES: Roles = Roles {
        mac_id: id::MAC,
        baud_rate: id::BAUD,
        bit_rates: &BAUD_RATES.sequence(),
        bus_off_interrupt: id::BOI,
        polled_assembly: id::POLLED,
        cyclic_assembly: id::CYCLIC,
        cos_delta: id::DELTA,
    };
    const OBJECTS: &'static [Object] = &[
        Object {
            revision: 3,
            ..Object::new(0x65, "Force", ATTRIBUTES)
        },
        Object::new(
            0x66,
            "Own",
            &[
                attribute(1, Source::Own(DataType::U8), true),
                attribute(2, Source::Own(DataType::I16), false),
            ],
        ),
    ];
    const OWN: &'static [Own<Force>] = &[
        Own {
            class: 0x66,
            attribute: 1,
            read: |node| node.parameters.get(id::NUMBER) / 10,
            write: set_tens,
        },
        Own::read_only(0x66, 2, |node| node.values.number(X) + 1),
    ];
    const ASSEMBLIES: &'static [Assembly] = &[
        Assembly::new(101, "X", &[X]),
        Assembly::new(102, "Y", &[Y]),
        Assembly::new(103, "X and Y", &[X, Y]),
    ];
    const IMAGE: ImageId = ImageId::new(0x7003);
    plumbline::project!(attributes);

    fn distance(_: &Parameters<Level>, one: u16, other: u16) -> u16 {
        (one as i16).abs_diff(other as i16)
    }
}

/// Sets the parameter of 71h, in tens.
fn set_tens(node: &mut Context<Force>, tens: u32) -> Result<(), Refused> {
    node.write(id::NUMBER, tens * 10).map(drop)
}

/// A DeviceNet node under test.
pub type LevelTester = Tester<DevicenetNode<Level>>;

/// The MAC ID of the examples, as a stored image.
pub const MAC_3: &[u8] = &[3];

/// A node after power-up with these contents of the memory. Its first request of the duplicate MAC ID check is not sent yet.
pub fn power_up(memory: Option<&[u8]>) -> LevelTester {
    let loaded = Boot {
        parameters: memory,
        ..Boot::default()
    };
    Tester::power_up(loaded, DevicenetNode::<Level>::new)
}

/// The node with the MAC ID 3, on-line, with X = 1.234 g and Y = -0.567 g.
pub fn online() -> LevelTester {
    online_with(MAC_3)
}

/// The same with these contents of the memory.
pub fn online_with(memory: &[u8]) -> LevelTester {
    let mut tester = power_up(Some(memory));
    let sent = tester.wait_text(2001);
    assert_eq!(sent.len(), 2, "two requests: {sent:?}");
    tester.force_milli(1234, -567);
    tester
}

/// The node with an explicit connection and these choices of the master 0Ah.
pub fn allocated(choice: u8) -> LevelTester {
    let mut tester = online();
    tester.allocate(choice | 1);
    tester
}

/// Allocates these choices, sends requests and compares the bodies of the responses, without and with XID.
pub fn compare(choice: u8, messages: &[(&str, &str)]) {
    let mut tester = allocated(choice);
    for (request, response) in messages {
        assert_eq!(tester.explicit(request), *response, "{request}");
        let with_xid = tester.exchange(&format!("41C#4A{request}"));
        assert_eq!(with_xid, [format!("41B#4A{response}")], "{request}");
    }
}

/// Sends requests of the master, on the port or on the explicit connection. Each has one response, or none.
#[track_caller]
pub fn run(tester: &mut LevelTester, steps: &[(&str, &str)]) {
    for (request, response) in steps {
        let sent = tester.exchange(request);
        let expected: &[&str] = if response.is_empty() {
            &[]
        } else {
            &[response]
        };
        assert_eq!(sent, expected, "{request}");
    }
}

impl LevelTester {
    /// Hands in a sample of this specific force in 0.001 g.
    pub fn force_milli(&mut self, x: i32, y: i32) {
        let in_units = |milli: i32| {
            let units = i64::from(milli) * i64::from(ONE_G);
            units.div_euclid(1000) as i32 + 1
        };
        self.hold([in_units(x), in_units(y), 0], 1);
    }

    /// Another node acknowledges the pending frame.
    pub fn acknowledge(&mut self) {
        self.node.sent(self.now);
        self.settle();
    }

    /// Allocates these choices for the master 0Ah.
    pub fn allocate(&mut self, choice: u8) {
        let request = format!("41E#0A4B0301{choice:02X}0A");
        assert_eq!(self.exchange(&request), ["41B#0ACB00"]);
    }

    /// Sends the body of a request of the master 0Ah on the explicit connection. Returns the body of the single response.
    pub fn explicit(&mut self, body: &str) -> String {
        let sent = self.exchange(&format!("41C#0A{body}"));
        assert_eq!(sent.len(), 1, "{body} -> {sent:?}");
        let response = sent[0].strip_prefix("41B#0A");
        response
            .unwrap_or_else(|| panic!("{body} -> {sent:?}"))
            .to_string()
    }

    /// Hands a frame in and sends nothing yet: the driver is still busy.
    pub fn node_receives(&mut self, text: &str) {
        self.node.receive(self.now, &frame(text));
    }

    /// Sets the expected packet rate of a connection in ms.
    pub fn set_rate(&mut self, instance: u8, rate: u16) {
        let rate = rate.swap_bytes();
        let response = self.explicit(&format!("1005{instance:02X}09{rate:04X}"));
        assert_eq!(response, format!("90{rate:04X}"));
    }

    /// Sends a frame that must not be answered.
    pub fn ignores(&mut self, text: &str) {
        let frame = frame(text);
        self.receive(frame);
        assert_eq!(self.sent_text(), [""; 0], "{text}");
    }

    /// Whether a connection set is allocated, asked on the unconnected port as another master.
    pub fn owner(&mut self) -> bool {
        let sent = self.exchange("41E#3E4C030101");
        match &sent[..] {
            [one] if one == "41B#3E940C01" => true,
            [one] if one == "41B#3E940B02" => false,
            _ => panic!("{sent:?}"),
        }
    }
}
