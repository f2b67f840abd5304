//! All peripherals: the address map, clock gating, and the effects of one peripheral on another.
//!
//! | address | peripheral | clock |
//! |---|---|---|
//! | 1FFF_F000h | electronic signature | |
//! | 4000_0400h | TIM3 | RCC_APB1ENR.TIM3EN |
//! | 4000_0800h | TIM4 | RCC_APB1ENR.TIM4EN |
//! | 4000_3000h | IWDG | |
//! | 4000_6400h | bxCAN | RCC_APB1ENR.CANEN |
//! | 4000_7000h | PWR | RCC_APB1ENR.PWREN |
//! | 4001_0000h | AFIO | RCC_APB2ENR.AFIOEN |
//! | 4001_0800h..4001_1BFFh | GPIOA to GPIOE | RCC_APB2ENR.IOPAEN to IOPEEN |
//! | 4001_3000h | SPI1 | RCC_APB2ENR.SPI1EN |
//! | 4002_1000h | RCC | |
//! | 4002_2000h | flash interface | |
//! | E004_2000h | DBGMCU | |
//!
//! (RM0008, table 3 and section 7.3.) Writes to the parameter pages of the flash are also handled here.

mod map;
#[cfg(test)]
mod tests;

use super::afio::{Afio, CAN_RX, CAN_TX, IMU_SELECT};
use super::bxcan::BxCan;
use super::capture_timer::CaptureTimer;
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
use map::Module;
use std::ops::Range;

/// The flash memory, for writes of the processor.
const FLASH_MEMORY: Range<u32> = 0x0800_0000..0x0801_0000;

/// The peripherals and the parts connected to them.
#[derive(Debug)]
pub struct Peripherals {
    /// Clocks and resets.
    pub rcc: Rcc,
    /// The supply and its detectors.
    pub pwr: Pwr,
    /// Pins.
    pub gpio: Gpio,
    /// Alternate functions of the pins.
    pub afio: Afio,
    /// The flash interface with the parameter pages.
    pub flash: FlashInterface,
    /// The SPI of the accelerometer.
    pub spi1: Spi,
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
    pub fn new(unique_id: [u32; 3], parameters: Flash, motion: Box<dyn Motion>) -> Self {
        Self {
            rcc: Rcc::default(),
            pwr: Pwr::default(),
            gpio: Gpio::default(),
            afio: Afio::default(),
            flash: FlashInterface::new(parameters),
            spi1: Spi::default(),
            tim3: Timer::default(),
            tim4: CaptureTimer::default(),
            iwdg: Iwdg::default(),
            dbgmcu: Dbgmcu::default(),
            imu: Ism330dhcx::new(motion),
            can: BxCan::new(),
            signature: Signature::new(unique_id),
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
        self.spi1 = Spi::default();
        for module in Module::ALL {
            self.reset_module(cycle, module);
        }
        self.can.set_clock(self.rcc.pclk1());
        self.changed = false;
    }

    /// The power returns at this time, cycles continue: everything restarts.
    pub fn power_on(&mut self, cycle: u64, time: Picoseconds) {
        self.rcc.go_on(cycle, time);
        self.dbgmcu = Dbgmcu::default();
        self.flash.parameters_mut().power_on();
        self.can.power_on();
        self.reset(cycle, ResetCause::PowerOn);
        self.imu.power_on(time);
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
        [
            self.spi1.next_event(),
            self.rcc.next_event(),
            expiry,
            supply,
        ]
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

    /// The level of SPI1's interrupt line (position 35).
    pub fn spi1_interrupt(&self) -> bool {
        self.spi1.interrupt()
    }

    /// The level of TIM4's interrupt line (position 30).
    pub fn tim4_interrupt(&self) -> bool {
        self.tim4.interrupt()
    }

    /// A new level of RXD; true is dominant, which is low. TIM4 has its channel 3 at this pin (RM0008, table 44).
    pub fn receive_pin(&mut self, now: Picoseconds, dominant: bool) {
        if self.is_ready(Module::Tim4) && self.gpio.mode(CAN_RX).is_digital_input() {
            self.tim4.edge(now, self.rcc.timer_clock(), !dominant);
        }
    }

    /// True when the module has a clock and is out of reset.
    fn is_ready(&self, module: Module) -> bool {
        let ready = |gate| self.rcc.is_clocked(gate) && !self.rcc.is_in_reset(gate);
        module.gate().is_some_and(ready)
    }

    /// True when the CAN controller has a clock, is out of reset, and sees the board's transceiver.
    pub fn can_is_connected(&self) -> bool {
        self.is_ready(Module::Can) && self.afio.can_receives(&self.gpio)
    }

    /// The level at the transceiver's TXD; true is dominant, which is low. The transceiver pulls an undriven pin high.
    pub fn transmits_dominant(&self) -> bool {
        match self.gpio.output(CAN_TX) {
            Some(high) => !high,
            None => {
                self.is_ready(Module::Can)
                    && self.afio.can_drives(&self.gpio)
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
            pclk2: self.rcc.pclk2(),
        }
    }

    /// Updates SPI and accelerometer.
    fn advance_spi(&mut self, cycle: u64) {
        if !self.spi1.is_due(cycle) {
            return;
        }
        let timebase = *self.rcc.timebase();
        let clocks = self.clocks();
        let time_at = |cycle| timebase.time_at(cycle);
        if self.afio.spi1_is_connected(&self.gpio) {
            self.spi1.advance(cycle, clocks, time_at, &mut self.imu);
        } else {
            self.spi1.advance(cycle, clocks, time_at, &mut OpenWires);
        }
        while let Some(register) = self.imu.take_unmodelled() {
            let name = format!("ISM330DHCX {register:02X}h");
            self.violations.add(name, "register not modelled");
        }
    }

    /// Resets the modules of RCC_APB1RSTR and RCC_APB2RSTR.
    fn reset_module(&mut self, cycle: u64, module: Module) {
        match module {
            Module::Can => self.can.reset(),
            Module::Pwr => self.pwr.reset(),
            Module::Afio => self.afio = Afio::default(),
            Module::Gpio(port) => self.change_pins(cycle, |gpio, _| gpio.reset(port)),
            Module::Spi1 => self.spi1 = Spi::default(),
            Module::Tim3 => self.tim3 = Timer::default(),
            Module::Tim4 => self.tim4 = CaptureTimer::default(),
            _ => {}
        }
    }

    /// Changes the pins and reports the chip select, which has a pull-up, to the accelerometer.
    fn change_pins<T>(&mut self, cycle: u64, f: impl FnOnce(&mut Gpio, &mut Violations) -> T) -> T {
        self.advance_spi(cycle);
        let is_low = |gpio: &Gpio| gpio.output(IMU_SELECT) == Some(false);
        let before = is_low(&self.gpio);
        let result = f(&mut self.gpio, &mut self.violations);
        let after = is_low(&self.gpio);
        if before != after {
            self.violations.check(
                self.spi1.is_busy(),
                "GPIOA",
                "the accelerometer's chip select changes within a frame",
            );
            self.imu.select(self.now(cycle), after);
        }
        result
    }

    fn check_clock(&self, module: Module) -> Result<(), AccessError> {
        match module.gate() {
            Some(gate) if !self.rcc.is_clocked(gate) => Err(AccessError::Unclocked(module.name())),
            _ => Ok(()),
        }
    }

    /// True when the module is held in reset: it does not answer, and the access is a violation.
    fn is_held_in_reset(&mut self, module: Module) -> bool {
        let held = module.gate().is_some_and(|gate| self.rcc.is_in_reset(gate));
        if held {
            self.violations
                .add(module.name(), "accessed while held in reset");
        }
        held
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
            Module::Spi1 => {
                self.advance_spi(cycle);
                self.spi1.read(offset)
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
            Module::Spi1 => {
                self.advance_spi(cycle);
                self.spi1
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
        for module in Module::ALL {
            let held = module.gate().is_some_and(|gate| self.rcc.is_in_reset(gate));
            if held {
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
        [self.spi1.interrupt(), self.tim4.interrupt()]
    }
}

impl Io for Peripherals {
    fn read(&mut self, cycle: u64, address: u32, width: Width) -> Result<u32, AccessError> {
        self.violations.at(cycle);
        let (module, offset) = Module::at(address)?;
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
                !self.rcc.hsi_is_on(),
                "RCC_CR",
                "the flash is programmed without HSI",
            );
            self.flash.set_supply(self.pwr.supply());
            return self
                .flash
                .program(now, address, width, value, &mut self.violations);
        }
        let (module, offset) = Module::at(address)?;
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

/// The pins of SPI1 without a connection: the input floats high.
struct OpenWires;

impl SpiPart for OpenWires {
    fn select(&mut self, _: Picoseconds, _: bool) {}

    fn transfer(&mut self, _: Picoseconds, _: u8) -> u8 {
        0xFF
    }
}

fn check_width(module: Module, width: Width) -> Result<(), AccessError> {
    if width != Width::Word && module.takes_words_only() {
        return Err(AccessError::Refused("accessed by words only"));
    }
    Ok(())
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
