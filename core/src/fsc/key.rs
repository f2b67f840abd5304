//! The names of the device parameters, which are also their places in the tables and in the EEPROM image.

/// The device parameters, in the order of their function select codes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Key {
    /// Set-Parameter-ID (10h, 20h).
    SetId,
    /// Reply-Parameter-ID (11h, 21h).
    ReplyId,
    /// Sync-ID (12h, 22h).
    SyncId,
    /// Baud rate code (13h, 23h).
    BaudRate,
    /// Automatic bus-off recovery (14h, 24h).
    BusOffRecovery,
    /// Cyclic time in ms (15h, 25h).
    CyclicTime,
    /// Cyclic mode (16h, 26h).
    CyclicMode,
    /// Cut-off frequency in mHz and filter type (17h, 27h).
    Filter,
    /// Zero offset, or zero offset X (18h, 28h).
    ZeroX,
    /// Zero offset Y (19h, 29h).
    ZeroY,
}

/// The number of [`Key`]s.
pub const KEYS: usize = 10;
