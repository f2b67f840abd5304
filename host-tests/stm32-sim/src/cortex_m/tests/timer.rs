//! SysTick (ARM ARM B3.3).

use super::*;

const CTRL: u32 = 0xE000_E010;
const LOAD_VALUE: u32 = 0xE000_E014;
const CURRENT: u32 = 0xE000_E018;
const PENDSTSET: u32 = 1 << 26;

fn started(code: &[u16], reload: u32, control: u32) -> CortexM3 {
    let mut processor = processor(code);
    write(&mut processor, LOAD_VALUE, reload);
    write(&mut processor, CURRENT, 0);
    write(&mut processor, CTRL, control);
    processor
}

/// From 0 the counter is set to the reload value, counts down to 0, and repeats: a period of reload + 1.
#[test]
fn counts_cycles() {
    let mut processor = started(&[NOP; 12], 3, 0b101);
    let mut seen = Vec::new();
    for _ in 0..9 {
        seen.push(read(&mut processor, CURRENT));
        step(&mut processor, 1);
    }
    assert_eq!(seen, [0, 3, 2, 1, 0, 3, 2, 1, 0]);
}

/// COUNTFLAG is set on the change from 1 to 0; reading it or writing the counter clears it.
#[test]
fn count_flag() {
    let mut processor = started(&[NOP; 20], 3, 0b101);
    step(&mut processor, 3);
    assert_eq!(read(&mut processor, CTRL), 0b101);
    step(&mut processor, 1);
    assert_eq!(read(&mut processor, CTRL), 1 << 16 | 0b101);
    assert_eq!(read(&mut processor, CTRL), 0b101);
    step(&mut processor, 4);
    write(&mut processor, CURRENT, 77);
    assert_eq!(read(&mut processor, CURRENT), 0);
    assert_eq!(read(&mut processor, CTRL), 0b101);
}

/// With TICKINT, reaching 0 pends exception 15 in that exact cycle, and wakes from WFI: 3 cycles, and 12 for the entry.
#[test]
fn wakes() {
    let mut processor = started(&[WFI, STAY], 999, 0b111);
    assert_eq!(processor.next_wake(), Some(1000));
    processor
        .run(&mut OneRegister::default(), 999)
        .expect("no fault");
    assert!(processor.is_asleep());
    processor
        .run(&mut OneRegister::default(), 1000)
        .expect("no fault");
    assert_eq!(
        (processor.active_exception(), processor.cycle()),
        (15, 1000 + 3 + 12)
    );
    assert_eq!(processor.next_wake(), Some(2000));
}

/// ICSR shows it pending in the same cycle while PRIMASK masks it; PENDSTCLR clears it.
#[test]
fn pending_is_visible() {
    let mut processor = started(&[CPSID_I, NOP, NOP, NOP, NOP, NOP], 4, 0b111);
    // CPSID takes 2 cycles.
    step(&mut processor, 3);
    assert_eq!(read(&mut processor, ICSR) & PENDSTSET, 0);
    step(&mut processor, 1);
    assert_eq!(read(&mut processor, ICSR) & PENDSTSET, PENDSTSET);
    assert_eq!(read(&mut processor, ICSR) >> 12 & 0x1FF, 15);
    write(&mut processor, ICSR, 1 << 25);
    assert_eq!(read(&mut processor, ICSR) & PENDSTSET, 0);
}

/// A new reload value takes effect at the next 0; with 0 the counter stops there.
#[test]
fn reload_takes_effect_at_zero() {
    let mut processor = started(&[NOP; 20], 5, 0b111);
    step(&mut processor, 2);
    write(&mut processor, LOAD_VALUE, 9);
    assert_eq!(processor.next_wake(), Some(6));
    write(&mut processor, LOAD_VALUE, 0);
    step(&mut processor, 8);
    assert_eq!(read(&mut processor, CURRENT), 0);
    assert_eq!(processor.next_wake(), None);
}

/// Without CLKSOURCE it counts at an eighth of the clock (RM0008).
#[test]
fn eighth_of_the_clock() {
    let mut processor = started(&[STAY], 3, 0b011);
    assert_eq!(processor.next_wake(), Some(32));
    // Four branches of 4 cycles.
    step(&mut processor, 4);
    assert_eq!(read(&mut processor, CURRENT), 2);
}
