//! Instructions: cases outside the differential test, and error-prone cases.

use super::super::decode::rule::Rule;
use super::*;

const N: u32 = 1 << 31;
const Z: u32 = 1 << 30;
const C: u32 = 1 << 29;
const V: u32 = 1 << 28;

/// R0 and the flags after one instruction on R0, R1 and the flags.
fn outcome(instruction: &[u16], r0: u32, r1: u32, flags: u32) -> (u32, u32) {
    let mut processor = processor(instruction);
    processor.set_register(0, r0);
    processor.set_register(1, r1);
    processor.set_xpsr(flags);
    step(&mut processor, 1);
    (processor.register(0), processor.xpsr() & 0xF800_0000)
}

/// A7.4.2: a shift by 0 keeps the carry; by 32 the last bit is shifted into the carry; above 32 the result is 0.
#[test]
fn shifts_by_a_register() {
    const LSL: &[u16] = &[0x4088];
    const LSR: &[u16] = &[0x40C8];
    const ASR: &[u16] = &[0x4108];
    const ROR: &[u16] = &[0x41C8];
    let value = 0x8000_0001;
    for shift in [LSL, LSR, ASR, ROR] {
        assert_eq!(outcome(shift, value, 0, C), (value, N | C));
        assert_eq!(
            outcome(shift, value, 0x100, 0),
            (value, N),
            "only the low byte is used"
        );
    }
    assert_eq!(outcome(LSL, value, 1, 0), (2, C));
    assert_eq!(outcome(LSL, value, 32, 0), (0, Z | C));
    assert_eq!(outcome(LSL, value, 33, C), (0, Z));
    assert_eq!(outcome(LSR, value, 1, 0), (0x4000_0000, C));
    assert_eq!(outcome(LSR, value, 32, 0), (0, Z | C));
    assert_eq!(outcome(LSR, value, 33, C), (0, Z));
    assert_eq!(outcome(ASR, value, 32, 0), (u32::MAX, N | C));
    assert_eq!(outcome(ASR, value, 200, 0), (u32::MAX, N | C));
    assert_eq!(outcome(ROR, value, 32, 0), (value, N | C));
    assert_eq!(outcome(ROR, value, 33, 0), (0xC000_0000, N | C));
}

/// Immediate shifts of LSR and ASR by "0" are shifts by 32; that of ROR is RRX (A7.4.2).
#[test]
fn shifts_by_an_immediate() {
    assert_eq!(outcome(&[0x0800], 0x8000_0000, 0, 0), (0, Z | C));
    assert_eq!(outcome(&[0x1000], 0x8000_0000, 0, 0), (u32::MAX, N | C));
    assert_eq!(outcome(&[0xEA5F, 0x0030], 0x3, 0, C), (0x8000_0001, N | C));
}

/// AddWithCarry (A2.2.1): the carry of a difference is "no borrow".
#[test]
fn flags_of_sums() {
    assert_eq!(outcome(&[0x1840], 0x7FFF_FFFF, 1, 0), (0x8000_0000, N | V));
    assert_eq!(outcome(&[0x1840], u32::MAX, 1, 0), (0, Z | C));
    assert_eq!(outcome(&[0x1A40], 0, 1, 0), (u32::MAX, N));
    assert_eq!(outcome(&[0x1A40], 0x8000_0000, 1, 0), (0x7FFF_FFFF, C | V));
    assert_eq!(outcome(&[0x4148], u32::MAX, 0, C), (0, Z | C));
    assert_eq!(outcome(&[0x4188], 5, 5, 0), (u32::MAX, N));
}

#[test]
fn division() {
    let sdiv = &[0xFB90, 0xF0F1];
    assert_eq!(outcome(sdiv, 0x8000_0000, u32::MAX, 0).0, 0x8000_0000);
    assert_eq!(outcome(sdiv, -7i32 as u32, 2, 0).0, -3i32 as u32);
    assert_eq!(outcome(sdiv, 7, 0, 0).0, 0);
    let mut processor = processor(sdiv);
    write(&mut processor, 0xE000_ED14, 1 << 4);
    assert_eq!(fault(&mut processor).kind, FaultKind::DivisionByZero);
}

/// ITTE EQ: moves R0 and R1, or R2; 16-bit instructions in it do not change the flags (A7.3.2).
#[test]
fn it_blocks() {
    for (flags, expected) in [(Z, [1, 2, 0]), (0, [0, 0, 3])] {
        let mut processor = processor(&[0xBF06, 0x2001, 0x2102, 0x2203, 0x2000]);
        processor.set_xpsr(flags);
        step(&mut processor, 4);
        assert_eq!([0, 1, 2].map(|n| processor.register(n)), expected);
        assert_eq!(
            processor.xpsr(),
            flags | 1 << 24,
            "flags unchanged, and the block has ended"
        );
        step(&mut processor, 1);
        assert_eq!(processor.xpsr() & Z, Z, "MOVS outside the block");
    }
}

/// The low bits of SP are always 0 (B1.4.1).
#[test]
fn stack_pointer_is_aligned() {
    let mut processor = processor(&[0x4685]);
    processor.set_register(0, 0x2000_0FF7);
    step(&mut processor, 1);
    assert_eq!(processor.register(13), 0x2000_0FF4);
    assert_eq!(processor.lowest_stack(), 0x2000_0FF4);
}

/// A3.4.1: STREX stores only after LDREX, and only once; an exception closes the monitor (B1.5.6).
#[test]
fn exclusive_accesses() {
    let strex = [0xE841, 0x3200];
    let code = [[0xE851, 0x0F00], strex, strex].concat();
    let mut processor = processor(&code);
    processor.set_register(1, DATA);
    processor.set_register(3, 7);
    step(&mut processor, 2);
    assert_eq!((processor.register(2), processor.word(DATA)), (0, Some(7)));
    step(&mut processor, 1);
    assert_eq!(processor.register(2), 1);

    processor.set_register(15, CODE);
    processor.set_register(3, 8);
    step(&mut processor, 1);
    enable(&mut processor, 0, 0);
    processor.set_interrupt_line(0, true);
    processor.set_interrupt_line(0, false);
    step(&mut processor, 2);
    assert_eq!((processor.register(2), processor.word(DATA)), (1, Some(7)));
}

/// A3.2.1: single accesses may be unaligned, unless UNALIGN_TRP is set; all others must be aligned.
#[test]
fn alignment() {
    let mut loads = processor(&[0xF8B1, 0x0001, 0xF8B1, 0x0001]);
    assert!(loads.load(DATA, &[1, 2, 3, 4]));
    loads.set_register(1, DATA);
    step(&mut loads, 1);
    assert_eq!(loads.register(0), 0x0302);
    write(&mut loads, 0xE000_ED14, 1 << 3);
    assert_eq!(fault(&mut loads).kind, FaultKind::Unaligned(DATA + 1));

    for code in [[0xC90C, NOP], [0xE9C1, 0x2300], [0xE851, 0x0F00]] {
        let mut several = processor(&code);
        several.set_register(1, DATA + 2);
        assert_eq!(fault(&mut several).kind, FaultKind::Unaligned(DATA + 2));
        assert_eq!(several.pc(), CODE);
    }
}

#[test]
fn refused_instructions() {
    use FaultKind::{Undefined, Unpredictable};
    for (code, kind) in [
        (&[0xDE00][..], Undefined(Rule::PermanentlyUndefined)),
        (&[0xB400], Unpredictable(Rule::ShortList)),
        (&[0x4500], Unpredictable(Rule::BothLow)),
        (&[0xFA80, 0xF081], Undefined(Rule::DspExtension)),
        (&[0xEE00, 0x0A10], Undefined(Rule::NoCoprocessor)),
        (&[0xFB90, 0xFDF1], Unpredictable(Rule::StackPointerOrPc)),
        (&[0xF100, 0x1000], Unpredictable(Rule::RepeatedZero)),
        // BX LR as the first in a block of two, and IT in a block. EQ is true.
        (&[0xBF04, BX_LR], Unpredictable(Rule::NotLastInItBlock)),
        (&[0xBF04, 0xBF08], Unpredictable(Rule::InItBlock)),
    ] {
        let mut processor = processor(code);
        processor.set_xpsr(Z);
        let fault = fault(&mut processor);
        let place = CODE + if code[0] == 0xBF04 { 2 } else { 0 };
        assert_eq!((fault.kind, fault.pc), (kind, place));
    }
}
