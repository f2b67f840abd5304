//! The diagnostic data of a sensor with the firmware of this project ([`plumbline::diagnosis`]). An original answers the first request with an
//! error, and gets no other one.

use crate::counted::{Erases, Saves, Starts};
use crate::error::Error;
use crate::identify::Found;
use crate::link::Link;
use plumbline::diagnosis::{LAST, ResetCauses};
use serde::{Serialize, Serializer};
use texts::texts;

texts! {
    /// The cause of a reset.
    Cause {
        PowerOn = "power-on", "Einschalten";
        Pin = "reset pin", "Reset-Pin";
        Software = "software", "Software";
        Watchdog = "watchdog", "Watchdog";
        LowSupply = "brown-out", "zu niedrige Versorgung";
        Other = "other cause", "andere Ursache";
    }
}

texts! {
    /// A line for people.
    Line {
        Reset(cause: Cause) = "last reset: {cause}", "letzter Reset: {cause}";
        Operation(starts: Starts, hours: f64) = "{starts}, {hours:.1} h in operation", "{starts}, {hours:.1} h in Betrieb";
        Temperature(coldest: f64, warmest: f64) = "measuring element {coldest:.2} to {warmest:.2} degC", "Messelement {coldest:.2} bis {warmest:.2} °C";
        Shock(shock: f64) = "highest acceleration {shock:.3} g", "größte Beschleunigung {shock:.3} g";
        Memory(saves: Saves, erases: Erases) = "until this start {saves} and {erases} of the memory", "bis zu diesem Start {saves} und {erases} des Speichers";
        Calibrated = "calibrated", "kalibriert";
        NotCalibrated = "not calibrated", "nicht kalibriert";
        Bus(overruns: u32, passive: u32, bus_off: u32) = "since this start: received frames lost {overruns} times, error passive {passive} times, bus-off {bus_off} times",
            "seit diesem Start: {overruns}-mal empfangene Frames verloren, {passive}-mal Error passive, {bus_off}-mal Bus-off";
    }
}

impl Cause {
    const ALL: [(ResetCauses, Self); 6] = [
        (ResetCauses::POWER_ON, Self::PowerOn),
        (ResetCauses::PIN, Self::Pin),
        (ResetCauses::SOFTWARE, Self::Software),
        (ResetCauses::WATCHDOG, Self::Watchdog),
        (ResetCauses::LOW_SUPPLY, Self::LowSupply),
        (ResetCauses::OTHER, Self::Other),
    ];

    /// The name for programs.
    const fn code(&self) -> &'static str {
        match self {
            Self::PowerOn => "power-on",
            Self::Pin => "pin",
            Self::Software => "software",
            Self::Watchdog => "watchdog",
            Self::LowSupply => "low-supply",
            Self::Other => "other",
        }
    }
}

impl Serialize for Cause {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.code())
    }
}

/// The diagnostic data of a sensor.
#[derive(Clone, Debug, Serialize)]
pub struct Usage {
    /// The sensor, as in [`Report::sensors`](super::Report::sensors).
    pub sensor: String,
    /// The causes of its last start; none: the board does not tell them.
    pub reset: Vec<Cause>,
    /// Its starts.
    pub starts: u32,
    /// The minutes in operation.
    pub minutes: u32,
    /// The lowest temperature in degC; None: there was no reading.
    pub coldest: Option<f64>,
    /// The highest one.
    pub warmest: Option<f64>,
    /// The highest acceleration in g.
    pub shock: f64,
    /// The saves of parameters until the last start.
    pub saves: u32,
    /// The erases of a page of the memory until the last start.
    pub erases: u32,
    /// It has a calibration.
    pub calibrated: bool,
    /// How often received frames were lost since its start.
    pub overruns: u32,
    /// How often it became error passive since its start.
    pub passive: u32,
    /// How often it became bus-off since its start.
    pub bus_off: u32,
}

impl Usage {
    /// Reads the data of a sensor that has answered; None: it is an original, or a product without them.
    ///
    /// # Errors
    /// The adapter fails.
    pub(super) fn ask(
        link: &mut Link,
        found: &Found,
        sensor: String,
    ) -> Result<Option<Self>, Error> {
        let Some(product) = found.products.first().filter(|_| !found.is_owned) else {
            return Ok(None);
        };
        let mut values = [0; LAST as usize];
        for (number, value) in (1..).zip(&mut values) {
            match found.target.diagnosis(link, product, number)? {
                Some(told) => *value = told,
                None => return Ok(None),
            }
        }
        Ok(Some(Self::new(sensor, values)))
    }

    fn new(sensor: String, values: [u32; LAST as usize]) -> Self {
        let [
            causes,
            starts,
            minutes,
            coldest,
            warmest,
            shock,
            saves,
            erases,
            is_calibrated,
            overruns,
            passive,
            bus_off,
        ] = values;
        let [coldest, warmest] = [coldest, warmest].map(|value| value as i32);
        let degrees = |value| (coldest <= warmest).then_some(f64::from(value) / 100.0);
        let told = Cause::ALL.into_iter();
        let told = told.filter(|(bit, _)| causes & u32::from(bit.0) != 0);
        Self {
            sensor,
            reset: told.map(|(_, cause)| cause).collect(),
            starts,
            minutes,
            coldest: degrees(coldest),
            warmest: degrees(warmest),
            shock: f64::from(shock) / 1000.0,
            saves,
            erases,
            calibrated: is_calibrated != 0,
            overruns,
            passive,
            bus_off,
        }
    }

    /// For people.
    pub(super) fn lines(&self) -> Vec<Line> {
        let mut lines: Vec<_> = self.reset.iter().cloned().map(Line::Reset).collect();
        let hours = f64::from(self.minutes) / 60.0;
        lines.push(Line::Operation(Starts(self.starts.into()), hours));
        if let (Some(coldest), Some(warmest)) = (self.coldest, self.warmest) {
            lines.push(Line::Temperature(coldest, warmest));
        }
        lines.push(Line::Shock(self.shock));
        let (saves, erases) = (Saves(self.saves.into()), Erases(self.erases.into()));
        lines.push(Line::Memory(saves, erases));
        lines.push(match self.calibrated {
            true => Line::Calibrated,
            false => Line::NotCalibrated,
        });
        lines.push(Line::Bus(self.overruns, self.passive, self.bus_off));
        lines
    }
}
