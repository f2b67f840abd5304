//! Tests against the ARM ARM, with small programs.

mod cortex_m4;
mod cycles;
mod exceptions;
mod faults;
mod instructions;
mod interruption;
mod machine;
mod timer;
mod waiting;

use super::{CortexM3, Fault, FaultKind, MemorySizes, Model, Pause};
use crate::io::{AccessError, Io, Width};

/// The start address of the programs.
const CODE: u32 = 0x0800_0200;
/// The initial stack pointer.
const STACK: u32 = 0x2000_1000;
/// Base address of the handlers; each has 16 bytes.
const HANDLERS: u32 = 0x0800_1000;
/// A word of RAM for the tests.
const DATA: u32 = 0x2000_2000;
/// ICSR.
const ICSR: u32 = 0xE000_ED04;

const NOP: u16 = 0xBF00;
/// Branches to itself.
const STAY: u16 = 0xE7FE;
const BX_LR: u16 = 0x4770;
const WFI: u16 = 0xBF30;
const WFE: u16 = 0xBF20;
/// STR R0, [R1].
const STORE: u16 = 0x6008;
/// LDR R0, [R1].
const LOAD: u16 = 0x6808;
const CPSID_I: u16 = 0xB672;
const CPSIE_I: u16 = 0xB662;

/// One peripheral register, and a list of the accesses to it.
#[derive(Default)]
struct OneRegister {
    value: u32,
    writes: Vec<(u64, u32, Width, u32)>,
}

impl Io for OneRegister {
    fn read(&mut self, _: u64, address: u32, _: Width) -> Result<u32, AccessError> {
        if address == 0x4000_0000 {
            Ok(self.value)
        } else {
            Err(AccessError::Unmapped)
        }
    }

    fn write(
        &mut self,
        cycle: u64,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result<(), AccessError> {
        self.value = value;
        self.writes.push((cycle, address, width, value));
        Ok(())
    }

    fn take_changed(&mut self) -> bool {
        !self.writes.is_empty()
    }
}

/// A processor at the start of this program. Every handler returns at once.
fn processor(code: &[u16]) -> CortexM3 {
    started(CortexM3::new(), code)
}

/// The same for the processor of the STM32F446RE.
fn cortex_m4(code: &[u16]) -> CortexM3 {
    let sizes = MemorySizes {
        flash: 512 * 1024,
        ram: 128 * 1024,
        ram_repeats: false,
    };
    started(CortexM3::with(Model::CortexM4, sizes), code)
}

fn started(mut processor: CortexM3, code: &[u16]) -> CortexM3 {
    put(
        &mut processor,
        0x0800_0000,
        &[STACK as u16, (STACK >> 16) as u16],
    );
    put_word(&mut processor, 0x0800_0004, CODE | 1);
    for number in 2..80 {
        put_word(
            &mut processor,
            0x0800_0000 + 4 * number,
            handler(number as u16) | 1,
        );
        put(&mut processor, handler(number as u16), &[BX_LR]);
    }
    put(&mut processor, CODE, code);
    processor.reset();
    processor
}

fn handler(number: u16) -> u32 {
    HANDLERS + 16 * u32::from(number)
}

fn put(processor: &mut CortexM3, address: u32, half_words: &[u16]) {
    for (address, half_word) in (address..).step_by(2).zip(half_words) {
        assert!(processor.load(address, &half_word.to_le_bytes()));
    }
}

fn put_word(processor: &mut CortexM3, address: u32, word: u32) {
    assert!(processor.load(address, &word.to_le_bytes()));
}

fn step(processor: &mut CortexM3, count: u64) {
    let end = processor.instructions() + count;
    while processor.instructions() < end {
        let next = processor.cycle() + 1;
        processor
            .run(&mut OneRegister::default(), next)
            .expect("no fault");
    }
}

/// Writes a register of the system control space, as a program does.
fn write(processor: &mut CortexM3, address: u32, value: u32) {
    processor
        .write_system(address, Width::Word, value)
        .expect("the register exists");
}

fn read(processor: &mut CortexM3, address: u32) -> u32 {
    processor
        .read_system(address, Width::Word)
        .expect("the register exists")
}

fn enable(processor: &mut CortexM3, interrupt: u8, priority: u8) {
    let number = u32::from(interrupt);
    write(processor, 0xE000_E100 + number / 32 * 4, 1 << (number % 32));
    processor
        .write_system(0xE000_E400 + number, Width::Byte, priority.into())
        .expect("the register exists");
}

/// The fault at the end of the program.
fn fault(processor: &mut CortexM3) -> Fault {
    let end = processor.cycle() + 100;
    processor
        .run(&mut OneRegister::default(), end)
        .expect_err("the program faults")
}
