//! The DeviceNet objects of the TILTIX: the angle object (class 65h) and the input assemblies (manual 5.1).

use super::application::value;
use super::parameters::{BIT_RATES, IN_RESOLUTION, SCALING, id};
use crate::application::Application;
use crate::devicenet::{Assembly, Attribute, Identity, Object, Roles, Source};
use crate::model::listing::{Adjustment, Guide, Offset, Resolution, Switch, Written};
use crate::param::{DataType, ParameterId, Table, ValueId};
use crate::walk::at;

/// The number of attributes of the angle object.
const COUNT: usize = 22;

/// The parameters that the protocol uses.
pub(super) const ROLES: Roles = Roles {
    mac_id: id::MAC_ID,
    baud_rate: id::BAUD_RATE,
    bit_rates: &BIT_RATES,
    bus_off_interrupt: id::BUS_OFF_INTERRUPT,
    polled_assembly: id::POLLED_ASSEMBLY,
    cyclic_assembly: id::CYCLIC_ASSEMBLY,
    cos_delta: id::COS_DELTA,
};

/// The input assemblies: the longitudinal slope, the lateral one, and both.
pub(super) const ASSEMBLIES: &[Assembly] = &[
    Assembly::new(101, "Slope long16", &[value::SLOPE[0]]),
    Assembly::new(102, "Slope lateral16", &[value::SLOPE[1]]),
    Assembly::new(103, "Slope long16, slope lateral16", &value::SLOPE),
];

/// The identity of a model.
pub(super) const fn identity(
    product_code: u16,
    name: &'static str,
    catalog: &'static str,
) -> Identity {
    Identity {
        vendor: 354,
        vendor_name: super::MAKER,
        device_type: 0,
        device_type_name: "Generic Device",
        product_code,
        revision: (1, 1),
        name,
        catalog,
    }
}

/// The object of the angles (class 65h) with these attributes.
#[track_caller]
pub(super) const fn angle(attributes: &'static [Attribute]) -> Object {
    Object::new(0x65, "Angle", attributes)
}

/// A parameter; its name is that of the table.
#[track_caller]
const fn parameter<A: Application>(
    number: u8,
    ParameterId(id): ParameterId,
    help: &'static str,
) -> Attribute {
    Attribute::new(
        number,
        at(A::Table::PARAMETERS, id as usize).name,
        Source::Parameter(ParameterId(id)),
    )
    .with_help(help)
    .settable()
}

/// A published value; its name is that of the quantity.
#[track_caller]
const fn published<A: Application>(
    number: u8,
    ValueId(id): ValueId,
    help: &'static str,
) -> Attribute {
    Attribute::new(
        number,
        at(A::QUANTITIES, id as usize).name,
        Source::Value(ValueId(id)),
    )
    .with_help(help)
}

/// The help text of a number whose unit is the resolution.
const UNIT: &str = "In units of the resolution";

/// The seven attributes of an axis, from the slope to the diagnostic slope.
#[track_caller]
const fn axis<A: Application>(first: u8, axis: usize) -> [Attribute; 7] {
    [
        published::<A>(first, *at(&value::SLOPE, axis), UNIT),
        parameter::<A>(
            first + 1,
            *at(&id::OPERATING, axis),
            "Scaling adds the offset and the differential offset",
        ),
        parameter::<A>(first + 2, *at(&id::PRESET, axis), UNIT),
        parameter::<A>(
            first + 3,
            *at(&id::PRESET_ENABLE, axis),
            "Stored; the change from 0 to 1 sets the offset",
        ),
        Attribute {
            settable: false,
            ..parameter::<A>(first + 4, *at(&id::OFFSET, axis), UNIT)
        },
        parameter::<A>(first + 5, *at(&id::DIFFERENTIAL, axis), UNIT),
        published::<A>(first + 6, *at(&value::DIAGNOSTIC, axis), ""),
    ]
}

/// The attributes of the angle object.
#[track_caller]
pub(super) const fn attributes<A: Application>() -> [Attribute; COUNT] {
    let [x0, x1, x2, x3, x4, x5, x6] = axis::<A>(0x72, 0);
    let [y0, y1, y2, y3, y4, y5, y6] = axis::<A>(0x7A, 1);
    [
        Attribute::new(
            1,
            "Number of attributes",
            Source::Constant(DataType::U16, COUNT as u32),
        ),
        parameter::<A>(
            0x71,
            id::RESOLUTION,
            "A change converts all numbers with this unit",
        ),
        x0,
        x1,
        x2,
        x3,
        x4,
        x5,
        x6,
        y0,
        y1,
        y2,
        y3,
        y4,
        y5,
        y6,
        parameter::<A>(
            0x81,
            id::POLLED_ASSEMBLY,
            "Not while a polled connection exists",
        ),
        parameter::<A>(
            0x82,
            id::CYCLIC_ASSEMBLY,
            "Not while a cyclic or COS connection exists",
        ),
        parameter::<A>(0x84, id::SIZE, "0: off"),
        parameter::<A>(0x85, id::WEIGHT, "In 1/1000; 0: off"),
        parameter::<A>(0x87, id::TERMINATION, ""),
        parameter::<A>(
            0x88,
            id::COS_DELTA,
            "In units of the resolution, at most 2 deg; 0: each change",
        ),
    ]
}

/// The preset value 0 becomes the present angle. Preset enable acts when it changes from 0 to 1. The offset acts only with scaling, which
/// is last: if the sensor refuses the preset, the angle stays as it is.
const fn zero(axis: usize) -> [(ParameterId, Written); 5] {
    [
        (*at(&id::PRESET, axis), Written::Number(0)),
        (*at(&id::PRESET_ENABLE, axis), Written::Number(0)),
        (*at(&id::PRESET_ENABLE, axis), Written::Number(1)),
        (*at(&id::PRESET_ENABLE, axis), Written::Number(0)),
        (*at(&id::OPERATING, axis), Written::Bits(SCALING)),
    ]
}

/// The preset changes the first offset of an angle, so a tool changes the second one, the differential offset.
const fn offset(axis: usize) -> Offset {
    Offset {
        angle: *at(&value::SLOPE, axis),
        parameter: *at(&id::DIFFERENTIAL, axis),
        switch: Some(Switch {
            other: *at(&id::OFFSET, axis),
            parameter: *at(&id::OPERATING, axis),
            bits: SCALING,
        }),
    }
}

const ZERO_X: Adjustment = Adjustment::new("x", &zero(0)).with_offset(offset(0));
const ZERO_Y: Adjustment = Adjustment::new("y", &zero(1)).with_offset(offset(1));

const fn guide(angles: &'static [ValueId], zero: &'static [Adjustment]) -> Guide {
    Guide {
        angles,
        resolution: Some(Resolution {
            parameter: id::RESOLUTION,
            parameters: &IN_RESOLUTION,
            values: &value::SLOPE,
        }),
        zero,
        ..Guide::NONE
    }
}

/// The guide of a product with one axis, for tools.
pub(super) const GUIDE_ONE_AXIS: Guide = guide(&[value::SLOPE[0]], &[ZERO_X]);

/// The guide of a product with two axes, for tools.
pub(super) const GUIDE_TWO_AXES: Guide = guide(&value::SLOPE, &[ZERO_X, ZERO_Y]);
