//! Each product for hours of random use, in virtual time: two masters read and write settings, save, restart; the supply is cut, also in a
//! save; the program is replaced; the bus and the memory fail; the sensor is moved and shaken. All of it is chosen by random numbers that a
//! seed reproduces.
//!
//! - [`stand`]: a bus with one sensor and two masters, which are those of the tool `plumbline`
//! - [`settings`]: the settings that the sensor must have
//! - [`program`]: programs for updates
//! - [`motion`]: how it is moved
//! - [`step`]: what can happen, and how often
//! - [`use_case`]: how it happens, and what must hold
//! - [`steps`]: random inputs of the node alone, without a bus
//! - [`random`]: the random numbers
//!
//! What must hold at all times:
//!
//! - the sensor does not panic, and its driver becomes idle;
//! - it answers each request, after a start within 4 s, and after a fault of the bus within 2 s (in bus-off as set: after it was switched on);
//! - a setting that it accepts is read back, and no other one changes by a refused write;
//! - after a start it has the settings that were stored last; after a power cut in a save, these or those before, never a mixture;
//! - after an update it has the new program, and its settings; after a power cut in it, the old or the new program, or a bootloader that takes
//!   the next one;
//! - with the factory settings and at rest, its angles are right.

pub mod motion;
pub mod program;
pub mod random;
pub mod settings;
pub mod stand;
pub mod step;
pub mod steps;
pub mod use_case;

use plumbline_tool::error::Error;

/// What did not hold.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// There is no such kind of sensor.
    #[error("there is no sensor {0:?}")]
    Kind(String),
    /// The sensor does not answer.
    #[error("the sensor does not answer")]
    Silent,
    /// A request fails.
    #[error("a request fails: {0}")]
    Request(#[from] Error),
    /// A setting is not what was written.
    #[error("{name} is {read} instead of {written}")]
    Written {
        /// The name of the setting.
        name: String,
        /// The number that was read.
        read: u32,
        /// The number that was written.
        written: u32,
    },
    /// A setting changed, though nobody has written it.
    #[error("{name} is {read} instead of {before}, though nobody has written it")]
    Changed {
        /// The name of the setting.
        name: String,
        /// The number that was read.
        read: u32,
        /// The number before.
        before: u32,
    },
    /// The settings after a start are none of those that were stored.
    #[error("{name} is {read} after the start; stored was {stored:?}")]
    Stored {
        /// The name of the first setting that is in no state of the memory.
        name: String,
        /// The number that was read.
        read: u32,
        /// The numbers in the states that the memory can have.
        stored: Vec<u32>,
    },
    /// Another program runs than one of the last update, or its memory has other bytes.
    #[error("the program has the CRC {read:?}, not that and the bytes of one of {right:?}")]
    Program {
        /// The CRC that the sensor tells.
        read: Option<u32>,
        /// Those of the programs that it can have.
        right: Vec<u32>,
    },
    /// An angle is wrong.
    #[error("{name} is {read} deg instead of {right} deg")]
    Angle {
        /// The name of the angle.
        name: String,
        /// The angle that was read.
        read: f64,
        /// The angle in which the sensor is.
        right: f64,
    },
}
