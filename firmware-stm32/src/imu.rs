//! The measuring element: the accelerometer, and for products with a gyroscope the gyroscope in the same part.
//!
//! An `Element` is the driver of a part. It has a folder with everything that only this part has. What the drivers share is in `line`,
//! `rates`, `repeats`, `self_test`, `testing`, `values` and `words`. The rest of the firmware uses only the trait, `Wires` and `Fitted`.
//!
//! | part | feature | folder |
//! |---|---|---|
//! | ISM330DHCX, and ASM330LHH as second source | the default | `ism330dhcx` |
//! | ADXL355, for products without a gyroscope | `adxl355` | `adxl355` |
//!
//! Each driver gives a [`Reading`](plumbline::measure::Reading) every 5 ms, in the axes of the sensor. The data rate of a part comes from
//! its own oscillator, so a driver reads a FIFO and uses the [`Resampler`](plumbline::measure::resampler::Resampler).

pub mod adxl355;
pub mod ism330dhcx;
pub mod line;
pub mod mounting;
pub mod rates;
pub mod repeats;
pub mod self_test;
pub mod values;

#[cfg(board)]
mod element;
#[cfg(board)]
mod testing;
#[cfg(board)]
mod words;
#[cfg(board)]
pub use element::{Element, SpiError, Wires};

/// The element that this firmware is built for.
#[cfg(all(board, not(feature = "adxl355")))]
pub type Fitted<const TESTS: usize, const GYROSCOPES: usize> =
    ism330dhcx::Ism330dhcx<TESTS, GYROSCOPES>;

/// Its name in an image file.
#[cfg(all(board, not(feature = "adxl355")))]
pub const NAME: plumbline::update::Element = plumbline::update::Element::Ism330dhcx;

/// Its name in an image file.
#[cfg(all(board, feature = "adxl355"))]
pub const NAME: plumbline::update::Element = plumbline::update::Element::Adxl355;

/// The element that this firmware is built for.
#[cfg(all(board, feature = "adxl355"))]
pub type Fitted<const TESTS: usize, const GYROSCOPES: usize> = adxl355::Adxl355<TESTS>;
