//! What a model that speaks CANopen is made of: its dictionary and tables, and its application behind them.

use super::abort::Abort;
use super::dictionary::{Object, Rule};
use super::emcy::Fault;
use super::values::Values;
use crate::can::BitRate;
use crate::measure::self_test::Working;
use crate::measure::{Calibration, Reading};
use crate::node::{Action, Pattern, Readout};
use crate::store::ImageId;
use crate::time::Instant;
use core::ops::Range;

/// Run and error LED patterns.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LedTable {
    /// Run LED in pre-operational.
    pub pre_operational: Pattern,
    /// Run LED in operational.
    pub operational: Pattern,
    /// Run LED in stopped.
    pub stopped: Pattern,
    /// Error LED while none of the following holds.
    pub working: Pattern,
    /// Error LED when the CAN warning limit has been reached.
    pub warning: Pattern,
    /// Error LED when the guarding master is silent.
    pub guarding: Pattern,
    /// Error LED in bus-off.
    pub bus_off: Pattern,
}

/// What has to happen besides after a value of the model was written.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Effect {
    /// Nothing.
    #[default]
    None,
    /// The values that outlast a power cycle at once ([`Model::AT_ONCE`]) have changed.
    Store,
    /// Restart the device.
    Restart,
    /// The model's own values, all but those of the communication profile, go back to the factory's.
    FactoryReset,
}

/// The longest text that can be written, in bytes, and the longest that is composed.
pub const TEXT_MAX: usize = 24;

/// A text that is composed.
pub type Text = heapless::Vec<u8, TEXT_MAX>;

/// A model that speaks CANopen.
///
/// Its own values live in the slots from [`OWN`](super::key::OWN) on.
pub trait Model: Sized {
    /// The object dictionary, sorted.
    const OBJECTS: &'static [Object];
    /// What the device keeps of it: its projection by [`rules`](super::dictionary::rules).
    const RULES: &'static [Rule];
    /// The factory values by slot: its projection by [`factory`](super::dictionary::factory).
    const FACTORY: &'static Values;
    /// Slots of stored values that are no objects.
    const HIDDEN: Range<u8>;
    /// Slots that are stored as soon as [`Effect::Store`] asks for it.
    const AT_ONCE: Range<u8>;
    /// The slot that tells whether a factory reset succeeded (1) or failed (0).
    const FACTORY_RESET: u8;
    /// Slots that a reset of the node takes along although they are not stored: node id and bit rate.
    const TAKEN_ALONG: Range<u8>;
    /// How faults are told, from bit 0 of the status register on.
    const FAULTS: &'static [Fault; 8];
    /// What the LEDs show.
    const LEDS: LedTable;
    /// Marks the images of this model.
    const IMAGE: ImageId;

    /// The application with a calibration; [`configure`](Self::configure) follows.
    fn new(calibration: Calibration) -> Self;

    /// The node id that these values stand for, 1 to 127.
    fn node_id(values: &Values) -> u8;

    /// The bit rate that these values stand for.
    fn bit_rate(values: &Values) -> BitRate;

    /// Whether values from memory, each of which is permitted, are so together.
    fn is_whole(values: &Values) -> bool;

    /// Puts the values into force.
    fn configure(&mut self, values: &Values);

    /// Sets a value of the model that is permitted; on an error nothing has changed.
    fn write(
        &mut self,
        now: Instant,
        slot: u8,
        value: u32,
        values: &mut Values,
    ) -> Result<Effect, Abort>;

    /// The text of the object whose home is [`Key`](super::dictionary::Home::Key).
    fn text(&self, values: &Values) -> Text;

    /// Carries out what was written to that object; on an error nothing has changed.
    fn write_text(&mut self, text: &[u8], values: &mut Values) -> Result<Effect, Abort>;

    /// Takes a reading in. Returns the faults that are now, of [`SENSOR`](super::emcy::SENSOR), [`LIMIT`](super::emcy::LIMIT)
    /// and [`TEMPERATURE`](super::emcy::TEMPERATURE).
    fn sample(&mut self, now: Instant, reading: &Reading) -> u8;

    /// No readings come any more.
    fn lose(&mut self);

    /// The number whose home is [`Measured`](super::dictionary::Home::Measured).
    fn measured(&self, which: u8) -> u32;

    /// The test of the accelerometer has ended.
    fn tested(&mut self, result: Working, values: &mut Values);

    /// Does what is due.
    fn tick(&mut self, now: Instant, values: &mut Values);

    /// When something is due.
    fn deadline(&self) -> Option<Instant>;

    /// Whether [`action`](Self::action) has something.
    fn has_action(&self) -> bool;

    /// What the hardware is to do next.
    fn action(&mut self) -> Option<Action>;

    /// The calibration of the unit.
    fn calibration(&self) -> &Calibration;

    /// The angles, for displays on a PC.
    fn readout(&self) -> Readout;
}
