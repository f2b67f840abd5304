//! slcan over TCP, as the virtual sensor and serial servers offer it.

use super::slcan::{Slcan, Stream};
use crate::failure::Failure;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

/// The wait for a connection.
const CONNECT: Duration = Duration::from_secs(3);

impl Stream for TcpStream {
    fn read(&mut self, bytes: &mut [u8], timeout: Duration) -> io::Result<usize> {
        // A read time-out of 0 means no time-out.
        let waits = !timeout.is_zero();
        self.set_nonblocking(!waits)?;
        if waits {
            self.set_read_timeout(Some(timeout))?;
        }
        let read = Read::read(self, bytes);
        self.set_nonblocking(false)?;
        match read {
            Ok(0) => Err(io::Error::new(
                ErrorKind::UnexpectedEof,
                "the connection was closed",
            )),
            Err(error) if is_timeout(&error) => Ok(0),
            result => result,
        }
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.write_all(bytes)
    }
}

/// Whether nothing came in time.
pub(super) fn is_timeout(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

/// Connects to `HOST:PORT`.
///
/// # Errors
/// Nobody accepts connections there.
pub fn connect(address: &str) -> Result<Slcan<TcpStream>, Failure> {
    let failed = |error: io::Error| {
        let message = format!(
            "cannot connect to {address} ({error}): is the adapter or the virtual sensor running there?"
        );
        Failure::bus("no-adapter", message)
    };
    let mut last = io::Error::new(ErrorKind::NotFound, "no address");
    for target in address.to_socket_addrs().map_err(failed)? {
        match TcpStream::connect_timeout(&target, CONNECT) {
            Ok(stream) => {
                stream.set_nodelay(true).map_err(failed)?;
                return Ok(Slcan::new(stream, &format!("slcan://{address}")));
            }
            Err(error) => last = error,
        }
    }
    Err(failed(last))
}
