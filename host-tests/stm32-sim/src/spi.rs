//! The SPI at the accelerometer as a master (RM0008, chapter 25; RM0390, chapter 26): SPI1 or SPI2, full duplex, 8 or 16 bits, most
//! significant bit first, software slave management.
//!
//! | offset | register | |
//! |---|---|---|
//! | 00h | SPI_CR1 | mode, prescaler, enable |
//! | 04h | SPI_CR2 | interrupt enables |
//! | 08h | SPI_SR | TXE, RXNE, OVR, MODF, BSY |
//! | 0Ch | SPI_DR | data |
//! | 10h | SPI_CRCPR | CRC polynomial: stored, without effect |
//! | 1Ch | SPI_I2SCFGR | 0: no I2S |
//!
//! Functions that are not modelled (slave, one line, CRC, hardware slave select, least significant bit first, DMA) are
//! violations. But a master that only receives (RXONLY; BIDIMODE without BIDIOE) gets frames without end, as a disturbance can cause it:
//! RXNE and OVR are set at once, and BSY only with RXONLY (RM0008, SPI status flags). In the TI mode of the STM32F446 (FRF), NSS is not that
//! of the part: nothing is received.

use super::io::AccessError;
use super::timebase::Picoseconds;
use super::violation::Violations;

// SPI_CR1.
const PHASE: u32 = 1 << 0;
const POLARITY: u32 = 1 << 1;
const MASTER: u32 = 1 << 2;
const ENABLE: u32 = 1 << 6;
const LEAST_SIGNIFICANT_FIRST: u32 = 1 << 7;
const INTERNAL_SELECT: u32 = 1 << 8;
const SOFTWARE_SELECT: u32 = 1 << 9;
const RECEIVE_ONLY: u32 = 1 << 10;
const SIXTEEN_BITS: u32 = 1 << 11;
const CRC_ENABLE: u32 = 1 << 13;
const ONE_LINE_OUTPUT: u32 = 1 << 14;
const ONE_LINE: u32 = 1 << 15;
/// SPI_I2SCFGR: I2S mode, and the bits that can be written.
const I2S_MODE: u32 = 1 << 11;
const I2S_WRITABLE: u32 = 0xFBF;
const NOT_MODELLED: u32 = LEAST_SIGNIFICANT_FIRST | RECEIVE_ONLY | CRC_ENABLE | ONE_LINE;

// SPI_CR2.
const DMA: u32 = 0b11;
const SELECT_OUTPUT: u32 = 1 << 2;
const ERROR_INTERRUPT: u32 = 1 << 5;
const RECEIVE_INTERRUPT: u32 = 1 << 6;
const TRANSMIT_INTERRUPT: u32 = 1 << 7;
const INTERRUPTS: u32 = ERROR_INTERRUPT | RECEIVE_INTERRUPT | TRANSMIT_INTERRUPT;

// SPI_SR.
const RECEIVED: u32 = 1 << 0;
const TRANSMIT_EMPTY: u32 = 1 << 1;
const MODE_FAULT: u32 = 1 << 5;
const OVERRUN: u32 = 1 << 6;
const BUSY: u32 = 1 << 7;

/// TI mode, only on the STM32F446.
const FRAME_FORMAT: u32 = 1 << 4;

/// The highest clock of the connected part, in Hz (ISM330DHCX datasheet, SPI timing).
const FASTEST: u32 = 10_000_000;

/// The part connected to the SPI.
pub trait SpiPart {
    /// The chip select becomes low (true) or high.
    fn select(&mut self, now: Picoseconds, selected: bool);

    /// Transfers a byte to the part and another back. If not selected, a part does not drive its output, which reads as FFh.
    fn transfer(&mut self, now: Picoseconds, byte: u8) -> u8;
}

/// The clocks of an access.
#[derive(Clone, Copy, Debug)]
pub struct Clocks {
    /// The frequency of HCLK in Hz.
    pub hclk: u32,
    /// The clock of the bus in Hz, not more than HCLK: PCLK2 of SPI1, PCLK1 of SPI2.
    pub pclk: u32,
}

/// A frame on the wires.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Frame {
    data: u16,
    end: u64,
}

/// The SPI as master, with its shift register.
#[derive(Debug)]
pub struct Spi {
    cr1: u32,
    cr2: u32,
    polynomial: u32,
    /// SPI_I2SCFGR. An STM32F103 of medium density does not have it, others and clones do.
    i2s: u32,
    waiting: Option<u16>,
    shifting: Option<Frame>,
    received: Option<u16>,
    /// The byte or word that SPI_DR reads.
    last: u16,
    overrun: bool,
    /// SPI_DR was read after the overrun; reading SPI_SR now clears it.
    overrun_seen: bool,
    mode_fault: bool,
}

impl Default for Spi {
    /// The SPI after a reset: off.
    fn default() -> Self {
        Self {
            cr1: 0,
            cr2: 0,
            polynomial: 7,
            i2s: 0,
            waiting: None,
            shifting: None,
            received: None,
            last: 0,
            overrun: false,
            overrun_seen: false,
            mode_fault: false,
        }
    }
}

impl Spi {
    /// The frequency of SCK in Hz.
    pub fn bit_rate(&self, clocks: Clocks) -> u32 {
        clocks.pclk / self.prescaler()
    }

    /// True if it is a master that is on.
    pub fn is_master(&self) -> bool {
        self.cr1 & (MASTER | ENABLE) == MASTER | ENABLE
    }

    /// True if NSS is an output (SSOE), without the software slave management.
    pub fn drives_select(&self) -> bool {
        self.cr2 & SELECT_OUTPUT != 0 && self.cr1 & SOFTWARE_SELECT == 0
    }

    /// True in TI mode.
    pub fn is_in_ti_mode(&self) -> bool {
        self.cr2 & FRAME_FORMAT != 0
    }

    /// A disturbance inverts FRF in SPI_CR2.
    pub fn disturb_frame_format(&mut self) {
        self.cr2 ^= FRAME_FORMAT;
    }

    /// True while a frame is on the wires.
    pub fn is_busy(&self) -> bool {
        self.shifting.is_some()
    }

    /// The level of the interrupt line.
    pub fn interrupt(&self) -> bool {
        let wants = |enable, event| self.cr2 & enable != 0 && event;
        // Firmware that polls enables no interrupt, and this is called twice for each access.
        self.cr2 & INTERRUPTS != 0
            && (wants(RECEIVE_INTERRUPT, self.received.is_some())
                || wants(TRANSMIT_INTERRUPT, self.waiting.is_none())
                || wants(ERROR_INTERRUPT, self.overrun || self.mode_fault))
    }

    /// The end of the current frame, if it may cause an interrupt. Firmware that polls needs no event: each access updates the
    /// peripheral.
    pub fn next_event(&self) -> Option<u64> {
        self.shifting
            .filter(|_| self.cr2 & INTERRUPTS != 0)
            .map(|frame| frame.end)
    }

    /// The cycle up to which the register at `offset` keeps its value without an access, after it was read; None for the others than the
    /// status.
    pub fn constant_until(&self, offset: u32) -> Option<u64> {
        let end = self.shifting.map_or(u64::MAX, |frame| frame.end);
        (offset == 0x08).then_some(end)
    }

    /// True when the current frame has ended by `cycle`.
    pub fn is_due(&self, cycle: u64) -> bool {
        self.shifting.is_some_and(|frame| frame.end <= cycle)
    }

    /// Completes the frames that end until `cycle`; `time_at` converts a cycle to time.
    pub fn advance(
        &mut self,
        cycle: u64,
        clocks: Clocks,
        time_at: impl Fn(u64) -> Picoseconds,
        part: &mut impl SpiPart,
    ) {
        while let Some(frame) = self.shifting.take_if(|frame| frame.end <= cycle) {
            let answer = self.exchange(frame.data, time_at(frame.end), part);
            match self.received {
                None => self.received = Some(answer),
                // The buffer keeps its content.
                Some(_) => {
                    self.overrun = true;
                    self.overrun_seen = false;
                }
            }
            if let Some(data) = self.waiting.take() {
                self.start(frame.end, data, clocks);
            }
        }
    }

    /// Reads the register at `offset`; [`advance`](Self::advance) comes first.
    pub fn read(&mut self, offset: u32) -> Result<u32, AccessError> {
        Ok(match offset {
            0x00 => self.cr1,
            0x04 => self.cr2,
            0x08 => self.read_status(),
            0x0C => self.read_data(),
            0x10 => self.polynomial,
            0x1C => self.i2s,
            _ => return Err(AccessError::Refused("SPI: register not modelled")),
        })
    }

    /// Writes the register at `offset`; [`advance`](Self::advance) comes first.
    pub fn write(
        &mut self,
        cycle: u64,
        offset: u32,
        value: u32,
        clocks: Clocks,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        match offset {
            0x00 => self.write_cr1(value & 0xFFFF, clocks, violations),
            0x04 => {
                violations.check(value & DMA != 0, "SPI_CR2", "DMA is not modelled");
                self.cr2 = value & 0xE7;
            }
            // Sequences clear the flags; only CRCERR, which is not modelled, is writable.
            0x08 => {}
            0x0C => self.write_data(cycle, value as u16, clocks, violations),
            0x10 => self.polynomial = value & 0xFFFF,
            0x1C => {
                violations.check(value != 0, "SPI_I2SCFGR", "not modelled");
                self.i2s = value & I2S_WRITABLE;
            }
            _ => return Err(AccessError::Refused("SPI: register not modelled")),
        }
        Ok(())
    }

    fn write_cr1(&mut self, value: u32, clocks: Clocks, violations: &mut Violations) {
        const NAME: &str = "SPI_CR1";
        let changed = value ^ self.cr1;
        let was_on = self.cr1 & ENABLE != 0;
        self.cr1 = value;
        self.mode_fault = false;
        violations.check(
            was_on && self.is_busy() && changed != 0,
            NAME,
            "changed within a frame",
        );
        violations.check(
            was_on && changed & SIXTEEN_BITS != 0,
            NAME,
            "DFF changed while the SPI is on",
        );
        if value & ENABLE == 0 {
            self.waiting = None;
            self.shifting = None;
            return;
        }
        if value & SOFTWARE_SELECT != 0 && value & INTERNAL_SELECT == 0 && value & MASTER != 0 {
            // NSS is low at a master (RM0008, section 25.3.10).
            self.mode_fault = true;
            self.cr1 &= !(ENABLE | MASTER);
            violations.add(NAME, "master mode fault: SSI is 0");
            return;
        }
        violations.check(
            value & MASTER == 0 || value & SOFTWARE_SELECT == 0 || value & NOT_MODELLED != 0,
            NAME,
            "mode not modelled",
        );
        violations.check(
            (value & PHASE != 0) != (value & POLARITY != 0),
            NAME,
            "the part supports modes 0 and 3 only",
        );
        violations.check(
            clocks.pclk / self.prescaler() > FASTEST,
            NAME,
            "faster than the 10 MHz of the part",
        );
        if self.only_receives() {
            self.overflow();
        }
    }

    fn write_data(&mut self, cycle: u64, data: u16, clocks: Clocks, violations: &mut Violations) {
        if self.i2s & I2S_MODE != 0 {
            violations.add("SPI_DR", "written in I2S mode: nothing is sent");
        } else if self.cr1 & ENABLE == 0 {
            violations.add("SPI_DR", "written while the SPI is off");
        } else if self.only_receives() {
            violations.add(
                "SPI_DR",
                "written in a mode that only receives: nothing is sent",
            );
        } else if self.shifting.is_none() {
            self.start(cycle, data, clocks);
        } else {
            violations.check(
                self.waiting.is_some(),
                "SPI_DR",
                "written while TXE is 0: the previous frame is lost",
            );
            self.waiting = Some(data);
        }
    }

    fn read_data(&mut self) -> u32 {
        if let Some(data) = self.received.take() {
            self.last = data;
        }
        self.overrun_seen = self.overrun;
        if self.only_receives() {
            self.overflow();
        }
        self.last.into()
    }

    fn read_status(&mut self) -> u32 {
        let flag = |on: bool, bit: u32| if on { bit } else { 0 };
        let status = flag(self.received.is_some(), RECEIVED)
            | flag(self.waiting.is_none(), TRANSMIT_EMPTY)
            | flag(self.mode_fault, MODE_FAULT)
            | flag(self.overrun, OVERRUN)
            | flag(
                self.is_busy() || self.only_receives() && self.cr1 & RECEIVE_ONLY != 0,
                BUSY,
            );
        if self.overrun_seen {
            self.overrun = false;
            self.overrun_seen = false;
        }
        status
    }

    /// True while a master receives without end.
    fn only_receives(&self) -> bool {
        let one_line_input = self.cr1 & (ONE_LINE | ONE_LINE_OUTPUT) == ONE_LINE;
        self.is_master() && (one_line_input || self.cr1 & RECEIVE_ONLY != 0)
    }

    /// Two frames of the idle line are received, the second one without room.
    fn overflow(&mut self) {
        self.received.get_or_insert(0xFF);
        self.overrun = true;
        self.overrun_seen = false;
    }

    fn prescaler(&self) -> u32 {
        2 << (self.cr1 >> 3 & 0b111)
    }

    fn start(&mut self, cycle: u64, data: u16, clocks: Clocks) {
        let bits = if self.cr1 & SIXTEEN_BITS != 0 { 16 } else { 8 };
        let cycles_per_bit = self.prescaler() * (clocks.hclk / clocks.pclk);
        let end = cycle + u64::from(bits * cycles_per_bit);
        self.shifting = Some(Frame { data, end });
    }

    fn exchange(&self, data: u16, now: Picoseconds, part: &mut impl SpiPart) -> u16 {
        let [high, low] = data.to_be_bytes();
        if self.cr1 & SIXTEEN_BITS == 0 {
            part.transfer(now, low).into()
        } else {
            let high = part.transfer(now, high);
            u16::from_be_bytes([high, part.transfer(now, low)])
        }
    }
}

#[cfg(test)]
mod tests;
