//! The features of the Cortex-M4 that the Cortex-M3 does not have.

use super::super::decode::rule::Rule;
use super::*;

/// CPACR.
const CPACR: u32 = 0xE000_ED88;

/// The start-up code of cortex-m-rt enables the floating-point unit, but the images contain no floating-point instruction.
#[test]
fn floating_point_can_be_enabled_but_not_executed() {
    // VADD.F32 S0, S0, S0; VPUSH {D8}; VMOV R0, S0.
    for code in [[0xEE30, 0x0A00], [0xED2D, 0x8B02], [0xEE10, 0x0A10]] {
        let mut processor = cortex_m4(&code);
        write(&mut processor, CPACR, 0x00F0_0001);
        assert_eq!(read(&mut processor, CPACR), 0x00F0_0000);
        let expected = FaultKind::Undefined(Rule::FloatingPoint);
        assert_eq!(fault(&mut processor).kind, expected, "{code:04X?}");
    }
    let mut other = cortex_m4(&[0xEE00, 0x0510]);
    let expected = FaultKind::Undefined(Rule::NoCoprocessor);
    assert_eq!(fault(&mut other).kind, expected);
}

#[test]
fn cortex_m3_has_no_coprocessors() {
    let mut processor = processor(&[STORE]);
    processor.set_register(1, CPACR);
    assert!(matches!(
        fault(&mut processor).kind,
        FaultKind::System(CPACR, _)
    ));
}

#[test]
fn identifier_and_number_of_interrupts_match_manual() {
    // PM0214: CPUID, ICTR, MPU_TYPE.
    let mut processor = cortex_m4(&[STAY]);
    let registers = [0xE000_ED00, 0xE000_E004, 0xE000_ED90];
    let values = registers.map(|register| read(&mut processor, register));
    assert_eq!(values, [0x410F_C241, 3, 0x800]);
}

/// RM0390, table 38: interrupt 96 is the last one.
#[test]
fn last_interrupt_is_taken() {
    let mut processor = cortex_m4(&[STAY]);
    let handler = CODE + 0x100;
    put(&mut processor, handler, &[BX_LR]);
    put_word(&mut processor, 0x0800_0000 + 4 * (16 + 96), handler | 1);
    enable(&mut processor, 96, 0);
    write(&mut processor, 0xE000_E10C, u32::MAX);
    assert_eq!(read(&mut processor, 0xE000_E10C), 1);
    processor.set_interrupt_line(96, true);
    step(&mut processor, 1);
    assert_eq!(processor.active_exception(), 16 + 96);
}

/// SADD8 sets the GE bits, SEL uses them, and an exception keeps them.
#[test]
fn exception_keeps_ge_bits() {
    // SADD8 R2, R0, R1; SEL R3, R0, R1.
    let mut processor = cortex_m4(&[0xFA80, 0xF201, 0xFAA0, 0xF381]);
    processor.set_register(0, 0x7F80_0180);
    processor.set_register(1, 0x0101_0102);
    step(&mut processor, 1);
    assert_eq!(processor.register(2), 0x8081_0282);
    assert_eq!(processor.xpsr() >> 16 & 0xF, 0b1010);
    enable(&mut processor, 5, 0);
    processor.set_interrupt_line(5, true);
    processor.set_interrupt_line(5, false);
    step(&mut processor, 2);
    assert_eq!(processor.register(3), 0x7F01_0102);
    assert_eq!(processor.xpsr() >> 16 & 0xF, 0b1010);
}

/// 128 KiB of RAM and 512 KiB of flash, also at address 0.
#[test]
fn memories_have_the_size_of_the_chip() {
    let mut processor = cortex_m4(&[LOAD]);
    for (address, exists) in [
        (0x2001_FFFC, true),
        (0x2002_0000, false),
        (0x0807_FFFC, true),
        (0x0007_FFFC, true),
        (0x0808_0000, false),
        (0x0008_0000, false),
    ] {
        processor.set_register(15, CODE);
        processor.set_register(1, address);
        let end = processor.cycle() + 1;
        let result = processor.run(&mut OneRegister::default(), end);
        assert_eq!(result.is_ok(), exists, "{address:08X}h");
    }
    let mut small = super::processor(&[LOAD]);
    for address in [0x0801_0000, 0x0001_0000, 0x2000_5000] {
        small.set_register(15, CODE);
        small.set_register(1, address);
        assert_eq!(fault(&mut small).kind, FaultKind::Unmapped(address));
    }
}
