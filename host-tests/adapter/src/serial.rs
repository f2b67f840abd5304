//! slcan on a serial port.

use super::background::{Background, SLICE};
use super::slcan::Slcan;
use crate::error::AdapterError;
use serial2::SerialPort;
use std::io;

/// The speed of the port. Adapters on USB ignore it.
const SPEED: u32 = 115_200;

/// Opens the serial port at this path.
///
/// # Errors
/// The port cannot be opened.
pub fn open(path: &str) -> Result<Slcan<Background<SerialPort>>, AdapterError> {
    let failed = |error: io::Error| {
        let ports = SerialPort::available_ports().unwrap_or_default();
        let ports: Vec<String> = ports
            .iter()
            .map(|port| port.display().to_string())
            .collect();
        let (path, reason) = (path.to_owned(), error.to_string());
        match &ports[..] {
            [] => AdapterError::NoSerial(path, reason),
            ports => AdapterError::OtherPorts(path, reason, ports.join(", ")),
        }
    };
    let port = in_background(path).map_err(failed)?;
    Ok(Slcan::new(port, &format!("slcan:{path}")))
}

fn in_background(path: &str) -> io::Result<Background<SerialPort>> {
    let mut port = SerialPort::open(path, SPEED)?;
    port.set_read_timeout(SLICE)?;
    let reader = port.try_clone()?;
    Background::start(port, move |bytes| reader.read(bytes))
}
