//! The measurement and actions of a product, independent of the protocol.
//!
//! An [`Application`] processes readings and returns a complete set of values: quantities, faults and outputs to the hardware.
//! The node publishes each set in one step, and the protocol sends the published values. The protocol writes parameters; the node
//! passes changed parameters to [`Application::apply`] after the reply.

use crate::heater;
use crate::measure::self_test::Working;
use crate::measure::{Calibration, Reading};
use crate::param::{ParameterId, Parameters, Quantity, Refused, Table, ValueId};
use crate::time::{Deadline, Instant};

/// Active faults, independent of the protocol: one bit for each.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Faults(pub u16);

impl Faults {
    /// No fault is active.
    pub const NONE: Self = Self(0);
    /// There is no valid measurement.
    pub const SENSOR: Self = Self(0x01);
    /// The inclination is outside the measuring range.
    pub const RANGE: Self = Self(0x02);
    /// The temperature of the measuring cell is outside its range.
    pub const TEMPERATURE: Self = Self(0x04);
    /// The first angle is not valid: outside its range, or not measured.
    pub const X: Self = Self(0x08);
    /// The second angle is not valid: outside its range, or not measured.
    pub const Y: Self = Self(0x10);
    /// The heated measuring cell has not reached its constant temperature.
    pub const WARM_UP: Self = Self(0x20);
    /// The supply voltage is outside its range.
    pub const SUPPLY: Self = Self(0x40);
    /// The sensing element of the first angle is defective.
    pub const X_DEFECTIVE: Self = Self(0x80);
    /// The sensing element of the second angle is defective.
    pub const Y_DEFECTIVE: Self = Self(0x100);

    /// The union of both sets of faults.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// These faults if `active`, otherwise none.
    pub const fn when(self, active: bool) -> Self {
        if active { self } else { Self::NONE }
    }

    /// Whether both have a common fault.
    pub const fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Sets all faults of `mask` if `active`, otherwise clears them. The other faults do not change.
    pub const fn set(self, mask: Self, active: bool) -> Self {
        Self(self.0 & !mask.0 | mask.when(active).0)
    }
}

/// The outputs to the hardware, except the bus and the LEDs.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Outputs(u32);

/// Bits 0 to 15: the duty of the heater.
const DUTY: u32 = 0xFFFF;
const HAS_HEATER: u32 = 1 << 16;
const HAS_TERMINATION: u32 = 1 << 17;
const TERMINATED: u32 = 1 << 18;
/// Bits 24 to 31: the number of self-tests.
const TESTS: u32 = 24;

impl Outputs {
    /// No heater, no terminating resistor, no self-test.
    pub const NONE: Self = Self(0);

    /// Sets the duty of the heater in permille.
    pub const fn with_heater(self, duty: u16) -> Self {
        Self(self.0 & !DUTY | HAS_HEATER | duty as u32)
    }

    /// Connects or disconnects the terminating resistor.
    pub const fn with_termination(self, connected: bool) -> Self {
        let state = if connected { TERMINATED } else { 0 };
        Self(self.0 & !TERMINATED | HAS_TERMINATION | state)
    }

    /// Requests one more self-test of the accelerometer. The requests are counted modulo 256.
    pub const fn with_self_test(self) -> Self {
        Self(self.0.wrapping_add(1 << TESTS))
    }

    /// The duty of the heater in permille; None without a heater.
    pub const fn heater(self) -> Option<u16> {
        if self.0 & HAS_HEATER == 0 {
            return None;
        }
        Some((self.0 & DUTY) as u16)
    }

    /// Whether the terminating resistor is connected; None without terminating resistor.
    pub const fn termination(self) -> Option<bool> {
        if self.0 & HAS_TERMINATION == 0 {
            return None;
        }
        Some(self.0 & TERMINATED != 0)
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
pub trait Values: Copy + Send + 'static {
    /// The values before the first published ones; they are not used. If all bits are 0, they need no flash.
    const INITIAL: Self;

    /// The maximum number of quantities.
    const CAPACITY: usize = usize::MAX;

    /// The value of a quantity. A signed number is sign-extended to 32 bits. 0 for a quantity that the product does not have.
    fn number(&self, id: ValueId) -> u32;

    /// The value of a quantity of 64 bits. The default is the [number](Self::number), sign-extended to 64 bits.
    fn wide(&self, id: ValueId) -> u64 {
        i64::from(self.number(id) as i32) as u64
    }

    /// The faults that are active in this state.
    fn faults(&self) -> Faults;

    /// The outputs to the hardware.
    fn outputs(&self) -> Outputs {
        Outputs::NONE
    }
}

/// Values for an application that publishes `N` numbers and its faults.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Published<const N: usize> {
    /// The value of each quantity, at the place of its id.
    pub numbers: [i32; N],
    /// The faults that are active with these numbers.
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
    const CAPACITY: usize = N;

    fn number(&self, id: ValueId) -> u32 {
        let number = self.numbers.get(usize::from(id.0));
        number.copied().unwrap_or(0) as u32
    }

    fn faults(&self) -> Faults {
        self.faults
    }
}

/// An additional action after a write of a parameter.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Effect {
    /// The write needs nothing more.
    #[default]
    None,
    /// Store the parameters with [`Persistence::AtOnce`](crate::param::Persistence::AtOnce), which may have changed. The written
    /// parameter must be one of them.
    Store,
}

/// The measurement and actions of a product.
pub trait Application: Sized + Send + 'static {
    /// The parameters of the product.
    type Table: Table;
    /// The values that the application publishes after each reading.
    type Values: Values;

    /// The published quantities; the id of each is its index.
    const QUANTITIES: &'static [Quantity];
    /// The heater of the measuring cell, if there is one.
    const HEATER: Option<&'static heater::Settings> = None;
    /// Whether it has [`Outputs`]. If not, the node ignores them.
    const HAS_OUTPUTS: bool = Self::HEATER.is_some();

    /// Whether it requests self-tests of the accelerometer. If not, a driver does not need that function.
    const HAS_SELF_TEST: bool = false;

    /// Whether it measures the supply voltage. If not, a driver does not need that function.
    const MEASURES_SUPPLY: bool = false;

    /// Whether it needs [`Reading::angular_rate`]. If not, a driver does not need the gyroscope.
    const HAS_GYROSCOPE: bool = false;

    /// Whether the sensor has [diagnostic data](crate::diagnosis), and a driver measures and stores the usage of the device.
    const HAS_DIAGNOSIS: bool = <Self::Table as Table>::KEEPS_USAGE;

    /// An application that is not started. If all its bits are 0, it needs no flash: a node is in static memory.
    const INITIAL: Self;

    /// Starts with the calibration of the device. A call of [`apply`](Self::apply) follows.
    fn start(&mut self, calibration: Calibration);

    /// Goes on with the state that [`kept`](Self::kept) returned before a restart by the program; 0 after power-up. Called after
    /// [`start`](Self::start).
    fn resume(&mut self, kept: u32) {
        let _ = kept;
    }

    /// The state to keep over a restart by the program, after [`stale`](Self::stale).
    fn kept(&self) -> u32 {
        0
    }

    /// Applies the parameters, at the start and after a write. Unchanged parameters have no effect.
    fn apply(&mut self, now: Instant, parameters: &Parameters<Self::Table>) -> Self::Values;

    /// Processes a reading, one every [`SAMPLE_PERIOD`](crate::measure::SAMPLE_PERIOD). Returns the new values.
    fn sample(&mut self, now: Instant, reading: &Reading) -> Self::Values;

    /// Handles missing readings. Also called before a restart. Switches the outputs off that must not stay on without readings.
    fn stale(&mut self) -> Self::Values;

    /// Handles a gap before the next reading: values of the accelerometer and the gyroscope were lost. A driver without gyroscope does
    /// not call it.
    fn interrupt(&mut self) {}

    /// Handles the result of the self-test of the accelerometer. Returns None if no value has changed.
    fn tested(&mut self, result: Working) -> Option<Self::Values> {
        let _ = result;
        None
    }

    /// Handles a measurement of the supply voltage in mV, not filtered; one every [`SAMPLE_PERIOD`](crate::measure::SAMPLE_PERIOD), also
    /// without readings. Returns None if no value has changed that must be published before the next reading.
    fn supply(&mut self, millivolts: u16) -> Option<Self::Values> {
        let _ = millivolts;
        None
    }

    /// The time at which [`tick`](Self::tick) is due.
    fn deadline(&self) -> Deadline {
        Deadline::NEVER
    }

    /// Performs the action of the deadline. Without a deadline it is not called.
    fn tick(&mut self, now: Instant) -> Self::Values {
        let _ = now;
        self.stale()
    }

    /// The value of a parameter derived from the present measurement, for example the zero offset for which the angle is 0. None
    /// for a parameter that cannot be derived from measurements.
    fn derive(id: ParameterId, values: &Self::Values) -> Option<u32> {
        let _ = (id, values);
        None
    }

    /// Writes a parameter and the parameters that depend on it. Its description permits `value`. On an error, no parameter
    /// changes.
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

    /// Checks the parameters against each other, in addition to the constraints of the table.
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

    /// An application with `N` quantities and no behaviour of its own.
    struct Plain<const N: usize>;

    struct NoParameters;

    impl Table for NoParameters {
        const PARAMETERS: &'static [crate::param::Parameter] = &[];
        crate::project!(parameters);
    }

    impl<const N: usize> Application for Plain<N> {
        type Table = NoParameters;
        type Values = Published<N>;
        const QUANTITIES: &'static [Quantity] =
            &[Quantity::new(ValueId(0), "angle", crate::param::DataType::I16); N];
        const INITIAL: Self = Self;
        fn start(&mut self, _: Calibration) {}
        fn apply(&mut self, _: Instant, _: &Parameters<NoParameters>) -> Self::Values {
            Published::INITIAL
        }
        fn sample(&mut self, _: Instant, _: &Reading) -> Self::Values {
            Published::INITIAL
        }
        fn stale(&mut self) -> Self::Values {
            Published::new([-1; N], Faults::SENSOR)
        }
    }

    #[test]
    fn readout_is_the_first_two_quantities() {
        let parameters = Parameters::factory();
        let one = Plain::<1>::readout(&Published::new([-5], Faults::NONE), &parameters);
        assert_eq!(one, Readout { x: -5, y: None });
        let two = Plain::<2>::readout(&Published::new([-5, 7], Faults::NONE), &parameters);
        assert_eq!(two, Readout { x: -5, y: Some(7) });
    }

    #[test]
    fn application_without_its_own_behaviour_has_the_documented_defaults() {
        let now = Instant::from_ticks(0);
        let values = Published::new([1], Faults::NONE);
        assert_eq!(values.outputs(), Outputs::NONE);
        assert_eq!(values.number(ValueId(1)), 0);
        assert_eq!(Plain::<1>::derive(ParameterId(0), &values), None);
        assert!(Plain::<1>::is_consistent(&Parameters::factory()));
        let mut plain = Plain::<1>;
        assert_eq!(plain.deadline(), Deadline::NEVER);
        let working = Working {
            x: true,
            y: true,
            z: true,
        };
        assert_eq!(plain.tested(working), None);
        assert_eq!(plain.supply(24_000), None);
        let stale = Published::new([-1], Faults::SENSOR);
        assert_eq!(plain.tick(now), stale);
    }

    #[test]
    fn outputs_are_independent_of_each_other() {
        let outputs = Outputs::NONE.with_heater(1000).with_self_test();
        assert_ne!(outputs, Outputs::NONE.with_heater(1000));
        assert_eq!(outputs.heater(), Some(1000));
        assert_eq!(outputs.termination(), None);
        let outputs = outputs.with_termination(true).with_heater(0);
        assert_eq!(outputs.heater(), Some(0));
        assert_eq!(outputs.termination(), Some(true));
        assert_eq!(outputs.with_termination(false).termination(), Some(false));
        let repeated = outputs.with_heater(0).with_termination(true);
        assert_eq!(repeated, outputs);
        let connected = Outputs::NONE.with_termination(true);
        assert_eq!(connected.heater(), None);
        assert_eq!(connected.with_heater(700).with_heater(5).heater(), Some(5));
        let wrapped = (0..256).fold(outputs, |outputs, _| outputs.with_self_test());
        assert_eq!(wrapped, outputs);
    }

    #[test]
    fn set_keeps_faults_outside_mask() {
        let faults = Faults::X.and(Faults::WARM_UP);
        assert_eq!(faults.set(Faults::X, false), Faults::WARM_UP);
        assert_eq!(faults.set(Faults::Y, true).0, faults.0 | Faults::Y.0);
        assert_eq!(faults.set(Faults::X, true), faults);
        assert_eq!(faults.and(Faults::X), faults);
        assert!(faults.intersects(Faults::X) && !faults.intersects(Faults::Y));
    }
}
