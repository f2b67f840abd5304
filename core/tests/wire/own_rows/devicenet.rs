//! DeviceNet: a product with attributes of its own: the number of writes, and a parameter in another unit.

use crate::tester::Tester;
use plumbline::can::BitRate;
use plumbline::devicenet::{
    Assembly, Attribute, DevicenetNode, Identity, Object, Own, Product, Roles, Source,
};
use plumbline::node::{Boot, Context};
use plumbline::param::{Coding, Persistence, Refused};
use plumbline::prelude::*;

const VALUE: ValueId = ValueId(0);

mod id {
    use plumbline::param::ParameterId;

    pub const MAC: ParameterId = ParameterId(0);
    pub const BAUD: ParameterId = ParameterId(1);
    pub const BOI: ParameterId = ParameterId(2);
    pub const POLLED: ParameterId = ParameterId(3);
    pub const CYCLIC: ParameterId = ParameterId(4);
    pub const DELTA: ParameterId = ParameterId(5);
    /// A length in mm.
    pub const LENGTH: ParameterId = ParameterId(6);
}

const RATES: Coding<BitRate, 1> = Coding([(0, "125 kbit/s", BitRate::K125)]);

struct Rod;

const fn byte(id: ParameterId, low: i64, high: i64, factory: i32) -> Parameter {
    Parameter {
        persistence: Persistence::AtOnce,
        ..Parameter::new(id, "byte", DataType::U8).within(low, high, factory)
    }
}

impl Table for Rod {
    const PARAMETERS: &'static [Parameter] = &[
        byte(id::MAC, 0, 63, 3),
        byte(id::BAUD, 0, 0, 0),
        byte(id::BOI, 0, 1, 0),
        byte(id::POLLED, 101, 101, 101),
        byte(id::CYCLIC, 101, 101, 101),
        byte(id::DELTA, 0, 200, 0),
        Parameter {
            persistence: Persistence::AtOnce,
            ..Parameter::new(id::LENGTH, "Length", DataType::U16).within(0, 1000, 120)
        },
    ];
    plumbline::project!(parameters);
}

struct Level;

const VALUES: Published<1> = Published::new([7], Faults::NONE);

impl Application for Level {
    type Table = Rod;
    type Values = Published<1>;
    const QUANTITIES: &'static [Quantity] = &[Quantity::new(VALUE, "Value", DataType::I16)];
    const INITIAL: Self = Self;
    fn start(&mut self, _: Calibration) {}
    fn apply(&mut self, _: Instant, _: &Parameters<Rod>) -> Published<1> {
        VALUES
    }
    fn sample(&mut self, _: Instant, _: &Reading) -> Published<1> {
        VALUES
    }
    fn stale(&mut self) -> Published<1> {
        VALUES
    }
}

const fn attribute(number: u8, settable: bool) -> Attribute {
    Attribute {
        number,
        name: "own",
        help: "",
        source: Source::Own(DataType::U8),
        settable,
    }
}

impl Product for Rod {
    type Application = Level;
    const IDENTITY: Identity = Identity {
        vendor: 354,
        vendor_name: "Own",
        device_type: 0,
        device_type_name: "Generic Device",
        product_code: 7,
        revision: (1, 2),
        name: "A ROD OF ITS OWN",
        catalog: "ROD",
    };
    const ROLES: Roles = Roles {
        mac_id: id::MAC,
        baud_rate: id::BAUD,
        bit_rates: &RATES.sequence(),
        bus_off_interrupt: id::BOI,
        polled_assembly: id::POLLED,
        cyclic_assembly: id::CYCLIC,
        cos_delta: id::DELTA,
    };
    const OBJECTS: &'static [Object] = &[Object {
        class: 0x64,
        name: "Rod",
        revision: 1,
        attributes: &[attribute(1, true), attribute(2, false)],
    }];
    const OWN: &'static [Own<Level>] = &[
        Own {
            class: 0x64,
            attribute: 1,
            read: |node| node.parameters.get(id::LENGTH) / 10,
            write: set_centimetres,
        },
        Own::read_only(0x64, 2, |node| node.values.number(VALUE) + 1),
    ];
    const ASSEMBLIES: &'static [Assembly] = &[Assembly {
        instance: 101,
        name: "Value",
        words: &[VALUE],
    }];
    const IMAGE: ImageId = ImageId::new(0x7007);
    plumbline::project!(attributes);

    fn distance(_: &Parameters<Rod>, one: u16, other: u16) -> u16 {
        one.abs_diff(other)
    }
}

/// Sets the length in cm.
fn set_centimetres(node: &mut Context<Level>, number: u32) -> Result<(), Refused> {
    node.write(id::LENGTH, number * 10).map(drop)
}

#[test]
fn own_attribute_is_read_written_and_stored_by_its_functions() {
    let mut tester = Tester::power_up(Boot::default(), DevicenetNode::<Rod>::new);
    tester.wait(2001);
    for (request, response) in [
        ("41E#0A4B0301010A", "41B#0ACB00"),
        ("41C#0A0E640101", "41B#0A8E0C"),
        ("41C#0A0E640102", "41B#0A8E08"),
        // 250 mm, and more than the length can have.
        ("41C#0A1064010119", "41B#0A90"),
        ("41C#0A0E640101", "41B#0A8E19"),
        ("41C#0A1064010165", "41B#0A9409FF"),
        ("41C#0A0E640101", "41B#0A8E19"),
        ("41C#0A1064010219", "41B#0A940EFF"),
    ] {
        assert_eq!(tester.exchange(request), [response], "{request}");
    }
    tester.wait(400);
    assert_eq!(
        tester.memory.as_deref(),
        Some(&[3, 0, 0, 101, 101, 0, 250, 0][..])
    );
}
