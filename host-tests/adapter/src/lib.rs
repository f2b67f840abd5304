//! CAN adapters behind one trait, and their names on the command line.
//!
//! | port | adapter |
//! |---|---|
//! | `slcan://HOST:PORT`, `socket://HOST:PORT` | slcan (LAWICEL ASCII) over TCP |
//! | `slcan:/dev/ttyACM0`, `slcan:COM3` | slcan on a serial port |
//! | `can0`, `vcan0` | SocketCAN, on Linux |
//! | `usb`, `usb:SERIAL` | gs_usb (candleLight) without a driver of the kernel |
//! | `pcan`, `pcan:USBBUS1` | PCAN, with the library of its maker |
//!
//! An adapter is also the clock: tests run the same program in the virtual time of a simulated bus ([`mod@bench`]). Tests of a
//! program set `PLUMBLINE_CLOCK=bus`: then the time of slcan is that of a virtual sensor with `--clock client`.

pub mod background;
pub mod bench;
mod error;
pub mod gs_usb;
mod meant;
pub mod pcan;
pub mod ports;
pub mod serial;
pub mod slcan;
#[cfg(target_os = "linux")]
pub mod socketcan;
pub mod tcp;
pub mod unread;

pub use error::{AdapterError, PcanHint, UsbHint};

use meant::{Meant, is_address, meant};
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;
use std::any::Any;
use std::fmt::Display;
use std::time::Duration;
use unread::Unread;

/// How an adapter takes part in the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Mode {
    /// It only listens: it sends nothing, acknowledges nothing and signals no errors.
    Listen,
    /// It takes part: it acknowledges and can send.
    Active,
}

/// What an adapter can do.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Capabilities {
    /// It has a listen-only mode. An adapter that finds this out when it opens refuses then.
    pub listen_only: bool,
    /// The tool sets the bit rate. If not, the interface has its own bit rate.
    pub sets_rate: bool,
    /// It must be opened with a bit rate.
    pub needs_rate: bool,
    /// It reports errors of the bus.
    pub reports_errors: bool,
}

/// A CAN adapter: what the tool needs of each kind.
pub trait Adapter {
    /// What the adapter can do, before and after it is opened.
    fn capabilities(&self) -> Capabilities;

    /// Opens it at a bit rate, or at the bit rate of the interface. If it is open, closes it first.
    ///
    /// # Errors
    /// It cannot have this rate, it has no listen-only mode (it is never opened in another mode instead), or it has failed.
    fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), AdapterError>;

    /// Closes it. Frames that wait are dropped. An adapter that has failed stays as it is.
    fn close(&mut self);

    /// Hands over a frame, which is sent as soon as the bus is free.
    ///
    /// # Errors
    /// It is not open for sending, or it has failed.
    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError>;

    /// The next received frame with the time of its reception, or None at `until`. A frame that has already arrived is received even if
    /// `until` is over; a caller that receives all frames until then must compare the time itself.
    ///
    /// # Errors
    /// It has failed, or was unplugged.
    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError>;

    /// The present time of the clock of the received frames.
    fn now(&self) -> Instant;

    /// The bit rate at which it is open, if the tool has not set it and the interface tells it.
    fn rate(&self) -> Option<BitRate> {
        None
    }

    /// The errors that it has seen since it was opened, at least; None if it does not say.
    fn errors(&mut self) -> Option<u64>;

    /// The received frames that it has lost since it was opened, at least; None if it does not say.
    fn overruns(&mut self) -> Option<u64> {
        None
    }

    /// The virtual sensor behind it, for a program that knows its type; None: the bus is real.
    fn stand_in(&mut self) -> Option<&mut dyn Any> {
        None
    }

    /// What the tool cannot read of the adapter, since it was made; None: its messages have one form only.
    fn unread(&self) -> Option<Unread> {
        None
    }
}

/// The time of an adapter whose clock is that of the computer.
fn instant(since_connected: Duration) -> Instant {
    let micros = since_connected.as_micros();
    Instant::from_ticks(micros.try_into().unwrap_or(u64::MAX))
}

/// The adapter has failed, or was unplugged.
fn lost(name: &str, reason: impl Display) -> AdapterError {
    AdapterError::Lost(name.to_owned(), reason.to_string())
}

/// The adapter cannot be opened without a bit rate.
fn no_rate(name: &str) -> AdapterError {
    AdapterError::NoRate(name.to_owned())
}

/// The adapter is not opened in another mode than asked for.
fn no_listen_only(name: &str) -> AdapterError {
    AdapterError::NoListenOnly(name.to_owned())
}

/// The variable of the environment that selects the time of the bus; for tests.
const CLOCK: &str = "PLUMBLINE_CLOCK";

/// Whether the time of the bus is selected; for tests.
pub fn is_in_bus_time() -> bool {
    std::env::var_os(CLOCK).is_some_and(|clock| clock == "bus")
}

/// The adapter of a port. It is not open yet.
///
/// # Errors
/// The text is no port, or the port cannot be used.
pub fn connect(port: &str) -> Result<Box<dyn Adapter>, AdapterError> {
    for scheme in ["slcan://", "socket://"] {
        if let Some(address) = port.strip_prefix(scheme) {
            check_address(port, address)?;
            let adapter = tcp::connect(address)?;
            return Ok(match is_in_bus_time() {
                true => Box::new(adapter.in_bus_time()?),
                false => Box::new(adapter),
            });
        }
    }
    if let Some(path) = port.strip_prefix("slcan:") {
        if path.is_empty() {
            return Err(AdapterError::SerialPort);
        }
        if let Some(Meant::Port(meant)) = meant(port, None)
            && meant.starts_with("slcan://")
        {
            return Err(AdapterError::Meant(port.to_owned(), meant));
        }
        let adapter = serial::open(path)?;
        return Ok(match is_in_bus_time() {
            true => Box::new(adapter.in_bus_time()?),
            false => Box::new(adapter),
        });
    }
    if port == "usb" {
        return Ok(Box::new(gs_usb::connect(None)?));
    }
    if let Some(serial) = port.strip_prefix("usb:") {
        return Ok(Box::new(gs_usb::connect(Some(serial))?));
    }
    if port == "pcan" {
        return Ok(Box::new(pcan::connect("")?));
    }
    if let Some(channel) = port.strip_prefix("pcan:") {
        return Ok(Box::new(pcan::connect(channel)?));
    }
    let interfaces = ports::interfaces();
    if interfaces.iter().any(|own| own == port) {
        return interface(port);
    }
    let is_linux = cfg!(target_os = "linux");
    match meant(port, is_linux.then_some(&interfaces[..])) {
        Some(Meant::Port(meant)) => return Err(AdapterError::Meant(port.to_owned(), meant)),
        Some(Meant::Unsupported) => return Err(AdapterError::NoDriver(port.to_owned())),
        None => {}
    }
    if port.is_empty() || port.contains([':', '/']) {
        return Err(AdapterError::UnknownPort(port.to_owned()));
    }
    interface(port)
}

/// Refuses an address that is not `HOST:PORT`.
fn check_address(port: &str, address: &str) -> Result<(), AdapterError> {
    match is_address(address) {
        true => Ok(()),
        false => Err(AdapterError::NoHost(port.to_owned())),
    }
}

#[cfg(target_os = "linux")]
fn interface(name: &str) -> Result<Box<dyn Adapter>, AdapterError> {
    Ok(Box::new(socketcan::connect(name)?))
}

#[cfg(not(target_os = "linux"))]
fn interface(name: &str) -> Result<Box<dyn Adapter>, AdapterError> {
    Err(AdapterError::OnlyLinux(name.to_owned()))
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
