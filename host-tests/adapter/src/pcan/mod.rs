//! PCAN adapters by PEAK's library PCAN-Basic, on Windows, Linux and macOS.
//!
//! | port | channel of the library |
//! |---|---|
//! | `pcan`, `pcan:USBBUS1` | the first adapter on USB |
//! | `pcan:USBBUS2` to `pcan:USBBUS16` | further ones, and further channels of an adapter with several |
//! | `pcan:PCIBUS1` to `pcan:PCIBUS16` | on PCI |
//! | `pcan:LANBUS1` to `pcan:LANBUS16` | gateways to Ethernet and WLAN |
//!
//! The library has no wait for a frame that works on all systems in the same way, so it is asked every half millisecond.

use super::{Adapter, Capabilities, Mode, instant, lost, no_listen_only, no_rate};
use crate::error::{AdapterError, PcanHint};
use embedded_can::{ExtendedId, Id, StandardId};
use library::{FILE, Message, Parameter, PcanBasic, Status};
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;
use std::time::Duration;
use std::{thread, time};

mod library;

/// The channels of a kind: its name, and the handles of the first eight and of the others.
const KINDS: [(&str, u16, u16); 3] = [
    ("USBBUS", 0x51, 0x509),
    ("PCIBUS", 0x41, 0x409),
    ("LANBUS", 0x801, 0x809),
];

/// The channels of each kind.
const CHANNELS: u16 = 16;

/// The prefix of the channels in PEAK's documents.
const PREFIX: &str = "PCAN_";

/// Bits of the kind of a frame.
mod kind {
    pub const REMOTE: u8 = 0x01;
    pub const EXTENDED: u8 = 0x02;
    /// Not a received frame: of CAN FD, an echo, a status.
    pub const OTHER: u8 = 0x04 | 0x20 | 0x80;
    pub const ERROR: u8 = 0x40;
}

/// The wait between two questions for a frame.
const PAUSE: Duration = Duration::from_micros(500);

/// How long a frame waits for room in the queue.
const PATIENCE: Duration = Duration::from_millis(250);

/// A channel of an adapter.
pub struct Pcan {
    library: PcanBasic,
    /// The name of the port, for messages.
    name: String,
    channel: u16,
    start: time::Instant,
    opened: Option<(BitRate, Mode)>,
    errors: u64,
    overruns: u64,
}

/// The handle of a channel by its name, for example `USBBUS1`.
fn handle(name: &str) -> Option<u16> {
    let name = name.to_ascii_uppercase();
    let name = name.strip_prefix(PREFIX).unwrap_or(&name);
    let (number, first, others) = KINDS.into_iter().find_map(|(kind, first, others)| {
        let number = name.strip_prefix(kind)?.parse::<u16>().ok()?;
        Some((number, first, others))
    })?;
    match number {
        1..=8 => Some(first + number - 1),
        9..=CHANNELS => Some(others + number - 9),
        _ => None,
    }
}

/// Whether the library has a channel with this name.
pub fn is_channel(name: &str) -> bool {
    handle(name).is_some()
}

/// BTR0 and BTR1 of an SJA1000 at 8 MHz: those of PCAN-Basic, and for 62.5 kbit/s the same sample point as for 125 kbit/s.
const fn timing(rate: BitRate) -> u16 {
    match rate {
        BitRate::K10 => 0x672F,
        BitRate::K20 => 0x532F,
        BitRate::K50 => 0x472F,
        BitRate::K62_5 => 0x071C,
        BitRate::K100 => 0x432F,
        BitRate::K125 => 0x031C,
        BitRate::K250 => 0x011C,
        BitRate::K500 => 0x001C,
        BitRate::K800 => 0x0016,
        BitRate::M1 => 0x0014,
    }
}

/// The library, or why there is none.
fn load() -> Result<PcanBasic, AdapterError> {
    PcanBasic::load().map_err(|_| {
        let hint = if cfg!(windows) {
            PcanHint::Windows
        } else if cfg!(target_os = "macos") {
            PcanHint::MacOs
        } else {
            PcanHint::Linux
        };
        AdapterError::NoLibrary(FILE, hint)
    })
}

/// The channel with this name, which is closed at first.
///
/// # Errors
/// There is no such name, or no library.
pub fn connect(name: &str) -> Result<Pcan, AdapterError> {
    let name = if name.is_empty() { "USBBUS1" } else { name };
    let Some(channel) = handle(name) else {
        return Err(AdapterError::NoChannel(name.to_owned(), CHANNELS));
    };
    Ok(Pcan {
        library: load()?,
        name: format!(
            "pcan:{}",
            name.to_ascii_uppercase().trim_start_matches(PREFIX)
        ),
        channel,
        start: time::Instant::now(),
        opened: None,
        errors: 0,
        overruns: 0,
    })
}

/// The ports of the channels that this computer has, and whether another program uses them. None without the library.
pub fn ports() -> Vec<(String, bool)> {
    let Ok(library) = load() else {
        return Vec::new();
    };
    let names = KINDS
        .iter()
        .flat_map(|(kind, ..)| (1..=CHANNELS).map(move |number| format!("{kind}{number}")));
    let present = names.filter_map(|name| {
        let (status, condition) = library.get(handle(&name)?, Parameter::Condition);
        let is_present = status == Status::OK && condition != 0;
        is_present.then(|| (format!("pcan:{name}"), condition != 1))
    });
    present.collect()
}

impl Pcan {
    fn lost(&self, status: Status) -> AdapterError {
        lost(&self.name, self.library.text(status))
    }

    /// Opens the channel. The library then has an empty queue.
    fn initialize(&self, rate: BitRate, mode: Mode) -> Result<(), AdapterError> {
        let (library, channel, name) = (&self.library, self.channel, &self.name);
        let listens = u32::from(mode == Mode::Listen);
        // Before the channel is open, so that it never acknowledges a frame. Older versions take it only afterwards.
        library.set(channel, Parameter::ListenOnly, listens);
        let status = library.initialize(channel, timing(rate));
        if status != Status::OK {
            library.uninitialize(channel);
            let text = library.text(status);
            return Err(match () {
                () if status.is_in_use() => AdapterError::InUse(name.clone()),
                () if status.is_missing() => AdapterError::Missing(name.clone(), text),
                () => AdapterError::Unopened(name.clone(), text),
            });
        }
        library.set(channel, Parameter::ListenOnly, listens);
        if library.get(channel, Parameter::ListenOnly) != (Status::OK, listens) {
            library.uninitialize(channel);
            return Err(no_listen_only(name));
        }
        // Without these, it still receives and sends.
        library.set(channel, Parameter::BusOffAutoReset, 1);
        library.set(channel, Parameter::AllowErrorFrames, 1);
        Ok(())
    }

    /// The next frame in the queue; None if it is empty.
    fn next(&mut self) -> Result<Option<Frame>, AdapterError> {
        loop {
            let (status, message) = self.library.read(self.channel);
            if !status.is_working() {
                return Err(self.lost(status));
            }
            self.errors += u64::from(status.is_disturbed());
            self.overruns += u64::from(status.is_overrun());
            if status != Status::OK {
                return Ok(None);
            }
            self.errors += u64::from(message.kind & kind::ERROR != 0);
            if let Some(frame) = frame(&message) {
                return Ok(Some(frame));
            }
        }
    }
}

/// A received frame; None for a message that is none.
fn frame(message: &Message) -> Option<Frame> {
    if message.kind & (kind::ERROR | kind::OTHER) != 0 {
        return None;
    }
    let id = match message.kind & kind::EXTENDED {
        0 => Id::Standard(StandardId::new(message.id.try_into().ok()?)?),
        _ => Id::Extended(ExtendedId::new(message.id)?),
    };
    let length = usize::from(message.length);
    match message.kind & kind::REMOTE {
        0 => Frame::data(id, message.data.get(..length)?),
        _ => Frame::remote(id, length),
    }
}

/// A frame to send.
fn message(frame: &Frame) -> Message {
    let (id, extended) = match frame.id() {
        Id::Standard(id) => (id.as_raw().into(), 0),
        Id::Extended(id) => (id.as_raw(), kind::EXTENDED),
    };
    let remote = if frame.is_remote() { kind::REMOTE } else { 0 };
    let mut data = [0; 8];
    data[..frame.bytes().len()].copy_from_slice(frame.bytes());
    Message {
        id,
        kind: extended | remote,
        length: u8::try_from(frame.dlc()).unwrap_or(8),
        data,
    }
}

impl Adapter for Pcan {
    fn capabilities(&self) -> Capabilities {
        Capabilities {
            listen_only: true,
            sets_rate: true,
            needs_rate: true,
            reports_errors: true,
        }
    }

    fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), AdapterError> {
        self.close();
        let Some(rate) = rate else {
            return Err(no_rate(&self.name));
        };
        self.initialize(rate, mode)?;
        (self.errors, self.overruns) = (0, 0);
        self.opened = Some((rate, mode));
        Ok(())
    }

    fn close(&mut self) {
        if self.opened.take().is_some() {
            self.library.uninitialize(self.channel);
        }
    }

    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError> {
        let Some((rate, Mode::Active)) = self.opened else {
            return Err(AdapterError::NotOpen);
        };
        let begin = time::Instant::now();
        loop {
            let status = self.library.write(self.channel, message(frame));
            if !status.is_working() {
                return Err(self.lost(status));
            }
            if status.is_bus_off() {
                self.errors += 1;
                self.library.uninitialize(self.channel);
                self.initialize(rate, Mode::Active)?;
            } else if !status.is_full() {
                return Ok(());
            } else if begin.elapsed() >= PATIENCE {
                // Nobody acknowledges the frames in the queue: they are dropped.
                self.errors += 1;
                let status = self.library.reset(self.channel);
                let last = self.library.write(self.channel, message(frame));
                let is_working = status.is_working() && last.is_working();
                return if is_working {
                    Ok(())
                } else {
                    Err(self.lost(last))
                };
            } else {
                thread::sleep(PAUSE);
            }
        }
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError> {
        loop {
            // It reads after it has taken the time: a late call still receives the frames that have already arrived.
            let now = self.now();
            if let Some(frame) = self.next()? {
                return Ok(Some((self.now(), frame)));
            }
            if now >= until {
                return Ok(None);
            }
            let left = Duration::from_micros(until.ticks().saturating_sub(now.ticks()));
            thread::sleep(left.min(PAUSE));
        }
    }

    fn now(&self) -> Instant {
        instant(self.start.elapsed())
    }

    fn errors(&mut self) -> Option<u64> {
        self.opened?;
        let is_disturbed = self.library.status(self.channel).is_disturbed();
        self.errors = self.errors.max(u64::from(is_disturbed));
        Some(self.errors)
    }

    fn overruns(&mut self) -> Option<u64> {
        Some(self.overruns)
    }
}

impl Drop for Pcan {
    fn drop(&mut self) {
        self.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_have_the_names_and_handles_of_the_library() {
        let handles = [
            ("USBBUS1", 0x51),
            ("usbbus8", 0x58),
            ("PCAN_USBBUS9", 0x509),
            ("USBBUS16", 0x510),
            ("PCIBUS1", 0x41),
            ("LANBUS16", 0x810),
        ];
        for (name, expected) in handles {
            assert_eq!(handle(name), Some(expected), "{name}");
        }
        for name in [
            "", "1", "USBBUS", "USBBUS0", "USBBUS17", "USBBUS-1", "ISABUS1",
        ] {
            assert_eq!(handle(name), None, "{name:?}");
        }
    }

    /// BTR0: prescaler - 1 in bits 0 to 5. BTR1: time segments - 1 in bits 0 to 3 and 4 to 6.
    #[test]
    fn timing_has_the_bit_rate_and_a_sample_point_of_68_to_88_percent() {
        for rate in BitRate::ALL {
            let [btr0, btr1] = timing(rate).to_be_bytes().map(u32::from);
            let (prescaler, first, second) =
                ((btr0 & 63) + 1, (btr1 & 15) + 1, (btr1 >> 4 & 7) + 1);
            let quanta = 1 + first + second;
            let bits = 8_000_000 / (prescaler * quanta);
            assert_eq!(bits, rate.bits_per_second(), "{}", rate.name());
            let sample_point = 100 * (1 + first) / quanta;
            assert!(
                (68..=88).contains(&sample_point),
                "{}: {sample_point}",
                rate.name()
            );
        }
    }

    #[test]
    fn frames_become_messages_and_messages_frames() {
        let standard = Id::Standard(StandardId::new(0x7FF).unwrap());
        let extended = Id::Extended(ExtendedId::new(0x18EF_FF80).unwrap());
        let frames = [
            Frame::data(standard, &[1, 2, 3]).unwrap(),
            Frame::remote(standard, 8).unwrap(),
            Frame::data(extended, &[]).unwrap(),
            Frame::remote(extended, 0).unwrap(),
        ];
        for (sent, kind) in frames.iter().zip([0, 1, 2, 3]) {
            let message = message(sent);
            assert_eq!(message.kind, kind);
            assert_eq!(frame(&message).as_ref(), Some(sent));
        }
        for kind in [0x04, 0x20, 0x40, 0x80] {
            assert_eq!(
                frame(&Message {
                    kind,
                    ..Message::default()
                }),
                None,
                "{kind:02X}h"
            );
        }
    }
}
