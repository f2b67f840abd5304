//! Memories, breakpoints, stops and faults.

use super::*;

fn run(processor: &mut CortexM3, io: &mut OneRegister) -> Pause {
    let end = processor.cycle() + 100;
    processor.run(io, end).expect("no fault")
}

/// An access to a peripheral has the correct width, and the run stops after the instruction when the peripheral requests it.
#[test]
fn peripherals() {
    let mut processor = processor(&[NOP, STORE, STAY]);
    processor.set_register(0, 5);
    processor.set_register(1, 0x4000_0000);
    let mut io = OneRegister::default();
    assert_eq!(run(&mut processor, &mut io), Pause::Changed);
    assert_eq!(io.writes, [(2, 0x4000_0000, Width::Word, 5)]);
    assert_eq!(processor.pc(), CODE + 4);
}

/// PM0056 2.2.5: one word for each bit of the peripherals and of RAM.
#[test]
fn bit_band() {
    let mut peripheral = processor(&[STORE, LOAD, STAY]);
    peripheral.set_register(0, 1);
    peripheral.set_register(1, 0x4200_0000 + 4 * 9);
    let mut io = OneRegister {
        value: 0x8000,
        ..OneRegister::default()
    };
    assert_eq!(run(&mut peripheral, &mut io), Pause::Changed);
    assert_eq!(io.value, 0x8200);

    let mut ram = processor(&[STORE, LOAD, STAY]);
    put_word(&mut ram, DATA, 0xFF);
    ram.set_register(0, 0xFE);
    ram.set_register(1, 0x2200_0000 + (DATA - 0x2000_0000) * 32 + 4 * 3);
    step(&mut ram, 2);
    assert_eq!((ram.word(DATA), ram.register(0)), (Some(0xF7), 0));
}

/// A store does not write flash; only the flash controller does. Changed flash is decoded again.
#[test]
fn flash_changes() {
    let mut processor = processor(&[0x2001, STAY]);
    step(&mut processor, 1);
    assert_eq!(processor.register(0), 1);
    assert!(processor.program(CODE, 0x2002));
    processor.set_register(15, CODE);
    step(&mut processor, 1);
    assert_eq!(processor.register(0), 2);

    assert!(processor.erase(CODE & !0x3FF, 1024));
    assert_eq!(processor.word(CODE), Some(u32::MAX));
    processor.set_register(15, CODE);
    assert!(matches!(
        fault(&mut processor).kind,
        FaultKind::Undefined(_)
    ));
}

/// A change of the second half of an instruction must also remove the first half from the cache.
#[test]
fn second_half_changes() {
    // MOVW R0, #1, then #2.
    let mut processor = processor(&[0xF240, 0x0001, STAY]);
    step(&mut processor, 1);
    assert!(processor.program(CODE + 2, 0x0002));
    processor.set_register(15, CODE);
    step(&mut processor, 1);
    assert_eq!(processor.register(0), 2);
}

/// A breakpoint stops before its instruction each time, in executed flash and in RAM.
#[test]
fn breakpoints() {
    for place in [CODE, 0x2000_0100] {
        // ADDS R0, #1; B back.
        let mut processor = processor(&[NOP]);
        put(&mut processor, place, &[0x3001, 0xE7FD]);
        processor.set_register(15, place);
        step(&mut processor, 2);
        processor.add_breakpoint(place);
        for count in 1..4 {
            assert_eq!(
                run(&mut processor, &mut OneRegister::default()),
                Pause::Breakpoint
            );
            assert_eq!((processor.pc(), processor.register(0)), (place, count));
        }
    }
}

#[test]
fn bkpt_and_reset_stop() {
    let mut bkpt = processor(&[NOP, 0xBE05]);
    assert_eq!(run(&mut bkpt, &mut OneRegister::default()), Pause::Bkpt(5));
    assert_eq!(bkpt.pc(), CODE + 2);

    let mut reset = processor(&[STORE, NOP]);
    reset.set_register(0, 0x05FA_0004);
    reset.set_register(1, 0xE000_ED0C);
    assert_eq!(run(&mut reset, &mut OneRegister::default()), Pause::Reset);
    reset.set_register(0, 0x0004);
    reset.set_register(15, CODE);
    step(&mut reset, 2);
    reset.reset();
    assert_eq!((reset.pc(), reset.register(13)), (CODE, STACK));
}

/// TakeReset (ARM ARM B1.5.5): bit 0 of the reset vector is copied to EPSR.T; if it is 0, the first instruction faults.
#[test]
fn even_reset_vector_faults() {
    let mut processor = processor(&[NOP]);
    put_word(&mut processor, 0x0800_0004, CODE);
    processor.reset();
    let expected = Fault {
        kind: FaultKind::InvalidState(CODE),
        pc: CODE,
        address: CODE,
    };
    assert_eq!(fault(&mut processor), expected);
    assert_eq!(processor.instructions(), 0);
    put_word(&mut processor, 0x0800_0004, CODE | 1);
    processor.reset();
    step(&mut processor, 1);
    assert_eq!(processor.pc(), CODE + 2);
}

/// A reset keeps RAM. A power cycle overwrites all of it, from start to end.
#[test]
fn power_off_clears_ram() {
    let mut processor = processor(&[NOP]);
    let places = [0x2000_0000, DATA, 0x2000_4FFC];
    for place in places {
        put_word(&mut processor, place, 0x1234_5678);
    }
    processor.reset();
    let words = |processor: &CortexM3| places.map(|place| processor.word(place));
    assert_eq!(words(&processor), [Some(0x1234_5678); 3]);
    processor.overwrite_ram();
    assert_eq!(words(&processor), [Some(0xA5A5_A5A5); 3]);
    assert_eq!(processor.word(0x0800_0004), Some(CODE | 1), "flash is kept");
}

#[test]
fn fault_has_address() {
    for (address, kind) in [
        (0x2000_5000, FaultKind::Unmapped(0x2000_5000)),
        (0x6000_0000, FaultKind::Unmapped(0x6000_0000)),
        (
            0x4000_0004,
            FaultKind::Access(0x4000_0004, AccessError::Unmapped),
        ),
        (0x4000_0001, FaultKind::Unaligned(0x4000_0001)),
        (
            0xE000_EFF0,
            FaultKind::System(0xE000_EFF0, "it is not modelled"),
        ),
    ] {
        let mut processor = processor(&[NOP, LOAD]);
        processor.set_register(1, address);
        assert_eq!(
            fault(&mut processor),
            Fault {
                kind,
                pc: CODE + 2,
                address
            }
        );
    }
    let mut even = processor(&[0x4780]);
    even.set_register(0, CODE);
    assert_eq!(fault(&mut even).kind, FaultKind::InvalidState(CODE));
    let mut nowhere = processor(&[0x4780]);
    nowhere.set_register(0, 0x3000_0001);
    assert_eq!(fault(&mut nowhere).kind, FaultKind::Unmapped(0x3000_0000));
    assert_eq!(nowhere.pc(), 0x3000_0000);
}

/// PUSH reaches a lower address than the final SP.
#[test]
fn lowest_stack() {
    let mut processor = processor(&[0xB510, 0xB510, 0xBC10, 0xBC10]);
    step(&mut processor, 4);
    assert_eq!(processor.register(13), STACK - 8);
    assert_eq!(processor.lowest_stack(), STACK - 16);
}
