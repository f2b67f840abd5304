//! Measures the usage of the device: operating time, temperatures and shocks.

use crate::measure::{ONE_G, Reading, SAMPLE_PERIOD};
use crate::store::Usage;
use crate::time::{Duration, millis};

/// The number of readings in a second.
const READINGS: u8 = (millis(1000).ticks() / SAMPLE_PERIOD.ticks()) as u8;
const _: () = assert!(SAMPLE_PERIOD.ticks() * READINGS as u64 == SECOND.ticks());
const SECOND: Duration = millis(1000);

/// The number of seconds after which a start is kept.
const FIRST: u32 = 10;
const HOUR: u32 = 3600;
const MINUTE: u32 = 60;

/// The bits of an acceleration that do not count: the sum of three squares then has 32 bits.
const SHIFT: u32 = 14;
/// 1 g without these bits.
const UNIT: u32 = (ONE_G >> SHIFT) as u32;

/// The readings since the last [`take`](Watch::take), and the time since the start.
pub(super) struct Watch {
    readings: u8,
    seconds: u32,
    coldest: i16,
    warmest: i16,
    /// The square of the highest acceleration.
    shock: u32,
    /// The usage must be kept, with this number of full hours since the start.
    due: Option<u32>,
}

impl Watch {
    pub(super) const START: Self = Self {
        readings: 0,
        seconds: 0,
        coldest: i16::MAX,
        warmest: i16::MIN,
        shock: 0,
        due: None,
    };

    /// Notes a reading.
    pub(super) fn note(&mut self, reading: &Reading) {
        self.readings = self.readings.saturating_add(1);
        self.coldest = self.coldest.min(reading.temperature);
        self.warmest = self.warmest.max(reading.temperature);
        let squares = reading.acceleration.to_array().map(|component| {
            let short = (component >> SHIFT).unsigned_abs();
            short.saturating_mul(short)
        });
        let sum = squares.into_iter().fold(0_u32, u32::saturating_add);
        self.shock = self.shock.max(sum);
    }

    /// Whether a second of readings is complete.
    pub(super) fn is_due(&self) -> bool {
        self.readings >= READINGS
    }

    /// Adds the readings of the last second. Returns the number of full hours since the start if the usage must be kept.
    pub(super) fn take(&mut self, usage: &mut Usage) -> Option<u32> {
        self.readings = 0;
        self.seconds = self.seconds.saturating_add(1);
        if self.seconds.is_multiple_of(MINUTE) {
            usage.minutes = usage.minutes.saturating_add(1);
        }
        usage.coldest = usage.coldest.min(self.coldest);
        usage.warmest = usage.warmest.max(self.warmest);
        let thousandths = self.shock.isqrt().saturating_mul(1000) / UNIT;
        usage.shock = usage.shock.max(thousandths as u16);
        if self.seconds == FIRST || self.seconds.is_multiple_of(HOUR) {
            self.due = Some(self.seconds / HOUR);
        }
        self.due
    }

    /// The usage is kept, or there is no room for it.
    pub(super) fn done(&mut self) {
        self.due = None;
    }
}
