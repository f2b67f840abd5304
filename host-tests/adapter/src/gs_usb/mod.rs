//! CAN adapters with the gs_usb protocol (candleLight and others), on USB without a driver of the kernel.
//!
//! ```text
//!  control requests: type vendor, recipient interface, little-endian words of 32 bits
//!   0 HOST_FORMAT  out  0000BEEFh: the words are little-endian
//!   1 BITTIMING    out  propagation segment, phase segment 1, phase segment 2, jump width, prescaler
//!   2 MODE         out  0 reset, 1 start; flags
//!   4 BT_CONST     in   features, clock in Hz, limits of the bit timing
//!  14 GET_STATE    in   state, receive error counter, transmit error counter
//!  bulk transfers: one frame each, see `wire`
//! ```
//!
//! The order is: reset, bit timing, start. The tool uses the first channel.

use super::{Adapter, Capabilities, Mode, instant, lost, no_listen_only, no_rate};
use crate::error::AdapterError;
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;
use std::collections::VecDeque;
use std::time::Duration;
use std::{io, time};
use timing::BitTiming;
use wire::{Constants, Received};

mod device;
mod timing;
mod wire;

pub use device::{Layout, NusbDevice, Port, connect, ports};

/// The requests to the control endpoint.
mod request {
    pub const HOST_FORMAT: u8 = 0;
    pub const BITTIMING: u8 = 1;
    pub const MODE: u8 = 2;
    pub const BT_CONST: u8 = 4;
    pub const GET_STATE: u8 = 14;
}

/// The first channel of the adapter, the only one that is used.
const CHANNEL: u16 = 0;

/// The value of HOST_FORMAT for this byte order.
const LITTLE_ENDIAN: u32 = 0x0000_BEEF;

/// Frames that wait in the adapter. Small adapters have room for about 60.
const IN_FLIGHT: usize = 10;

/// How long a frame waits for room in the adapter. At 10 kbit/s, ten frames last 140 ms.
const PATIENCE: Duration = Duration::from_millis(250);

/// How long frames of the time before are dropped.
const DROPPING: Duration = Duration::from_millis(50);

/// An adapter that has sent nothing for this time has nothing left from the time before.
const QUIET: Duration = Duration::from_millis(2);

/// The transfers that are read after the end of a wait.
const LATE: u32 = 64;

/// The transfers to a USB device.
pub trait Usb {
    /// The bytes of the configuration descriptor and of the descriptors in it.
    fn configuration(&self) -> Vec<u8>;

    /// Takes the interface and its endpoints. All requests and transfers are to them.
    ///
    /// # Errors
    /// Another program or driver has it, or the device is gone.
    fn claim(&mut self, layout: &Layout) -> io::Result<()>;

    /// A vendor request with data to the interface.
    ///
    /// # Errors
    /// It was refused, or the device is gone.
    fn control_out(&mut self, request: u8, value: u16, data: &[u8]) -> io::Result<()>;

    /// A vendor request to the interface that returns `length` bytes or fewer.
    ///
    /// # Errors
    /// It was refused, or the device is gone.
    fn control_in(&mut self, request: u8, value: u16, length: u16) -> io::Result<Vec<u8>>;

    /// A bulk transfer to the device.
    ///
    /// # Errors
    /// `TimedOut`: the device does not take it. Others: the device is gone.
    fn write(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// The next bulk transfer from the device, as soon as there is one; None after this time.
    ///
    /// # Errors
    /// The device is gone.
    fn read(&mut self, timeout: Duration) -> io::Result<Option<Vec<u8>>>;
}

/// An adapter with the protocol of gs_usb (candleLight and others).
pub struct GsUsb<U: Usb> {
    usb: U,
    /// The name of the port, for messages.
    name: String,
    start: time::Instant,
    constants: Constants,
    opened: Option<(BitTiming, Mode)>,
    received: VecDeque<(Instant, Frame)>,
    /// The echo numbers of the frames that wait in the adapter.
    waiting: [bool; IN_FLIGHT],
    /// It has switched itself off the bus.
    is_off: bool,
    errors: u64,
    /// The frames with the flag of an overrun: frames before them are lost.
    overruns: u64,
}

impl<U: Usb> GsUsb<U> {
    /// The adapter with these transfers, which is closed at first.
    ///
    /// # Errors
    /// It is in use, has failed, or does not speak this protocol.
    pub fn new(mut usb: U, name: &str) -> Result<Self, AdapterError> {
        let foreign = || AdapterError::NotGsUsb(name.to_owned());
        let layout = Layout::of(&usb.configuration()).ok_or_else(foreign)?;
        usb.claim(&layout)
            .map_err(|error| AdapterError::UsbUnclaimed(name.to_owned(), error.to_string()))?;
        let format = LITTLE_ENDIAN.to_le_bytes();
        let constants = usb
            .control_out(request::HOST_FORMAT, 1, &format)
            .and_then(|()| usb.control_in(request::BT_CONST, CHANNEL, Constants::LENGTH));
        let constants = constants.map_err(|error| lost(name, &error))?;
        Ok(Self {
            usb,
            name: name.to_owned(),
            start: time::Instant::now(),
            constants: Constants::read(&constants).ok_or_else(foreign)?,
            opened: None,
            received: VecDeque::new(),
            waiting: [false; IN_FLIGHT],
            is_off: false,
            errors: 0,
            overruns: 0,
        })
    }

    fn lost(&self, error: &io::Error) -> AdapterError {
        lost(&self.name, error)
    }

    fn request(&mut self, request: u8, words: &[u32]) -> Result<(), AdapterError> {
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let done = self.usb.control_out(request, CHANNEL, &bytes);
        done.map_err(|error| self.lost(&error))
    }

    /// Stops the channel: it sends and acknowledges nothing, and drops the frames that wait in it.
    fn reset(&mut self) -> Result<(), AdapterError> {
        self.waiting = [false; IN_FLIGHT];
        self.is_off = false;
        self.request(request::MODE, &[0, 0])
    }

    /// Starts the channel, which was reset.
    fn run(&mut self, timing: &BitTiming, mode: Mode) -> Result<(), AdapterError> {
        self.request(request::BITTIMING, &timing.words())?;
        let flags = match mode {
            // Each error of the bus is reported, if it can.
            Mode::Listen => wire::LISTEN_ONLY | self.constants.features & wire::BUS_ERRORS,
            Mode::Active => 0,
        };
        self.request(request::MODE, &[1, flags])
    }

    /// Stops and starts the channel after bus-off, or when nobody acknowledges its frames.
    fn restart(&mut self) -> Result<(), AdapterError> {
        self.errors += 1;
        self.reset()?;
        match self.opened {
            Some((timing, mode)) => self.run(&timing, mode),
            None => Ok(()),
        }
    }

    /// Takes the next transfer. False: there was none in this time.
    fn pump(&mut self, timeout: Duration) -> Result<bool, AdapterError> {
        let read = self.usb.read(timeout);
        let Some(bytes) = read.map_err(|error| self.lost(&error))? else {
            return Ok(false);
        };
        let now = self.now();
        match Received::read(&bytes, CHANNEL) {
            Some(Received::Frame { frame, is_overrun }) => {
                self.errors += u64::from(is_overrun);
                self.overruns += u64::from(is_overrun);
                self.received.push_back((now, frame));
            }
            Some(Received::Echo(number)) => {
                let place = usize::try_from(number).unwrap_or(usize::MAX);
                if let Some(waits) = self.waiting.get_mut(place) {
                    *waits = false;
                }
            }
            Some(Received::Error { is_off }) => {
                self.errors += 1;
                self.is_off |= is_off;
            }
            None => {}
        }
        Ok(true)
    }

    /// A free echo number. If there is none for a while, nobody acknowledges the frames: they are dropped.
    fn echo_number(&mut self) -> Result<usize, AdapterError> {
        let begin = time::Instant::now();
        while !self.is_off && !self.waiting.contains(&false) {
            let left = PATIENCE.saturating_sub(begin.elapsed());
            // At least once, also if the computer was busy until now.
            self.pump(left)?;
            if left.is_zero() {
                break;
            }
        }
        if self.is_off || !self.waiting.contains(&false) {
            self.restart()?;
        }
        let free = self.waiting.iter().position(|waits| !waits);
        Ok(free.unwrap_or(0))
    }
}

impl<U: Usb> Adapter for GsUsb<U> {
    fn capabilities(&self) -> Capabilities {
        Capabilities {
            listen_only: self.constants.features & wire::LISTEN_ONLY != 0,
            sets_rate: true,
            needs_rate: true,
            reports_errors: true,
        }
    }

    fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), AdapterError> {
        self.opened = None;
        let name = &self.name;
        let Some(rate) = rate else {
            return Err(no_rate(name));
        };
        if mode == Mode::Listen && !self.capabilities().listen_only {
            return Err(no_listen_only(name));
        }
        let timing = BitTiming::find(rate, &self.constants).ok_or_else(|| {
            AdapterError::NoTiming(name.clone(), rate.name(), self.constants.clock)
        })?;
        // Another program may have left it open.
        self.reset()?;
        let begin = time::Instant::now();
        while self.pump(QUIET)? && begin.elapsed() < DROPPING {}
        self.received.clear();
        self.is_off = false;
        (self.errors, self.overruns) = (0, 0);
        self.run(&timing, mode)?;
        self.opened = Some((timing, mode));
        Ok(())
    }

    fn close(&mut self) {
        self.opened = None;
        // An adapter that has failed cannot be closed.
        let _ = self.reset();
        self.received.clear();
    }

    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError> {
        if !matches!(self.opened, Some((_, Mode::Active))) {
            return Err(AdapterError::NotOpen);
        }
        let mut number = self.echo_number()?;
        let mut written = self.usb.write(&self.constants.write(frame, number));
        if matches!(&written, Err(error) if error.kind() == io::ErrorKind::TimedOut) {
            // Its queue is full: nobody acknowledges the frames.
            self.restart()?;
            number = 0;
            written = self.usb.write(&self.constants.write(frame, number));
        }
        written.map_err(|error| self.lost(&error))?;
        self.waiting[number] = true;
        Ok(())
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError> {
        let mut late = 0;
        loop {
            if let Some(received) = self.received.pop_front() {
                return Ok(Some(received));
            }
            // It reads before it compares the time: a late call still receives the frames that have already arrived.
            let wait = until.ticks().saturating_sub(self.now().ticks());
            let came = self.pump(Duration::from_micros(wait))?;
            if self.received.is_empty() && self.now() >= until {
                if !came || late == LATE {
                    return Ok(None);
                }
                late += 1;
            }
        }
    }

    fn now(&self) -> Instant {
        instant(self.start.elapsed())
    }

    fn errors(&mut self) -> Option<u64> {
        self.opened?;
        if self.constants.features & wire::GET_STATE != 0 {
            let state = self.usb.control_in(request::GET_STATE, CHANNEL, 12).ok()?;
            // A counter above 0: there was an error. It decreases with each good frame.
            let is_disturbed = state.iter().skip(4).any(|byte| *byte != 0);
            self.errors = self.errors.max(u64::from(is_disturbed));
        }
        Some(self.errors)
    }

    fn overruns(&mut self) -> Option<u64> {
        Some(self.overruns)
    }
}

impl<U: Usb> Drop for GsUsb<U> {
    fn drop(&mut self) {
        if self.opened.is_some() {
            self.close();
        }
    }
}

#[cfg(test)]
mod tests;
