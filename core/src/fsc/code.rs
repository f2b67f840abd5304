//! The function select codes of table 17 that are not reads or writes of a parameter.
//!
//! Parameters are read with the codes from [`READ`] on and written with those from [`WRITE`] on, in the order of
//! [`Key`](super::Key).

/// Read the inclination values.
pub const INCLINATION: u8 = 0x00;
/// Read the status; clears its sticky bits.
pub const STATUS: u8 = 0x02;
/// Read product number and revision.
pub const PRODUCT: u8 = 0x03;
/// Read serial number and software version.
pub const SERIAL: u8 = 0x04;
/// Read the first parameter; the others follow.
pub const READ: u8 = 0x10;
/// Write the first parameter; the others follow.
pub const WRITE: u8 = 0x20;
/// Load the default device parameters.
pub const LOAD: u8 = 0x40;
/// Save the device parameters.
pub const SAVE: u8 = 0x50;
/// Alive frame, or software reset; also the code of the boot-up message.
pub const ALIVE: u8 = 0xFF;

/// What must follow [`LOAD`].
pub const LOAD_SIGNATURE: &[u8] = b"LOAD";
/// What must follow [`SAVE`].
pub const SAVE_SIGNATURE: &[u8] = b"SAVE";
/// What makes a software reset of [`ALIVE`].
pub const RESET_SIGNATURE: &[u8] = b"RESET";
