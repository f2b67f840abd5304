//! The file of a measurement: one line for each position, one with the measuring element, and one with the serial number of the unit.
//!
//! ```text
//! up,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps,temp_c
//! # element ism330dhcx
//! # serial number 7
//! +z,0.025000,-0.030000,1.060000,0.3100,-0.0200,0.0050,25.10
//! ```

use crate::backup::{Unread, read_text, write_file};
use crate::calibrate::rest::Average;
use crate::error::{CalibrationError, Error};
use host_tests::calibrate::{ELEMENT, HEADER, HEADER_WITHOUT_RATE, Side, element, set_at};
use plumbline::measure::calibration::Part;
use std::path::Path;

/// The start of the line of a measurement with the serial number.
const SERIAL: &str = "# serial number ";

/// The file of the measurement.
pub(super) struct Measurement<'a> {
    pub(super) path: &'a Path,
    pub(super) text: String,
    pub(super) serial: Option<u32>,
    /// The user has said the serial number.
    pub(super) is_named: bool,
}

impl<'a> Measurement<'a> {
    /// Reads the file; a new one has the heading only.
    pub(super) fn open(
        path: &'a Path,
        serial: Option<u32>,
        may_be_new: bool,
    ) -> Result<Self, Error> {
        let text = match read_text(path) {
            Ok(text) => text,
            Err(Unread::Failed(error))
                if may_be_new && error.kind() == std::io::ErrorKind::NotFound =>
            {
                format!("{HEADER}\n")
            }
            Err(error) => {
                let shown = path.display().to_string();
                return Err(CalibrationError::Unread(shown, error.to_string()).into());
            }
        };
        let own = text.lines().find_map(|line| line.strip_prefix(SERIAL));
        let own = own.and_then(|serial| serial.trim().parse().ok());
        let mut measurement = Self {
            path,
            text,
            serial: own,
            is_named: serial.is_some(),
        };
        if let Some(serial) = serial {
            measurement.is_of(serial)?;
        }
        Ok(measurement)
    }

    /// The unit has this serial number.
    pub(super) fn is_of(&mut self, serial: u32) -> Result<(), Error> {
        match self.serial {
            Some(own) if own != serial => {
                let shown = self.path.display().to_string();
                Err(CalibrationError::OtherSerial(shown, own, serial).into())
            }
            Some(_) => Ok(()),
            None => {
                self.serial = Some(serial);
                self.add_line(&format!("{SERIAL}{serial}"));
                Ok(())
            }
        }
    }

    /// The unit has this measuring element. A file with positions and without an element is that of an ISM330DHCX.
    pub(super) fn is_with(&mut self, part: Part) -> Result<(), Error> {
        let shown = self.path.display().to_string();
        let named = element(&shown, &self.text).map_err(CalibrationError::Measurement)?;
        let has_positions = self.text.lines().any(|line| line.starts_with(['+', '-']));
        match named.or(has_positions.then_some(Part::default())) {
            Some(own) if own != part => {
                Err(CalibrationError::OtherElement(shown, own.name(), part.name()).into())
            }
            Some(_) => Ok(()),
            None => {
                self.add_line(&format!("{ELEMENT}{}", part.name()));
                Ok(())
            }
        }
    }

    /// Adds a line to the text.
    fn add_line(&mut self, line: &str) {
        if !self.text.ends_with('\n') {
            self.text.push('\n');
        }
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// The set at a temperature, and its sides; see [`set_at`].
    pub(super) fn set_at(&self, temperature: f64) -> Result<Option<(f64, Vec<Side>)>, Error> {
        let name = self.path.display().to_string();
        Ok(set_at(&name, &self.text, temperature).map_err(CalibrationError::Measurement)?)
    }

    /// Adds a position and writes the file.
    pub(super) fn add(&mut self, side: Side, average: &Average) -> Result<(), Error> {
        let [x, y, z] = average.acceleration;
        let [gx, gy, gz] = average.rate;
        let temperature = average.temperature;
        // A file from before the rates goes on without them.
        let has_rate = !self.text.lines().any(|line| line == HEADER_WITHOUT_RATE);
        let rate = match has_rate {
            true => format!("{gx:.4},{gy:.4},{gz:.4},"),
            false => String::new(),
        };
        self.add_line(&format!(
            "{side},{x:.6},{y:.6},{z:.6},{rate}{temperature:.2}"
        ));
        write_file(self.path, &self.text)
    }
}
