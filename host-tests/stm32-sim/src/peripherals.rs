//! All peripherals: clock gating, and the effects of one peripheral on another. The address map and the clock gates are those of the
//! [chip](super::chip). Writes to the parameter pages of the flash are also handled here.

#[cfg(test)]
mod tests;

use super::afio::Afio;
use super::board;
use super::bxcan::BxCan;
use super::capture_timer::CaptureTimer;
use super::chip::{Chip, Module};
use super::dbgmcu::Dbgmcu;
use super::flash::FlashInterface;
use super::gpio::Gpio;
use super::io::{AccessError, Io, Width};
use super::ism330dhcx::Ism330dhcx;
use super::iwdg::Iwdg;
use super::pwr::Pwr;
use super::rcc::{Rcc, ResetCause};
use super::signature::Signature;
use super::spi::{Clocks, Spi, SpiPart};
use super::timebase::Picoseconds;
use super::timer::Timer;
use super::violation::{Violation, Violations};
use bench::Flash;
use bench::motion::Motion;
use std::ops::Range;

/// The addresses of flash memories, for writes of the processor, which knows the size.
const FLASH_MEMORY: Range<u32> = 0x0800_0000..0x1000_0000;

/// The size of the area of a peripheral.
const AREA: u32 = 0x400;

/// The peripherals and the parts connected to them.
#[derive(Debug)]
pub struct Peripherals {
    chip: Chip,
    /// Clocks and resets.
    pub rcc: Rcc,
    /// The supply and its detectors.
    pub pwr: Pwr,
    /// Pins.
    pub gpio: Gpio,
    /// Alternate functions of the pins of the STM32F103.
    pub afio: Afio,
    /// The flash interface with the parameter pages.
    pub flash: FlashInterface,
    /// The SPI of the accelerometer.
    pub spi: Spi,
    /// The timer of the heater's PWM.
    pub tim3: Timer,
    /// The timer at RXD, for the bit rate detection.
    pub tim4: CaptureTimer,
    /// The independent watchdog.
    pub iwdg: Iwdg,
    /// What stops while a debugger halts the processor.
    pub dbgmcu: Dbgmcu,
    /// The accelerometer.
    pub imu: Ism330dhcx,
    /// The CAN controller.
    pub can: BxCan,
    signature: Signature,
    violations: Violations,
    changed: bool,
}

impl Peripherals {
    /// A microcontroller with this unique device identifier and these parameter pages, powered on at cycle 0. `motion` moves its
    /// accelerometer.
    pub fn new(
        chip: Chip,
        unique_id: [u32; 3],
        parameters: Flash,
        motion: Box<dyn Motion>,
    ) -> Self {
        let [_, lsi, _] = chip.facts().lsi;
        let mut iwdg = Iwdg::default();
        iwdg.set_lsi(lsi);
        Self {
            chip,
            rcc: Rcc::new(chip),
            pwr: Pwr::default(),
            gpio: Gpio::new(chip),
            afio: Afio::default(),
            flash: FlashInterface::new(chip, parameters),
            spi: Spi::default(),
            tim3: Timer::default(),
            tim4: CaptureTimer::default(),
            iwdg,
            imu: Ism330dhcx::new(motion),
            can: match chip {
                Chip::F103 => BxCan::new(),
                Chip::F446 => BxCan::with_shared_filters(),
            },
            dbgmcu: Dbgmcu::new(chip),
            signature: Signature::new(chip, unique_id),
            violations: Violations::default(),
            changed: false,
        }
    }

    /// A reset at `cycle`; cycles and time continue.
    pub fn reset(&mut self, cycle: u64, cause: ResetCause) {
        self.rcc.reset(cycle, cause);
        self.flash.reset();
        self.iwdg.reset();
        self.pwr.reset();
        // All modules at the same time: a transfer that is cut off is no violation of its chip select.
        self.spi = Spi::default();
        for module in Module::WITH_RESET {
            self.reset_module(cycle, module);
        }
        self.can.set_clock(self.rcc.pclk1());
        self.changed = false;
    }

    /// The power returns at this time, cycles continue: everything restarts.
    pub fn power_on(&mut self, cycle: u64, time: Picoseconds) {
        self.rcc.go_on(cycle, time);
        self.flash.parameters_mut().power_on();
        self.can.power_on();
        self.reset(cycle, ResetCause::PowerOn);
        self.imu.power_on(time);
        self.dbgmcu = Dbgmcu::new(self.chip);
    }

    /// The microcontroller.
    pub fn chip(&self) -> Chip {
        self.chip
    }

    /// The violations of the firmware so far.
    pub fn violations(&self) -> &[Violation] {
        self.violations.list()
    }

    /// The cycle of the next event without an access: the end of an SPI frame with its interrupt enabled, the time-out of the
    /// watchdog, a change of the clock. Then call [`settle`](Self::settle).
    pub fn next_event(&self) -> Option<u64> {
        let expiry = self
            .iwdg
            .expires_at()
            .map(|time| self.rcc.timebase().cycle_at(time));
        let cycle = |time| self.rcc.timebase().cycle_at(time);
        let supply = self.pwr.next_event().map(cycle);
        [self.spi.next_event(), self.rcc.next_event(), expiry, supply]
            .into_iter()
            .flatten()
            .min()
    }

    /// Processes the events that are due at `cycle`.
    pub fn settle(&mut self, cycle: u64) {
        self.rcc.settle(cycle);
        if self.rcc.nmi() {
            // The hardware has changed the clock: this is no violation of the firmware.
            self.can.lose_clock(self.rcc.pclk1());
        } else {
            self.can.set_clock(self.rcc.pclk1());
        }
        self.advance_spi(cycle);
    }

    /// True when the watchdog was not reloaded in time: the machine resets the microcontroller.
    pub fn watchdog_has_expired(&self, cycle: u64) -> bool {
        let now = self.now(cycle);
        self.iwdg.expires_at().is_some_and(|time| time <= now)
    }

    /// The level of the SPI's interrupt line.
    pub fn spi_interrupt(&self) -> bool {
        self.spi.interrupt()
    }

    /// The level of TIM4's interrupt line.
    pub fn tim4_interrupt(&self) -> bool {
        self.tim4.interrupt()
    }

    /// A new level of RXD; true is dominant, which is low. TIM4 has its channel 3 at PB8.
    pub fn receive_pin(&mut self, now: Picoseconds, dominant: bool) {
        if self.is_ready(Module::Tim4) && board::pulses_are_connected(self.chip, &self.gpio) {
            self.tim4.edge(now, self.rcc.timer_clock(), !dominant);
        }
    }

    /// True when the module has a clock and is out of reset.
    fn is_ready(&self, module: Module) -> bool {
        let ready = |gate| self.rcc.is_clocked(gate) && !self.rcc.is_in_reset(gate);
        self.chip.gate(module).is_some_and(ready)
    }

    /// True when the CAN controller has a clock, is out of reset, and sees the board's transceiver.
    pub fn can_is_connected(&self) -> bool {
        self.is_ready(Module::Can) && board::can_receives(self.chip, &self.afio, &self.gpio)
    }

    /// The level at the transceiver's TXD; true is dominant, which is low. The transceiver pulls an undriven pin high.
    pub fn transmits_dominant(&self) -> bool {
        match self.gpio.output(self.chip.facts().board.transmit) {
            Some(high) => !high,
            None => {
                self.is_ready(Module::Can)
                    && board::can_drives(self.chip, &self.afio, &self.gpio)
                    && self.can.is_dominant()
            }
        }
    }

    /// The time of a cycle.
    pub fn now(&self, cycle: u64) -> Picoseconds {
        self.rcc.timebase().time_at(cycle)
    }

    fn clocks(&self) -> Clocks {
        Clocks {
            hclk: self.rcc.hclk(),
            pclk: self.rcc.spi_clock(),
        }
    }

    /// Updates SPI and accelerometer.
    fn advance_spi(&mut self, cycle: u64) {
        if !self.spi.is_due(cycle) {
            return;
        }
        let timebase = *self.rcc.timebase();
        let clocks = self.clocks();
        let time_at = |cycle| timebase.time_at(cycle);
        if board::spi_is_connected(self.chip, &self.afio, &self.gpio) {
            let rate = self.spi.bit_rate(clocks);
            if board::spi_pins_are_fast_enough(self.chip, &self.gpio, rate) {
                self.spi.advance(cycle, clocks, time_at, &mut self.imu);
            } else {
                let reason = "the pins of the SPI are too slow for its clock";
                self.violations.add("GPIOx_OSPEEDR", reason);
                let mut late = LateEdges(&mut self.imu);
                self.spi.advance(cycle, clocks, time_at, &mut late);
            }
        } else {
            self.spi.advance(cycle, clocks, time_at, &mut OpenWires);
        }
        while let Some(register) = self.imu.take_unmodelled() {
            let name = format!("ISM330DHCX {register:02X}h");
            self.violations.add(name, "register not modelled");
        }
    }

    /// Resets the modules of RCC's reset registers.
    fn reset_module(&mut self, cycle: u64, module: Module) {
        match module {
            Module::Can => self.can.reset(),
            Module::Pwr => self.pwr.reset(),
            Module::Afio => self.afio = Afio::default(),
            Module::Gpio(port) => self.change_pins(cycle, |gpio, _| gpio.reset(port)),
            Module::Spi => self.spi = Spi::default(),
            Module::Tim3 => self.tim3 = Timer::default(),
            Module::Tim4 => self.tim4 = CaptureTimer::default(),
            _ => {}
        }
    }

    /// Changes the pins and reports the chip select, which has a pull-up, to the accelerometer.
    fn change_pins<T>(&mut self, cycle: u64, f: impl FnOnce(&mut Gpio, &mut Violations) -> T) -> T {
        self.advance_spi(cycle);
        let select = self.chip.facts().board.select;
        let is_low = |gpio: &Gpio| gpio.output(select) == Some(false);
        let before = is_low(&self.gpio);
        let result = f(&mut self.gpio, &mut self.violations);
        let after = is_low(&self.gpio);
        if before != after {
            self.violations.check(
                self.spi.is_busy(),
                "GPIOx",
                "the accelerometer's chip select changes within a frame",
            );
            self.imu.select(self.now(cycle), after);
        }
        result
    }

    fn check_clock(&self, module: Module) -> Result<(), AccessError> {
        match self.chip.gate(module) {
            Some(gate) if !self.rcc.is_clocked(gate) => {
                Err(AccessError::Unclocked(self.chip.name_of(module)))
            }
            _ => Ok(()),
        }
    }

    /// True when the module is held in reset: it does not answer, and the access is a violation.
    fn is_held_in_reset(&mut self, module: Module) -> bool {
        let held = self.holds_in_reset(module);
        if held {
            self.violations
                .add(self.chip.name_of(module), "accessed while held in reset");
        }
        held
    }

    fn holds_in_reset(&self, module: Module) -> bool {
        let gate = self.chip.gate(module);
        gate.is_some_and(|gate| self.rcc.is_in_reset(gate))
    }

    /// The module at an address, and the offset in it.
    fn module_at(&self, address: u32) -> Result<(Module, u32), AccessError> {
        let module = self.chip.module(address & !(AREA - 1));
        Ok((module.ok_or(AccessError::Unmapped)?, address % AREA))
    }

    fn read_register(
        &mut self,
        cycle: u64,
        module: Module,
        offset: u32,
    ) -> Result<u32, AccessError> {
        let now = self.now(cycle);
        match module {
            Module::Signature => Err(AccessError::Unmapped),
            Module::Tim3 => self.tim3.read(offset),
            Module::Tim4 => self.tim4.read(now, self.rcc.timer_clock(), offset),
            Module::Iwdg => self.iwdg.read(now, offset),
            Module::Can => self.can.read(now, offset),
            Module::Pwr => self.pwr.read(now, offset),
            Module::Afio => self.afio.read(offset),
            Module::Gpio(port) => self.gpio.read(port, offset),
            Module::Spi => {
                self.advance_spi(cycle);
                self.spi.read(offset)
            }
            Module::Rcc => self.rcc.read(cycle, offset),
            Module::Flash => self.flash.read(now, offset),
            Module::Dbgmcu => self.dbgmcu.read(offset),
        }
    }

    fn write_register(
        &mut self,
        cycle: u64,
        module: Module,
        offset: u32,
        value: u32,
    ) -> Result<(), AccessError> {
        let now = self.now(cycle);
        let clocks = self.clocks();
        match module {
            Module::Signature => Err(AccessError::Refused("system memory is read-only")),
            Module::Tim3 => self.tim3.write(offset, value, &mut self.violations),
            Module::Tim4 => {
                let clock = self.rcc.timer_clock();
                self.tim4
                    .write(now, clock, offset, value, &mut self.violations)
            }
            Module::Iwdg => {
                self.iwdg.write(now, offset, value, &mut self.violations)?;
                if self.iwdg.is_running() {
                    self.rcc.watchdog_runs(now);
                }
                Ok(())
            }
            Module::Can => self.can.write(now, offset, value),
            Module::Pwr => self.pwr.write(offset, value, &mut self.violations),
            Module::Afio => self.afio.write(offset, value, &mut self.violations),
            Module::Gpio(port) => self.change_pins(cycle, |gpio, violations| {
                gpio.write(port, offset, value, violations)
            }),
            Module::Spi => {
                self.advance_spi(cycle);
                self.spi
                    .write(cycle, offset, value, clocks, &mut self.violations)
            }
            Module::Rcc => self.write_rcc(cycle, offset, value),
            Module::Flash => {
                self.flash.set_supply(self.pwr.supply());
                let busy = self.flash.is_busy();
                self.flash.write(now, offset, value, &mut self.violations)?;
                // Erasing needs HSI, as programming does (PM0075, section 2.3).
                self.violations.check(
                    !busy && self.flash.is_busy() && !self.rcc.hsi_is_on(),
                    "RCC_CR",
                    "the flash is erased without HSI",
                );
                self.flash
                    .check_wait_states(self.rcc.sysclk(), &mut self.violations);
                Ok(())
            }
            Module::Dbgmcu => self.dbgmcu.write(offset, value),
        }
    }

    fn write_rcc(&mut self, cycle: u64, offset: u32, value: u32) -> Result<(), AccessError> {
        // The clock at the start of a frame determines its timing.
        self.advance_spi(cycle);
        self.rcc.write(cycle, offset, value, &mut self.violations)?;
        self.can.set_clock(self.rcc.pclk1());
        self.flash
            .check_wait_states(self.rcc.sysclk(), &mut self.violations);
        for module in Module::WITH_RESET {
            if self.holds_in_reset(module) {
                self.reset_module(cycle, module);
            }
        }
        Ok(())
    }

    /// The state that the machine checks after an access.
    fn watched(&self) -> (Option<u64>, [bool; 2], bool) {
        (
            self.next_event(),
            self.interrupts(),
            self.transmits_dominant(),
        )
    }

    /// The levels of the interrupt lines that a read can change.
    fn interrupts(&self) -> [bool; 2] {
        [self.spi.interrupt(), self.tim4.interrupt()]
    }
}

impl Io for Peripherals {
    fn read(&mut self, cycle: u64, address: u32, width: Width) -> Result<u32, AccessError> {
        self.violations.at(cycle);
        let (module, offset) = self.module_at(address)?;
        if module == Module::Signature {
            return self.signature.read(address, width);
        }
        self.check_clock(module)?;
        check_width(module, width)?;
        if self.is_held_in_reset(module) {
            return Ok(0);
        }
        let before = self.interrupts();
        let word = self.read_register(cycle, module, offset & !3)?;
        self.changed |= self.interrupts() != before;
        let (shift, mask) = lane(offset, width);
        Ok(word >> shift & mask)
    }

    fn write(
        &mut self,
        cycle: u64,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result<(), AccessError> {
        self.violations.at(cycle);
        if FLASH_MEMORY.contains(&address) {
            self.changed = true;
            let now = self.now(cycle);
            // Programming needs HSI (PM0075, section 2.3).
            self.violations.check(
                self.chip == Chip::F103 && !self.rcc.hsi_is_on(),
                "RCC_CR",
                "the flash is programmed without HSI",
            );
            self.flash.set_supply(self.pwr.supply());
            return self
                .flash
                .program(now, address, width, value, &mut self.violations);
        }
        let (module, offset) = self.module_at(address)?;
        self.check_clock(module)?;
        check_width(module, width)?;
        if self.is_held_in_reset(module) {
            return Ok(());
        }
        // The bridge to the APBs repeats a byte or half-word over the complete word (RM0008, section 3.1).
        let value = match width {
            Width::Byte => (value & 0xFF) * 0x0101_0101,
            Width::HalfWord => (value & 0xFFFF) * 0x0001_0001,
            Width::Word => value,
        };
        let before = match module {
            Module::Can | Module::Rcc | Module::Flash => None,
            _ => Some(self.watched()),
        };
        self.write_register(cycle, module, offset & !3, value)?;
        let after = self.watched();
        self.changed |= before.is_none_or(|before| before != after);
        if before.is_some_and(|(_, _, dominant)| dominant != after.2) {
            self.can.touch();
        }
        Ok(())
    }

    fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }
}

/// The pins of the SPI without a connection: the input floats high.
struct OpenWires;

impl SpiPart for OpenWires {
    fn select(&mut self, _: Picoseconds, _: bool) {}

    fn transfer(&mut self, _: Picoseconds, _: u8) -> u8 {
        0xFF
    }
}

/// Pins whose edges are late: the last bit that is read is the one before it.
struct LateEdges<'a>(&'a mut Ism330dhcx);

impl SpiPart for LateEdges<'_> {
    fn select(&mut self, now: Picoseconds, selected: bool) {
        self.0.select(now, selected);
    }

    fn transfer(&mut self, now: Picoseconds, byte: u8) -> u8 {
        let answer = self.0.transfer(now, byte);
        answer & !1 | answer >> 1 & 1
    }
}

fn check_width(module: Module, width: Width) -> Result<(), AccessError> {
    let takes = match module {
        Module::Signature | Module::Iwdg | Module::Spi => true,
        // RM0008, section 15.4; RM0390, section 17.4.
        Module::Tim3 | Module::Tim4 => width != Width::Byte,
        // By words only, by the manual or in this model.
        _ => width == Width::Word,
    };
    if takes {
        Ok(())
    } else {
        Err(AccessError::Refused("accessed by words only"))
    }
}

/// The position of a narrow access in its word: shift and mask.
fn lane(offset: u32, width: Width) -> (u32, u32) {
    let shift = 8 * (offset & 3);
    match width {
        Width::Byte => (shift, 0xFF),
        Width::HalfWord => (shift, 0xFFFF),
        Width::Word => (0, u32::MAX),
    }
}
