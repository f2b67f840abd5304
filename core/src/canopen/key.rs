//! The names of the values that every CANopen sensor has, which are also their places in [`Values`](super::Values).

/// The values of the communication profile. A model's own values follow behind them, from [`OWN`] on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Key {
    /// COB-ID of the SYNC (1005h).
    SyncId,
    /// Guard time in ms (100Ch).
    GuardTime,
    /// Life time factor (100Dh).
    LifeTimeFactor,
    /// COB-ID of the EMCY (1014h).
    EmcyId,
    /// Inhibit time of the EMCY in 100 us (1015h).
    EmcyInhibit,
    /// Heartbeat time in ms (1017h).
    Heartbeat,
    /// What a communication error does to the NMT state (1029h:01).
    ErrorBehaviour,
    /// NMT start-up (1F80h).
    StartUp,
    /// The first value of the first TPDO; four for each TPDO, see [`TpdoKey`].
    Tpdo,
}

/// The values of a TPDO's communication parameter, in their order.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum TpdoKey {
    /// COB-ID (sub-index 1).
    Id,
    /// Transmission type (sub-index 2).
    Type,
    /// Inhibit time in 100 us (sub-index 3).
    Inhibit,
    /// Event timer in ms (sub-index 5).
    Event,
}

/// The number of TPDOs.
pub const TPDOS: usize = 2;

/// The values of each TPDO.
const TPDO_KEYS: u8 = 4;

/// The place of a TPDO's value; `number` counts from 0.
pub const fn tpdo(number: u8, key: TpdoKey) -> u8 {
    Key::Tpdo as u8 + number * TPDO_KEYS + key as u8
}

/// The place of the first value that is a model's own.
pub const OWN: u8 = Key::Tpdo as u8 + TPDOS as u8 * TPDO_KEYS;
