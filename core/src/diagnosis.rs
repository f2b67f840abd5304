//! Diagnostic data of a sensor, in a range of this project. No original has this range, so it is in no table, EDS file or DBC file of a
//! product. An original answers a request for it as any request that it does not know.
//!
//! | protocol | request | its reply | error for another number | error for a write |
//! |---|---|---|---|---|
//! | CANopen | upload of 5F00h, number as sub-index | u32 or i32; sub-index 0: the highest number | abort 0609 0011h | abort 0601 0002h |
//! | J1939 | the same through PGN 61184 | as in CANopen | as in CANopen | as in CANopen |
//! | function select codes | 61h, number | 61h, error bits of the status, number, u32 or i32; number 0: the highest number | 61h, status with CmdParamError | as for another number |
//! | DeviceNet | get attribute single of class C7h, instance 1, number as attribute | u32 or i32; class attribute 1: the revision, 1 | error 14h | error 0Eh |
//!
//! The IMS360 does not have it, because its image fills the Blue Pill
//! ([`Application::HAS_DIAGNOSIS`](crate::application::Application::HAS_DIAGNOSIS)). It answers as its original. Products of your own have
//! it also in J1939.
//!
//! The four manuals leave index, code and class free. An original answers 5F00h with abort 0602 0000h, code 61h with CmdParamError, and
//! class C7h with error 16h.
//!
#![doc = include_str!("diagnosis.md")]

use crate::measure::Calibration;
use crate::node::{Boot, BusState};
use crate::store::Usage;

/// The index of the object in CANopen and J1939.
pub const OBJECT: u16 = 0x5F00;

/// The function select code.
pub const CODE: u8 = 0x61;

/// The class in DeviceNet.
pub const CLASS: u8 = 0xC7;

/// The causes of a reset, one bit for each. An internal reset also pulls the reset pin, so [`PIN`](Self::PIN) is only set without another
/// cause.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ResetCauses(pub u8);

impl ResetCauses {
    /// The board does not know them.
    pub const NONE: Self = Self(0);
    /// Power-on.
    pub const POWER_ON: Self = Self(0x01);
    /// The reset pin.
    pub const PIN: Self = Self(0x02);
    /// Software: a command of the master, an update, a fault, or a check of the guard.
    pub const SOFTWARE: Self = Self(0x04);
    /// The watchdog: the main loop has stopped.
    pub const WATCHDOG: Self = Self(0x08);
    /// The supply was low (brown-out). The STM32F103 has no flag for it: it is a power-on.
    pub const LOW_SUPPLY: Self = Self(0x10);
    /// Any other.
    pub const OTHER: Self = Self(0x20);
}

/// The diagnostic data of a sensor.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Diagnosis {
    /// The usage of the device, this start included.
    pub usage: Usage,
    /// The causes of this start.
    pub causes: ResetCauses,
    /// The device has a calibration.
    pub is_calibrated: bool,
    /// How often received frames were lost since the start.
    pub overruns: u16,
    /// How often the CAN controller became error passive since the start.
    pub passive: u16,
    /// How often the CAN controller became bus-off since the start.
    pub bus_off: u16,
}

/// The highest number of a value.
pub const LAST: u8 = 12;

impl Diagnosis {
    /// All bits are 0, so that a node needs no flash before its start.
    pub(crate) const NONE: Self = Self {
        usage: Usage {
            minutes: 0,
            starts: 0,
            saves: 0,
            erases: 0,
            coldest: 0,
            warmest: 0,
            shock: 0,
        },
        causes: ResetCauses::NONE,
        is_calibrated: false,
        overruns: 0,
        passive: 0,
        bus_off: 0,
    };

    /// The data at this start.
    pub(crate) fn of(boot: &Boot) -> Self {
        Self {
            usage: Usage {
                starts: boot.usage.starts.saturating_add(1),
                ..boot.usage
            },
            causes: boot.causes,
            is_calibrated: boot.calibration != Calibration::IDENTITY,
            ..Self::NONE
        }
    }

    /// Counts lost frames.
    pub(crate) fn note_overrun(&mut self) {
        self.overruns = self.overruns.saturating_add(1);
    }

    /// Counts a change of the fault confinement state.
    #[cold]
    #[inline(never)]
    pub(crate) fn note(&mut self, from: BusState, to: BusState) {
        let count = match to {
            BusState::Passive if from != BusState::BusOff => &mut self.passive,
            BusState::BusOff if from != BusState::BusOff => &mut self.bus_off,
            _ => return,
        };
        *count = count.saturating_add(1);
    }

    /// The value with this number of the table; 0: the highest number. None: there is no such value.
    pub(crate) fn value(&self, number: u8) -> Option<u32> {
        let usage = &self.usage;
        Some(match number {
            0 => LAST.into(),
            1 => self.causes.0.into(),
            2 => usage.starts,
            3 => usage.minutes,
            4 => i32::from(usage.coldest) as u32,
            5 => i32::from(usage.warmest) as u32,
            6 => usage.shock.into(),
            7 => usage.saves,
            8 => usage.erases,
            9 => self.is_calibrated.into(),
            10 => self.overruns.into(),
            11 => self.passive.into(),
            LAST => self.bus_off.into(),
            _ => return None,
        })
    }
}
