//! An ARM Cortex-M3 r1p1 as in the STM32F103C8, or Cortex-M4 r0p1 as in the STM32F446RE ([`Model`]): processor, interrupt
//! controller, SysTick, system control, flash and RAM.
//!
//! "ARM ARM" in this module is the ARMv7-M Architecture Reference Manual, DDI 0403E; RM0008 is the reference manual of the chip.
//!
//! Both models share all of this except [`timing`], which has the cycles of the instructions of the Cortex-M3 only. On the Cortex-M4 each
//! instruction takes one cycle: the cycles count instructions, and do not give the time on the chip.
//!
//! Only permitted operations run: UNDEFINED and UNPREDICTABLE instructions, accesses to unmapped addresses, and all other faults
//! stop the run with a [`Fault`]. [`CortexM3::take_fault`] continues with the handler of the fault.

pub mod decode;

mod cache;
pub mod disturbance;
mod dwt;
mod exceptions;
mod execute;
mod fault;
mod fault_entry;
mod frames;
pub mod interruption;
mod memory;
mod model;
mod nvic;
mod registers;
mod scb;
mod sleep;
mod systick;
pub mod timing;
mod waiting;

#[cfg(test)]
mod tests;

use super::io::Io;
use cache::Cache;
use decode::instruction::Register;
use dwt::Dwt;
use exceptions::{Exceptions, HARD_FAULT, NMI, SYSTICK, only};
pub use fault::{Fault, FaultKind};
use fault_entry::FaultStatus;
use interruption::Interruption;
pub use memory::MemorySizes;
use memory::{FLASH_START, Memory};
pub use model::Model;
use nvic::Nvic;
use registers::{Flags, ItState, Registers};
use scb::SystemControl;
use sleep::Sleep;
use systick::SysTick;
use timing::cost::Leaves;
use timing::{Buses, Cycles, Fetch};
use waiting::Waiting;

/// The reason why [`CortexM3::run`] returned.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Pause {
    /// The requested cycle is reached, or exceeded by less than an exception entry.
    Reached,
    /// [`Io::take_changed`] was true after an instruction.
    Changed,
    /// The program requested a reset (AIRCR.SYSRESETREQ). The caller has to perform it.
    Reset,
    /// Before the instruction at a breakpoint. The next run executes it.
    Breakpoint,
    /// At a BKPT instruction, with its number. The next run executes it again unless PC is changed.
    Bkpt(u8),
}

/// The processor, Cortex-M3 or Cortex-M4, with its memories.
#[derive(Clone, Debug)]
pub struct CortexM3 {
    model: Model,
    /// CPUID, which a program can read.
    identity: u32,
    /// Arm erratum 602117: an interrupted LDRD starts again with a wrong base.
    restarts_loads: bool,
    interruption: Option<Interruption>,
    registers: Registers,
    /// The address of the next instruction.
    next: u32,
    /// EPSR.T: if clear, no instruction can be executed (ARM ARM B1.4.2).
    thumb: bool,
    cycle: u64,
    /// The number of executed instructions.
    instructions: u64,
    /// The costs; None: every instruction takes one cycle.
    cycles: Option<Cycles>,
    /// What the last instruction has left for the next one.
    left: Leaves,
    fetch: Fetch,
    buses: Buses,
    /// When the last buffered store has left the write buffer.
    buffer_free_at: u64,
    /// The cycle at which the instruction loop stops; 0 as soon as it has to stop.
    stop_at: u64,
    /// The instruction that executes is an exception return.
    returned: bool,
    /// An instruction in an IT block executes.
    in_it_block: bool,
    /// An instruction in an IT block was abandoned.
    abandoned: bool,
    /// The local monitor of LDREX and STREX.
    exclusive: bool,
    /// [`Io::take_changed`] has returned true since the last pause.
    changed: bool,
    pause: Option<Pause>,
    /// The breakpoint of the last pause.
    stopped_at: Option<u32>,
    sleep: Option<Sleep>,
    /// The event register of WFE and SEV.
    event: bool,
    /// The pending exceptions at the last check for SEVONPEND.
    noted_pending: u128,
    cache: Cache,
    memory: Memory,
    exceptions: Exceptions,
    nvic: Nvic,
    systick: SysTick,
    system: SystemControl,
    faults: FaultStatus,
    /// A fault has occurred in the handler of HardFault or NMI.
    locked_up: bool,
    dwt: Dwt,
    waiting: Waiting,
}

impl Default for CortexM3 {
    fn default() -> Self {
        Self::new()
    }
}

impl CortexM3 {
    /// The processor of the STM32F103C8. Flash is erased. Call [`load`](Self::load), then [`reset`](Self::reset).
    pub fn new() -> Self {
        let sizes = MemorySizes {
            ram_repeats: false,
            flash: 64 * 1024,
            ram: 20 * 1024,
        };
        Self::with(Model::CortexM3, sizes)
    }

    /// A processor of this model with these memories. Flash is erased.
    pub fn with(model: Model, sizes: MemorySizes) -> Self {
        Self {
            model,
            identity: model.cpuid(),
            restarts_loads: false,
            interruption: None,
            registers: Registers::new(0),
            next: 0,
            thumb: true,
            cycle: 0,
            instructions: 0,
            cycles: match model {
                Model::CortexM3 => Some(Cycles::default()),
                Model::CortexM4 => None,
            },
            left: Leaves::default(),
            fetch: Fetch::default(),
            buses: Buses::default(),
            buffer_free_at: 0,
            stop_at: 0,
            returned: false,
            in_it_block: false,
            abandoned: false,
            exclusive: false,
            changed: false,
            pause: None,
            stopped_at: None,
            sleep: None,
            event: false,
            noted_pending: 0,
            cache: Cache::new(sizes.flash),
            memory: Memory::new(sizes),
            exceptions: Exceptions::new(model.interrupts()),
            nvic: Nvic::default(),
            systick: SysTick::new(),
            system: SystemControl::new(),
            faults: FaultStatus::default(),
            locked_up: false,
            dwt: Dwt::default(),
            waiting: Waiting::default(),
        }
    }

    /// Sets CPUID and the sizes of the memories. The flash is erased.
    pub fn set_silicon(&mut self, identity: u32, memories: MemorySizes) {
        self.identity = identity;
        self.memory = Memory::new(memories);
        self.cache = Cache::new(memories.flash);
    }

    /// Selects whether the processor has Arm erratum 602117: each interrupt that comes at an LDRD with its base as the first destination
    /// comes between the two loads, and the instruction starts again with the wrong base.
    pub fn set_restarts_loads(&mut self, restarts: bool) {
        self.restarts_loads = restarts;
    }

    /// Whether the chip has flash at this address.
    pub fn has_flash(&self, address: u32) -> bool {
        self.memory.is_flash(address)
    }

    /// Writes bytes to flash or RAM; false when they do not fit into one of them.
    #[must_use]
    pub fn load(&mut self, address: u32, bytes: &[u8]) -> bool {
        let Some(place) = self.memory.bytes_mut(address, bytes.len()) else {
            return false;
        };
        place.copy_from_slice(bytes);
        self.cache.forget(address, bytes.len());
        true
    }

    /// Resets the processor (ARM ARM B1.5.5): loads the main stack pointer and PC from the start of flash, and resets the core
    /// peripherals and the interrupt lines. Memories, breakpoints and the cycle counter stay. Bit 0 of the reset vector is copied
    /// to EPSR.T (TakeReset): with an even vector the first instruction faults.
    pub fn reset(&mut self) {
        let word = |address| self.memory.word(address).expect("flash has a start");
        let (stack, entry) = (word(FLASH_START), word(FLASH_START + 4));
        self.registers = Registers::new(stack);
        self.next = entry & !1;
        self.thumb = entry & 1 != 0;
        self.returned = false;
        self.in_it_block = false;
        self.abandoned = false;
        self.exclusive = false;
        self.changed = false;
        self.pause = None;
        self.stopped_at = None;
        self.sleep = None;
        self.event = false;
        self.noted_pending = 0;
        self.exceptions = Exceptions::new(self.model.interrupts());
        self.nvic = Nvic::default();
        self.systick = SysTick::new();
        self.system = SystemControl::new();
        self.faults = FaultStatus::default();
        self.locked_up = false;
        self.dwt = Dwt::default();
        self.left = Leaves::default();
        self.fetch = Fetch::default();
        self.buses = Buses::default();
        self.buffer_free_at = 0;
    }

    /// Overwrites RAM after a power loss, so that a program cannot depend on its content.
    pub fn overwrite_ram(&mut self) {
        self.memory.overwrite_ram();
    }

    /// Runs up to cycle `until`. During sleep, the cycle counter advances without instructions.
    ///
    /// # Errors
    ///
    /// An operation that is a fault on the chip, or has no defined effect there. PC stays at the instruction.
    pub fn run(&mut self, io: &mut impl Io, until: u64) -> Result<Pause, Fault> {
        // Moved out for the run, so that instructions are executed without a copy.
        let mut cache = std::mem::take(&mut self.cache);
        let result = loop {
            let kind = match self.run_to(io, &mut cache, until) {
                Ok(pause) => break Ok(pause),
                Err(kind) => kind,
            };
            let pc = self.registers.get(Register::PC).wrapping_sub(4);
            self.next = pc;
            let fault = Fault {
                pc,
                address: kind.address().unwrap_or(pc),
                kind: *kind,
            };
            if !self.ignore_fault(&fault) {
                break Err(fault);
            }
        };
        self.cache = cache;
        result
    }

    fn run_to(&mut self, io: &mut impl Io, cache: &mut Cache, until: u64) -> fault::Result<Pause> {
        if !self.thumb {
            self.registers.set_read_pc(self.next.wrapping_add(4));
            return Err(FaultKind::InvalidState(self.next).into());
        }
        if self.locked_up {
            self.cycle = self.cycle.max(until);
            return Ok(Pause::Reached);
        }
        self.waiting.forget();
        loop {
            self.note_systick();
            self.note_pending();
            if self.wake() {
                self.take_exception()?;
            }
            if self.cycle >= until {
                return Ok(Pause::Reached);
            }
            let limit = self.next_wake().map_or(until, |wake| wake.min(until));
            if self.sleep.is_some() {
                self.cycle = self.cycle.max(limit);
                continue;
            }
            let exempt = matches!(self.registers.exception, NMI | HARD_FAULT);
            if self.system.forbids_all() && !exempt {
                self.registers.set_read_pc(self.next.wrapping_add(4));
                return Err(FaultKind::Protected(self.next).into());
            }
            self.stop_at = limit;
            self.execute_until_stop(io, cache)?;
            if let Some(pause) = self.pause.take() {
                return Ok(pause);
            }
            if std::mem::take(&mut self.changed) {
                return Ok(Pause::Changed);
            }
            self.skip_passes(io, cache, limit);
        }
    }

    /// The instruction loop, kept minimal for speed: counters do not check for an overflow.
    #[inline(always)]
    fn execute_until_stop(&mut self, io: &mut impl Io, cache: &mut Cache) -> fault::Result<()> {
        while self.cycle < self.stop_at {
            let pc = self.next;
            self.registers.set_read_pc(pc.wrapping_add(4));
            let Some(place) = cache.get(pc) else {
                self.execute_unknown(io, cache, pc)?;
                continue;
            };
            let length = u32::from(place.length);
            if !self.fetch.has(pc, length) && !self.fetch_more(pc, length) {
                continue;
            }
            let after = pc.wrapping_add(length);
            self.next = after;
            self.cycle = self.cycle.wrapping_add(1);
            self.instructions = self.instructions.wrapping_add(1);
            if self.registers.it.is_active() {
                self.execute_apart(io, place)?;
            } else {
                self.execute(io, &place.instruction)?;
                self.charge(after, &place.cost);
            }
        }
        Ok(())
    }

    /// Ends the instruction loop after this instruction.
    #[inline(always)]
    fn interrupt(&mut self) {
        self.stop_at = 0;
    }

    /// Executes an instruction that is not in the cache, or stops before it at a breakpoint.
    #[cold]
    #[inline(never)]
    fn execute_unknown(
        &mut self,
        io: &mut impl Io,
        cache: &mut Cache,
        pc: u32,
    ) -> fault::Result<()> {
        let Some(place) = self.decode(cache, pc)? else {
            self.pause = Some(Pause::Breakpoint);
            self.interrupt();
            return Ok(());
        };
        let length = u32::from(place.length);
        while !self.fetch.has(pc, length) && !self.fetch_more(pc, length) {}
        self.next = pc.wrapping_add(length);
        self.cycle += 1;
        self.instructions += 1;
        self.execute_apart(io, &place)
    }

    /// Updates the exception of SysTick.
    fn note_systick(&mut self) {
        if self.systick.advance(self.cycle) {
            self.exceptions.pending |= only(SYSTICK);
            self.interrupt();
        }
    }

    /// Takes the exception that preempts, if there is one.
    fn take_exception(&mut self) -> fault::Result<()> {
        match self.exceptions.next(&self.registers) {
            Some(number) => {
                self.waiting.forget();
                if self.restarts_loads {
                    self.restart_load();
                }
                // A fault during entry belongs to the instruction that is not executed.
                self.registers.set_read_pc(self.next.wrapping_add(4));
                self.enter_exception(number)
            }
            None => Ok(()),
        }
    }

    /// The cycle counter, which never decreases.
    pub fn cycle(&self) -> u64 {
        self.cycle
    }

    /// The number of executed instructions.
    pub fn instructions(&self) -> u64 {
        self.instructions
    }

    /// True in WFI or WFE, and after a lockup.
    pub fn is_asleep(&self) -> bool {
        self.sleep.is_some() || self.locked_up
    }

    /// The cycle in which SysTick next pends its exception.
    pub fn next_wake(&self) -> Option<u64> {
        self.systick.next_exception()
    }

    /// Sets the level of an interrupt line: if high, the interrupt becomes pending, and again after its handler.
    pub fn set_interrupt_line(&mut self, interrupt: u8, high: bool) {
        self.nvic.set_line(&mut self.exceptions, interrupt, high);
    }

    /// Makes the exception NMI pending.
    pub fn raise_nmi(&mut self) {
        self.exceptions.pending |= only(NMI);
        self.interrupt();
    }

    /// The address of the next instruction.
    pub fn pc(&self) -> u32 {
        self.next
    }

    /// R0 to R15, where R15 is [`pc`](Self::pc).
    pub fn register(&self, number: u8) -> u32 {
        match Register::new(number.into()) {
            Register::PC => self.next,
            register => self.registers.get(register),
        }
    }

    /// Sets one of the registers R0 to R15.
    pub fn set_register(&mut self, number: u8, value: u32) {
        match Register::new(number.into()) {
            Register::PC => self.next = value & !1,
            register => self.registers.set(register, value),
        }
    }

    /// The program status: flags, ITSTATE, exception.
    pub fn xpsr(&self) -> u32 {
        self.registers.xpsr()
    }

    /// Sets the flags and ITSTATE from a program status.
    pub fn set_xpsr(&mut self, value: u32) {
        self.restore_flags(value);
        self.registers.it = ItState::from_bits(value);
    }

    /// Sets the flags from a program status.
    fn restore_flags(&mut self, status: u32) {
        self.registers.flags = Flags {
            greater_equal: self.model.greater_equal(status),
            ..Flags::from_bits(status)
        };
    }

    /// A word of flash or RAM.
    pub fn word(&self, address: u32) -> Option<u32> {
        self.memory.word(address)
    }

    /// Bytes of flash or RAM.
    pub fn bytes(&self, address: u32, length: usize) -> Option<&[u8]> {
        self.memory.bytes(address, length)
    }

    /// Programs a half-word of flash, as the flash controller does. False when the address is not in flash.
    pub fn program(&mut self, address: u32, half_word: u16) -> bool {
        self.memory.is_flash(address) && self.load(address, &half_word.to_le_bytes())
    }

    /// Erases a part of flash. False when it is not completely in flash.
    pub fn erase(&mut self, address: u32, length: usize) -> bool {
        self.memory.is_flash(address) && self.load(address, &vec![0xFF; length])
    }

    /// Adds a breakpoint: runs stop before the instruction at this address.
    pub fn add_breakpoint(&mut self, address: u32) {
        self.cache.add_breakpoint(address);
    }

    /// The lowest value of the stack pointer since reset.
    pub fn lowest_stack(&self) -> u32 {
        self.registers.lowest_stack
    }

    /// The number of the active exception, 0 in thread mode.
    pub fn active_exception(&self) -> u16 {
        self.registers.exception
    }
}
