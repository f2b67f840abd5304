//! Which exception is pending, active and next (ARM ARM B1.5.4).

use super::registers::Registers;

/// Numbers of exceptions.
pub const NMI: u16 = 2;
/// The supervisor call.
pub const SVCALL: u16 = 11;
/// The request for a context switch.
pub const PENDSV: u16 = 14;
/// The system timer.
pub const SYSTICK: u16 = 15;
/// Interrupt 0.
pub const FIRST_INTERRUPT: u16 = 16;
/// Interrupts of the STM32F103 (RM0008 10.1.2, without the connectivity line).
pub const INTERRUPTS: u16 = 60;

/// The bits of a priority that the STM32F103 has (RM0008 10.1.1).
const PRIORITY_BITS: u8 = 0xF0;
/// The lowest priority there is: that of a program outside of exceptions.
const LOWEST: i16 = 256;

/// The state of every exception, as sets of exception numbers.
#[derive(Clone, Debug)]
pub struct Exceptions {
    /// Waiting to be taken.
    pub pending: u128,
    /// Being handled, or interrupted in it.
    pub active: u128,
    /// Interrupts that may be taken; system exceptions always may.
    pub enabled: u128,
    priority: [u8; 128],
    /// AIRCR.PRIGROUP.
    pub priority_group: u8,
}

/// The set with only this exception.
pub const fn only(number: u16) -> u128 {
    1 << (number & 127)
}

impl Exceptions {
    /// As after reset.
    pub fn new() -> Self {
        Self {
            pending: 0,
            active: 0,
            enabled: only(FIRST_INTERRUPT) - 1,
            priority: [0; 128],
            priority_group: 0,
        }
    }

    /// The priority of an exception, as it is in its register.
    pub fn priority(&self, number: u16) -> u8 {
        self.priority[usize::from(number & 127)]
    }

    /// Sets a priority.
    pub fn set_priority(&mut self, number: u16, priority: u8) {
        self.priority[usize::from(number & 127)] = priority & PRIORITY_BITS;
    }

    /// What of a priority decides whether it preempts: PRIGROUP takes the bits below off.
    fn group(&self, priority: u8) -> i16 {
        let below = (1 << (self.priority_group + 1)) - 1;
        i16::from(priority) & !below
    }

    /// The group priority of an exception, where NMI beats all that can be set.
    fn group_priority(&self, number: u16) -> i16 {
        match number {
            NMI => -2,
            _ => self.group(self.priority(number)),
        }
    }

    /// The priority at which the processor runs (ExecutionPriority), with PRIMASK or as if it were clear.
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

    /// What BASEPRI and FAULTMASK alone hold back: this group priority and all below.
    fn mask(&self, registers: &Registers) -> i16 {
        match (registers.faultmask, registers.basepri) {
            (true, _) => -1,
            (false, 0) => LOWEST,
            (false, basepri) => self.group(basepri),
        }
    }

    /// The pending exception to be taken first: of the best priority, then of the lowest number.
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

    /// Whether an exception of this number would preempt.
    pub fn preempts(&self, number: u16, registers: &Registers, with_primask: bool) -> bool {
        self.group_priority(number) < self.execution_priority(registers, with_primask)
    }

    /// The exception to be taken now.
    pub fn next(&self, registers: &Registers) -> Option<u16> {
        self.first_pending()
            .filter(|number| self.preempts(*number, registers, true))
    }

    /// Whether a pending exception ends WFI: PRIMASK does not count (B1.5.19).
    pub fn wakes(&self, registers: &Registers) -> bool {
        self.first_pending()
            .is_some_and(|number| self.preempts(number, registers, false))
    }

    /// The number in ICSR.VECTPENDING, 0 for none: BASEPRI and FAULTMASK count, PRIMASK does not (PM0056 4.4.3).
    pub fn pending_number(&self, registers: &Registers) -> u16 {
        self.first_pending()
            .filter(|number| self.group_priority(*number) < self.mask(registers))
            .unwrap_or(0)
    }
}
