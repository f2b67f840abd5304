//! slcan on a serial port.

use super::slcan::{Slcan, Stream};
use super::tcp::is_timeout;
use crate::failure::Failure;
use serial2::SerialPort;
use std::io;
use std::time::Duration;

/// The speed of the port. Adapters on USB ignore it.
const SPEED: u32 = 115_200;

impl Stream for SerialPort {
    fn read(&mut self, bytes: &mut [u8], timeout: Duration) -> io::Result<usize> {
        // The port counts whole milliseconds: a shorter wait becomes 0. On Windows the shortest wait is 1 ms.
        let timeout = match timeout.is_zero() {
            true => timeout,
            false => timeout.max(Duration::from_millis(1)),
        };
        self.set_read_timeout(timeout)?;
        match SerialPort::read(self, bytes) {
            Err(error) if is_timeout(&error) => Ok(0),
            result => result,
        }
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.write_all(bytes)
    }
}

/// Opens the serial port at this path.
///
/// # Errors
/// The port cannot be opened.
pub fn open(path: &str) -> Result<Slcan<SerialPort>, Failure> {
    let port = SerialPort::open(path, SPEED).map_err(|error| {
        let ports = SerialPort::available_ports().unwrap_or_default();
        let ports: Vec<String> = ports
            .iter()
            .map(|port| port.display().to_string())
            .collect();
        let hint = match &ports[..] {
            [] => "this computer has no serial port: plug in the adapter".to_owned(),
            ports => format!("the serial ports are {}", ports.join(", ")),
        };
        Failure::bus(
            "no-adapter",
            format!("cannot open {path} ({error}): {hint}"),
        )
    })?;
    Ok(Slcan::new(port, &format!("slcan:{path}")))
}
