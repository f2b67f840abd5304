//! The IMS360 in J1939: its process data and diagnostic trouble codes.
//!
//! The manufacturer's J1939 manual is not public. Pitch is the longitudinal angle (6110h), roll the lateral one (6120h), both with their
//! zero offsets. Signs are those of the objects.

use super::Ims360Product;
use super::application::{Ims360Application, SUPPLY, value};
use super::objects::OBJECTS;
use super::parameters::{self, FILTER_KINDS, has_two_axes, id};
use super::range::Beyond;
use crate::angle::Angle;
use crate::application::{Faults, Values};
use crate::canopen;
use crate::canopen::dictionary::text_at;
use crate::j1939::diagnostics::Trouble;
use crate::j1939::groups::{self, GROUPS};
use crate::j1939::signal::{Group, Measured, Merit, Motion};
use crate::j1939::{self, Conditions, Sent, Timer};
use crate::measure::low_pass::Kind;
use crate::measure::{PATH_DELAY, fusion};
use crate::node::Context;
use crate::param::{ParameterId, Parameters, Setting, ValueId, meaning};
use crate::store::ImageId;
use crate::walk::{at, each};

/// One degree in the unit of [`Motion`].
const DEGREE: i64 = 32_768;

/// The longest latency that can be sent, in us.
const LONGEST: u32 = 125_000;

/// Failure modes: above and below the range, voltage above and below normal, data erratic, out of calibration or defective.
const ABOVE: u8 = 0;
const BELOW: u8 = 1;
const ERRATIC: u8 = 2;
const VOLTAGE_ABOVE: u8 = 3;
const VOLTAGE_BELOW: u8 = 4;
const DEFECTIVE: u8 = 12;

/// The suspect parameter numbers of the trouble codes.
const PITCH: u32 = groups::PITCH_SPN;
const ROLL: u32 = groups::ROLL_SPN;
const BATTERY: u32 = 168;
const MEMORY: u32 = 630;
const NETWORK: u32 = 639;

/// The trouble codes, from bit 0 on.
const TROUBLES: [Trouble; 12] = [
    Trouble::new(PITCH, ABOVE),
    Trouble::new(PITCH, BELOW),
    Trouble::new(PITCH, ERRATIC),
    Trouble::new(ROLL, ABOVE),
    Trouble::new(ROLL, BELOW),
    Trouble::new(ROLL, ERRATIC),
    Trouble::new(PITCH, DEFECTIVE),
    Trouble::new(ROLL, DEFECTIVE),
    Trouble::new(BATTERY, VOLTAGE_ABOVE),
    Trouble::new(BATTERY, VOLTAGE_BELOW),
    Trouble::new(MEMORY, DEFECTIVE),
    Trouble::new(NETWORK, ERRATIC),
];

/// The bit of a trouble code.
const fn bit(spn: u32, fmi: u8) -> u16 {
    let mut bit = 0;
    each!(place, Trouble { code, .. } in &TROUBLES => {
        if code.spn == spn && code.fmi == fmi {
            bit = 1 << place;
        }
    });
    assert!(bit != 0, "the table has no such trouble code");
    bit
}

type Node = Context<Ims360Application>;

/// A group with this data, at the rate and with the priority of its parameters.
const fn sent(place: usize, data: fn(&Node) -> [u8; 8]) -> Sent<Ims360Application> {
    Sent {
        pgn: at(&GROUPS, place).pgn,
        rate: Setting::Parameter(*at(&id::J1939_RATES, place)),
        priority: Setting::Parameter(*at(&id::J1939_PRIORITIES, place)),
        data,
    }
}

const NAME: [Setting; 8] = {
    let [a, b, c, d, e, f, g, h] = id::J1939_NAME;
    [
        Setting::Parameter(a),
        Setting::Parameter(b),
        Setting::Parameter(c),
        Setting::Parameter(d),
        Setting::Parameter(e),
        Setting::Parameter(f),
        Setting::Parameter(g),
        Setting::Parameter(h),
    ]
};

impl j1939::Product for Ims360Product {
    type Application = Ims360Application;
    type Timers = [Timer; 4];

    const SENT: &'static [Sent<Ims360Application>] = &[
        sent(0, |node| groups::ssi2(&motion(node))),
        sent(1, |node| groups::ssi(&motion(node))),
        sent(2, |node| groups::ari(&motion(node))),
        sent(3, |node| groups::accs(&motion(node))),
    ];
    const GROUPS: &'static [Group] = &GROUPS;
    const ADDRESS: ParameterId = id::J1939_ADDRESS;
    const NAME: [Setting; 8] = NAME;
    const MAKE: &'static str = "Plumbline";
    const MODEL: &'static str = text_at(OBJECTS, 0x1008, 0);
    const VERSION: &'static str = text_at(OBJECTS, 0x100A, 0);
    const TYPE: &'static str = "Inclinometer";
    const TROUBLES: &'static [Trouble] = &TROUBLES;
    const IMAGE: ImageId = <Self as canopen::Product>::IMAGE;
    crate::project!(groups);

    fn recovers(parameters: &Parameters<Self>) -> bool {
        parameters::recovers(parameters)
    }

    fn active(node: &Node, conditions: Conditions) -> u16 {
        let values = &node.values;
        let faults = values.faults();
        let flag = |set: bool, bit: u16| if set { bit } else { 0 };
        let has = |fault: Faults| faults.intersects(fault);
        let [beyond_x, beyond_y] = values.beyond();
        let angle = |beyond: Beyond, [above, below, clips]: [u16; 3]| match beyond {
            Beyond::No => 0,
            Beyond::Above => above,
            Beyond::Below => below,
            Beyond::Clips => clips,
        };
        let pitch = const { [bit(PITCH, ABOVE), bit(PITCH, BELOW), bit(PITCH, ERRATIC)] };
        let roll = const { [bit(ROLL, ABOVE), bit(ROLL, BELOW), bit(ROLL, ERRATIC)] };
        let voltage = values.number(value::SUPPLY);
        let supply = if voltage > SUPPLY.lowest.midpoint(SUPPLY.highest).into() {
            const { bit(BATTERY, VOLTAGE_ABOVE) }
        } else {
            const { bit(BATTERY, VOLTAGE_BELOW) }
        };
        angle(beyond_x, pitch)
            | angle(beyond_y, roll)
            | flag(has(Faults::X_DEFECTIVE), const { bit(PITCH, DEFECTIVE) })
            | flag(has(Faults::Y_DEFECTIVE), const { bit(ROLL, DEFECTIVE) })
            | flag(has(Faults::SUPPLY), supply)
            | flag(conditions.memory, const { bit(MEMORY, DEFECTIVE) })
            | flag(conditions.network, const { bit(NETWORK, ERRATIC) })
    }
}

/// The values of the groups.
#[inline(never)] // once in the image, for four groups
fn motion(node: &Node) -> Motion {
    let (values, parameters) = (&node.values, &node.parameters);
    let faults = values.faults();
    let two_axes = has_two_axes(parameters);
    // Without a sample in the time in which one must come, no value is available, and no range can be exceeded.
    let (fine, [range_x, range_y], usual) = match values.fine() {
        Some(fine) => (fine, [Faults::X, Faults::Y], Merit::Good),
        None => (Default::default(), [Faults::NONE; 2], Merit::Unavailable),
    };
    let defective = Faults::X_DEFECTIVE.and(Faults::Y_DEFECTIVE);
    let rest = merit(faults, Faults::NONE, defective, usual);
    let value = |id: ValueId| Measured {
        number: values.number(id) as i32,
        merit: rest,
    };
    let [x, y, z] = value::RATE32.map(value);
    // The pitch of one axis is the rotation about Z; the other two rates are those of the axes that are left.
    let [pitch_rate, roll_rate, yaw_rate] = if two_axes { [y, x, z] } else { [z, x, y] };
    let [force_x, force_y, force_z] = value::FORCE32.map(value);
    let [pitch, roll] = angles(fine, parameters);
    let pitch = Measured {
        number: pitch,
        merit: merit(faults, range_x, Faults::X_DEFECTIVE, usual),
    };
    let roll = if two_axes {
        Measured {
            number: roll,
            merit: merit(faults, range_y, Faults::Y_DEFECTIVE, usual),
        }
    } else {
        Measured::default()
    };
    Motion {
        values: [
            pitch, roll, pitch_rate, roll_rate, yaw_rate, force_x, force_y, force_z,
        ],
        latency: latency(parameters),
    }
}

/// The quality of a value; `usual` without faults.
fn merit(faults: Faults, range: Faults, defective: Faults, usual: Merit) -> Merit {
    if faults.intersects(defective) {
        Merit::Error
    } else if faults.intersects(range) {
        Merit::Degraded
    } else {
        usual
    }
}

/// The angles with their zero offsets in 1/32768 deg; 1-axis from -180 deg on.
fn angles(fine: [Angle; 2], parameters: &Parameters<Ims360Product>) -> [i32; 2] {
    let [x, y] = fine;
    let [offset_x, offset_y] = [id::ZERO_X, id::ZERO_Y].map(|id| parameters.get(id) as i32);
    if has_two_axes(parameters) {
        return [(x, offset_x), (y, offset_y)].map(|(angle, offset)| {
            // The offset is in 0.01 deg. Its part of a degree is rounded to nearest.
            let degrees = i64::from(offset.div_euclid(100));
            let part = (i64::from(offset.rem_euclid(100)) * (2 * DEGREE) + 100) as u32 / 200;
            let sum = scaled(angle) + degrees * DEGREE + i64::from(part);
            sum.clamp(i32::MIN.into(), i32::MAX.into()) as i32
        });
    }
    [scaled(x + Angle::from_centidegrees(offset_x)) as i32, 0]
}

/// An angle from -180 deg on in 1/32768 deg.
fn scaled(Angle(angle): Angle) -> i64 {
    let product = i64::from(angle as i32) * (360 * DEGREE);
    (product + (1 << 31)) >> 32
}

/// The latency of the angles in 0.5 ms.
fn latency(parameters: &Parameters<Ims360Product>) -> u8 {
    let delay = if parameters.get(id::FUSION) != 0 {
        fusion::LAG
    } else {
        let kind = meaning(&FILTER_KINDS, parameters.get(id::FILTER_TYPE)).unwrap_or(Kind::Off);
        PATH_DELAY + kind.delay(parameters.get(id::CUT_OFF) as u16)
    };
    if delay > LONGEST {
        u8::MAX
    } else {
        ((delay + 250) / 500) as u8
    }
}
