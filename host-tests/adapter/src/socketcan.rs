//! SocketCAN of Linux. Bit rate and listen-only mode are properties of the interface: the tool reads them and says what to type. What the
//! interface has depends on its kind, which the kernel tells.
//!
//! | kind | bit rate and listen-only mode |
//! |---|---|
//! | `can` | set with `ip` |
//! | `vcan`, `vxcan` | none: there is no wire |
//! | others, for example the slcan driver of older kernels | set by the program that made the interface, and not told |

use super::{Adapter, Capabilities, Mode, instant};
use crate::error::AdapterError;
use embedded_can::Frame as _;
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;
use serde_json::Value;
use socketcan::{CanFrame, CanSocket, Socket as _};
use std::process::Command;
use std::{io, time};

/// ENOBUFS of Linux: the queue of the interface is full.
const NO_BUFFER: i32 = 105;

/// A socket of an interface.
pub trait Interface {
    /// The output of `ip -details -json link show` for the interface; None if the program `ip` is not there.
    ///
    /// # Errors
    /// There is no such interface.
    fn describe(&self) -> io::Result<Option<String>>;

    /// The received frames that the interface has lost since it was made; None: it does not tell.
    fn lost(&self) -> Option<u64>;

    /// Opens a socket.
    ///
    /// # Errors
    /// The interface does not exist or is down.
    fn open(&mut self) -> io::Result<()>;

    /// Closes the socket, so that other programs can change the interface.
    fn close(&mut self);

    /// Sends a frame.
    ///
    /// # Errors
    /// The interface is down or its queue is full.
    fn write(&mut self, frame: &CanFrame) -> io::Result<()>;

    /// The next frame; None after this time.
    ///
    /// # Errors
    /// The interface is down or was removed.
    fn read(&mut self, timeout: time::Duration) -> io::Result<Option<CanFrame>>;

    /// The time since it was made.
    fn elapsed(&self) -> time::Duration;
}

/// An interface of this computer.
pub struct Kernel {
    name: String,
    start: time::Instant,
    socket: Option<CanSocket>,
}

impl Interface for Kernel {
    fn describe(&self) -> io::Result<Option<String>> {
        let path = format!("/sys/class/net/{}", self.name);
        if !std::path::Path::new(&path).exists() {
            return Err(io::Error::new(io::ErrorKind::NotFound, "no such interface"));
        }
        let output = Command::new("ip")
            .args(["-details", "-json", "link", "show", "dev", &self.name])
            .output();
        Ok(output
            .ok()
            .map(|output| String::from_utf8_lossy(&output.stdout).into_owned()))
    }

    fn lost(&self) -> Option<u64> {
        let count = |name: &str| {
            let path = format!("/sys/class/net/{}/statistics/{name}", self.name);
            std::fs::read_to_string(path)
                .ok()?
                .trim()
                .parse::<u64>()
                .ok()
        };
        Some(count("rx_over_errors")? + count("rx_dropped")?)
    }

    fn open(&mut self) -> io::Result<()> {
        self.socket = Some(CanSocket::open(&self.name)?);
        Ok(())
    }

    fn close(&mut self) {
        self.socket = None;
    }

    fn write(&mut self, frame: &CanFrame) -> io::Result<()> {
        let socket = self.socket.as_ref().ok_or(io::ErrorKind::NotConnected)?;
        socket.write_frame(frame)
    }

    fn read(&mut self, timeout: time::Duration) -> io::Result<Option<CanFrame>> {
        let socket = self.socket.as_ref().ok_or(io::ErrorKind::NotConnected)?;
        match socket.read_frame_timeout(timeout) {
            Ok(frame) => Ok(Some(frame)),
            Err(error) if super::tcp::is_timeout(&error) => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn elapsed(&self) -> time::Duration {
        self.start.elapsed()
    }
}

/// An adapter that Linux has as a network interface.
pub struct SocketCan<I: Interface> {
    interface: I,
    name: String,
    mode: Option<Mode>,
    /// The bit rate of the interface, as it was when it was opened.
    rate: Option<BitRate>,
    errors: u64,
    /// The frames that the interface had lost before.
    lost_before: u64,
}

/// The adapter of an interface.
///
/// # Errors
/// There is no such interface.
pub fn connect(name: &str) -> Result<SocketCan<Kernel>, AdapterError> {
    let kernel = Kernel {
        name: name.to_owned(),
        start: time::Instant::now(),
        socket: None,
    };
    SocketCan::new(kernel, name)
}

impl<I: Interface> SocketCan<I> {
    /// The adapter of an interface.
    ///
    /// # Errors
    /// There is no such interface.
    pub fn new(interface: I, name: &str) -> Result<Self, AdapterError> {
        let described = interface
            .describe()
            .map_err(|_| AdapterError::NoInterface(name.to_owned()))?;
        if !Settings::of(&described.unwrap_or_default()).is_can {
            return Err(AdapterError::NotCan(name.to_owned()));
        }
        Ok(Self {
            interface,
            name: name.to_owned(),
            mode: None,
            rate: None,
            errors: 0,
            lost_before: 0,
        })
    }

    fn lost(&self, error: &io::Error) -> AdapterError {
        AdapterError::InterfaceLost(self.name.clone(), error.to_string())
    }

    /// The commands that give the interface a rate in bit/s and a mode, or switch on one that has neither.
    fn commands(&self, kind: &Kind, rate: Option<u32>, mode: Mode) -> String {
        let name = &self.name;
        if *kind != Kind::Can {
            return format!("sudo ip link set {name} up");
        }
        let rate = rate.map_or("RATE".to_owned(), |rate| rate.to_string());
        let listen = if mode == Mode::Listen { "on" } else { "off" };
        format!(
            "sudo ip link set {name} down; sudo ip link set {name} type can bitrate {rate} listen-only {listen}; sudo ip link set {name} up"
        )
    }

    fn settings(&self) -> Result<Settings, AdapterError> {
        let described = self.interface.describe();
        let text = described.map_err(|error| self.lost(&error))?;
        Ok(Settings::of(&text.unwrap_or_default()))
    }

    /// Checks rate and mode of the interface, and returns its rate. A virtual interface has neither.
    fn check(&self, rate: Option<BitRate>, mode: Mode) -> Result<Option<BitRate>, AdapterError> {
        let settings = self.settings()?;
        let (name, own, listens) = (&self.name, settings.rate, settings.listens);
        match &settings.kind {
            Kind::Can => {}
            Kind::Virtual => return Ok(None),
            Kind::Other(kind) if mode == Mode::Listen => {
                return Err(AdapterError::KindListens(name.clone(), kind.clone()));
            }
            Kind::Other(_) => return Ok(None),
        }
        let wanted = rate.map(BitRate::bits_per_second);
        let commands = self.commands(&settings.kind, wanted.or(own), mode);
        if mode == Mode::Listen && !listens {
            return Err(AdapterError::NotListening(name.clone(), commands));
        }
        if mode == Mode::Active && listens {
            return Err(AdapterError::OnlyListens(name.clone(), commands));
        }
        if let (Some(rate), Some(own)) = (rate, own)
            && own != rate.bits_per_second()
        {
            return Err(AdapterError::WrongRate(
                name.clone(),
                own,
                rate.name(),
                commands,
            ));
        }
        let mut rates = BitRate::ALL.into_iter();
        Ok(rates.find(|rate| Some(rate.bits_per_second()) == own))
    }
}

/// The kinds of interfaces, by what can be set.
#[derive(Clone, PartialEq, Eq, Debug)]
enum Kind {
    /// It has a bit rate and a mode.
    Can,
    /// It has neither, because there is no wire.
    Virtual,
    /// It has both, but another program sets them.
    Other(String),
}

/// What the kernel tells of an interface.
struct Settings {
    is_can: bool,
    kind: Kind,
    /// The bit rate in bit/s.
    rate: Option<u32>,
    listens: bool,
}

impl Settings {
    /// The settings in the output of `ip`. Without it, the interface counts as one of the kind `can` that does not tell its settings.
    fn of(text: &str) -> Self {
        let described: Value = serde_json::from_str(text).unwrap_or_default();
        let link = &described[0];
        let (info, data) = (&link["linkinfo"], &link["linkinfo"]["info_data"]);
        let kind = match info["info_kind"].as_str() {
            Some("can") => Kind::Can,
            Some("vcan" | "vxcan") => Kind::Virtual,
            Some(other) => Kind::Other(other.to_owned()),
            None if link.is_null() => Kind::Can,
            None => Kind::Other("without a kind".to_owned()),
        };
        // Some adapters have a list of rates in place of bit timing.
        let rate = data["bittiming"]["bitrate"].as_u64();
        let rate = rate.or_else(|| data["bittiming_bitrate"].as_u64());
        let modes = data["ctrlmode"].as_array();
        Self {
            is_can: link["link_type"].as_str().is_none_or(|own| own == "can"),
            kind,
            rate: rate
                .and_then(|rate| u32::try_from(rate).ok())
                .filter(|rate| *rate > 0),
            listens: modes.is_some_and(|modes| modes.iter().any(|mode| mode == "LISTEN-ONLY")),
        }
    }
}

impl<I: Interface> Adapter for SocketCan<I> {
    fn capabilities(&self) -> Capabilities {
        Capabilities {
            listen_only: true,
            sets_rate: false,
            needs_rate: false,
            reports_errors: false,
        }
    }

    fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), AdapterError> {
        self.close();
        self.rate = self.check(rate, mode)?;
        let opened = self.interface.open();
        opened.map_err(|error| {
            let wanted = rate.map(BitRate::bits_per_second);
            let kind = self.settings().map_or(Kind::Can, |settings| settings.kind);
            let (name, commands) = (&self.name, self.commands(&kind, wanted, mode));
            AdapterError::InterfaceUnopened(name.clone(), error.to_string(), commands)
        })?;
        self.mode = Some(mode);
        self.errors = 0;
        self.lost_before = self.interface.lost().unwrap_or(0);
        Ok(())
    }

    fn close(&mut self) {
        self.interface.close();
        self.mode = None;
    }

    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError> {
        if self.mode != Some(Mode::Active) {
            return Err(AdapterError::NotOpen);
        }
        let converted = if frame.is_remote() {
            CanFrame::new_remote(frame.id(), frame.dlc())
        } else {
            CanFrame::new(frame.id(), frame.bytes())
        };
        let Some(converted) = converted else {
            return Ok(());
        };
        let written = self.interface.write(&converted);
        written.map_err(|error| match error.raw_os_error() {
            Some(NO_BUFFER) => AdapterError::QueueFull,
            _ => self.lost(&error),
        })
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError> {
        loop {
            let wait = until.ticks().saturating_sub(self.now().ticks());
            let read = self
                .interface
                .read(time::Duration::from_micros(wait.max(100)));
            let frame = read.map_err(|error| self.lost(&error))?;
            let now = self.now();
            match frame {
                Some(CanFrame::Error(_)) => self.errors += 1,
                Some(frame) => {
                    let converted = if frame.is_remote_frame() {
                        Frame::remote(frame.id(), frame.dlc())
                    } else {
                        Frame::data(frame.id(), frame.data())
                    };
                    if let Some(frame) = converted {
                        return Ok(Some((now, frame)));
                    }
                }
                None if now >= until => return Ok(None),
                None => {}
            }
        }
    }

    fn now(&self) -> Instant {
        instant(self.interface.elapsed())
    }

    fn rate(&self) -> Option<BitRate> {
        self.rate
    }

    fn errors(&mut self) -> Option<u64> {
        None
    }

    fn overruns(&mut self) -> Option<u64> {
        let lost = self.interface.lost()?;
        Some(lost.saturating_sub(self.lost_before))
    }
}

#[cfg(test)]
mod tests;
