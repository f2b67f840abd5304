//! The driver of the ADXL355: acceleration at +-8 g and temperature, for products without a gyroscope.
//!
//! The part runs at 1000 Hz with its low-pass at a quarter of this rate. Its FIFO holds 32 values, which is 32 ms. Every 5 ms the driver
//! reads the FIFO, and a [`Resampler`] converts the values to readings at 200 Hz. The part does not state the error of its oscillator: the
//! driver counts the values of the first 1.3 s, and uses the nominal rate until then.
//!
//! The state of the part and each value are transfers of their own, a value in two halves (`Element::step`). Between two halves the main
//! loop handles frames. The part stores the axes of a value one after the other, so the driver reads only complete values
//! (no-OS, issue 2431).
//!
//! A stall of more than 32 ms loses values: an erase on the F103 takes up to 40 ms, on the F446 0.5 s. The part reports it, and the
//! resampler begins again, because a reading must not have values from before and after the gap.
//!
//! After power-up, and whenever the part is found again, it is reset. Its shadow registers must be the same before and after the reset;
//! otherwise it has not started correctly, and is reset again (the driver of the manufacturer does the same).
//!
//! Checks, so that no angle is wrong in silence:
//!
//! - Identity and configuration are compared before each reading of the FIFO, so no value is used that was measured with another
//!   configuration. If one is different, the part is started again, within 50 ms.
//! - A value without the marker of X at its place, or of an empty FIFO, is not used. If errors repeat within a second, there are no readings
//!   until the line was good for 0.5 s.
//! - A wrong bit of a value is corrected ([`values`](super::values)); more than 16 in a second end the readings as repeated errors do.
//! - An axis that does not change ends the readings as repeated errors do.
//!
//! The range is +-8 g in all states: a shock of 6 g does not clip, and the noise is wider than a digit of 15.6 ug in each range.
//!
//! [`Resampler`]: plumbline::measure::resampler::Resampler

pub mod counts;

#[cfg(board)]
mod driver;
#[cfg(board)]
mod fifo;
#[cfg(board)]
mod registers;

#[cfg(board)]
pub use driver::Adxl355;
