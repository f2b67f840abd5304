//! Determines the pending, active and next exceptions (ARM ARM B1.5.4).

use super::registers::Registers;

/// The numbers of the system exceptions.
pub const NMI: u16 = 2;
/// A fault that no other handler takes.
pub const HARD_FAULT: u16 = 3;
/// A memory management fault, if its handler is enabled.
pub const MEMORY_FAULT: u16 = 4;
/// A bus fault, if its handler is enabled.
pub const BUS_FAULT: u16 = 5;
/// A usage fault, if its handler is enabled.
pub const USAGE_FAULT: u16 = 6;
/// The supervisor call (SVC instruction).
pub const SVCALL: u16 = 11;
/// The request for a context switch.
pub const PENDSV: u16 = 14;
/// The system timer has counted to 0.
pub const SYSTICK: u16 = 15;
/// The number of interrupt 0.
pub const FIRST_INTERRUPT: u16 = 16;

/// The implemented bits of a priority on both chips (RM0008 10.1.1, RM0390 10.1.1).
const PRIORITY_BITS: u8 = 0xF0;
/// The lowest priority: that of a program outside exceptions.
const LOWEST: i16 = 256;

/// The state of every exception, as sets of exception numbers.
#[derive(Clone, Debug)]
pub struct Exceptions {
    /// The exceptions that wait until they are taken.
    pub pending: u128,
    /// The exceptions in execution, and those they have preempted.
    pub active: u128,
    /// Enabled interrupts; system exceptions are always enabled.
    pub enabled: u128,
    priority: [u8; 128],
    /// The field PRIGROUP of AIRCR.
    pub priority_group: u8,
    /// The number of interrupts of the chip.
    pub interrupts: u16,
}

/// The set with only this exception.
pub const fn only(number: u16) -> u128 {
    1 << (number & 127)
}

impl Exceptions {
    /// State after reset, with this many interrupts.
    pub fn new(interrupts: u16) -> Self {
        Self {
            pending: 0,
            active: 0,
            enabled: only(FIRST_INTERRUPT) - 1,
            priority: [0; 128],
            priority_group: 0,
            interrupts,
        }
    }

    /// The priority of an exception in its register.
    pub fn priority(&self, number: u16) -> u8 {
        self.priority[usize::from(number & 127)]
    }

    pub fn set_priority(&mut self, number: u16, priority: u8) {
        self.priority[usize::from(number & 127)] = priority & PRIORITY_BITS;
    }

    /// The group priority, which determines preemption: PRIGROUP removes the lower bits.
    fn group(&self, priority: u8) -> i16 {
        let below = (1 << (self.priority_group + 1)) - 1;
        i16::from(priority) & !below
    }

    /// The group priority of an exception; NMI and HardFault are higher than all configurable ones.
    fn group_priority(&self, number: u16) -> i16 {
        match number {
            NMI => -2,
            HARD_FAULT => -1,
            _ => self.group(self.priority(number)),
        }
    }

    /// The execution priority of the processor (ExecutionPriority), with PRIMASK or as if it were clear.
    pub fn execution_priority(&self, registers: &Registers, with_primask: bool) -> i16 {
        let mut priority = self.mask(registers);
        let mut left = self.active;
        while left != 0 {
            priority = priority.min(self.group_priority(left.trailing_zeros() as u16));
            left &= left - 1;
        }
        if registers.primask && with_primask {
            priority = priority.min(0);
        }
        priority
    }

    /// The mask level of BASEPRI and FAULTMASK alone: masks this group priority and all lower ones.
    fn mask(&self, registers: &Registers) -> i16 {
        match (registers.faultmask, registers.basepri) {
            (true, _) => -1,
            (false, 0) => LOWEST,
            (false, basepri) => self.group(basepri),
        }
    }

    /// The first pending exception: the highest priority, then the lowest number.
    fn first_pending(&self) -> Option<u16> {
        let mut left = self.pending & self.enabled;
        let mut best: Option<((i16, u8), u16)> = None;
        while left != 0 {
            let number = left.trailing_zeros() as u16;
            let rank = (self.group_priority(number), self.priority(number));
            if best.is_none_or(|(other, _)| rank < other) {
                best = Some((rank, number));
            }
            left &= left - 1;
        }
        best.map(|(_, number)| number)
    }

    /// True if an exception with this number would preempt.
    pub fn preempts(&self, number: u16, registers: &Registers, with_primask: bool) -> bool {
        self.group_priority(number) < self.execution_priority(registers, with_primask)
    }

    /// The exception to be taken now.
    pub fn next(&self, registers: &Registers) -> Option<u16> {
        self.first_pending()
            .filter(|number| self.preempts(*number, registers, true))
    }

    /// True if a pending exception ends WFI: PRIMASK is ignored (B1.5.19).
    pub fn wakes(&self, registers: &Registers) -> bool {
        self.first_pending()
            .is_some_and(|number| self.preempts(number, registers, false))
    }

    /// The number in ICSR.VECTPENDING, 0 for none: respects BASEPRI and FAULTMASK, not PRIMASK (PM0056 4.4.3).
    pub fn pending_number(&self, registers: &Registers) -> u16 {
        self.first_pending()
            .filter(|number| self.group_priority(*number) < self.mask(registers))
            .unwrap_or(0)
    }
}
