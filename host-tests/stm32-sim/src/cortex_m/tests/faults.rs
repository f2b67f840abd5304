//! Faults as exceptions (ARM ARM B1.5.14, B3.2.15 to B3.2.18).

use super::super::decode::instruction::Register;
use super::*;

const CFSR: u32 = 0xE000_ED28;
const HFSR: u32 = 0xE000_ED2C;
const BFAR: u32 = 0xE000_ED38;
const SHCSR: u32 = 0xE000_ED24;
/// UDF.
const UNDEFINED: u16 = 0xDE00;
const PUSH_R0: u16 = 0xB401;
const UNMAPPED: u32 = 0x6000_0000;

/// Runs this program until it causes a fault, then starts the handler of the fault.
fn faulted(code: &[u16], prepare: impl FnOnce(&mut CortexM3)) -> CortexM3 {
    let mut processor = processor(code);
    // The handlers of the faults are endless loops.
    for number in 3..7 {
        put(&mut processor, handler(number), &[STAY]);
    }
    prepare(&mut processor);
    let fault = fault(&mut processor);
    assert!(processor.take_fault(&fault));
    processor
}

#[test]
fn load_from_unmapped_address_is_precise_bus_fault_that_escalates() {
    let mut processor = faulted(&[NOP, LOAD], |it| it.set_register(1, UNMAPPED));
    assert_eq!(processor.active_exception(), 3);
    assert_eq!(processor.pc(), handler(3));
    // The return address in the frame is that of the load.
    assert_eq!(processor.word(STACK - 8), Some(CODE + 2));
    assert_eq!(read(&mut processor, CFSR), 1 << 9 | 1 << 15);
    assert_eq!(read(&mut processor, HFSR), 1 << 30);
    assert_eq!(read(&mut processor, BFAR), UNMAPPED);
    write(&mut processor, CFSR, 1 << 9);
    write(&mut processor, HFSR, 1 << 30);
    assert_eq!(read(&mut processor, CFSR), 1 << 15);
    assert_eq!(read(&mut processor, HFSR), 0);
}

#[test]
fn usage_faults_have_their_bits() {
    let mut processor = faulted(&[UNDEFINED], |_| {});
    assert_eq!(read(&mut processor, CFSR), 1 << 16);
    // BX R0 with an even address.
    let mut processor = faulted(&[0x4700, NOP], |it| it.set_register(0, DATA));
    assert_eq!(read(&mut processor, CFSR), 1 << 17);
    // UNALIGN_TRP.
    let mut processor = faulted(&[LOAD], |it| {
        write(it, 0xE000_ED14, 1 << 9 | 1 << 3);
        it.set_register(1, DATA + 1);
    });
    assert_eq!(read(&mut processor, CFSR), 1 << 24);
}

#[test]
fn fetch_from_unmapped_address_is_instruction_bus_error() {
    let mut processor = faulted(&[0x4700], |it| it.set_register(0, UNMAPPED | 1));
    assert_eq!(read(&mut processor, CFSR), 1 << 8);
}

#[test]
fn enabled_handler_takes_its_fault() {
    // BUSFAULTENA, USGFAULTENA.
    let mut processor = faulted(&[LOAD], |it| {
        write(it, SHCSR, 1 << 17 | 1 << 18);
        it.set_register(1, UNMAPPED);
    });
    assert_eq!(processor.active_exception(), 5);
    assert_eq!(read(&mut processor, HFSR), 0);
    let masked = faulted(&[CPSID_I, LOAD], |it| {
        write(it, SHCSR, 1 << 17);
        it.set_register(1, UNMAPPED);
    });
    assert_eq!(masked.active_exception(), 3, "PRIMASK masks BusFault");
}

/// PM0056 4.4.7, BFHFNMIGN: only at priority -1 and -2. The status is set.
#[test]
fn load_at_priority_of_hard_fault_ignores_a_bus_fault() {
    const CPSID_F: u16 = 0xB671;
    const CCR: u32 = 0xE000_ED14;
    let load = |masks: u16, bit: u32| {
        let mut processor = processor(&[masks, LOAD, STAY]);
        write(&mut processor, CCR, 1 << 9 | bit);
        processor.set_register(1, UNMAPPED);
        processor
    };
    let mut ignoring = load(CPSID_F, 1 << 8);
    step(&mut ignoring, 3);
    assert_eq!(ignoring.active_exception(), 0);
    assert_eq!(read(&mut ignoring, CFSR), 1 << 9 | 1 << 15);
    for (masks, bit) in [(CPSID_F, 0), (CPSID_I, 1 << 8)] {
        let mut processor = load(masks, bit);
        assert_eq!(fault(&mut processor).kind, FaultKind::Unmapped(UNMAPPED));
    }
}

#[test]
fn handler_of_a_stack_overflow_runs_without_a_frame() {
    let start = super::super::memory::RAM_START;
    let mut processor = faulted(&[PUSH_R0, PUSH_R0], |it| it.set_register(13, start + 4));
    assert_eq!(processor.active_exception(), 3);
    assert_eq!(processor.pc(), handler(3));
    assert!(processor.register(13) < start);
    assert_eq!(read(&mut processor, CFSR), 1 << 9 | 1 << 15);
    assert_eq!(processor.registers.get(Register::LR), 0xFFFF_FFF9);
}

#[test]
fn fault_in_the_handler_of_a_fault_locks_up_until_reset() {
    let mut processor = processor(&[UNDEFINED]);
    put(&mut processor, handler(3), &[UNDEFINED]);
    for _ in 0..2 {
        assert!(!processor.is_locked_up());
        let fault = fault(&mut processor);
        assert!(processor.take_fault(&fault));
    }
    assert!(processor.is_locked_up());
    let (instructions, until) = (processor.instructions(), processor.cycle() + 1000);
    let pause = processor.run(&mut OneRegister::default(), until);
    assert_eq!(pause, Ok(Pause::Reached));
    assert_eq!(processor.instructions(), instructions);
    processor.reset();
    assert!(!processor.is_locked_up());
    assert_eq!(read(&mut processor, CFSR), 0);
}

#[test]
fn operation_without_a_defined_effect_has_no_handler() {
    // SLEEPDEEP is not modelled.
    let mut processor = processor(&[STORE]);
    processor.set_register(0, 1 << 2);
    processor.set_register(1, 0xE000_ED10);
    let fault = fault(&mut processor);
    assert!(!processor.take_fault(&fault));
}

/// SysTick becomes pending during the entry: its priority is lower, so that it does not replace the fault.
#[test]
fn exception_that_arrives_during_entry_does_not_replace_fault() {
    let mut processor = faulted(&[UNDEFINED], |it| {
        write(it, 0xE000_E014, 5);
        write(it, 0xE000_E010, 0b111);
    });
    assert_eq!(processor.active_exception(), 3);
    let pending_system_timer = 1 << 26;
    let control = read(&mut processor, 0xE000_ED04);
    assert_eq!(control & pending_system_timer, pending_system_timer);
}

#[test]
fn mpu_without_a_region_permits_only_the_handlers_of_faults() {
    const MPU_CTRL: u32 = 0xE000_ED94;
    let mut processor = cortex_m4(&[STAY]);
    put(&mut processor, handler(3), &[STAY]);
    // PRIVDEFENA alone, and with ENABLE.
    for value in [0b100, 0b101] {
        write(&mut processor, MPU_CTRL, value);
        step(&mut processor, 1);
    }
    assert!(processor.disturb(MPU_CTRL, 0b100));
    let fault = fault(&mut processor);
    assert_eq!(fault.kind, FaultKind::Protected(CODE));
    assert!(processor.take_fault(&fault));
    assert_eq!(processor.active_exception(), 3);
    assert_eq!(read(&mut processor, CFSR), 1);
    step(&mut processor, 1);
    assert_eq!(processor.pc(), handler(3));
}
