//! What the main loop needs of a measuring element, and what a measuring element needs of the board.

use crate::board::ImuWires;
use plumbline::measure::Reading;
use plumbline::measure::calibration::Part;
use plumbline::measure::self_test::{Limits, Working};
use plumbline::time::Instant;

/// The driver of a measuring element. It never waits longer than one short transfer: the main loop handles frames between two steps.
pub trait Element {
    /// The part, to which a calibration belongs.
    const PART: Part;

    /// Whether the part has a gyroscope.
    const GYROSCOPE: bool;

    /// Whether the part has a self-test.
    const SELF_TEST: bool;

    /// The nominal range of each axis, 1 g = 2^26.
    const RANGE: i32;

    /// The change of an axis that works during the self-test.
    const LIMITS: Limits;

    /// The driver for the part on this bus, before the first attempt to find it.
    fn new(wires: ImuWires) -> Self;

    /// Begins to read the FIFO, or tries to find a missing part. Call it every 5 ms.
    fn start(&mut self, now: Instant);

    /// True while the FIFO is read.
    fn busy(&self) -> bool;

    /// Performs one step of reading the FIFO. Returns a reading if one is complete, unless the part is missing or settling.
    fn step(&mut self, now: Instant) -> Option<Reading>;

    /// Returns true once if values were lost before the last reading.
    fn lost(&mut self) -> bool;

    /// Begins a self-test. [`tested`](Self::tested) returns the result after about 2 s. A running self-test begins again.
    fn test(&mut self);

    /// The result of a finished self-test, once.
    fn tested(&mut self) -> Option<Working>;
}

/// The SPI (mode 0 or 3, at most 10 MHz) and the chip select of the measuring element.
pub trait Wires {
    /// Begins or ends a transfer.
    fn select(&mut self, selected: bool);

    /// Sends `bytes` and replaces them by the received bytes.
    fn exchange(&mut self, bytes: &mut [u8]) -> Result<(), SpiError>;

    /// A complete transfer.
    fn transfer(&mut self, bytes: &mut [u8]) -> Result<(), SpiError> {
        self.select(true);
        let result = self.exchange(bytes);
        self.select(false);
        result
    }
}

/// Error: a transfer has failed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SpiError;
