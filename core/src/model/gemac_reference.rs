//! GEMAC's reference line: a model with active compensation of the thermal drift (section 9.3), and nothing else changed.

use crate::fsc::table::{Function, LedTable, Parameter, Rule};
use crate::fsc::{Measured, Model, Product};
use crate::heater::Settings;
use crate::measure::I32x3;
use core::marker::PhantomData;

/// The heater of the measuring cell.
///
/// The temperature is to be independent of the operating temperature (section 9.3), which ends at +80 degC (table 1). A heater cannot
/// cool, so the set point lies above that; the accelerometer is specified up to 85 degC. The power is what the peak of 4.8 W
/// (table 1) leaves beside the electronics. In a cell that it makes 150 K warmer, in 90 s, the temperature stands after two minutes
/// from 25 degC and after four from -20 degC, and overshoots by at most 0.2 K.
static HEATER: Settings = Settings {
    set_point: 82_00,
    proportional: 100,
    integral_time: 45,
    derivative_time: 20,
    full_power: 4000,
    tolerance: 50,
    steady_after: 30,
};

/// Model `M` with a heated measuring cell.
pub struct Heated<M>(PhantomData<M>);

impl<M: Model> Model for Heated<M> {
    const PARAMETERS: &'static [Parameter] = M::PARAMETERS;
    const FUNCTIONS: &'static [Function] = M::FUNCTIONS;
    const STATUS_BITS: [&'static str; 8] = M::STATUS_BITS;
    const LEDS: LedTable = M::LEDS;
    const RULES: &'static [Rule] = M::RULES;
    const AXES: u8 = M::AXES;
    const SENSOR_ERRORS: u8 = M::SENSOR_ERRORS;
    const HEATER: Option<&'static Settings> = Some(&HEATER);

    fn measure(up: I32x3, product: &Product) -> Measured {
        M::measure(up, product)
    }

    fn with_offset(measured: i32, offset: u32) -> i32 {
        M::with_offset(measured, offset)
    }

    fn zero_for(measured: i32) -> u32 {
        M::zero_for(measured)
    }
}
