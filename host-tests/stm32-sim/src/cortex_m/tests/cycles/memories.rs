//! Code in RAM, the prefetch buffer, busy flash, and exceptions.

use super::*;

const RAM_SEQUENCE: u32 = 0x2000_0400;
/// ADD.W R0, R0, R2.
const WIDE: [u16; 2] = [0xEB00, 0x0002];

/// Code in RAM has no wait states of the flash, but a fetch of a word takes 2 cycles: as long as two narrow instructions, twice as
/// long as a wide one.
#[test]
fn code_in_ram_is_fetched_by_words_in_2_cycles() {
    for wait_states in [0, 2] {
        let mut narrow = at(RAM_SEQUENCE, &[NOP; 8], wait_states);
        assert_eq!(cycles(&mut narrow, 8), 1 + 8, "+ 1 for the first word");
        let mut wide = at(RAM_SEQUENCE, &WIDE.repeat(4), wait_states);
        assert_eq!(
            cycles(&mut wide, 4),
            1 + 4 + 2,
            "+ 1 for the third and fourth word"
        );
    }
}

/// A data access takes the system bus from the fetch: + 1 for a load of 2 cycles among narrow instructions.
#[test]
fn data_access_delays_code_in_ram() {
    // LDR.W R0, [R1], twice, then ADD.W: after the first word, each of the loads delays the next word.
    let code = [0xF8D1, 0x0000, 0xF8D1, 0x0000, WIDE[0], WIDE[1]];
    // Word 0: 1 to 3. Word 1: there at 1 + 1, until 4; word 2 is there at 3 + 2 + 1.
    assert_eq!(cycles(&mut at(RAM_SEQUENCE, &code, 2), 3), 7);
}

/// Without the prefetch buffer, each word is read when it is needed.
#[test]
fn each_word_waits_without_prefetch() {
    for (wait_states, expected) in [(0, 8), (1, 12), (2, 16)] {
        let mut processor = at(SEQUENCE, &[NOP; 8], wait_states);
        let off = FlashTiming {
            wait_states,
            prefetch: false,
        };
        processor.set_memories(off, Buses::default());
        assert_eq!(cycles(&mut processor, 8), expected);
    }
}

/// While the flash is programmed or erased, code in it waits and code in RAM runs, until it branches to flash.
#[test]
fn busy_flash_stalls_only_code_in_flash() {
    let mut flash = at(SEQUENCE, &[NOP; 8], 0);
    flash.occupy_flash(1000);
    assert_eq!(cycles(&mut flash, 4), 4, "the time has passed before");
    assert_eq!(flash.cycle(), 4 + 1000 + 4, "and B has taken 4 cycles");

    let mut ram = at(RAM_SEQUENCE, &[NOP, NOP, 0x4740], 0);
    ram.set_register(8, SEQUENCE + 1);
    put(&mut ram, SEQUENCE, &[NOP]);
    ram.occupy_flash(1000);
    assert_eq!(cycles(&mut ram, 2), 3);
    // BX R8, and the NOP in flash.
    assert_eq!(cycles(&mut ram, 2), 1000 - 3 + 1);
}

/// Cycles from the pending interrupts until this many instructions have been executed.
fn exceptions(wait_states: u8, interrupts: &[u8], count: u64) -> (CortexM3, u64) {
    let mut processor = at(SEQUENCE, &[NOP; 16], wait_states);
    for interrupt in interrupts {
        enable(&mut processor, *interrupt, 0);
    }
    run(&mut processor, 4);
    for interrupt in interrupts {
        processor.set_interrupt_line(*interrupt, true);
        processor.set_interrupt_line(*interrupt, false);
    }
    let cycles = cycles(&mut processor, count);
    (processor, cycles)
}

/// Entry 12, BX LR 1, return 12, NOP 1. With 2 wait states the vector, the handler's line and the line of the NOP add 2 each.
#[test]
fn exception_takes_12_cycles_to_enter_and_to_return() {
    assert_eq!(exceptions(0, &[0], 2).1, 12 + 1 + 12 + 1);
    assert_eq!(exceptions(2, &[0], 2).1, 2 + 12 + 2 + 1 + 12 + 2 + 1);
}

/// The second handler starts 6 cycles after the first, and the thread's registers are restored once.
#[test]
fn pending_exception_is_tail_chained() {
    let (processor, cycles) = exceptions(0, &[0, 1], 3);
    assert_eq!(cycles, 12 + 1 + 6 + 1 + 12 + 1);
    assert_eq!(processor.active_exception(), 0);
    assert_eq!(processor.lowest_stack(), STACK - 32);
    assert_eq!(processor.register(13), STACK);
    assert_eq!(
        exceptions(2, &[0, 1], 3).1,
        12 + 4 + 1 + 6 + 4 + 1 + 12 + 2 + 1
    );
}

/// SysTick with a higher priority becomes pending during the entry of interrupt 0: it is taken first, in the same entry.
#[test]
fn late_arrival_is_taken_first() {
    let mut processor = at(SEQUENCE, &[NOP; 16], 0);
    enable(&mut processor, 0, 0x80);
    let write = |processor: &mut CortexM3, address, value| {
        processor
            .write_system(address, Width::Word, value)
            .expect("the register exists");
    };
    write(&mut processor, 0xE000_E014, 999);
    write(&mut processor, 0xE000_E018, 0);
    write(&mut processor, 0xE000_E010, 0b111);
    let due = processor.next_wake().expect("it counts");
    run(&mut processor, 1);
    processor.set_register(15, SEQUENCE);
    // Entry until 12 cycles later; SysTick is due 5 cycles after its start.
    while processor.cycle() < due - 5 {
        run(&mut processor, 1);
        processor.set_register(15, SEQUENCE);
    }
    processor.set_interrupt_line(0, true);
    processor.set_interrupt_line(0, false);
    let start = processor.cycle();
    processor.run(&mut Zeros, start + 1).expect("no fault");
    assert_eq!(processor.active_exception(), 15);
    run(&mut processor, 1);
    processor
        .run(&mut Zeros, processor.cycle())
        .expect("no fault");
    assert_eq!(processor.active_exception(), 16, "tail-chained after it");
}
