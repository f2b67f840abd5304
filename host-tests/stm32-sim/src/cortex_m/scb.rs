//! The system control space (ARM ARM B3.2 to B3.4): the address of each register, and the registers of the system control block.

use super::CortexM3;
use super::exceptions::{FIRST_INTERRUPT, HARD_FAULT, NMI, PENDSV, SYSTICK, only};
use super::fault::{FaultKind, Result};
use super::{Pause, nvic};
use crate::io::Width;

/// The key for writes to AIRCR, which also reads back in its place.
const KEY: u32 = 0x05FA;
const KEY_READ: u32 = 0xFA05;

/// The address of SCR.
pub const SCR: u32 = 0xE000_ED10;

/// SCR: sleep when the last handler ends.
const SLEEPONEXIT: u32 = 1 << 1;
/// SCR: WFI and WFE enter Stop or Standby mode (RM0008 4.3.4).
const SLEEPDEEP: u32 = 1 << 2;
/// SCR: an exception that becomes pending is an event.
const SEVONPEND: u32 = 1 << 4;

/// MPU_CTRL: the MPU is on, and the default memory map applies to a privileged program.
const MPU_ENABLE: u32 = 1 << 0;
const PRIVDEFENA: u32 = 1 << 2;

/// CCR: nested handlers may return to the thread.
const NONBASETHRDENA: u32 = 1 << 0;
/// CCR: unaligned words and half-words fault.
const UNALIGN_TRP: u32 = 1 << 3;
/// CCR: division by zero faults.
const DIV_0_TRP: u32 = 1 << 4;
/// CCR: at priority -1 and -2, loads and stores ignore bus faults.
const BFHFNMIGN: u32 = 1 << 8;
/// CCR: exceptions align the stack to 8 bytes. Set at reset (PM0056 4.4.7).
const STKALIGN: u32 = 1 << 9;
const CCR_BITS: u32 = NONBASETHRDENA | 1 << 1 | UNALIGN_TRP | DIV_0_TRP | BFHFNMIGN | STKALIGN;

/// The registers of the system control block that only store their value.
#[derive(Clone, Debug)]
pub struct SystemControl {
    /// VTOR, the address of the vector table.
    pub vector_table: u32,
    sleep_control: u32,
    configuration: u32,
    handler_control: u32,
    /// DEMCR, debug exception and monitor control.
    pub debug_monitor: u32,
    coprocessors: u32,
    /// MPU_CTRL.
    protection: u32,
}

impl SystemControl {
    /// The registers after a reset.
    pub fn new() -> Self {
        Self {
            vector_table: 0,
            sleep_control: 0,
            configuration: STKALIGN,
            handler_control: 0,
            debug_monitor: 0,
            coprocessors: 0,
            protection: 0,
        }
    }

    /// A disturbance changes SCR.
    pub fn disturb_sleep(&mut self, value: u32) {
        self.sleep_control = value & (SLEEPONEXIT | SLEEPDEEP | SEVONPEND);
    }

    /// True if WFI starts Stop mode, which is not modelled.
    pub fn sleeps_deeply(&self) -> bool {
        self.sleep_control & SLEEPDEEP != 0
    }

    pub fn sleeps_on_exit(&self) -> bool {
        self.sleep_control & SLEEPONEXIT != 0
    }

    pub fn sends_event_on_pending(&self) -> bool {
        self.sleep_control & SEVONPEND != 0
    }

    pub fn allows_nested_thread(&self) -> bool {
        self.configuration & NONBASETHRDENA != 0
    }

    #[inline(always)]
    pub fn traps_unaligned(&self) -> bool {
        self.configuration & UNALIGN_TRP != 0
    }

    pub fn traps_division_by_zero(&self) -> bool {
        self.configuration & DIV_0_TRP != 0
    }

    /// True for HardFault, and for a fault with its handler enabled in SHCSR.
    pub fn has_handler(&self, number: u16) -> bool {
        number == HARD_FAULT || self.handler_control >> (12 + number) & 1 != 0
    }

    /// True if the MPU is on: without a region, it permits a privileged program nothing (PM0214 4.2.6), except in the handlers of HardFault
    /// and NMI.
    #[inline(always)]
    pub fn forbids_all(&self) -> bool {
        self.protection & (MPU_ENABLE | PRIVDEFENA) == MPU_ENABLE
    }

    pub fn ignores_bus_faults(&self) -> bool {
        self.configuration & BFHFNMIGN != 0
    }

    pub fn aligns_stack(&self) -> bool {
        self.configuration & STKALIGN != 0
    }
}

impl CortexM3 {
    /// Reads a register at 0xE000_E000..0xE000_F000; the address is aligned.
    pub(super) fn read_system(&mut self, address: u32, width: Width) -> Result<u32> {
        self.require_privilege(address)?;
        self.note_systick();
        let lane = 8 * (address & 3);
        let value = self.read_system_word(address & !3)? >> lane;
        Ok(match width {
            Width::Byte => value & 0xFF,
            Width::HalfWord => value & 0xFFFF,
            Width::Word => value,
        })
    }

    /// Writes a register at 0xE000_E000..0xE000_F000; the address is aligned. Only priorities can be written by bytes and
    /// half-words.
    pub(super) fn write_system(&mut self, address: u32, width: Width, value: u32) -> Result<()> {
        self.require_privilege(address)?;
        self.note_systick();
        self.interrupt();
        let first = match address & 0xFFF {
            offset if self.is_priority(offset) => nvic::priority_owner(address),
            0xD18..0xD24 => ((address & 0xFF) - 0x18 + 4) as u16,
            _ if width == Width::Word => return self.write_system_word(address, value),
            _ => return Err(FaultKind::System(address, "it can only be written as a word").into()),
        };
        let lanes = match width {
            Width::Byte => 1,
            Width::HalfWord => 2,
            Width::Word => 4,
        };
        for (number, priority) in (first..).zip(value.to_le_bytes()).take(lanes) {
            self.exceptions.set_priority(number, priority);
        }
        Ok(())
    }

    /// True for a priority register. Each of them has the priorities of four interrupts.
    fn is_priority(&self, offset: u32) -> bool {
        let end = 0x400 + u32::from(self.exceptions.interrupts.next_multiple_of(4));
        (0x400..end).contains(&offset)
    }

    fn require_privilege(&self, address: u32) -> Result<()> {
        if self.registers.is_privileged() {
            return Ok(());
        }
        Err(FaultKind::System(address, "the program is unprivileged").into())
    }

    pub(super) fn read_system_word(&mut self, address: u32) -> Result<u32> {
        Ok(match address & 0xFFF {
            // ICTR: the number of interrupts in units of 32, minus one.
            0x004 => u32::from(self.exceptions.interrupts.div_ceil(32)) - 1,
            offset @ 0x010..0x020 => self.systick.read(self.cycle, offset - 0x010),
            0x100..0x400 => self.nvic.read(&self.exceptions, address),
            offset if self.is_priority(offset) => self.nvic.read(&self.exceptions, address),
            0xD00 => self.identity,
            0xD04 => self.interrupt_control(),
            0xD08 => self.system.vector_table,
            0xD0C => KEY_READ << 16 | u32::from(self.exceptions.priority_group) << 8,
            0xD10 => self.system.sleep_control,
            0xD14 => self.system.configuration,
            offset @ 0xD18..0xD24 => {
                let first = (offset - 0xD18 + 4) as u16;
                u32::from_le_bytes(std::array::from_fn(|lane| {
                    self.exceptions.priority(first + lane as u16)
                }))
            }
            0xD24 => self.system.handler_control,
            0xD28 => self.faults.configurable,
            0xD2C => self.faults.hard,
            0xD38 => self.faults.bus_address,
            // DFSR, MMFAR, AFSR: there is no debugger, and no data access violates the MPU. DHCSR: no debugger.
            0xD30..0xD40 | 0xDF0..0xDFC => 0,
            0xD88 if self.model.coprocessors().is_some() => self.system.coprocessors,
            0xD90 => self.model.protection(),
            0xD94 if self.model.protection() != 0 => self.system.protection,
            0xDFC => self.system.debug_monitor,
            _ => return Err(FaultKind::System(address, "it is not modelled").into()),
        })
    }

    fn write_system_word(&mut self, address: u32, value: u32) -> Result<()> {
        match address & 0xFFF {
            offset @ 0x010..0x020 => self.systick.write(self.cycle, offset - 0x010, value),
            0x100..0x300 => self.nvic.write(&mut self.exceptions, address, value),
            0xD04 => self.write_interrupt_control(value),
            0xD08 => self.system.vector_table = value & 0x3FFF_FF80,
            0xD0C => self.write_reset_control(address, value)?,
            0xD10 => self.write_sleep_control(address, value)?,
            0xD14 => self.system.configuration = value & CCR_BITS,
            0xD24 => self.system.handler_control = value & 0x0007_0000,
            // Writing 1 clears a bit.
            0xD28 => self.faults.configurable &= !value,
            0xD2C => self.faults.hard &= !value,
            0xD30 => {}
            0xD88 if let Some(writable) = self.model.coprocessors() => {
                self.system.coprocessors = value & writable;
            }
            0xD94 if self.model.protection() != 0 => self.system.protection = value & 0b111,
            0xDFC => self.system.debug_monitor = value,
            0xF00 => self.nvic.trigger(&mut self.exceptions, value),
            _ => return Err(FaultKind::System(address, "it is read-only or not modelled").into()),
        }
        Ok(())
    }

    /// The value of ICSR.
    fn interrupt_control(&self) -> u32 {
        let exceptions = &self.exceptions;
        let flag = |condition: bool, bit: u32| u32::from(condition) << bit;
        let pends = |number: u16| exceptions.pending & only(number) != 0;
        let interrupts = exceptions.pending >> FIRST_INTERRUPT != 0;
        let others_active = exceptions.active & !only(self.registers.exception) != 0;
        u32::from(self.registers.exception)
            | flag(!others_active, 11)
            | u32::from(exceptions.pending_number(&self.registers)) << 12
            | flag(interrupts, 22)
            | flag(pends(SYSTICK), 26)
            | flag(pends(PENDSV), 28)
            | flag(pends(NMI), 31)
    }

    fn write_interrupt_control(&mut self, value: u32) {
        let bit = |index: u32, number: u16| {
            if value >> index & 1 != 0 {
                only(number)
            } else {
                0
            }
        };
        self.exceptions.pending &= !(bit(25, SYSTICK) | bit(27, PENDSV));
        self.exceptions.pending |= bit(26, SYSTICK) | bit(28, PENDSV) | bit(31, NMI);
    }

    /// A write to SCR.
    fn write_sleep_control(&mut self, address: u32, value: u32) -> Result<()> {
        if value & SLEEPDEEP != 0 {
            // It would also stop the clocks of the peripherals.
            return Err(FaultKind::System(address, "SLEEPDEEP is not modelled").into());
        }
        self.system.sleep_control = value & (SLEEPONEXIT | SEVONPEND);
        Ok(())
    }

    /// AIRCR ignores writes without its key.
    fn write_reset_control(&mut self, address: u32, value: u32) -> Result<()> {
        if value >> 16 != KEY {
            return Ok(());
        }
        if value & 0b011 != 0 {
            return Err(FaultKind::System(
                address,
                "VECTRESET and VECTCLRACTIVE are for debuggers",
            )
            .into());
        }
        self.exceptions.priority_group = (value >> 8 & 7) as u8;
        if value & 0b100 != 0 {
            self.pause = Some(Pause::Reset);
        }
        Ok(())
    }
}
