//! slcan over TCP, as the virtual sensor and serial servers offer it.

use super::background::{Background, SLICE};
use super::slcan::Slcan;
use crate::error::AdapterError;
use std::io::{self, ErrorKind, Read};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

/// The wait for a connection.
const CONNECT: Duration = Duration::from_secs(3);

/// A TCP connection that is read in the background.
pub type Connection = Background<TcpStream>;

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
pub fn connect(address: &str) -> Result<Slcan<Connection>, AdapterError> {
    let failed =
        |error: io::Error| AdapterError::NoConnection(address.to_owned(), error.to_string());
    let mut last = io::Error::new(ErrorKind::NotFound, "no address");
    for target in address.to_socket_addrs().map_err(failed)? {
        match TcpStream::connect_timeout(&target, CONNECT) {
            Ok(stream) => {
                let stream = in_background(stream).map_err(failed)?;
                return Ok(Slcan::new(stream, &format!("slcan://{address}")));
            }
            Err(error) => last = error,
        }
    }
    Err(failed(last))
}

fn in_background(stream: TcpStream) -> io::Result<Connection> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(SLICE))?;
    let mut reader = stream.try_clone()?;
    Background::start(stream, move |bytes| reader.read(bytes))
}
