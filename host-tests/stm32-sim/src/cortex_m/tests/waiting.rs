//! Passes of a waiting loop that are skipped: the same as if they were executed.

use super::*;
use crate::cortex_m::timing::{Buses, FlashTiming};
use std::cell::Cell;

/// A peripheral whose register changes at a cycle, and counts its reads.
struct Flag {
    from: u64,
    reads: u64,
    last: u64,
    /// It knows when it changes.
    known: bool,
    asked: Cell<u64>,
}

impl Flag {
    fn from(from: u64, known: bool) -> Self {
        Self {
            from,
            reads: 0,
            last: 0,
            known,
            asked: Cell::new(0),
        }
    }
}

impl Io for Flag {
    fn read(&mut self, cycle: u64, _: u32, _: Width) -> Result<u32, AccessError> {
        self.reads += 1;
        self.last = cycle;
        Ok((cycle >= self.from).into())
    }

    fn write(&mut self, _: u64, _: u32, _: Width, _: u32) -> Result<(), AccessError> {
        Err(AccessError::Unmapped)
    }

    fn constant_until(&self, cycle: u64, _: u32) -> Option<u64> {
        self.asked.set(self.asked.get() + 1);
        let until = if cycle < self.from {
            self.from
        } else {
            u64::MAX
        };
        self.known.then_some(until)
    }

    fn take_changed(&mut self) -> bool {
        false
    }
}

/// LDR R0, [R1]; LSLS R0, R0, #31; BEQ to the first; then NOP, B to the NOP.
const POLL: [u16; 5] = [LOAD, 0x07C0, 0xD0FC, NOP, 0xE7FD];
/// The same with a conditional branch out of the loop: LDR, LSLS, BNE to the end, ADDS R2, #0, B to the first.
const POLL_AND_LEAVE: [u16; 6] = [LOAD, 0x07C0, 0xD101, 0x3200, 0xE7FA, STAY];
/// LDR R0, [R1]; ADDS R2, #1; LSLS R0, R0, #31; BEQ to the first.
const COUNT: [u16; 5] = [LOAD, 0x3201, 0x07C0, 0xD0FB, STAY];

const END: u64 = 3000;

/// All that a program can see.
fn state(processor: &CortexM3) -> (u64, u64, Vec<u32>, u32) {
    let registers = (0..16).map(|number| processor.register(number));
    (
        processor.cycle(),
        processor.instructions(),
        registers.collect(),
        processor.xpsr(),
    )
}

/// Runs the processor at once, and another one cycle by cycle, which skips nothing. Returns the peripheral of the first.
fn same(start: &dyn Fn() -> CortexM3, flag: &dyn Fn() -> Flag, end: u64) -> Flag {
    let (mut at_once, mut stepped) = (start(), start());
    let (mut io, mut other) = (flag(), flag());
    at_once.run(&mut io, end).expect("no fault");
    while stepped.cycle() < end {
        let next = stepped.cycle() + 1;
        stepped.run(&mut other, next).expect("no fault");
    }
    assert_eq!(state(&at_once), state(&stepped));
    assert_eq!(io.last, other.last, "the last access");
    io
}

fn polling(code: &'static [u16], wait_states: u8) -> impl Fn() -> CortexM3 {
    move || {
        let mut processor = processor(code);
        let flash = FlashTiming {
            wait_states,
            prefetch: true,
        };
        processor.set_memories(flash, Buses { apb1: 2, apb2: 1 });
        processor.set_register(1, 0x4000_0000);
        processor
    }
}

#[test]
fn polled_flag_is_seen_in_the_cycle_in_which_it_is_set() {
    for code in [&POLL[..], &POLL_AND_LEAVE] {
        for wait_states in 0..3 {
            for from in (0..40).chain(500..560) {
                let io = same(&polling(code, wait_states), &|| Flag::from(from, true), END);
                assert!(io.reads < 20, "{} reads up to cycle {from}", io.reads);
            }
        }
    }
}

#[test]
fn cortex_m4_skips_the_same_passes() {
    let start = || {
        let mut processor = cortex_m4(&POLL);
        processor.set_register(1, 0x4000_0000);
        processor
    };
    for from in 500..520 {
        let io = same(&start, &|| Flag::from(from, true), END);
        assert!(io.reads < 20, "{} reads up to cycle {from}", io.reads);
    }
}

#[test]
fn each_pass_is_executed_if_the_time_of_a_change_is_unknown() {
    let io = same(&polling(&POLL, 2), &|| Flag::from(500, false), END);
    assert!(io.reads > 30 && io.asked.get() > 0, "{} reads", io.reads);
}

#[test]
fn each_pass_of_a_loop_that_counts_is_executed() {
    let io = same(&polling(&COUNT, 2), &|| Flag::from(500, true), END);
    assert!(io.reads > 30 && io.asked.get() == 0, "{} reads", io.reads);
}

#[test]
fn systick_interrupts_a_waiting_loop_in_the_same_cycle() {
    for reload in (200..240).chain([999]) {
        let start = || {
            let mut processor = polling(&POLL, 2)();
            write(&mut processor, 0xE000_E014, reload);
            write(&mut processor, 0xE000_E010, 0b111);
            processor
        };
        same(&start, &|| Flag::from(2500, true), END);
    }
}

/// The loop reads SYST_CSR: LDR R0, [R1]; LSLS R0, R0, #15; BPL to the first; NOP, B to the NOP.
#[test]
fn polled_countflag_is_seen_in_the_same_cycle() {
    for reload in [500, 501, 502, 503, 504, 505, 506, 507] {
        let start = || {
            let mut processor = polling(&[LOAD, 0x03C0, 0xD5FC, NOP, 0xE7FD], 1)();
            write(&mut processor, 0xE000_E014, reload);
            write(&mut processor, 0xE000_E010, 0b101);
            processor.set_register(1, 0xE000_E010);
            processor
        };
        same(&start, &|| Flag::from(0, true), END);
    }
}

#[test]
fn branch_to_itself_is_not_executed_each_time() {
    let mut processor = processor(&[STAY]);
    let end = 1_000_000_000_000;
    processor
        .run(&mut Flag::from(0, true), end)
        .expect("no fault");
    // 4 cycles each.
    assert_eq!(processor.instructions(), end / 4);
}
