//! The registers of the core (ARM ARM B1.4): R0 to R15, the two stack pointers, the program status and the special registers.

use super::decode::instruction::{Condition, Register};

/// The condition flags, and the sticky saturation flag.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Flags {
    /// N: the result is negative.
    pub negative: bool,
    /// Z: the result is 0.
    pub zero: bool,
    /// C: a carry, or no borrow.
    pub carry: bool,
    /// V: the signed result does not fit.
    pub overflow: bool,
    /// Q: a saturation has occurred.
    pub saturated: bool,
    /// GE: a bit for each byte. Always 0 without the DSP extension.
    pub greater_equal: u8,
}

impl Flags {
    /// The value of APSR.
    pub fn to_bits(self) -> u32 {
        u32::from(self.negative) << 31
            | u32::from(self.zero) << 30
            | u32::from(self.carry) << 29
            | u32::from(self.overflow) << 28
            | u32::from(self.saturated) << 27
            | u32::from(self.greater_equal) << 16
    }

    /// From APSR, without GE.
    pub fn from_bits(bits: u32) -> Self {
        Self {
            negative: bits >> 31 & 1 != 0,
            zero: bits >> 30 & 1 != 0,
            carry: bits >> 29 & 1 != 0,
            overflow: bits >> 28 & 1 != 0,
            saturated: bits >> 27 & 1 != 0,
            greater_equal: 0,
        }
    }

    /// N and Z of a result.
    #[inline(always)]
    pub fn set_result(&mut self, result: u32) {
        self.negative = result >> 31 != 0;
        self.zero = result == 0;
    }

    /// True if a condition is fulfilled (A7.3). By reference: the flags have just been written one by one, and reading them as
    /// one copy would stall on these writes.
    #[inline(always)]
    pub fn pass(&self, condition: Condition) -> bool {
        match condition {
            Condition::Eq => self.zero,
            Condition::Ne => !self.zero,
            Condition::Cs => self.carry,
            Condition::Cc => !self.carry,
            Condition::Mi => self.negative,
            Condition::Pl => !self.negative,
            Condition::Vs => self.overflow,
            Condition::Vc => !self.overflow,
            Condition::Hi => self.carry && !self.zero,
            Condition::Ls => !self.carry || self.zero,
            Condition::Ge => self.negative == self.overflow,
            Condition::Lt => self.negative != self.overflow,
            Condition::Gt => !self.zero && self.negative == self.overflow,
            Condition::Le => self.zero || self.negative != self.overflow,
            Condition::Always => true,
        }
    }
}

/// ITSTATE: the rest of an IT block (A7.3.3).
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct ItState(pub u8);

impl ItState {
    /// True in an IT block.
    #[inline(always)]
    pub fn is_active(self) -> bool {
        self.0 != 0
    }

    /// True at the last instruction of an IT block.
    pub fn is_last(self) -> bool {
        self.0 & 0xF == 0b1000
    }

    /// The condition of the instruction.
    pub fn condition(self) -> Condition {
        Condition::from_code(u32::from(self.0 >> 4))
    }

    /// The state after the instruction (ITAdvance).
    pub fn next(self) -> Self {
        if self.0 & 0b111 == 0 {
            Self(0)
        } else {
            Self(self.0 & 0xE0 | self.0 << 1 & 0x1F)
        }
    }

    /// The bits of EPSR that contain it.
    pub fn to_bits(self) -> u32 {
        u32::from(self.0 & 0b11) << 25 | u32::from(self.0 >> 2) << 10
    }

    /// Takes the bits from EPSR.
    pub fn from_bits(bits: u32) -> Self {
        Self((bits >> 25 & 0b11 | bits >> 8 & 0xFC) as u8)
    }
}

/// EPSR.T, which is always set.
pub const THUMB: u32 = 1 << 24;

/// The registers of the processor, with both stack pointers.
#[derive(Clone, Debug)]
pub struct Registers {
    /// R0 to R14. While an instruction executes, R15 is the value that reading PC returns: its address plus 4.
    general: [u32; 16],
    /// The stack pointer that is not selected: the process or the main one.
    other_stack: u32,
    /// True when R13 is the process stack pointer.
    on_process_stack: bool,
    /// The lowest value of R13 since reset.
    pub lowest_stack: u32,
    /// The flags of APSR.
    pub flags: Flags,
    /// The state of IT blocks.
    pub it: ItState,
    /// IPSR: the number of the active exception, 0 in thread mode.
    pub exception: u16,
    /// PRIMASK: only NMI and faults are taken.
    pub primask: bool,
    /// FAULTMASK: only NMI is taken.
    pub faultmask: bool,
    /// BASEPRI: the lowest priority value that is not taken; 0: off.
    pub basepri: u8,
    /// CONTROL.nPRIV: thread mode is unprivileged.
    pub unprivileged_thread: bool,
}

impl Registers {
    /// The state after a reset (B1.5.5).
    pub fn new(main_stack: u32) -> Self {
        let mut general = [0; 16];
        general[Register::SP.index()] = main_stack & !3;
        general[Register::LR.index()] = 0xFFFF_FFFF;
        Self {
            general,
            other_stack: 0,
            on_process_stack: false,
            lowest_stack: main_stack & !3,
            flags: Flags::default(),
            it: ItState::default(),
            exception: 0,
            primask: false,
            faultmask: false,
            basepri: 0,
            unprivileged_thread: false,
        }
    }

    /// The value of R0 to R15.
    #[inline(always)]
    pub fn get(&self, register: Register) -> u32 {
        self.general[register.index()]
    }

    /// Writes any register except PC.
    #[inline(always)]
    pub fn set(&mut self, register: Register, value: u32) {
        self.general[register.index()] = value;
        if register == Register::SP {
            self.set_stack_pointer(value);
        }
    }

    /// Writes R13, whose low two bits are always 0.
    #[inline(always)]
    pub fn set_stack_pointer(&mut self, value: u32) {
        let value = value & !3;
        self.general[Register::SP.index()] = value;
        self.lowest_stack = self.lowest_stack.min(value);
    }

    /// Sets the value that reading PC returns.
    #[inline(always)]
    pub fn set_read_pc(&mut self, value: u32) {
        self.general[Register::PC.index()] = value;
    }

    /// Whether an exception handler is running.
    pub fn in_handler(&self) -> bool {
        self.exception != 0
    }

    /// True when the special registers and the system control space are accessible.
    pub fn is_privileged(&self) -> bool {
        self.in_handler() || !self.unprivileged_thread
    }

    /// True when R13 is PSP.
    pub fn is_on_process_stack(&self) -> bool {
        self.on_process_stack
    }

    /// Selects the process or the main stack pointer as R13.
    pub fn select_stack(&mut self, process: bool) {
        if process != self.on_process_stack {
            self.on_process_stack = process;
            std::mem::swap(
                &mut self.general[Register::SP.index()],
                &mut self.other_stack,
            );
        }
    }

    /// The main stack pointer, or that of the process.
    pub fn stack_pointer(&self, process: bool) -> u32 {
        if process == self.on_process_stack {
            self.get(Register::SP)
        } else {
            self.other_stack
        }
    }

    /// Sets the main stack pointer, or that of the process.
    pub fn write_stack_pointer(&mut self, process: bool, value: u32) {
        if process == self.on_process_stack {
            self.set_stack_pointer(value);
        } else {
            self.other_stack = value & !3;
        }
    }

    /// XPSR, as pushed on exception entry.
    pub fn xpsr(&self) -> u32 {
        self.flags.to_bits() | self.it.to_bits() | THUMB | u32::from(self.exception)
    }
}
