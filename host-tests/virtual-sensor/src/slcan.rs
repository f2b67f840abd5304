//! The LAWICEL ASCII protocol ("slcan") of an adapter: lines from a client become calls of a CAN port, received frames become
//! lines. No I/O.
//!
//! A line ends with CR (0Dh). Every line is answered at once: with CR, or with BEL (07h) when it is refused, which has no other
//! effect.
//!
//! ```text
//!  line           answer     meaning
//!  (empty)        CR         drivers send empty lines to get in step
//!  Sn             CR         bit rate 10, 20, 50, 100, 125, 250, 500, 800, 1000 kbit/s for n = 0..8; only while closed
//!  sxxyy          CR         bit rate from the SJA1000's registers BTR0 and BTR1 at 16 MHz; only while closed
//!  O   L          CR         open; open listen-only. The same again while open: nothing changes
//!  C              CR         close. Again while closed: nothing changes
//!  tiiil(dd)*     z CR       send a data frame: identifier of 3 hex digits, length 0..8, that many bytes of 2 digits
//!  Tiiiiiiiil...  Z CR       the same with a 29-bit identifier of 8 digits
//!  riiil          z CR       send a remote frame
//!  Riiiiiiiil     Z CR       the same with a 29-bit identifier
//!  F              Fhh CR     status flags: bit 1 = the transmit queue has overrun since they were last read; only while open
//!  Z0  Z1         CR         time stamps off, on; only while closed
//!  V   N          V1010 CR   version, Nxxxx CR serial number
//! ```
//!
//! Received frames are sent as `t`, `T`, `r` and `R` lines; with time stamps on, followed by the milliseconds within the current
//! minute in 4 digits. Before the channel is open, only answers are sent. Hexadecimal digits are accepted in either case and sent
//! in upper case. The acceptance filter commands `M` and `m` are refused: a client receives all frames of the bus.
//!
//! Two differences from the LAWICEL manual: python-can opens twice and closes a closed channel, so both are answered with CR; and
//! opening without a bit rate is permitted, because a simulated bus has one.

use can_wire::slcan::{RATES, read_hex, write_frame, write_hex};
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;

const CR: u8 = b'\r';
const BEL: u8 = 0x07;

/// The longest valid line: `T`, 8 digits of identifier, length, 8 bytes.
const LINE_MAX: usize = 1 + 8 + 1 + 16;

/// The status flag "transmit queue full" in the answer to `F`.
const TRANSMIT_OVERRUN: u8 = 1 << 1;

/// The answers to `V` (hardware 1.0, protocol 1.0) and `N`.
const VERSION: &[u8] = b"V1010";
const SERIAL: &[u8] = b"N0001";

/// The CAN controller of a [`Channel`].
pub trait Port {
    /// Takes part in the bus at `rate` (None: at the rate of the bus), or only listens.
    fn open(&mut self, rate: Option<BitRate>, listen_only: bool);
    /// Leaves the bus and receives nothing more.
    fn close(&mut self);
    /// Queues a frame for transmission.
    fn send(&mut self, frame: Frame) -> Result<(), QueueFull>;
}

/// A frame was refused because too many are already waiting.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct QueueFull;

/// The settings of one client, and its incomplete line.
#[derive(Clone, Debug, Default)]
pub struct Channel {
    line: heapless::Vec<u8, LINE_MAX>,
    /// The line is longer than any valid one; the rest of it is ignored.
    too_long: bool,
    mode: Mode,
    rate: Option<BitRate>,
    time_stamps: bool,
    flags: u8,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
enum Mode {
    #[default]
    Closed,
    Open,
    ListenOnly,
}

/// The line is not a command, or not permitted in this state of the channel.
struct Refused;

impl Channel {
    /// The initial channel of a client: closed, without time stamps.
    pub fn new() -> Self {
        Self::default()
    }

    /// True between `O` or `L` and `C`.
    pub fn is_open(&self) -> bool {
        self.mode != Mode::Closed
    }

    /// Processes input from the client, in pieces of any size, and appends the answers to `answers`.
    pub fn input(&mut self, bytes: &[u8], port: &mut impl Port, answers: &mut Vec<u8>) {
        for &byte in bytes {
            if byte != CR {
                self.too_long |= self.line.push(byte).is_err();
                continue;
            }
            let line = core::mem::take(&mut self.line);
            let too_long = core::mem::take(&mut self.too_long);
            let start = answers.len();
            if too_long || self.execute(&line, port, answers).is_err() {
                answers.truncate(start);
                answers.push(BEL);
            } else {
                answers.push(CR);
            }
        }
    }

    /// Appends the line for a frame received at `at`; nothing while the channel is closed.
    pub fn received(&self, at: Instant, frame: &Frame, lines: &mut Vec<u8>) {
        if !self.is_open() {
            return;
        }
        write_frame(frame, lines);
        if self.time_stamps {
            write_hex(at.ticks() / 1000 % 60_000, 4, lines);
        }
        lines.push(CR);
    }

    /// Executes one line; returns the answer without its CR.
    fn execute(
        &mut self,
        line: &[u8],
        port: &mut impl Port,
        answer: &mut Vec<u8>,
    ) -> Result<(), Refused> {
        match line {
            [] => {}
            [b'S', digit] => self.set_rate(standard_rate(*digit))?,
            [b's', registers @ ..] => self.set_rate(register_rate(registers))?,
            [b'O'] => self.open(Mode::Open, port)?,
            [b'L'] => self.open(Mode::ListenOnly, port)?,
            [b'C'] => {
                if self.is_open() {
                    self.mode = Mode::Closed;
                    port.close();
                }
            }
            [kind @ (b't' | b'T' | b'r' | b'R'), ..] => {
                let frame = read_frame(line).ok_or(Refused)?;
                if self.mode != Mode::Open {
                    return Err(Refused);
                }
                if port.send(frame) == Err(QueueFull) {
                    self.flags |= TRANSMIT_OVERRUN;
                    return Err(Refused);
                }
                answer.push(if kind.is_ascii_lowercase() {
                    b'z'
                } else {
                    b'Z'
                });
            }
            [b'F'] if self.is_open() => {
                answer.push(b'F');
                write_hex(core::mem::take(&mut self.flags).into(), 2, answer);
            }
            [b'Z', digit @ (b'0' | b'1')] if !self.is_open() => self.time_stamps = *digit == b'1',
            [b'V'] => answer.extend_from_slice(VERSION),
            [b'N'] => answer.extend_from_slice(SERIAL),
            _ => return Err(Refused),
        }
        Ok(())
    }

    fn set_rate(&mut self, rate: Option<BitRate>) -> Result<(), Refused> {
        if self.is_open() {
            return Err(Refused);
        }
        self.rate = Some(rate.ok_or(Refused)?);
        Ok(())
    }

    fn open(&mut self, mode: Mode, port: &mut impl Port) -> Result<(), Refused> {
        if !self.is_open() {
            self.mode = mode;
            self.flags = 0;
            port.open(self.rate, mode == Mode::ListenOnly);
        }
        if self.mode == mode {
            Ok(())
        } else {
            Err(Refused)
        }
    }
}

/// The bit rate of `Sn`.
fn standard_rate(digit: u8) -> Option<BitRate> {
    RATES.get(usize::from(digit.checked_sub(b'0')?)).copied()
}

/// The bit rate of `sxxyy`; None when it is not one of the ten.
///
/// The SJA1000 divides its 16 MHz by 2 and by (the low 6 bits of BTR0) + 1 for the time quantum; a bit has 1 quantum, (the low 4
/// bits of BTR1) + 1 and (the next 3 bits) + 1.
fn register_rate(registers: &[u8]) -> Option<BitRate> {
    if registers.len() != 4 {
        return None;
    }
    let (btr0, btr1) = read_hex(registers).map(|both| (both >> 8, both & 0xFF))?;
    let quanta = 1 + (btr1 & 0xF) + 1 + (btr1 >> 4 & 7) + 1;
    let divider = ((btr0 & 0x3F) + 1) * quanta;
    BitRate::ALL
        .into_iter()
        .find(|rate| rate.bits_per_second() * divider == 8_000_000)
}

/// Reads a `t`, `T`, `r` or `R` line without its CR; None unless the complete line is valid.
fn read_frame(line: &[u8]) -> Option<Frame> {
    let (frame, rest) = can_wire::slcan::read_frame(line)?;
    rest.is_empty().then_some(frame)
}

#[cfg(test)]
mod tests;
