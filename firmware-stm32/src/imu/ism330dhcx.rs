//! The driver of the ISM330DHCX: acceleration at +-8 g and temperature, and for products with a gyroscope the angular rate at +-1000
//! deg/s.
//!
//! The accelerometer runs at 833 Hz in high-performance mode without LPF2. Each value goes into its FIFO, so none is lost or read
//! twice, although its oscillator has an error of some per cent, and none is lost while the flash stalls the processor. Every 5 ms
//! the driver reads the FIFO, and a [`Resampler`] converts the values to readings at 200 Hz. It takes the data rate from
//! INTERNAL_FREQ_FINE, in which the accelerometer states the error of its oscillator.
//!
//! The number of words in the FIFO and each word are transfers of their own, a word in two halves (`Element::step`). Between two
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
//! If the accelerometer is missing or fails, there are no samples, and the driver tries to find it every second.
//!
//! [`MeanRate`]: plumbline::measure::mean_rate::MeanRate
//! [`Resampler`]: plumbline::measure::resampler::Resampler

pub mod counts;

#[cfg(board)]
mod driver;
#[cfg(board)]
mod fifo;
#[cfg(board)]
mod registers;

#[cfg(board)]
pub use driver::Ism330dhcx;
