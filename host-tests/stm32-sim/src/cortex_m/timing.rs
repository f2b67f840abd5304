//! Cycles of the Cortex-M3, by the timing table of its Technical Reference Manual (TRM, sections 3.3.1 and 3.3.2 of revision r2p1),
//! and of the flash and the buses of the STM32F103. The figures are cycles by this table. They are not measured on hardware. The chip
//! has revision r1p1 of the processor, whose TRM was not compared.
//!
//! | instruction | cycles |
//! |---|---|
//! | data processing, MUL, saturation, bit fields, NOP, SEV, CLREX | 1 |
//! | MLA, MLS | 2 |
//! | SMULL, UMULL; SMLAL, UMLAL | 3 to 5; 4 to 7, by the size of the operands |
//! | SDIV, UDIV | 2 to 12, by the leading zeros of the operands |
//! | load of one value, LDREX, STREX | 2; 1 after a load that does not give its address |
//! | store, `[Rn, #imm]` | 1: the write buffer takes it |
//! | store, `[Rn, Rm]` | 2; 1 after a load that does not give its address |
//! | LDRD, STRD, LDM, STM, PUSH, POP of N registers | 1 + N |
//! | address from the result of the data processing just before | + 1 |
//! | unaligned load | + 1, at an odd address of a word + 2 |
//! | branch that is not taken, skipped instruction of an IT block | 1 |
//! | taken branch, write to PC | 1 + P; a load to PC has P in addition to its own cycles |
//! | TBB, TBH | 2 or 3, + P |
//! | IT | 1, or 0 when folded |
//! | MRS, MSR, CPS | 1 or 2 |
//! | DMB, DSB; ISB | 1 + B until the write buffer is empty; 1 + P |
//! | WFI, WFE | 1, then sleep |
//! | exception: entry, return, tail-chaining | 12, 10 to 12, 6 |
//!
//! [`Timing`] has each parameter that the manuals leave open, as a [`Range`]. The processor runs with the worst end of each range,
//! unless [`set_cycles`](super::CortexM3::set_cycles) says otherwise. `cyccnt`, a binary of `firmware-stm32`, measures on a board
//! what narrows the ranges.
//!
//! - [`cost`]: the cycles of an instruction, calculated when it is decoded
//! - [`fetch`]: instructions from flash (lines of 64 bits, wait states, prefetch buffer) and from RAM
//! - `charge`: what the processor does with both
//! - [`bus`]: data in flash, RAM and registers, the write buffer
//!
//! Assumptions. No [`Range`] covers them, and no measurement on a board has confirmed them:
//!
//! - The cycles of a divide are interpolated: between the ends that the TRM gives, it takes a cycle for each four bits of the quotient.
//! - The cycles of a long multiply are interpolated: each small operand saves one cycle. So SMLAL and UMLAL take 5 cycles at least,
//!   where the TRM has 4. An operand that is 0 is small also at the slow end.
//!
//! Not modelled:
//!
//! - An interrupt waits for the end of LDM, STM, a divide or a long multiply. The chip interrupts them, and then continues or
//!   restarts them.
//! - A buffered store reaches its register when it executes, not when the bus ends the access: at most
//!   [`Buses::wait`] cycles early.
//! - Late arrival: an exception that becomes pending during the entry of another one is taken first if it is known at the end of
//!   the entry. An interrupt line that changes within the entry preempts after it, which takes longer.
//! - An interrupt line reaches the NVIC at once; the manuals do not give the cycles of its synchronisation.
//! - The flash reads data by words: two words of a line are two reads. The wait states of the first line of a handler, and of the
//!   first line after a return, are not hidden behind the stack.

pub mod bus;
mod charge;
pub mod cost;
pub mod fetch;

pub use bus::Buses;
pub use cost::Cost;
pub use fetch::{Fetch, FlashTiming};

/// A parameter that the manuals leave open: the value that makes programs fastest, and the one that makes them slowest.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Range {
    /// The value at the fast end.
    pub best: u8,
    /// The value at the slow end, which counts.
    pub worst: u8,
}

/// An end of all ranges.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum End {
    /// The fastest value of each range.
    Best,
    /// The slowest value of each range.
    Worst,
}

/// Declares the parameters once: [`Timing`] has their ranges, [`Cycles`] one value of each.
macro_rules! parameters {
    ($($(#[$doc:meta])* $name:ident: $best:literal to $worst:literal;)*) => {
        /// The parameters that the manuals leave open.
        #[derive(Clone, Copy, PartialEq, Eq, Debug)]
        pub struct Timing {
            $($(#[$doc])* pub $name: Range,)*
        }

        /// One value of each parameter of [`Timing`].
        #[derive(Clone, Copy, PartialEq, Eq, Debug)]
        pub struct Cycles {
            $($(#[$doc])* pub $name: u8,)*
        }

        impl Timing {
            /// The ranges by the manuals.
            pub const MANUALS: Self = Self {
                $($name: Range { best: $best, worst: $worst },)*
            };

            /// The values at one end of all ranges.
            pub const fn at(&self, end: End) -> Cycles {
                match end {
                    End::Best => Cycles { $($name: self.$name.best,)* },
                    End::Worst => Cycles { $($name: self.$name.worst,)* },
                }
            }

            /// Name and range of each parameter, in order.
            pub fn list(&self) -> Vec<(&'static str, Range)> {
                vec![$((stringify!($name), self.$name),)*]
            }
        }
    };
}

parameters! {
    /// P, the cycles to refill the pipeline after a branch: 1 to 3 by alignment and width of the target, and by whether the
    /// processor speculates the address early (TRM, table 3-1).
    refill: 1 to 3;
    /// TBB and TBH without the refill: 2 by table 3-1, 3 by the text of 3.3.2.
    table_branch: 2 to 3;
    /// IT: 0 when folded onto a narrow instruction before it.
    if_then: 0 to 1;
    /// MRS, MSR and CPS.
    special: 1 to 2;
    /// B of DMB and DSB once the write buffer is empty. The TRM gives only the minimum.
    barrier: 0 to 3;
    /// What a load relative to PC can add "because of contention with the fetch unit".
    literal: 0 to 1;
    /// A long multiply ends a cycle earlier for each operand of at most this many bits. The TRM does not say how many.
    long_multiply_bits: 16 to 0;
    /// Cycles of a divide besides one for each four bits of the quotient, of which 32 bits take 12 cycles together. The TRM has
    /// the ends 2 and 12, and "leading ones and zeroes" between them.
    divide: 2 to 4;
    /// The return from an exception.
    exception_return: 10 to 12;
    /// 1 if the 12 cycles of an exception entry do not hide the wait states of the vector.
    vector_read: 0 to 1;
    /// Cycles from the event that ends WFI or WFE to the exception entry or the next instruction. DS5319 has 1.8 us at 8 MHz for
    /// both together, of which 12 cycles are the entry.
    wake_up: 0 to 3;
    /// 1 if a branch discards the lines in the prefetch buffer of the flash, so that a target in them is read again.
    branch_discards_lines: 0 to 1;
    /// Lines that the prefetch buffer is ahead of the executed one.
    lines_ahead: 2 to 1;
    /// 1 if each word is read from flash again while the prefetch buffer is off, 0 if only each line is.
    words_without_prefetch: 0 to 1;
    /// 1 if a data read of the flash waits for the end of the line that is being read.
    data_waits_for_line: 0 to 1;
    /// Cycles that a data access takes from the fetch of code in RAM: both use the system bus.
    ram_contention: 0 to 1;
    /// Cycles of an APB that an access to it waits for the edge of the APB clock, if that is slower.
    bridge_edge: 0 to 1;
    /// Cycles of the AHB in the bridge to an APB.
    bridge: 0 to 1;
    /// What an access to a register on the AHB adds: RCC, flash interface.
    ahb_register: 0 to 1;
    /// What an access to a register of the core adds: SCB, NVIC, SysTick. The write buffer does not take it.
    core_register: 0 to 1;
}

impl Default for Cycles {
    /// The worst of each range.
    fn default() -> Self {
        Timing::MANUALS.at(End::Worst)
    }
}

impl Cycles {
    /// SDIV and UDIV: the absolute values of the operands.
    pub fn divide(&self, dividend: u32, divisor: u32) -> u64 {
        let bits = if divisor == 0 {
            0
        } else {
            (divisor.leading_zeros() + 1).saturating_sub(dividend.leading_zeros())
        };
        u64::from(self.divide) + u64::from(bits.div_ceil(4))
    }

    /// SMULL and UMULL, or SMLAL and UMLAL: the operands, for signed ones their absolute values.
    pub fn long_multiply(&self, accumulate: bool, operands: [u32; 2]) -> u64 {
        let limit = u32::from(self.long_multiply_bits);
        let small = |operand: &u32| 32 - operand.leading_zeros() <= limit;
        let saved = operands.iter().filter(|operand| small(operand)).count() as u64;
        let most = if accumulate { 7 } else { 5 };
        most - saved
    }
}
