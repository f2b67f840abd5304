//! Interrupts within loads and stores of several words (ARM ARM B1.5.10).

use super::super::interruption::Interruptions;
use super::*;

const INTERRUPT: u8 = 5;

/// The handler counts in R11, which is not in the frame: ADD R11, #1; BX LR.
const COUNTING: [u16; 3] = [0xF10B, 0x0B01, BX_LR];

/// A processor at the start of this program, with interrupts within its loads and stores.
fn interrupted(code: &[u16], restarts_loads: bool, places: &Interruptions) -> CortexM3 {
    let mut processor = processor(code);
    processor.set_restarts_loads(restarts_loads);
    let bytes: Vec<u8> = COUNTING.iter().flat_map(|it| it.to_le_bytes()).collect();
    assert!(processor.load(handler(21), &bytes));
    for number in 0..8 {
        put_word(&mut processor, DATA + 4 * number, 100 + number);
    }
    enable(&mut processor, INTERRUPT, 0);
    processor.set_register(0, DATA);
    processor.set_register(11, 0);
    processor.interrupt_within_instructions(INTERRUPT, places);
    processor
}

fn finish(processor: &mut CortexM3, code: &[u16]) {
    while processor.pc() != CODE + 2 * code.len() as u32 {
        step(processor, 1);
    }
}

#[test]
fn interrupt_comes_once_after_each_word_but_the_last() {
    // LDMIA R0!, {R1-R4}; PUSH {R4-R7}; POP {R4-R7}; STRD R2, R3, [R0]; LDRD R5, R6, [R0]; STMIA R0!, {R1, R2}; LDMIA R0!, {R7}
    let code = [
        0xC81E, 0xB4F0, 0xBCF0, 0xE9C0, 0x2300, 0xE9D0, 0x5600, 0xC006, 0xC880,
    ];
    let places = Interruptions::default();
    let mut processor = interrupted(&code, false, &places);
    finish(&mut processor, &code);
    assert_eq!(processor.register(11), 3 + 3 + 3 + 1 + 1 + 1);
    let counts: Vec<usize> = places.places().into_values().collect();
    assert_eq!(counts, [3, 3, 3, 1, 1, 1, 0]);
    let all: Vec<u32> = (1..7).map(|number| processor.register(number)).collect();
    assert_eq!(all, [100, 101, 102, 103, 101, 102]);
    assert_eq!(processor.register(0), DATA + 28);
    assert_eq!(processor.register(13), STACK);
    assert_eq!(processor.word(DATA + 16), Some(100));
    assert_eq!(processor.word(DATA + 20), Some(101));
}

#[test]
fn base_in_the_list_is_restored() {
    // LDMIA R0, {R0, R1}
    let code = [0xC803];
    let mut processor = interrupted(&code, true, &Interruptions::default());
    finish(&mut processor, &code);
    assert_eq!([processor.register(0), processor.register(1)], [100, 101]);
}

/// Arm erratum 602117.
#[test]
fn base_of_a_load_pair_is_restored_without_the_erratum() {
    for (restarts, expected) in [(false, [100, 101]), (true, [7, 8])] {
        // LDRD R0, R1, [R0]
        let code = [0xE9D0, 0x0100];
        let mut processor = interrupted(&code, restarts, &Interruptions::default());
        if restarts {
            // The first word is the address of the second attempt.
            put_word(&mut processor, DATA, DATA + 0x40);
            put_word(&mut processor, DATA + 0x40, 7);
            put_word(&mut processor, DATA + 0x44, 8);
        }
        finish(&mut processor, &code);
        assert_eq!([processor.register(0), processor.register(1)], expected);
    }
}

#[test]
fn it_block_continues_with_the_abandoned_instruction() {
    // CMP R0, R0; ITE EQ; LDMIAEQ R0, {R1, R2}; MOVNE R1, #1
    let code = [0x4280, 0xBF0C, 0xC806, 0x2101];
    let mut processor = interrupted(&code, false, &Interruptions::default());
    finish(&mut processor, &code);
    assert_eq!(processor.register(11), 1);
    assert_eq!([processor.register(1), processor.register(2)], [100, 101]);
}

#[test]
fn masked_interrupt_does_not_come() {
    // CPSID i; LDMIA R0, {R1, R2}
    let code = [CPSID_I, 0xC806];
    let places = Interruptions::default();
    let mut processor = interrupted(&code, false, &places);
    finish(&mut processor, &code);
    assert_eq!(processor.register(11), 0);
    assert!(places.places().is_empty());
}
