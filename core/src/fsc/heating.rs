//! Active compensation of the thermal drift (section 9.3): the measuring cell is kept at a constant temperature, and
//! AccuracyWarning (section 9.5.2) is set until it has that.

use super::sensor::{Link, Sensor};
use super::status::Status;
use super::table::Model;
use crate::heater::{Heater, PERIOD, Settings};
use crate::node::Action;
use crate::time::{Instant, after, reached};

/// The heater of a sensor that has one.
pub(super) struct Heating {
    heater: Heater,
    /// When the temperature is to be taken in next; None: with the next sample.
    due: Option<Instant>,
    /// The duty that the hardware was told, in permille; None: it was not told yet.
    told: Option<u16>,
}

impl Heating {
    /// A heater that is off.
    pub(super) const fn new(settings: &'static Settings) -> Self {
        Self {
            heater: Heater::new(settings),
            due: None,
            told: None,
        }
    }

    /// Takes in the temperature of a sample in 0.01 degC, when it is time to.
    fn take(&mut self, now: Instant, temperature: i16) {
        if self.due.is_none_or(|due| reached(now, due)) {
            self.due = Some(after(now, PERIOD));
            self.heater.regulate(Some(temperature));
        }
    }

    /// Off at once; the next temperature starts the regulator afresh.
    fn stop(&mut self) {
        self.due = None;
        self.heater.regulate(None);
    }

    /// The hardware has not been told the duty in force.
    fn has_news(&self) -> bool {
        self.told != Some(self.heater.duty())
    }
}

// Who asks for the constant first lets the compiler drop all of this from a model without heater.
impl<M: Model> Sensor<M> {
    /// The heater follows the temperature of a sample in 0.01 degC. A sensor that restarts does not heat any more.
    pub(super) fn keep_warm(&mut self, now: Instant, temperature: i16) {
        if M::HEATER.is_none() || matches!(self.link, Link::Restarting(_) | Link::Restarted) {
            return;
        }
        if let Some(heating) = &mut self.heating {
            heating.take(now, temperature);
        }
        self.judge_temperature();
    }

    /// Stops heating, because there are no readings or a restart is near.
    pub(super) fn stop_heating(&mut self) {
        if M::HEATER.is_none() {
            return;
        }
        if let Some(heating) = &mut self.heating {
            heating.stop();
        }
        self.judge_temperature();
    }

    /// What the heater is to do now, unless it knows.
    pub(super) fn heater_action(&mut self) -> Option<Action> {
        M::HEATER?;
        let heating = self.heating.as_mut().filter(|heating| heating.has_news())?;
        let duty = heating.heater.duty();
        heating.told = Some(duty);
        Some(Action::Heater(duty))
    }

    fn judge_temperature(&mut self) {
        if let Some(heating) = &self.heating {
            self.attention |= heating.has_news();
            let steady = heating.heater.is_steady();
            let warning = if steady { 0 } else { Status::ACCURACY_WARNING };
            self.status.replace(Status::ACCURACY_WARNING, warning);
        }
    }
}
