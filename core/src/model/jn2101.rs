//! ifm JN2101: two axes, +-45 deg, CANopen with the device profile for inclination sensors (CiA 410).
//!
//! Sections are those of the device manual, "JN2101 from firmware 2.2.0".

mod base64;
mod key;
mod measuring;
mod objects;
mod slots;

use crate::can::BitRate;
use crate::canopen::dictionary::{Object, Rule, factory, rules};
use crate::canopen::emcy::{self, Fault};
use crate::canopen::{self, Abort, Device, Effect, LedTable, Text, Values};
use crate::heater::{self, Heater, Settings};
use crate::measure::self_test::Working;
use crate::measure::{Calibration, I32x3, ONE_G, Reading};
use crate::node::{Action, Pattern, Readout, SELF_TEST_LIMIT};
use crate::store::ImageId;
use crate::time::{Instant, after, is_due};
use core::ops::Range;
use measuring::{Measuring, Output, frame, keep_frame};

/// The sensor.
pub type Jn2101 = Device<Application>;

static RULES: [Rule; objects::ROWS] = rules(&objects::OBJECTS);
static FACTORY: Values = Values::new(factory(&objects::OBJECTS));

/// The emergency codes (7.6.1 and 11) of the bits of the status register.
static FAULTS: [Fault; 8] = [
    fault(0x1000, 0),      // sensor: generic error
    fault(0x9000, 0),      // measuring range: external error
    fault(0x4200, 1 << 3), // device temperature
    fault(0x1000, 0),      // hardware: generic error
    fault(0x8110, 1 << 4), // CAN overrun
    fault(0x8120, 1 << 4), // CAN in error passive mode
    fault(0x8130, 1 << 4), // life guard error
    fault(0x8140, 1 << 4), // recovered from bus off
];

const fn fault(code: u16, register: u8) -> Fault {
    Fault { code, register }
}

/// The heater of the measuring cell.
static HEATER: Settings = Settings {
    set_point: 50_00,
    proportional: 50,
    integral_time: 60,
    derivative_time: 20,
    full_power: 1500,
    tolerance: 50,
    steady_after: 30,
};

/// The temperatures of the measuring cell beyond which there is an emergency, in 0.01 degC.
const TEMPERATURES: (i16, i16) = (-40_00, 85_00);
/// How far it must come back for the emergency to end, in 0.01 K.
const TEMPERATURE_HYSTERESIS: i16 = 2_00;

/// Samples for which a clipped one still counts: 100 ms, so that vibration does not make the error flicker.
const CLIP_HOLD: u8 = 20;

/// Self-test register: the X axis works.
const X_WORKS: u32 = 1 << 2;
/// Self-test register: the Y axis works.
const Y_WORKS: u32 = 1 << 1;

/// What the JN2101 does besides CANopen.
pub struct Application {
    measuring: Measuring,
    heater: Heater,
    /// The temperature of the measuring cell in 0.1 degC (4080h).
    temperature: i32,
    temperature_due: Option<Instant>,
    clip_hold: u8,
    axes_failed: bool,
    /// The faults as last judged.
    faults: u8,
    /// The end of the time that a self-test may take.
    test_until: Option<Instant>,
    wanted: Wanted,
    /// What the hardware was told.
    told: Wanted,
}

/// What the hardware is to do; None: it was not told yet.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
struct Wanted {
    termination: Option<bool>,
    duty: Option<u16>,
    /// Counts the self-tests.
    tests: u8,
}

impl canopen::Model for Application {
    const OBJECTS: &'static [Object] = &objects::OBJECTS;
    const RULES: &'static [Rule] = &RULES;
    const FACTORY: &'static Values = &FACTORY;
    const HIDDEN: Range<u8> = slots::HIDDEN;
    const AT_ONCE: Range<u8> = slots::TEACH..slots::HIDDEN.end;
    const FACTORY_RESET: u8 = slots::FACTORY_RESET;
    const TAKEN_ALONG: Range<u8> = slots::NODE_ID..slots::QUADRANT;
    const FAULTS: &'static [Fault; 8] = &FAULTS;
    /// 11.3: unlike CiA 303-3, the run LED is steady in pre-operational and flashes in operational.
    const LEDS: LedTable = LedTable {
        pre_operational: Pattern::On,
        operational: Pattern::Blinking,
        stopped: Pattern::SingleFlash,
        working: Pattern::Off,
        warning: Pattern::SingleFlash,
        guarding: Pattern::DoubleFlash,
        bus_off: Pattern::On,
    };
    const IMAGE: ImageId = ImageId(0x2101);

    fn new(calibration: Calibration) -> Self {
        Self {
            measuring: Measuring::new(calibration),
            heater: Heater::new(&HEATER),
            temperature: 0,
            temperature_due: None,
            clip_hold: 0,
            axes_failed: false,
            faults: 0,
            test_until: None,
            wanted: Wanted {
                duty: Some(0),
                ..Wanted::default()
            },
            told: Wanted::default(),
        }
    }

    fn node_id(values: &Values) -> u8 {
        (values.at(slots::NODE_ID) as u8).clamp(1, 127)
    }

    fn bit_rate(values: &Values) -> BitRate {
        match values.at(slots::BIT_RATE) {
            10 => BitRate::K10,
            20 => BitRate::K20,
            50 => BitRate::K50,
            250 => BitRate::K250,
            500 => BitRate::K500,
            800 => BitRate::K800,
            1000 => BitRate::M1,
            _ => BitRate::K125,
        }
    }

    fn is_whole(values: &Values) -> bool {
        let taught = match values.at(slots::TEACH) {
            1 => frame(values).is_some(),
            index => index == 2,
        };
        taught && values.at(slots::ZERO) != 0
    }

    fn configure(&mut self, values: &Values) {
        self.measuring.configure(values);
        self.heater.enable(values.at(slots::HEATING) == 1);
        self.wanted.duty = Some(self.heater.duty());
        self.wanted.termination = Some(values.at(slots::TERMINATION) == 1);
    }

    fn write(
        &mut self,
        now: Instant,
        slot: u8,
        value: u32,
        values: &mut Values,
    ) -> Result<Effect, Abort> {
        match (slot, value) {
            (slots::TEACH | slots::ZERO, 0) => return Ok(Effect::None),
            (slots::RESET, 0) | (slots::SELF_TEST, 0) => return Ok(Effect::None),
            (slots::RESET, _) => return Ok(Effect::Restart),
            (slots::FACTORY_RESET, _) => return Ok(Effect::FactoryReset),
            (slots::TEACH, 1) => {
                let frame = self.measuring.teach().ok_or(Abort::DeviceState)?;
                keep_frame(&frame, values);
            }
            (slots::ZERO, 1) => {
                let [x, y] = self.measuring.zero_point().ok_or(Abort::DeviceState)?;
                values.set(slots::ZERO_X, x.0);
                values.set(slots::ZERO_Y, y.0);
            }
            (slots::SELF_TEST, _) if self.test_until.is_none() => {
                self.test_until = Some(after(now, SELF_TEST_LIMIT));
                self.wanted.tests = self.wanted.tests.wrapping_add(1);
            }
            _ => {}
        }
        values.set(slot, value);
        Ok(match slot {
            slots::TEACH | slots::ZERO => Effect::Store,
            _ => Effect::None,
        })
    }

    fn text(&self, values: &Values) -> Text {
        key::compose(values, &FACTORY)
    }

    fn write_text(&mut self, text: &[u8], values: &mut Values) -> Result<Effect, Abort> {
        let mut new = key::parse(text, values, &FACTORY, &RULES)?;
        // A key does not carry what was taught or zeroed, so it can end that but not bring it about.
        let mut effect = Effect::None;
        for slot in [slots::TEACH, slots::ZERO] {
            if new.at(slot) != 2 {
                new.set(slot, values.at(slot));
            } else if values.at(slot) != 2 {
                effect = Effect::Store;
            }
        }
        *values = new;
        Ok(effect)
    }

    fn sample(&mut self, now: Instant, reading: &Reading) -> u8 {
        let up = self.measuring.sample(reading);
        if reading.clipped {
            self.clip_hold = CLIP_HOLD;
        }
        let clips = self.clip_hold > 0;
        self.clip_hold = self.clip_hold.saturating_sub(1);
        if self.temperature_due.is_none() || is_due(&self.temperature_due, now) {
            self.temperature_due = Some(after(now, heater::PERIOD));
            self.take_temperature(reading.temperature);
        }
        self.judge(emcy::SENSOR, clips || self.axes_failed);
        self.judge(
            emcy::LIMIT,
            beyond_range(up, self.faults & emcy::LIMIT != 0),
        );
        self.faults
    }

    fn lose(&mut self) {
        self.measuring.lose();
        self.wanted.duty = Some(self.heater.regulate(None));
    }

    fn measured(&self, which: u8) -> u32 {
        const X16: u8 = Output::X16 as u8;
        const Y16: u8 = Output::Y16 as u8;
        const X32: u8 = Output::X32 as u8;
        const Y32: u8 = Output::Y32 as u8;
        const TEMPERATURE: u8 = Output::Temperature as u8;
        let number = match which {
            X16 => saturated(self.measuring.angle(true)),
            Y16 => saturated(self.measuring.angle(false)),
            X32 => self.measuring.angle(true),
            Y32 => self.measuring.angle(false),
            TEMPERATURE => self.temperature,
            _ => self.heater.power().into(),
        };
        number as u32
    }

    fn tested(&mut self, result: Working, values: &mut Values) {
        if self.test_until.take().is_none() {
            return;
        }
        let bit = |works: bool, bit: u32| if works { bit } else { 0 };
        let register = bit(result.x, X_WORKS) | bit(result.y, Y_WORKS);
        values.set(slots::SELF_TEST, 0);
        values.set(slots::SELF_TEST_RESULT, register);
        self.axes_failed = register != X_WORKS | Y_WORKS;
    }

    fn tick(&mut self, now: Instant, values: &mut Values) {
        if is_due(&self.test_until, now) {
            self.tested(Working::default(), values);
        }
    }

    fn deadline(&self) -> Option<Instant> {
        self.test_until
    }

    fn has_action(&self) -> bool {
        self.wanted != self.told
    }

    fn action(&mut self) -> Option<Action> {
        if self.wanted == self.told {
            return None;
        }
        let (wanted, told) = (self.wanted, self.told);
        self.told = told;
        if wanted.termination != told.termination {
            self.told.termination = wanted.termination;
            return wanted.termination.map(Action::Termination);
        }
        if wanted.duty != told.duty {
            self.told.duty = wanted.duty;
            return wanted.duty.map(Action::Heater);
        }
        self.told.tests = wanted.tests;
        Some(Action::SelfTest)
    }

    fn calibration(&self) -> &Calibration {
        &self.measuring.calibration
    }

    fn readout(&self) -> Readout {
        self.measuring.readout()
    }
}

impl Application {
    fn judge(&mut self, fault: u8, is: bool) {
        self.faults = self.faults & !fault | if is { fault } else { 0 };
    }

    /// The temperature of the measuring cell is determined (9.9), and the heating follows it (9.7).
    fn take_temperature(&mut self, temperature: i16) {
        self.temperature = (i32::from(temperature) + 5).div_euclid(10);
        self.wanted.duty = Some(self.heater.regulate(Some(temperature)));
        let margin = if self.faults & emcy::TEMPERATURE == 0 {
            0
        } else {
            TEMPERATURE_HYSTERESIS
        };
        let (coldest, hottest) = TEMPERATURES;
        let beyond = temperature < coldest + margin || temperature > hottest - margin;
        self.judge(emcy::TEMPERATURE, beyond);
    }
}

/// A number as 16 bits can show it.
fn saturated(number: i32) -> i32 {
    number.clamp(i16::MIN.into(), i16::MAX.into())
}

/// Whether the X or Y axis is inclined by more than 45 deg; once it is, by more than 44 deg.
///
/// The sine of an inclination is the axis's component over the length: sin^2 is 1/2 and 0.4844.
fn beyond_range(up: I32x3, was: bool) -> bool {
    // The upper half of a square is enough: 2^24 for 1 g.
    let square = |component: i32| ((i64::from(component) * i64::from(component)) >> 32) as i32;
    let [x, y, z] = up
        .to_array()
        .map(|component| square(component.clamp(-2 * ONE_G, 2 * ONE_G)));
    let squares = x + y + z;
    let limit = squares / 2 - if was { squares >> 6 } else { 0 };
    x.max(y) > limit
}
