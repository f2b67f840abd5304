//! Accesses of the processor to the registers of the peripherals, with the clock gating, and its writes to the flash memory.

use super::Peripherals;
use crate::chip::Module;
use crate::flash::FlashInterface;
use crate::io::{AccessError, Io, Width};
use crate::timebase::Picoseconds;
use crate::violation::Violations;
use std::ops::Range;

/// The addresses of flash memories, for writes of the processor. The processor passes only writes to the flash that exists.
const FLASH_MEMORY: Range<u32> = 0x0800_0000..0x1000_0000;

/// The size of the area of a peripheral.
pub(super) const AREA: u32 = 0x400;

impl Peripherals {
    pub(super) fn check_clock(&self, module: Module) -> Result<(), AccessError> {
        match self.board.gate(module) {
            Some(gate) if !self.rcc.is_clocked(gate) => {
                Err(AccessError::Unclocked(self.board.name_of(module)))
            }
            _ => Ok(()),
        }
    }

    /// True when the module is held in reset: it does not answer, and the access is a violation.
    fn is_held_in_reset(&mut self, module: Module) -> bool {
        let held = self.holds_in_reset(module);
        if held {
            self.violations
                .add(self.board.name_of(module), "accessed while held in reset");
        }
        held
    }

    fn holds_in_reset(&self, module: Module) -> bool {
        let gate = self.board.gate(module);
        gate.is_some_and(|gate| self.rcc.is_in_reset(gate))
    }

    /// The module at an address, and the offset in it.
    pub(super) fn module_at(&self, address: u32) -> Result<(Module, u32), AccessError> {
        let module = self.board.module(address & !(AREA - 1));
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
            Module::Crc => self.crc.read(offset),
            Module::Iwdg => self.iwdg.read(now, offset),
            Module::Can => self.can.read(now, offset),
            Module::Pwr => self.pwr.read(now, offset),
            Module::Adc => {
                self.advance_adc(now);
                self.adc.read(offset)
            }
            Module::Afio => self.afio.read(offset),
            Module::Gpio(port) => self.gpio.read(port, offset),
            Module::Spi => {
                self.advance_spi(cycle);
                self.spi.read(offset)
            }
            Module::Rcc => self.rcc.read(cycle, offset),
            Module::Flash => self.flash.read(now, offset, &mut self.violations),
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
            Module::Crc => self.crc.write(offset, value),
            Module::Iwdg => {
                self.iwdg.write(now, offset, value, &mut self.violations)?;
                if self.iwdg.is_running() {
                    self.rcc.watchdog_runs(now);
                }
                Ok(())
            }
            Module::Can => self.can.write(now, offset, value),
            Module::Pwr => self.pwr.write(offset, value, &mut self.violations),
            Module::Adc => {
                self.advance_adc(now);
                let around = self.around_adc(now);
                self.adc.write(offset, value, around, &mut self.violations)
            }
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
                self.access_flash(|flash, violations| flash.write(now, offset, value, violations))?;
                self.flash
                    .check_wait_states(self.rcc.sysclk(), &mut self.violations);
                Ok(())
            }
            Module::Dbgmcu => self.dbgmcu.write(offset, value),
        }
    }

    /// Performs an access that can start an operation of the flash. The operation depends on the supply, and on the STM32F103 it needs HSI.
    fn access_flash(
        &mut self,
        access: impl FnOnce(&mut FlashInterface, &mut Violations) -> Result<(), AccessError>,
    ) -> Result<(), AccessError> {
        self.flash
            .set_supply(self.pwr.supply(), self.pwr.reset_level());
        let busy = self.flash.is_busy();
        let result = access(&mut self.flash, &mut self.violations);
        let begins = !busy && self.flash.is_busy();
        self.violations.check(
            begins && self.chip.facts().flash_needs_hsi && !self.rcc.hsi_is_on(),
            "RCC_CR",
            "the flash is programmed or erased without HSI",
        );
        result
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

    /// The state that the machine checks after an access: the next events, the interrupt lines and the level at TXD.
    fn watched(&self) -> Watched {
        Watched {
            spi: self.spi.next_event(),
            others: [self.iwdg.expires_at(), self.pwr.next_event()],
            interrupts: self.interrupts(),
            dominant: self.transmits_dominant(),
        }
    }

    /// The levels of the interrupt lines that a read can change.
    fn interrupts(&self) -> [bool; 2] {
        [self.spi.interrupt(), self.tim4.interrupt()]
    }
}

/// The state that the machine checks after an access.
#[derive(PartialEq)]
struct Watched {
    spi: Option<u64>,
    others: [Option<Picoseconds>; 2],
    interrupts: [bool; 2],
    dominant: bool,
}

impl Io for Peripherals {
    fn read(&mut self, cycle: u64, address: u32, width: Width) -> Result<u32, AccessError> {
        self.violations.at(cycle);
        let (module, offset) = self.module_at(address)?;
        if module == Module::Signature {
            return self.signature.read(address, width);
        }
        match self.check_clock(module) {
            Err(_) if self.lenient => return Ok(0),
            result => result?,
        }
        check_width(module, width)?;
        if self.is_held_in_reset(module) {
            return Ok(0);
        }
        // Such a read completes what is due.
        self.touched |= matches!(module, Module::Spi | Module::Rcc | Module::Iwdg);
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
            return self.access_flash(|flash, violations| {
                flash.program(now, address, width, value, violations)
            });
        }
        let (module, offset) = self.module_at(address)?;
        match self.check_clock(module) {
            Err(_) if self.lenient => return Ok(()),
            result => result?,
        }
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
        self.touched = true;
        self.write_register(cycle, module, offset & !3, value)?;
        if self.connects_pins(module, offset & !3) {
            self.check_pins();
        }
        if let Module::Gpio(_) = module {
            self.check_heater();
        }
        let Some(before) = before else {
            self.changed = true;
            return Ok(());
        };
        let after = self.watched();
        if before.dominant != after.dominant {
            self.can.touch();
        }
        self.changed |= before != after;
        Ok(())
    }

    fn constant_until(&self, cycle: u64, address: u32) -> Option<u64> {
        let (module, offset) = self.module_at(address).ok()?;
        match module {
            Module::Rcc => Some(self.rcc.constant_until(cycle)),
            Module::Iwdg => {
                let update = self.iwdg.next_update();
                Some(update.map_or(u64::MAX, |time| self.rcc.timebase().cycle_at(time)))
            }
            Module::Spi => self.spi.constant_until(offset),
            Module::Can => self.can.is_constant(offset).then_some(u64::MAX),
            _ => None,
        }
    }

    fn barrier(&mut self) {
        self.flash.barrier();
    }

    fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.changed)
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
