//! A product with J1939 only, without mistakes. The tests replace one text of this file and compile it.

use plumbline::j1939::diagnostics::Trouble;
use plumbline::j1939::signal::{Contents, Group, Signal, Source};
use plumbline::j1939::{Product, Sent, Timer};
use plumbline::param::Setting;
use plumbline::prelude::*;

include!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/tests/wire/stranger/idle.rs"
));

plumbline::ids! { pub ParameterId: ADDRESS, RATE, PRIORITY, MANUFACTURER }
plumbline::ids! { pub ValueId: SLOPE }

pub struct Mast;

impl Table for Mast {
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::new(ADDRESS, "Address", DataType::U8).within(0, 253, 0x90),
        Parameter::new(RATE, "Rate", DataType::U16).within(0, 1000, 100),
        Parameter::new(PRIORITY, "Priority", DataType::U8).within(0, 7, 3),
        Parameter::new(MANUFACTURER, "Manufacturer", DataType::U16).within(0, 2047, 2047),
    ];
    plumbline::project!(parameters);
}

pub struct Slope;

impl Application for Slope {
    type Table = Mast;
    type Values = Published<1>;
    const QUANTITIES: &'static [Quantity] = &[Quantity::new(SLOPE, "Slope", DataType::I16)];
    const INITIAL: Self = Self;

    idle!();
}

const fn sent(pgn: u32, rate: Setting) -> Sent<Slope> {
    Sent {
        pgn,
        rate,
        priority: Setting::Parameter(PRIORITY),
        data: |_| [0xFF; 8],
    }
}

const PITCH: Contents = Contents::Value {
    source: Source::Pitch,
    resolution: (1, 500),
    offset: -64,
    unit: "deg",
};

const ANGLE: &[Signal] = &[
    Signal::new("Slope", 3318, 0, 16, PITCH),
    Signal::new("Quality", 3323, 48, 2, Contents::Merit(Source::Pitch)),
];

const AGE: &[Signal] = &[Signal::new("Latency", 3327, 56, 8, Contents::Latency)];

impl Product for Mast {
    type Application = Slope;
    type Timers = [Timer; 2];
    const SENT: &'static [Sent<Slope>] = &[
        sent(0xFF20, Setting::Parameter(RATE)),
        sent(0xFF21, Setting::Constant(1000)),
    ];
    const GROUPS: &'static [Group] = &[
        Group::new("SLOPE", 0xFF20, ANGLE),
        Group::new("AGE", 0xFF21, AGE),
    ];
    const ADDRESS: ParameterId = ADDRESS;
    const NAME: [Setting; 8] = [
        Setting::Constant(1),
        Setting::Constant(2),
        Setting::Constant(0),
        Setting::Constant(127),
        Setting::Constant(145),
        Setting::Constant(0),
        Setting::Constant(0),
        Setting::Parameter(MANUFACTURER),
    ];
    const MAKE: &'static str = "Own";
    const MODEL: &'static str = "Mast";
    const VERSION: &'static str = "1.0";
    const TYPE: &'static str = "Slope";
    const TROUBLES: &'static [Trouble] = &[
        Trouble::new(3318, 12),
        Trouble::new(639, 2),
    ];
    const IMAGE: ImageId = ImageId::new(0x7006);
    plumbline::project!(groups);
}
