//! Where the JN2101's own values live.

use crate::canopen::OWN;

/// Node id (2000h).
pub const NODE_ID: u8 = OWN;
/// Bit rate in kbit/s (2001h).
pub const BIT_RATE: u8 = OWN + 1;
/// Quadrant correction (2040h).
pub const QUADRANT: u8 = OWN + 2;
/// Heating (2041h).
pub const HEATING: u8 = OWN + 3;
/// FIR filter (2043h).
pub const FILTER: u8 = OWN + 4;
/// Angle definition (2044h).
pub const DEFINITION: u8 = OWN + 5;
/// Terminating resistor (2045h).
pub const TERMINATION: u8 = OWN + 6;
/// Resolution in 0.001 deg (6000h).
pub const RESOLUTION: u8 = OWN + 7;
/// Teach index (2042h).
pub const TEACH: u8 = OWN + 8;
/// Zero point (2046h).
pub const ZERO: u8 = OWN + 9;
/// The zero point itself, longitudinal and lateral, as binary angles; no objects.
pub const ZERO_X: u8 = OWN + 10;
/// See [`ZERO_X`].
pub const ZERO_Y: u8 = OWN + 11;
/// The first of the four numbers of the reference frame; no objects.
pub const FRAME: u8 = OWN + 12;
/// Device reset (2002h).
pub const RESET: u8 = OWN + 16;
/// Factory reset (207Fh).
pub const FACTORY_RESET: u8 = OWN + 17;
/// Self-test under way (4004h:01).
pub const SELF_TEST: u8 = OWN + 18;
/// Result of the self-test (4004h:02).
pub const SELF_TEST_RESULT: u8 = OWN + 19;

/// What is kept of teach-in and zero point besides their objects.
pub const HIDDEN: core::ops::Range<u8> = ZERO_X..RESET;
