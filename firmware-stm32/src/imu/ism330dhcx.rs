//! The driver of the ISM330DHCX: acceleration at +-8 g and temperature, and for products with a gyroscope the angular rate at +-1000
//! deg/s.
//!
//! The accelerometer runs at 833 Hz in high-performance mode without LPF2. Each value goes into its FIFO, so none is lost or read
//! twice, although its oscillator has an error of some per cent, and none is lost while the flash stalls the processor. Every 5 ms
//! the driver reads the FIFO, and a [`Resampler`] converts the values to readings at 200 Hz. It takes the data rate from
//! INTERNAL_FREQ_FINE, in which the accelerometer states the error of its oscillator.
//!
//! The registers, the number of words in the FIFO and each word are steps of their own, a word in two halves (`Element::step`). Between two
//! halves the main loop handles frames.
//!
//! The gyroscope has the same data rate, and its values are in the same FIFO. A reading has their mean since the last reading
//! ([`MeanRate`]). The FIFO holds values for 0.55 s, and with the gyroscope for 0.28 s. A longer stall loses the oldest values: while the
//! F446 erases a sector, which takes 0.25 s and at most 0.5 s. The rotation in these values is not known, so the driver reports the gap
//! (`Element::lost`). If the gyroscope gives no values, there are no readings.
//!
//! During the self-test ([`self_test`](super::self_test)) the last acceleration before it is used. Its range is then +-4 g, for which the
//! datasheet specifies the change.
//!
//! Checks, so that no angle is wrong in silence:
//!
//! - The control registers are compared before each reading of the FIFO, so no value is used that was measured with another
//!   configuration. One of the others is compared too, all within 35 ms. If one is different, or the FIFO is empty for 50 ms, the part is
//!   reset and configured again. That takes 45 ms, less than the 100 ms after which the sensor reports the fault.
//! - The range of the gyroscope is one of them, also if the product does not use it: the IIS2ICLX has the same identifier, but no
//!   gyroscope, two axes and other ranges. The ASM330LHH has the same registers and values, and is accepted.
//! - A word of the FIFO with a wrong tag is not a value ([`tags`]). If errors repeat within a second, there are no readings until the line
//!   was good for 0.5 s.
//! - A wrong bit of an acceleration is corrected ([`values`](super::values)); more than 16 in a second are an error as above. A wrong angular
//!   rate is left out ([`rates`](super::rates)). A temperature is used if it differs from the one before by at most 1 degC.
//! - An axis that does not change ends the readings as repeated errors do.
//!
//! If the accelerometer is missing or fails, there are no readings. The driver looks for it every 5 ms. If a part answers that is not the right
//! one, it is configured again every 100 ms. Nothing is written while the line reads FFh, or 0 for less than 15 ms: the part can be in its
//! boot of 10 ms.
//!
//! [`MeanRate`]: plumbline::measure::mean_rate::MeanRate
//! [`Resampler`]: plumbline::measure::resampler::Resampler

pub mod counts;
pub mod tags;

#[cfg(board)]
mod driver;
#[cfg(board)]
mod fifo;
#[cfg(board)]
mod registers;

#[cfg(board)]
pub use driver::Ism330dhcx;
