//! The six-position measurement of a unit, guided step by step, and the calibration that follows from it.
//!
//! The raw acceleration is in the log of the board: no protocol of the sensors has it. A position is taken only after a yes, and the
//! measurement is in the file after each one, so that it can be continued.

mod measurement;

use crate::calibrate::host::{Host, Question, State, Step, Up};
use crate::calibrate::log::{Log, Message, Sample, Source};
use crate::calibrate::rest::{Average, Window};
use crate::error::{CalibrationError, Error, FileError, RequestError};
use crate::identify;
use crate::link::stopped;
use crate::note::Note;
use host_tests::calibrate::{Side, Units, calibration as computed};
use host_tests::store_file;
use measurement::Measurement;
use plumbline::measure::calibration::Calibration;
use serde::{Serialize, Serializer};
use serde_json::json;
use std::path::Path;
use std::time::Duration;

/// The order of the positions.
const SIDES: [Side; 6] = {
    const fn side(axis: usize, up: bool) -> Side {
        Side { axis, up }
    }
    [
        side(2, true),
        side(2, false),
        side(0, true),
        side(0, false),
        side(1, true),
        side(1, false),
    ]
};

/// The longest wait without a check for Ctrl-C.
const SLICE: Duration = Duration::from_millis(100);

/// The longest pause between two samples.
const PAUSE: Duration = Duration::from_secs(10);

/// The samples between two checks of the window: 0.5 s.
const LOOK: usize = 100;

/// The unit whose calibration is computed.
#[derive(Clone, Copy, Debug)]
pub struct Unit<'a> {
    /// The name of its product.
    pub product: Option<&'a str>,
    /// The serial number; another unit ignores the calibration.
    pub serial: Option<u32>,
    /// The store file into which the calibration is written.
    pub store: Option<&'a Path>,
}

/// A calibration that is computed, and written if there is a store file.
pub struct Done {
    calibration: Calibration,
    /// What the user must do next.
    pub next: Note,
}

impl Done {
    /// For people.
    pub fn line(&self) -> String {
        Units::from(&self.calibration).to_string()
    }
}

/// The numbers: the offset in mg, the deviation of the response from 1, the drift in mg/K, the zero rate in deg/s, its drift in deg/s/K.
impl Serialize for Done {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let units = Units::from(&self.calibration);
        let document = json!({
            "offset_mg": units.offset,
            "deviation": units.deviation,
            "drift_mg_per_k": units.drift,
            "zero_rate_dps": units.zero_rate,
            "zero_rate_drift_dps_per_k": units.zero_rate_drift,
        });
        document.serialize(to)
    }
}

/// Measures what is missing, if there is a log, and computes the calibration. A store file is written.
///
/// # Errors
/// A file cannot be read or written, the log ends, the unit is another one, or the user stops.
pub fn run(
    path: &Path,
    log: Option<&Source>,
    unit: Unit,
    host: &mut dyn Host,
) -> Result<Done, Error> {
    // Errors are reported before the measurement.
    let product = match (unit.store, unit.product) {
        (Some(_), None) => {
            return Err(RequestError::StoreProduct.into());
        }
        (_, name) => name.map(identify::product).transpose()?,
    };
    let mut measurement = Measurement::open(path, unit.serial, log.is_some())?;
    if let Some(log) = log {
        Guide::start(log, host)?.run(&mut measurement, host)?;
    }
    let name = path.display().to_string();
    let calibration = computed(&name, &measurement.text).map_err(CalibrationError::Invalid)?;
    let (Some(store), Some(product)) = (unit.store, product) else {
        let next = Note::NoStore;
        return Ok(Done { calibration, next });
    };
    let serial = measurement.serial.ok_or(CalibrationError::NoSerial)?;
    store_file::calibrate(product.owner(serial), &calibration, store).map_err(FileError::Store)?;
    let next = Note::Calibration(product.name, serial, store.display().to_string());
    Ok(Done { calibration, next })
}

/// Leads the user through the positions.
struct Guide {
    log: Log,
    window: Window,
    /// The serial number in the log.
    serial: Option<u32>,
    /// The sum of the waits since the last sample, which a stop of this computer does not extend. None: no sample came yet.
    silence: Option<Duration>,
    /// A position was taken, and nobody has said of which unit.
    is_unknown: bool,
}

impl Guide {
    fn start(source: &Source, host: &mut dyn Host) -> Result<Self, Error> {
        host.report(&Step::Waiting(source.to_string()));
        Ok(Self {
            log: Log::start(source)?,
            window: Window::default(),
            serial: None,
            silence: None,
            is_unknown: false,
        })
    }

    /// Measures the sides that the set at the present temperature does not have.
    fn run(&mut self, measurement: &mut Measurement, host: &mut dyn Host) -> Result<(), Error> {
        let first = self.sample(measurement, host)?;
        let set = measurement.set_at(first.temperature)?;
        let done = set.as_ref().map_or(&[][..], |(_, sides)| sides);
        let mut set_temperature = set.as_ref().map(|(temperature, _)| *temperature);
        let missing: Vec<Side> = SIDES
            .into_iter()
            .filter(|side| !done.contains(side))
            .collect();
        if missing.is_empty() {
            host.report(&Step::Complete);
        } else if let (Some(own), None, false) =
            (measurement.serial, self.serial, measurement.is_named)
        {
            return Err(
                CalibrationError::SerialOfLog(measurement.path.display().to_string(), own).into(),
            );
        }
        for side in missing {
            let place = SIDES.iter().position(|own| *own == side).unwrap_or(0) + 1;
            host.report(&Step::Place(place, Up(side)));
            self.log.turn(side);
            let average = self.position(side, set_temperature, measurement, host)?;
            measurement.add(side, &average)?;
            self.is_unknown |= measurement.serial.is_none();
            if set_temperature.is_none() {
                let set = measurement.set_at(average.temperature)?;
                set_temperature = set.map(|(temperature, _)| temperature);
            }
            host.report(&Step::Taken(
                Up(side),
                measurement.path.display().to_string(),
            ));
        }
        Ok(())
    }

    /// Waits until the sensor is at rest in this position, and until the user takes it.
    fn position(
        &mut self,
        side: Side,
        set_temperature: Option<f64>,
        measurement: &mut Measurement,
        host: &mut dyn Host,
    ) -> Result<Average, Error> {
        self.restart(measurement, host)?;
        let mut samples = 0;
        loop {
            let sample = self.sample(measurement, host)?;
            self.window.push(sample);
            samples += 1;
            if samples % LOOK != 0 {
                continue;
            }
            let Some(average) = self.window.average() else {
                continue;
            };
            let set = measurement.set_at(average.temperature)?;
            let set = set.map(|(temperature, _)| temperature);
            let state = match (average.side(), set_temperature) {
                _ if !average.is_at_rest() => State::Moves,
                (None, _) => State::NoSide,
                (Some(up), _) if up != side => State::OtherSide(Up(up), Up(side)),
                (_, Some(first)) if set != Some(first) => State::TooFar(first),
                // The six positions of an earlier measurement must stay six.
                (_, None) if set.is_some() => State::TooNear,
                _ => State::Ready,
            };
            if state != State::Ready {
                host.report(&Step::Measured(state, average));
                continue;
            }
            if host.ask(&Question::Take(Up(side), average)) {
                return Ok(average);
            }
            if !host.is_stopped() && host.ask(&Question::Again) {
                self.restart(measurement, host)?;
                samples = 0;
                continue;
            }
            return Err(match host.is_stopped() {
                true => CalibrationError::Stopped,
                false => CalibrationError::Declined,
            }
            .into());
        }
    }

    /// Forgets what was measured before the user has moved the sensor.
    fn restart(&mut self, measurement: &mut Measurement, host: &mut dyn Host) -> Result<(), Error> {
        for message in self.log.drop_waiting() {
            self.start_of(message, measurement, host)?;
        }
        self.window.clear();
        self.silence = Some(Duration::ZERO);
        Ok(())
    }

    /// What the log tells at the start of the unit.
    fn start_of(
        &mut self,
        message: Message,
        measurement: &mut Measurement,
        host: &mut dyn Host,
    ) -> Result<(), Error> {
        match message {
            Message::Element(Some(part)) => measurement.is_with(part),
            Message::Element(None) => Err(CalibrationError::UnknownElement.into()),
            Message::Serial(serial) => self.unit(serial, measurement, host),
            Message::Sample(_) => Ok(()),
        }
    }

    /// The log tells the serial number of the unit: at its start, and whenever it starts again.
    fn unit(
        &mut self,
        serial: u32,
        measurement: &mut Measurement,
        host: &mut dyn Host,
    ) -> Result<(), Error> {
        match self.serial {
            Some(own) if own != serial => Err(CalibrationError::Changed(own, serial).into()),
            Some(_) => Ok(()),
            None if self.is_unknown && measurement.serial.is_none() => {
                Err(CalibrationError::Unknown(serial).into())
            }
            None => {
                measurement.is_of(serial)?;
                self.serial = Some(serial);
                // The samples before can be of another unit.
                self.window.clear();
                host.report(&Step::Serial(serial));
                Ok(())
            }
        }
    }

    fn sample(
        &mut self,
        measurement: &mut Measurement,
        host: &mut dyn Host,
    ) -> Result<Sample, Error> {
        loop {
            if host.is_stopped() {
                return Err(stopped());
            }
            match self.log.next(SLICE)? {
                Some(Message::Sample(sample)) => {
                    self.silence = Some(Duration::ZERO);
                    return Ok(sample);
                }
                Some(message) => self.start_of(message, measurement, host)?,
                None => {
                    self.silence = self.silence.map(|silence| silence + SLICE);
                    if self.silence > Some(PAUSE) {
                        return Err(CalibrationError::Silent.into());
                    }
                }
            }
        }
    }
}
