//! Cycles of instruction sequences, derived by hand from the tables of [`timing`](super::super::timing), at the worst end of each
//! range.
//!
//! A sequence begins at a line of the flash, after a branch to it, so its first line must be read: at 2 wait states that takes 2
//! cycles more, and the second line is there at cycle 3. The prefetch buffer is on. HCLK is twice PCLK1 and equal to PCLK2.

mod memories;
mod table;

use super::*;
use crate::cortex_m::timing::{Buses, Cycles, End, FlashTiming, Timing};
use table::CASES;

/// The start of a sequence.
const SEQUENCE: u32 = CODE + 0x40;
/// B from the start of the program to it.
const BRANCH: u16 = 0xE01E;
/// Words in RAM for loads and stores.
const WORDS: u32 = DATA + 0x40;

const APB1: u32 = 0x4000_6400;
const APB2: u32 = 0x4001_0800;
const RCC: u32 = 0x4002_1000;
const SYSTICK_CURRENT: u32 = 0xE000_E018;

/// Registers of peripherals that read as 0.
struct Zeros;

impl Io for Zeros {
    fn read(&mut self, _: u64, _: u32, _: Width) -> Result<u32, AccessError> {
        Ok(0)
    }

    fn write(&mut self, _: u64, _: u32, _: Width, _: u32) -> Result<(), AccessError> {
        Ok(())
    }

    fn take_changed(&mut self) -> bool {
        false
    }
}

/// A processor that has just branched to a sequence at this address. Registers: R0 and R2 small, R1 and R3 point to RAM, R5 large,
/// R6 = 3, R7 = 0, R8 points to flash, R9 to R12 to registers, LR behind the sequence's first line.
fn at(place: u32, code: &[u16], wait_states: u8) -> CortexM3 {
    let mut processor = processor_for(place, code, wait_states);
    run(&mut processor, 1);
    processor.set_register(15, place);
    processor
}

/// The same before the branch.
fn processor_for(place: u32, code: &[u16], wait_states: u8) -> CortexM3 {
    let mut processor = processor(&[BRANCH]);
    put(&mut processor, place, code);
    let registers = [
        7,
        DATA,
        4,
        WORDS,
        0,
        0x1234_5678,
        3,
        0,
        0x0800_3000,
        APB1,
        APB2,
        RCC,
        SYSTICK_CURRENT,
    ];
    for (number, value) in (0..).zip(registers) {
        processor.set_register(number, value);
    }
    processor.set_register(14, place + 8 + 1);
    put_word(&mut processor, DATA, place + 8 + 1);
    put_word(&mut processor, WORDS, DATA);
    let flash = FlashTiming {
        wait_states,
        prefetch: true,
    };
    processor.set_memories(flash, Buses { apb1: 2, apb2: 1 });
    processor
}

fn run(processor: &mut CortexM3, count: u64) {
    let end = processor.instructions() + count;
    while processor.instructions() < end {
        let next = processor.cycle() + 1;
        processor.run(&mut Zeros, next).expect("no fault");
    }
}

/// The cycles of `count` instructions.
fn cycles(processor: &mut CortexM3, count: u64) -> u64 {
    let before = processor.cycle();
    run(processor, count);
    processor.cycle() - before
}

#[test]
fn sequences_take_the_cycles_derived_by_hand() {
    assert!(CASES.len() >= 40);
    let mut wrong = Vec::new();
    for &(name, code, count, expected, derivation) in CASES {
        let measured =
            [0, 2].map(|wait_states| cycles(&mut at(SEQUENCE, code, wait_states), count));
        if measured != expected {
            wrong.push(format!(
                "{name}: {measured:?}, not {expected:?}: {derivation}"
            ));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// With the branch to it, every sequence is at most as long with the fastest values as with the slowest ones, and has at least a
/// cycle for each instruction except IT, which can be folded.
#[test]
fn ends_of_ranges_enclose_each_sequence() {
    for &(name, code, count, [_, slowest], _) in CASES {
        let mut processor = processor_for(SEQUENCE, code, 2);
        processor.set_cycles(Some(Timing::MANUALS.at(End::Best)));
        let branch = cycles(&mut processor, 1);
        assert_eq!(branch, 2 + 1 + 1);
        processor.set_register(15, SEQUENCE);
        let fastest = branch + cycles(&mut processor, count);
        let folded = u64::from(name.contains("; it "));
        let limits = branch + count - folded..=2 + 1 + 3 + slowest;
        assert!(limits.contains(&fastest), "{name}: {fastest} in {limits:?}");
    }
}

/// The instruction counts do not depend on the cycles.
#[test]
fn each_instruction_counts_once() {
    for &(name, code, count, _, _) in CASES {
        let mut processor = at(SEQUENCE, code, 2);
        let before = processor.instructions();
        run(&mut processor, count);
        assert_eq!(processor.instructions() - before, count, "{name}");
        let mut without = at(SEQUENCE, code, 2);
        without.set_cycles(None);
        assert_eq!(cycles(&mut without, count), count, "{name} without costs");
    }
}

/// DDI 0337, table 3-1: 2 to 12 cycles, more for more bits of the quotient.
#[test]
fn divide_takes_2_to_12_cycles_by_the_bits_of_the_quotient() {
    let divide = |end, dividend, divisor| Timing::MANUALS.at(end).divide(dividend, divisor);
    for (dividend, divisor, slowest, fastest) in [
        (0, 1, 4, 2),
        (5, 6, 5, 3),
        (1, 2, 4, 2),
        (15, 1, 5, 3),
        (16, 1, 6, 4),
        (u32::MAX, 16, 11, 9),
        (u32::MAX, 1, 12, 10),
        (u32::MAX, 0, 4, 2),
    ] {
        assert_eq!(
            divide(End::Worst, dividend, divisor),
            slowest,
            "{dividend} / {divisor}"
        );
        assert_eq!(
            divide(End::Best, dividend, divisor),
            fastest,
            "{dividend} / {divisor}"
        );
    }
}

/// DDI 0337, table 3-1: 3 to 5, with accumulation 4 to 7.
#[test]
fn long_multiply_is_shorter_for_small_operands_at_the_fast_end() {
    let best = Timing::MANUALS.at(End::Best);
    for (operands, cycles) in [
        ([0xFFFF, 0xFFFF], 3),
        ([0x1_0000, 0xFFFF], 4),
        ([0xFFFF, 0x1_0000], 4),
        ([u32::MAX, 0x1_0000], 5),
    ] {
        assert_eq!(best.long_multiply(false, operands), cycles);
        assert_eq!(best.long_multiply(true, operands), cycles + 2);
        let worst = Cycles::default();
        assert_eq!(worst.long_multiply(false, operands), 5);
        assert_eq!(worst.long_multiply(true, operands), 7);
    }
}
