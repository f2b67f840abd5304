//! A J1939 sensor of your own, outside of Plumbline: one slope in a group of its own (Proprietary B, FF20h) with a status, and two commands
//! in Proprietary A. Run it with `cargo run -p core --example new_j1939_sensor`.
//!
//! | Proprietary A (EF00h)  | answer     | meaning                                              |
//! |------------------------|------------|------------------------------------------------------|
//! | 01 low high            | 01 result  | sets the mounting angle in 0.01 deg                  |
//! | 02                     | 02 result  | stores the parameters; the answer comes after it     |
//!
//! result: 0 done, 1 refused or failed.

use plumbline::j1939::diagnostics::Trouble;
use plumbline::j1939::signal::{self, Contents, Field, Group, Signal};
use plumbline::j1939::{Conditions, J1939Node, Product, Sent, Timer, name};
use plumbline::model::listing::{self, Article, Guide};
use plumbline::node::Context;
use plumbline::param::Setting;
use plumbline::prelude::*;

plumbline::ids! { ParameterId: ADDRESS, RATE, MOUNTING }
plumbline::ids! { ValueId: SLOPE }

/// The group with the slope.
const PGN: u32 = 0xFF20;

/// The tables of the product.
pub struct Mast;
impl Table for Mast {
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::new(ADDRESS, "Preferred address", DataType::U8).within(0, 253, 0x90),
        Parameter::new(RATE, "Transmission rate", DataType::U16).within(0, 1000, 100),
        Parameter::new(MOUNTING, "Mounting angle", DataType::I16)
            .in_unit("deg", 2)
            .within(-90_00, 90_00, 0),
    ];
    plumbline::project!(parameters);
}

/// Calibration and low-pass, the mounting angle in 0.01 deg, the last values.
pub struct Slope(Inclinometer, i32, Published<1>);
impl Application for Slope {
    type Table = Mast;
    type Values = Published<1>;
    const QUANTITIES: &'static [Quantity] =
        &[Quantity::new(SLOPE, "Slope", DataType::I16).in_unit("deg", 2)];
    const INITIAL: Self = Self(Inclinometer::INITIAL, 0, Published::INITIAL);
    fn start(&mut self, calibration: Calibration) {
        self.0.calibration = calibration;
    }
    fn apply(&mut self, _: Instant, parameters: &Parameters<Mast>) -> Published<1> {
        self.1 = i32::from(parameters.get(MOUNTING) as i16);
        self.2
    }
    fn sample(&mut self, _: Instant, reading: &Reading) -> Published<1> {
        let angles = definition::perpendicular(self.0.sample(reading));
        self.2 = Published::new([angles.x.centidegrees() - self.1], Faults::NONE);
        self.2
    }
    fn stale(&mut self) -> Published<1> {
        self.2 = Published::new(self.2.numbers, Faults::SENSOR);
        self.2
    }
}

/// The description of the group.
const SLOPE_GROUP: Group = Group::new(
    "SLOPE",
    PGN,
    &[
        Signal::new(
            "Slope",
            520_193,
            0,
            16,
            Contents::Own {
                resolution: (1, 100),
                offset: -300,
                unit: "deg",
            },
        ),
        Signal::new(
            "SlopeStatus",
            520_194,
            16,
            2,
            Contents::Own {
                resolution: (1, 1),
                offset: 0,
                unit: "",
            },
        ),
    ],
);

static FIELDS: [Field; 2] = signal::fields(SLOPE_GROUP.signals);

/// The data of the group: a slope that is not measured is not available.
fn group(node: &Context<Slope>) -> [u8; 8] {
    let defective = node.values.faults().intersects(Faults::SENSOR);
    let [slope] = node.values.numbers;
    let numbers = [(!defective).then_some(slope), Some(defective.into())];
    signal::data(&FIELDS, numbers)
}

impl Product for Mast {
    type Application = Slope;
    type Timers = [Timer; 1];
    const SENT: &'static [Sent<Slope>] = &[Sent {
        pgn: PGN,
        rate: Setting::Parameter(RATE),
        priority: Setting::Constant(3),
        data: group,
    }];
    const GROUPS: &'static [Group] = &[SLOPE_GROUP];
    const ADDRESS: ParameterId = ADDRESS;
    // Arbitrary address capable, industry group, vehicle system instance, vehicle system, function, function instance, ECU instance,
    // manufacturer code.
    const NAME: [Setting; 8] = name::constants([1, 0, 0, 0, 145, 0, 0, 2047]);
    const MAKE: &'static str = "Example Works";
    const MODEL: &'static str = "MAST";
    const VERSION: &'static str = "1.0";
    const TYPE: &'static str = "Slope";
    const TROUBLES: &'static [Trouble] = &[Trouble::new(520_193, 12)];
    const IMAGE: ImageId = ImageId::new(0x7012);
    plumbline::project!(groups);

    fn active(node: &Context<Slope>, _: Conditions) -> u16 {
        u16::from(node.values.faults().intersects(Faults::SENSOR))
    }

    fn proprietary(node: &mut Context<Slope>, message: [u8; 8]) -> Option<[u8; 8]> {
        match message {
            [1, low, high, ..] => {
                let written = node.write(MOUNTING, u16::from_le_bytes([low, high]).into());
                node.apply();
                Some(answer(1, written.is_ok()))
            }
            [2, ..] if node.is_saving() => Some(answer(2, false)),
            [2, ..] => {
                node.save(node.parameters);
                None
            }
            _ => None,
        }
    }

    fn stored(_: &mut Context<Slope>, succeeded: bool) -> Option<[u8; 8]> {
        Some(answer(2, succeeded))
    }
}

fn answer(command: u8, done: bool) -> [u8; 8] {
    let failed = u8::from(!done);
    [command, failed, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF]
}

/// The product as data, for programs on a PC.
pub const LISTING: listing::Product = listing::Product::j1939::<Mast>(
    "mast",
    "Example Works",
    Article {
        name: "MAST",
        number: "0001",
    },
)
.sold_by("Example Works")
.guided(&Guide {
    angles: &[SLOPE],
    ..Guide::NONE
});

/// The sensor.
pub type Sensor = J1939Node<Mast>;

/// Prints the frames of half a second.
pub fn main() {
    use plumbline::can::extended;
    use plumbline::time::{after, millis};
    let mut sensor = Sensor::new(Instant::from_ticks(0), &Boot::default());
    // From 21h to the address 90h: mounting angle -5.00 deg. Then a request for the group.
    let mounting = (
        0x18EF_9021,
        &[1, 0x0C, 0xFE, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF][..],
    );
    let request = (0x18EA_9021, &[0x20, 0xFF, 0x00][..]);
    for period in 0..100 {
        let now = after(Instant::from_ticks(0), millis(5 * period));
        sensor.sample(now, &Reading::default());
        if let 80 | 90 = period {
            let (id, data) = if period == 80 { mounting } else { request };
            sensor.receive(now, &Frame::data(extended(id), data).expect("a frame"));
        }
        while sensor.poll(now).is_some() {}
        while let Some(frame) = sensor.transmit(now) {
            println!("{frame:?}");
            sensor.sent(now);
        }
    }
}
