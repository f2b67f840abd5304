//! The ISM330DHCX on the SPI: accelerometer, gyroscope and thermometer, with readings from a [`Motion`] and the noise of
//! the real one.
//!
//! | address | register (datasheet) | reset | |
//! |---|---|---|---|
//! | 01h | FUNC_CFG_ACCESS | 00h | other register banks, which are not modelled |
//! | 02h | PIN_CTRL | 3Fh | stored |
//! | 07h, 08h | FIFO_CTRL1, FIFO_CTRL2 | 00h | stored: without threshold, without compression |
//! | 09h, 0Ah | FIFO_CTRL3, FIFO_CTRL4 | 00h | batch data rates, mode |
//! | 0Fh | WHO_AM_I | 6Bh | read-only |
//! | 10h | CTRL1_XL | 00h | accelerometer: rate, full scale, LPF2 |
//! | 11h | CTRL2_G | 00h | gyroscope: rate, full scale |
//! | 12h | CTRL3_C | 04h | BOOT, BDU, IF_INC, SW_RESET |
//! | 13h | CTRL4_C | 00h | stored; I2C_disable |
//! | 14h | CTRL5_C | 00h | self-test |
//! | 15h, 16h | CTRL6_C, CTRL7_G | 00h | stored |
//! | 17h | CTRL8_XL | 00h | cut-off of LPF2 |
//! | 18h | CTRL9_XL | E0h | stored |
//! | 19h | CTRL10_C | 00h | stored |
//! | 1Eh | STATUS_REG | 00h | TDA, GDA, XLDA |
//! | 1Fh | reserved | | reads as 0, for a driver that reads the status together with the values |
//! | 20h..2Dh | OUT_TEMP, OUTX_G.. OUTZ_A | | values, low byte first |
//! | 3Ah, 3Bh | FIFO_STATUS1, FIFO_STATUS2 | 00h | number of words, flags |
//! | 63h | INTERNAL_FREQ_FINE | | deviation of the oscillator in 0.15 % |
//! | 78h..7Eh | FIFO_DATA_OUT | | tag and data of a word; 78h follows 7Eh |
//!
//! The axes of the part are those of the sensor. Other registers read as 0; an access to one is recorded
//! ([`Ism330dhcx::take_unmodelled`]).
//!
//! It can be another part with the same identifier ([`Sibling`]), and it can have a [`Fault`].

pub(crate) mod digits;
pub(crate) mod fault;
mod fifo;
mod filter;
mod sampling;
mod sibling;
#[cfg(test)]
mod tests;

use super::spi::SpiPart;
use super::timebase::{MICROSECOND, Picoseconds};
use bench::motion::Motion;
pub use digits::Noise;
pub use fault::Fault;
use fault::Line;
use plumbline::measure::Reading;
use plumbline::time::Instant;
use sampling::Sampling;
pub use sibling::Sibling;
use std::fmt;

const FUNC_CFG_ACCESS: u8 = 0x01;
const PIN_CTRL: u8 = 0x02;
const FIFO_CTRL1: u8 = 0x07;
const FIFO_CTRL3: u8 = 0x09;
const FIFO_CTRL4: u8 = 0x0A;
const WHO_AM_I: u8 = 0x0F;
const CTRL1_XL: u8 = 0x10;
const CTRL2_G: u8 = 0x11;
const CTRL3_C: u8 = 0x12;
const CTRL5_C: u8 = 0x14;
const CTRL4_C: u8 = 0x13;
const CTRL8_XL: u8 = 0x17;
const CTRL9_XL: u8 = 0x18;
const CTRL10_C: u8 = 0x19;
const STATUS_REG: u8 = 0x1E;
const RESERVED: u8 = 0x1F;
const OUT_TEMP_L: u8 = 0x20;
const OUTZ_H_A: u8 = 0x2D;
const FIFO_STATUS1: u8 = 0x3A;
const FIFO_STATUS2: u8 = 0x3B;
const INTERNAL_FREQ_FINE: u8 = 0x63;
const FIFO_DATA_OUT_TAG: u8 = 0x78;
const FIFO_DATA_OUT_Z_H: u8 = 0x7E;

/// The value of WHO_AM_I.
const IDENTIFIER: u8 = 0x6B;

// CTRL3_C.
const SW_RESET: u8 = 1 << 0;
const IF_INC: u8 = 1 << 2;
const THREE_WIRES: u8 = 1 << 3;
const BDU: u8 = 1 << 6;
const BOOT: u8 = 1 << 7;

/// The data rate in CTRL2_G; 0 is power-down, which must come before a software reset (AN5398, section 5.8).
const GYROSCOPE_RATE: u8 = 0xF0;
/// The self-test of the gyroscope in CTRL5_C.
const GYROSCOPE_SELF_TEST: u8 = 0b11 << 2;
/// I2C_disable in CTRL4_C.
const I2C_DISABLE: u8 = 1 << 2;
/// The high-pass path in CTRL8_XL.
const HIGH_PASS: u8 = 1 << 2;

/// A software reset takes 50 us (AN5398, section 5.8).
const RESET_TIME: Picoseconds = 50 * MICROSECOND;

/// After power-on, and after BOOT was set, the part loads its trimming for 10 ms (AN5398, section 5.8).
const BOOT_TIME: Picoseconds = 10_000 * MICROSECOND;

/// The value read from a part that is not mounted or not selected: the line floats high.
const NOTHING: u8 = 0xFF;

/// The state of a transfer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Transfer {
    Idle,
    Address,
    Read(u8),
    Write(u8),
}

/// The part.
pub struct Ism330dhcx {
    motion: Box<dyn Motion>,
    mounted: bool,
    fault: Fault,
    line: Line,
    transfer: Transfer,
    registers: Registers,
    sampling: Sampling,
    /// The time from which it answers.
    booted: Picoseconds,
    /// The end of a software reset.
    reset_until: Option<Picoseconds>,
    /// The end of a reboot of the trimming.
    boot_until: Option<Picoseconds>,
    unmodelled: Vec<u8>,
    /// What the program did and the manual does not permit.
    complaint: Option<&'static str>,
}

impl fmt::Debug for Ism330dhcx {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Ism330dhcx")
            .field("mounted", &self.mounted)
            .field("fault", &self.fault)
            .field("registers", &self.registers)
            .finish_non_exhaustive()
    }
}

/// The writable registers, 00h to 19h.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Registers([u8; CTRL10_C as usize + 1]);

impl Registers {
    const RESET: Self = {
        let mut registers = [0; CTRL10_C as usize + 1];
        registers[PIN_CTRL as usize] = 0x3F;
        registers[CTRL3_C as usize] = IF_INC;
        registers[CTRL9_XL as usize] = 0xE0;
        Self(registers)
    };

    fn get(&self, register: u8) -> u8 {
        self.0[register as usize]
    }
}

impl Ism330dhcx {
    /// A part that is powered on at time 0.
    pub fn new(motion: Box<dyn Motion>) -> Self {
        Self {
            motion,
            mounted: true,
            fault: Fault::None,
            line: Line::default(),
            transfer: Transfer::Idle,
            registers: Registers::RESET,
            sampling: Sampling::default(),
            booted: BOOT_TIME,
            reset_until: None,
            boot_until: None,
            unmodelled: Vec::new(),
            complaint: None,
        }
    }

    /// Replaces its motion from `now` on.
    pub fn set_motion(&mut self, now: Picoseconds, motion: Box<dyn Motion>) {
        self.settle(now);
        self.motion = motion;
    }

    /// Takes its motion; it has none from now on.
    pub(crate) fn take_motion(&mut self) -> Box<dyn Motion> {
        std::mem::replace(&mut self.motion, Box::new(Reading::default()))
    }

    /// The supply of the sensor in the scene, in mV.
    pub fn supply(&mut self, now: Picoseconds) -> u16 {
        self.motion.supply(Instant::from_ticks(now / MICROSECOND))
    }

    /// From `now` on its oscillator is this many percent faster than nominal (slower if negative).
    pub fn set_clock_deviation(&mut self, now: Picoseconds, percent: f64) {
        self.settle(now);
        self.sampling.set_clock_deviation(percent);
    }

    /// Sets whether the self-test moves the accelerometer as specified in the datasheet.
    pub fn set_self_test_works(&mut self, works: bool) {
        self.sampling.self_test_works = works;
    }

    /// Sets its noise, which is the real one from the start.
    pub fn set_noise(&mut self, noise: Noise) {
        self.sampling.set_noise(noise);
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
        self.boot_until = None;
        self.reset_until = None;
        self.reset_registers();
    }

    /// True if its I2C interface is disabled (CTRL4_C).
    pub fn i2c_is_disabled(&self) -> bool {
        self.registers.get(CTRL4_C) & I2C_DISABLE != 0
    }

    /// A register that was accessed since the last call, but is not modelled, or not for this access.
    pub fn take_unmodelled(&mut self) -> Option<u8> {
        self.unmodelled.pop()
    }

    /// What the program did since the last call and the manual does not permit.
    pub fn take_complaint(&mut self) -> Option<&'static str> {
        self.complaint.take()
    }

    fn answers(&self, now: Picoseconds) -> bool {
        self.mounted && now >= self.booted && !matches!(self.fault(now), Fault::Silent(_))
    }

    fn reset_registers(&mut self) {
        self.registers = Registers::RESET;
        self.sampling.reset();
    }

    /// Its fault at this time: its own one, or that of the motion.
    fn fault(&self, now: Picoseconds) -> Fault {
        Fault::at(now, self.fault, &*self.motion)
    }

    /// Updates the state of the part.
    fn settle(&mut self, now: Picoseconds) {
        if self.reset_until.take_if(|end| *end <= now).is_some() {
            self.reset_registers();
        }
        if self.boot_until.take_if(|end| *end <= now).is_some() {
            self.registers.0[CTRL3_C as usize] &= !BOOT;
        }
        self.sampling.advance(now, self.fault, &mut *self.motion);
    }

    fn read(&mut self, register: u8) -> u8 {
        let user_bank = self.registers.get(FUNC_CFG_ACCESS) & 0xC0 == 0;
        match register {
            FUNC_CFG_ACCESS if self.sampling.sibling.has_banks() => self.registers.get(register),
            _ if !user_bank => self.refuse(register),
            PIN_CTRL | FIFO_CTRL1..=FIFO_CTRL4 | CTRL1_XL..=CTRL10_C => {
                self.registers.get(register)
            }
            FIFO_STATUS1..=FIFO_STATUS2 => {
                self.sampling.fifo.status()[usize::from(register - FIFO_STATUS1)]
            }
            INTERNAL_FREQ_FINE => self.sampling.frequency_fine() as u8,
            FIFO_DATA_OUT_TAG..=FIFO_DATA_OUT_Z_H => {
                self.sampling.fifo.read(register - FIFO_DATA_OUT_TAG)
            }
            WHO_AM_I => IDENTIFIER,
            STATUS_REG => self.sampling.status(),
            RESERVED => 0,
            OUT_TEMP_L..=OUTZ_H_A => self.sampling.output(
                register - OUT_TEMP_L,
                self.registers.get(CTRL3_C) & BDU != 0,
            ),
            _ => self.refuse(register),
        }
    }

    fn write(&mut self, now: Picoseconds, register: u8, value: u8) {
        let user_bank = self.registers.get(FUNC_CFG_ACCESS) & 0xC0 == 0;
        let value = value & self.sampling.sibling.bits(register);
        match register {
            FUNC_CFG_ACCESS if self.sampling.sibling.has_banks() => {}
            PIN_CTRL | FIFO_CTRL1..=FIFO_CTRL4 | CTRL1_XL..=CTRL10_C if user_bank => {}
            _ => {
                self.refuse(register);
                return;
            }
        }
        let not_modelled = match register {
            CTRL3_C => value & THREE_WIRES,
            CTRL5_C => value & GYROSCOPE_SELF_TEST,
            CTRL8_XL => value & HIGH_PASS,
            _ => 0,
        };
        if not_modelled != 0 {
            self.refuse(register);
        }
        self.registers.0[register as usize] = value;
        let [rates, control] = [FIFO_CTRL3, FIFO_CTRL4].map(|at| self.registers.get(at));
        let [accelerometer, gyroscope] = [CTRL1_XL, CTRL2_G].map(|at| self.registers.get(at));
        let fifo = &mut self.sampling.fifo;
        if !fifo.set_up(rates, control) || !fifo.matches(accelerometer, gyroscope) {
            self.refuse(register);
        }
        match register {
            CTRL1_XL | CTRL5_C | CTRL8_XL => self.sampling.set_up_accelerometer(
                now,
                self.registers.get(CTRL1_XL),
                self.registers.get(CTRL8_XL),
                self.registers.get(CTRL5_C),
            ),
            CTRL2_G => self.sampling.set_up_gyroscope(now, value),
            CTRL3_C => {
                if value & SW_RESET != 0 {
                    if gyroscope & GYROSCOPE_RATE != 0 {
                        self.complaint = Some("software reset while the gyroscope runs");
                    }
                    self.reset_until.get_or_insert(now + RESET_TIME);
                }
                if value & BOOT != 0 {
                    self.boot_until.get_or_insert(now + BOOT_TIME);
                }
            }
            _ => {}
        }
    }

    /// Records an access that is not modelled.
    fn refuse(&mut self, register: u8) -> u8 {
        self.unmodelled.push(register);
        0
    }

    /// The next register in the same transfer.
    fn next(&self, register: u8) -> u8 {
        if register == FIFO_DATA_OUT_Z_H {
            FIFO_DATA_OUT_TAG
        } else if self.registers.get(CTRL3_C) & IF_INC == 0 {
            register
        } else {
            (register + 1) & 0x7F
        }
    }
}

impl SpiPart for Ism330dhcx {
    fn select(&mut self, _: Picoseconds, selected: bool) {
        self.transfer = if selected {
            Transfer::Address
        } else {
            Transfer::Idle
        };
    }

    fn transfer(&mut self, now: Picoseconds, byte: u8) -> u8 {
        if !self.answers(now) {
            let begins = std::mem::replace(&mut self.transfer, Transfer::Idle) == Transfer::Address;
            let boots = self.mounted && now < self.booted;
            if begins && boots && byte & 0x80 == 0 {
                self.complaint = Some("written during its boot");
            }
            return match self.fault(now) {
                Fault::Silent(byte) => byte,
                _ => NOTHING,
            };
        }
        if self.transfer == Transfer::Idle {
            return NOTHING;
        }
        self.settle(now);
        match self.transfer {
            Transfer::Idle => NOTHING,
            Transfer::Address => {
                let register = byte & 0x7F;
                self.transfer = if byte & 0x80 != 0 {
                    Transfer::Read(register)
                } else {
                    Transfer::Write(register)
                };
                // The part does not drive its output during the address.
                NOTHING
            }
            Transfer::Read(register) => {
                self.transfer = Transfer::Read(self.next(register));
                let byte = self.read(register);
                self.line.carry(register, byte)
            }
            Transfer::Write(register) => {
                self.transfer = Transfer::Write(self.next(register));
                self.write(now, register, byte);
                NOTHING
            }
        }
    }
}
