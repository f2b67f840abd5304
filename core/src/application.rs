//! What a product measures and does, whatever protocol it speaks.
//!
//! An [`Application`] takes readings in and returns a complete set of values: quantities, faults and what the hardware is to do.
//! The node publishes each set in one step, and the protocol sends what it finds there. Parameters come the other way: the
//! protocol writes them, and the node hands those that changed to [`Application::apply`] outside of the reply.

use crate::heater;
use crate::measure::self_test::Working;
use crate::measure::{Calibration, Reading};
use crate::param::{ParameterId, Parameters, Quantity, Refused, Table, ValueId};
use crate::time::Instant;

/// Active faults, independent of any protocol: a bit for each.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Faults(pub u16);

impl Faults {
    /// No fault.
    pub const NONE: Self = Self(0);
    /// There is no valid measurement.
    pub const SENSOR: Self = Self(1 << 0);
    /// The inclination is beyond the measuring range.
    pub const RANGE: Self = Self(1 << 1);
    /// The temperature of the measuring cell is out of its range.
    pub const TEMPERATURE: Self = Self(1 << 2);
    /// The first angle is not valid: beyond its range, or not measured.
    pub const X: Self = Self(1 << 3);
    /// The second angle is not valid.
    pub const Y: Self = Self(1 << 4);
    /// The heated measuring cell does not have its constant temperature.
    pub const WARM_UP: Self = Self(1 << 5);

    /// The faults of both.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// These faults when `active`, otherwise none.
    pub const fn when(self, active: bool) -> Self {
        if active { self } else { Self::NONE }
    }

    /// Whether one of the faults is in both.
    pub const fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// These faults with those of `mask` replaced: by all of them when `active`, otherwise by none.
    pub const fn set(self, mask: Self, active: bool) -> Self {
        Self(self.0 & !mask.0 | mask.when(active).0)
    }
}

/// What the hardware around the node is to do, apart from the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Outputs(u32);

/// The heater's duty is in the lower half.
const DUTY: u32 = 0xFFFF;
const HAS_HEATER: u32 = 1 << 16;
const HAS_TERMINATION: u32 = 1 << 17;
const TERMINATED: u32 = 1 << 18;
/// The count of self-tests is in the highest byte.
const TESTS: u32 = 24;

impl Outputs {
    /// No heater, no terminating resistor, no self-test.
    pub const NONE: Self = Self(0);

    /// The heater's duty in permille.
    pub const fn with_heater(self, duty: u16) -> Self {
        Self(self.0 & !DUTY | HAS_HEATER | duty as u32)
    }

    /// Whether the terminating resistor is connected.
    pub const fn with_termination(self, connected: bool) -> Self {
        let state = if connected { TERMINATED } else { 0 };
        Self(self.0 & !TERMINATED | HAS_TERMINATION | state)
    }

    /// Asks for one self-test of the accelerometer more.
    pub const fn with_self_test(self) -> Self {
        Self(self.0.wrapping_add(1 << TESTS))
    }

    /// The heater's duty in permille; None without a heater.
    pub const fn heater(self) -> Option<u16> {
        if self.0 & HAS_HEATER == 0 {
            return None;
        }
        Some((self.0 & DUTY) as u16)
    }

    /// Whether the terminating resistor is connected; None without one.
    pub const fn termination(self) -> Option<bool> {
        if self.0 & HAS_TERMINATION == 0 {
            return None;
        }
        Some(self.0 & TERMINATED != 0)
    }

    /// How many self-tests have been asked for; wraps after 255.
    pub const fn self_tests(self) -> u8 {
        (self.0 >> TESTS) as u8
    }
}

/// The inclination, for displays on a PC.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Readout {
    /// The angle of a 1-axis sensor, or X, in 0.01 deg, zero offset included.
    pub x: i32,
    /// The second angle, or Y, in 0.01 deg; None on a 1-axis sensor.
    pub y: Option<i32>,
}

/// A complete set of published values.
pub trait Values: Copy {
    /// What is there before the application has published any; nobody reads it. With all bits 0 it costs no flash.
    const INITIAL: Self;

    /// The value of a quantity; a signed number with the sign in all 32 bits. 0 for one that the product does not have.
    fn number(&self, id: ValueId) -> u32;

    /// The active faults.
    fn faults(&self) -> Faults;

    /// What the hardware is to do.
    fn outputs(&self) -> Outputs {
        Outputs::NONE
    }
}

/// Values for an application that publishes so many numbers and its faults.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Published<const N: usize> {
    /// The value of each quantity, at the place of its id.
    pub numbers: [i32; N],
    /// The active faults.
    pub faults: Faults,
}

impl<const N: usize> Published<N> {
    /// These numbers with these active faults.
    pub const fn new(numbers: [i32; N], faults: Faults) -> Self {
        Self { numbers, faults }
    }
}

impl<const N: usize> Values for Published<N> {
    const INITIAL: Self = Self {
        numbers: [0; N],
        faults: Faults::NONE,
    };

    fn number(&self, id: ValueId) -> u32 {
        let number = self.numbers.get(usize::from(id.0));
        number.copied().unwrap_or(0) as u32
    }

    fn faults(&self) -> Faults {
        self.faults
    }
}

/// What has to happen besides after a parameter was written.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Effect {
    /// Nothing.
    #[default]
    None,
    /// Parameters that are stored at once have changed.
    Store,
}

/// What a product measures and does.
pub trait Application: Sized {
    /// The parameters of the product.
    type Table: Table;
    /// What it publishes.
    type Values: Values;

    /// The quantities that it publishes, each at the place of its id.
    const QUANTITIES: &'static [Quantity];
    /// The heater of the measuring cell, if there is one.
    const HEATER: Option<&'static heater::Settings> = None;
    /// Whether it has [`Outputs`]; without them the node does not look.
    const HAS_OUTPUTS: bool = Self::HEATER.is_some();

    /// An application that was not started. With all bits 0 it costs no flash: a node lies in static memory.
    const INITIAL: Self;

    /// Starts as the application of a unit with this calibration. The parameters follow.
    fn start(&mut self, calibration: Calibration);

    /// Takes the parameters over: at the start, and after some were written. What has not changed goes on undisturbed.
    fn apply(&mut self, now: Instant, parameters: &Parameters<Self::Table>) -> Self::Values;

    /// Takes a reading in.
    fn sample(&mut self, now: Instant, reading: &Reading) -> Self::Values;

    /// No readings come any more.
    fn stale(&mut self) -> Self::Values;

    /// The restart is near: switches off what must not stay on. No readings follow.
    fn stop(&mut self) -> Self::Values {
        self.stale()
    }

    /// The self-test of the accelerometer has ended; None when nothing has changed.
    fn tested(&mut self, result: Working) -> Option<Self::Values> {
        let _ = result;
        None
    }

    /// When [`tick`](Self::tick) is due; None: never.
    fn deadline(&self) -> Option<Instant> {
        None
    }

    /// Does what is due at the deadline. Without a deadline it is not called.
    fn tick(&mut self, now: Instant) -> Self::Values {
        let _ = now;
        self.stale()
    }

    /// The value that makes a parameter fit the present measurement, for example the zero offset that makes the angle 0; None for
    /// a parameter that does not follow from measurements.
    fn derive(id: ParameterId, values: &Self::Values) -> Option<u32> {
        let _ = (id, values);
        None
    }

    /// Writes a parameter with a value that its description permits, and those that follow from it. On an error nothing has
    /// changed.
    fn write(
        id: ParameterId,
        value: u32,
        values: &Self::Values,
        parameters: &mut Parameters<Self::Table>,
    ) -> Result<Effect, Refused> {
        let _ = values;
        parameters.set(id, value);
        Ok(Effect::None)
    }

    /// Whether values from memory fit each other, beyond what the table's constraints say.
    fn is_consistent(parameters: &Parameters<Self::Table>) -> bool {
        let _ = parameters;
        true
    }

    /// The inclination, for displays on a PC; the first two quantities unless a product says otherwise.
    fn readout(values: &Self::Values, parameters: &Parameters<Self::Table>) -> Readout {
        let _ = parameters;
        let number = |id| values.number(ValueId(id)) as i32;
        Readout {
            x: number(0),
            y: (Self::QUANTITIES.len() > 1).then(|| number(1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_keep_their_parts_apart() {
        let outputs = Outputs::NONE.with_heater(1000).with_self_test();
        assert_eq!(outputs.heater(), Some(1000));
        assert_eq!(outputs.termination(), None);
        assert_eq!(outputs.self_tests(), 1);
        let outputs = outputs.with_termination(true).with_heater(0);
        assert_eq!(outputs.heater(), Some(0));
        assert_eq!(outputs.termination(), Some(true));
        assert_eq!(outputs.with_termination(false).termination(), Some(false));
        let wrapped = (0..255).fold(outputs, |outputs, _| outputs.with_self_test());
        assert_eq!(wrapped.self_tests(), 0);
        assert_eq!(wrapped.heater(), Some(0));
    }

    #[test]
    fn setting_faults_leaves_the_others() {
        let faults = Faults::X.and(Faults::WARM_UP);
        assert_eq!(faults.set(Faults::X, false), Faults::WARM_UP);
        assert_eq!(faults.set(Faults::Y, true).0, faults.0 | Faults::Y.0);
        assert!(faults.intersects(Faults::X) && !faults.intersects(Faults::Y));
    }
}
