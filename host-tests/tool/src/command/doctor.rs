//! `doctor`: prints what is wrong with the bus. A fault is exit code 1.

use super::bus::Bus;
use crate::cli::time;
use crate::error::{Error, SensorError};
use crate::ops::{Report, doctor};
use crate::output::Terminal;

/// Examines the bus.
pub(super) fn examine(
    bus: &mut Bus,
    seconds: Option<f64>,
    active: bool,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let request = doctor::Request {
        rate: bus.options.rate,
        time: time(seconds)?.unwrap_or(doctor::USUAL),
        active,
        target: bus.options.sensor.target()?,
    };
    let report = doctor::doctor(bus.adapter()?, request, terminal)?;
    let faults = report.findings.len();
    terminal.report(&Report::Doctor(report))?;
    match faults {
        0 => Ok(()),
        count => Err(Error::from(SensorError::BusFaults(count)).after_document()),
    }
}
