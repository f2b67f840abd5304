//! The ADXL355 on the SPI: accelerometer and thermometer, with readings from a [`Motion`] and the noise of the real one.
//!
//! | address | register | reset | |
//! |---|---|---|---|
//! | 00h..03h | DEVID_AD, DEVID_MST, PARTID, REVID | ADh, 1Dh, EDh, 01h | read-only |
//! | 04h | STATUS | | data ready, FIFO full, FIFO overrun, NVM busy |
//! | 05h | FIFO_ENTRIES | 0 | entries of the FIFO, three for each value |
//! | 06h, 07h | TEMP2, TEMP1 | | 12 bits |
//! | 08h..10h | XDATA to ZDATA | | 20 bits each, left-justified |
//! | 11h | FIFO_DATA | | three bytes for each entry; the address stays |
//! | 1Eh..23h | OFFSET_X to OFFSET_Z | 0 | in 2^4 counts |
//! | 24h..27h | ACT_EN to ACT_COUNT | 0, 0, 0, 1 | stored |
//! | 28h | FILTER | 0 | data rate; without high-pass |
//! | 29h | FIFO_SAMPLES | 60h | |
//! | 2Ah, 2Bh | INT_MAP, SYNC | 0 | stored |
//! | 2Ch | RANGE | 81h | |
//! | 2Dh | POWER_CTL | 01h | standby, temperature off |
//! | 2Eh | SELF_TEST | 0 | mode and force |
//! | 2Fh | RESET | | 52h resets |
//! | 50h..54h | shadow registers | | the same after each correct start |
//!
//! A write of the configuration while the part measures, and an access to another register, is recorded ([`Adxl355::take_complaint`]).
//!
//! Not confirmed by a datasheet: when the axes of a value appear in the FIFO (here one every 20 us), the length of the boot and of a reset,
//! and the response of the low-pass (here the mean with triangular weights of two periods, whose gain at a quarter of the data rate is that
//! of the table of the manufacturer, -1.8 dB).

mod fifo;
mod sampling;
#[cfg(test)]
mod tests;

use super::ism330dhcx::Noise;
use super::ism330dhcx::fault::Line;
use super::spi::SpiPart;
use super::timebase::{MICROSECOND, Picoseconds};
use bench::motion::Motion;
use sampling::Sampling;
use std::fmt;

const PARTID: u8 = 0x02;
const STATUS: u8 = 0x04;
const FIFO_ENTRIES: u8 = 0x05;
const TEMP2: u8 = 0x06;
const TEMP1: u8 = 0x07;
const XDATA3: u8 = 0x08;
const ZDATA1: u8 = 0x10;
const FIFO_DATA: u8 = 0x11;
const OFFSET_X_H: u8 = 0x1E;
const ACT_COUNT: u8 = 0x27;
const FILTER: u8 = 0x28;
const FIFO_SAMPLES: u8 = 0x29;
const SYNC: u8 = 0x2B;
const RANGE: u8 = 0x2C;
const POWER_CTL: u8 = 0x2D;
const SELF_TEST: u8 = 0x2E;
const RESET: u8 = 0x2F;
const SHADOWS: u8 = 0x50;

/// The identity, with the revision.
const IDENTITY: [u8; 4] = [0xAD, 0x1D, 0xED, 0x01];

/// The shadow registers of a part that has started.
const STARTED: [u8; 5] = [0x12, 0x34, 0x56, 0x78, 0x9A];

/// The value of RESET that resets.
const RESET_CODE: u8 = 0x52;

/// The time from power-up until it answers, and the time in which it loads its trimming after a reset.
const BOOT_TIME: Picoseconds = 10_000 * MICROSECOND;
const LOADING_TIME: Picoseconds = 2_000 * MICROSECOND;

/// The value read from a part that is not mounted or not selected: the line floats high.
const NOTHING: u8 = 0xFF;

/// A fault of the part.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Fault {
    /// Nothing.
    None,
    /// It does not answer: every byte reads as this value, FFh or 00h.
    Silent(u8),
    /// Its oscillator has stopped: it answers, but there are no values.
    Stopped,
    /// All values are 0.
    Zeros,
    /// The value of an axis does not change.
    StuckAxis(usize),
    /// No value changes.
    Frozen,
    /// The temperature does not change.
    StuckTemperature,
}

/// The state of a transfer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Transfer {
    Idle,
    Address,
    Read(u8),
    Write(u8),
}

/// The registers from OFFSET_X_H to SELF_TEST.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Registers([u8; (SELF_TEST - OFFSET_X_H + 1) as usize]);

impl Registers {
    const RESET: Self = {
        let mut registers = [0; (SELF_TEST - OFFSET_X_H + 1) as usize];
        registers[(ACT_COUNT - OFFSET_X_H) as usize] = 1;
        registers[(FIFO_SAMPLES - OFFSET_X_H) as usize] = 0x60;
        registers[(RANGE - OFFSET_X_H) as usize] = 0x81;
        registers[(POWER_CTL - OFFSET_X_H) as usize] = 0x01;
        Self(registers)
    };

    fn get(&self, register: u8) -> u8 {
        self.0[usize::from(register - OFFSET_X_H)]
    }
}

/// The part.
pub struct Adxl355 {
    motion: Box<dyn Motion>,
    mounted: bool,
    fault: Fault,
    part: u8,
    /// The number of resets after which it has not started.
    bad_starts: u8,
    shadows: [u8; 5],
    line: Line,
    transfer: Transfer,
    registers: Registers,
    sampling: Sampling,
    /// The time from which it answers, and the end of the loading of the trimming.
    booted: Picoseconds,
    loaded: Picoseconds,
    complaints: Vec<(u8, &'static str)>,
}

impl fmt::Debug for Adxl355 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Adxl355")
            .field("mounted", &self.mounted)
            .field("fault", &self.fault)
            .field("registers", &self.registers)
            .finish_non_exhaustive()
    }
}

impl Adxl355 {
    /// A part that is powered on at time 0.
    pub fn new(motion: Box<dyn Motion>) -> Self {
        Self {
            motion,
            mounted: true,
            fault: Fault::None,
            part: IDENTITY[2],
            bad_starts: 0,
            shadows: STARTED,
            line: Line::default(),
            transfer: Transfer::Idle,
            registers: Registers::RESET,
            sampling: Sampling::new(),
            booted: BOOT_TIME,
            loaded: BOOT_TIME,
            complaints: Vec::new(),
        }
    }

    /// Replaces its motion from `now` on.
    pub fn set_motion(&mut self, now: Picoseconds, motion: Box<dyn Motion>) {
        self.settle(now);
        self.motion = motion;
    }

    /// Sets its fault from `now` on.
    pub fn set_fault(&mut self, now: Picoseconds, fault: Fault) {
        self.settle(now);
        self.fault = fault;
    }

    /// Inverts each bit that it sends with this probability, the same bits for the same seed.
    pub fn set_bit_error_rate(&mut self, rate: f64, seed: u64) {
        self.line.set_rate(rate, seed);
    }

    /// Replaces the next `count` bytes that it sends after `skipped` more ones by this value: the contact of the line is open for a moment.
    pub fn open_line(&mut self, skipped: u32, count: u32, value: u8) {
        self.line.open(skipped, count, value);
    }

    /// PARTID: EDh, or E9h of an ADXL359.
    pub fn set_part(&mut self, part: u8) {
        self.part = part;
    }

    /// The next resets do not start it correctly.
    pub fn set_bad_starts(&mut self, count: u8) {
        self.bad_starts = count;
    }

    /// From `now` on its oscillator is this many percent faster than nominal (slower if negative).
    pub fn set_clock_deviation(&mut self, now: Picoseconds, percent: f64) {
        self.settle(now);
        self.sampling.set_clock_deviation(percent);
    }

    /// The error of its axes at 0 g, in g.
    pub fn set_offset(&mut self, offset: [f64; 3]) {
        self.sampling.offset = offset;
    }

    /// Sets whether the self-test moves the accelerometer as specified in the datasheet.
    pub fn set_self_test_works(&mut self, works: bool) {
        self.sampling.self_test_works = works;
    }

    /// Sets its noise, which is the real one from the start.
    pub fn set_noise(&mut self, noise: Noise) {
        self.sampling.digits.noise = noise;
    }

    /// Removes it from the board.
    pub fn unmount(&mut self) {
        self.mounted = false;
    }

    /// Mounts it on the board, or switches its supply on: it restarts.
    pub fn power_on(&mut self, now: Picoseconds) {
        self.mounted = true;
        self.transfer = Transfer::Idle;
        self.booted = now + BOOT_TIME;
        self.reset(self.booted);
    }

    /// A register changes by a disturbance.
    pub fn disturb(&mut self, now: Picoseconds, register: u8, bits: u8) {
        self.settle(now);
        self.registers.0[usize::from(register - OFFSET_X_H)] ^= bits;
        self.apply(now);
    }

    /// The value of a register of the configuration.
    pub fn register(&self, register: u8) -> u8 {
        self.registers.get(register)
    }

    /// The number of values that its FIFO has lost since the last call.
    pub fn take_overruns(&mut self) -> u32 {
        std::mem::take(&mut self.sampling.fifo.lost)
    }

    /// What was wrong since the last call, with its register.
    pub fn take_complaint(&mut self) -> Option<(u8, &'static str)> {
        self.complaints.pop()
    }

    fn reset(&mut self, now: Picoseconds) {
        self.registers = Registers::RESET;
        self.sampling.reset();
        self.loaded = now + LOADING_TIME;
    }

    fn answers(&self, now: Picoseconds) -> bool {
        self.mounted && now >= self.booted && !matches!(self.fault, Fault::Silent(_))
    }

    /// Updates the state of the part.
    fn settle(&mut self, now: Picoseconds) {
        self.sampling.advance(now, self.fault, &mut *self.motion);
    }

    /// The configuration takes effect.
    fn apply(&mut self, now: Picoseconds) {
        let registers = &self.registers;
        let offsets =
            [0, 2, 4].map(|at| i16::from_be_bytes([registers.0[at], registers.0[at + 1]]).into());
        self.sampling.set_up(
            now,
            registers.get(POWER_CTL),
            registers.get(FILTER),
            registers.get(RANGE),
            registers.get(SELF_TEST),
            offsets,
        );
    }

    fn read(&mut self, now: Picoseconds, register: u8) -> u8 {
        match register {
            PARTID => self.part,
            0..STATUS => IDENTITY[usize::from(register)],
            STATUS => {
                let loading = u8::from(now < self.loaded) << 4;
                let samples = self.registers.get(FIFO_SAMPLES);
                loading | self.sampling.take_status(now, samples)
            }
            FIFO_ENTRIES => self.sampling.fifo.entries(now),
            TEMP2..=TEMP1 => self.sampling.temperature[usize::from(register - TEMP2)],
            XDATA3..=ZDATA1 => self.sampling.data[usize::from(register - XDATA3)],
            FIFO_DATA => self.sampling.fifo.read(now),
            OFFSET_X_H..=SELF_TEST => self.registers.get(register),
            SHADOWS..=0x54 => self.shadows[usize::from(register - SHADOWS)],
            _ => {
                self.complain(register, "register not modelled");
                0
            }
        }
    }

    fn write(&mut self, now: Picoseconds, register: u8, value: u8) {
        let measures = self.registers.get(POWER_CTL) & 1 == 0;
        match register {
            RESET if value == RESET_CODE => {
                self.shadows = STARTED;
                if self.bad_starts > 0 {
                    self.bad_starts -= 1;
                    self.shadows[usize::from(self.bad_starts) % 5] ^= 0xFF;
                }
                self.reset(now);
                return;
            }
            OFFSET_X_H..=RANGE if measures => {
                self.complain(register, "written while the part measures");
            }
            OFFSET_X_H..=SELF_TEST => {}
            _ => {
                self.complain(register, "register not modelled");
                return;
            }
        }
        if now < self.loaded {
            self.complain(register, "written while the part loads its trimming");
        }
        if register == FILTER && value & 0xF0 != 0 || register == SYNC && value != 0 {
            self.complain(register, "value not modelled");
        }
        self.registers.0[usize::from(register - OFFSET_X_H)] = value;
        self.apply(now);
    }

    fn complain(&mut self, register: u8, what: &'static str) {
        self.complaints.push((register, what));
    }
}

impl SpiPart for Adxl355 {
    fn select(&mut self, _: Picoseconds, selected: bool) {
        self.transfer = if selected {
            Transfer::Address
        } else {
            Transfer::Idle
        };
        self.sampling.fifo.end_transfer();
    }

    fn transfer(&mut self, now: Picoseconds, byte: u8) -> u8 {
        if !self.answers(now) {
            self.transfer = Transfer::Idle;
            return match self.fault {
                Fault::Silent(byte) if self.mounted => byte,
                _ => NOTHING,
            };
        }
        self.settle(now);
        match self.transfer {
            Transfer::Idle => NOTHING,
            Transfer::Address => {
                let register = byte >> 1;
                self.transfer = if byte & 1 != 0 {
                    Transfer::Read(register)
                } else {
                    Transfer::Write(register)
                };
                NOTHING
            }
            Transfer::Read(register) => {
                if register != FIFO_DATA {
                    self.transfer = Transfer::Read(register + 1);
                }
                let byte = self.read(now, register);
                self.line.carry(register, byte)
            }
            Transfer::Write(register) => {
                self.transfer = Transfer::Write(register + 1);
                self.write(now, register, byte);
                NOTHING
            }
        }
    }
}
