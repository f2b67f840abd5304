//! Exceptions, priorities and sleep (ARM ARM B1.5).

use super::*;

/// A pulse on an interrupt line.
fn pulse(processor: &mut CortexM3, interrupt: u8) {
    processor.set_interrupt_line(interrupt, true);
    processor.set_interrupt_line(interrupt, false);
}

/// Takes pending exceptions without executing an instruction.
fn settle(processor: &mut CortexM3) {
    let now = processor.cycle();
    processor
        .run(&mut OneRegister::default(), now)
        .expect("no fault");
}

/// B1.5.6: eight words, SP aligned to 8 bytes with bit 9 of xPSR set, EXC_RETURN in LR; the return restores everything.
#[test]
fn frame_and_return() {
    for (stack, frame, aligned) in [(STACK, STACK - 32, 0), (STACK - 4, STACK - 40, 1 << 9)] {
        let mut processor = processor(&[NOP, NOP]);
        for number in 0..13 {
            processor.set_register(number, 100 + u32::from(number));
        }
        processor.set_register(13, stack);
        processor.set_register(14, 114);
        processor.set_xpsr(0xA800_0000);
        enable(&mut processor, 5, 0);
        step(&mut processor, 1);
        pulse(&mut processor, 5);
        let before = processor.cycle();
        settle(&mut processor);

        assert_eq!(
            (processor.pc(), processor.active_exception()),
            (handler(21), 21)
        );
        assert_eq!(processor.cycle(), before + 12);
        assert_eq!(processor.register(13), frame);
        assert_eq!(processor.lowest_stack(), frame);
        assert_eq!(processor.register(14), 0xFFFF_FFF9);
        let words: Vec<_> = (0..8)
            .filter_map(|n| processor.word(frame + 4 * n))
            .collect();
        assert_eq!(
            words,
            [
                100,
                101,
                102,
                103,
                112,
                114,
                CODE + 2,
                0xA900_0000 | aligned
            ]
        );

        processor.set_register(0, 0);
        processor.set_xpsr(0);
        step(&mut processor, 1);
        assert_eq!(
            (processor.pc(), processor.active_exception()),
            (CODE + 2, 0)
        );
        assert_eq!(
            (processor.register(13), processor.register(0)),
            (stack, 100)
        );
        assert_eq!(processor.xpsr(), 0xA900_0000);
        assert_eq!(processor.instructions(), 2);
    }
}

/// An interrupt in an IT block: the handler runs outside the block, and the block continues after it.
#[test]
fn interrupt_in_an_it_block() {
    let mut processor = processor(&[0xBF06, 0x2001, 0x2102, 0x2203]);
    processor.set_xpsr(1 << 30);
    enable(&mut processor, 0, 0);
    step(&mut processor, 2);
    let inside = processor.xpsr();
    // ITSTATE 0000_1100: EQ, one more "then" and one "else".
    assert_eq!(inside & 0x0600_FC00, 0x0C00);
    pulse(&mut processor, 0);
    settle(&mut processor);
    assert_eq!(processor.xpsr() & 0x0600_FC00, 0);
    step(&mut processor, 1);
    assert_eq!(processor.xpsr(), inside);
    step(&mut processor, 2);
    assert_eq!([0, 1, 2].map(|n| processor.register(n)), [1, 2, 0]);
}

/// A higher priority preempts, an equal one does not; the pending exception with the highest priority is next, then the lowest
/// number.
#[test]
fn nesting() {
    let mut processor = processor(&[STAY]);
    for (interrupt, priority) in [(0, 0x80), (1, 0x80), (2, 0x40), (3, 0x40)] {
        enable(&mut processor, interrupt, priority);
    }
    pulse(&mut processor, 1);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 17);
    pulse(&mut processor, 0);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 17);
    pulse(&mut processor, 3);
    pulse(&mut processor, 2);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 18);
    assert_eq!(processor.register(14), 0xFFFF_FFF1);
    let mut order = Vec::new();
    while processor.active_exception() != 0 {
        step(&mut processor, 1);
        settle(&mut processor);
        order.push(processor.active_exception());
    }
    assert_eq!(order, [19, 17, 16, 0]);
}

/// PRIGROUP 5: two bits of group priority. 0x40 and 0x60 are in one group, where the lower value only determines the order of
/// pending exceptions.
#[test]
fn priority_groups() {
    let mut processor = processor(&[STAY]);
    write(&mut processor, 0xE000_ED0C, 0x05FA_0500);
    enable(&mut processor, 0, 0x60);
    enable(&mut processor, 1, 0x40);
    pulse(&mut processor, 0);
    settle(&mut processor);
    pulse(&mut processor, 1);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 16);
    write(&mut processor, 0xE000_ED0C, 0x05FA_0400);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 17);
}

/// BASEPRI masks its own priority and all lower ones; PRIMASK all configurable ones; FAULTMASK as well, until the return.
#[test]
fn masks() {
    // MSR BASEPRI, R0; CPSID I; CPSIE I; CPSID F.
    let mut processor = processor(&[0xF380, 0x8811, CPSID_I, CPSIE_I, 0xB671, STAY]);
    for (interrupt, priority) in [(0, 0x80), (1, 0x70), (2, 0x00)] {
        enable(&mut processor, interrupt, priority);
    }
    processor.set_register(0, 0x80);
    step(&mut processor, 1);
    pulse(&mut processor, 0);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 0);
    pulse(&mut processor, 1);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 17);
    step(&mut processor, 2);
    pulse(&mut processor, 2);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 0);
    step(&mut processor, 1);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 18);
    step(&mut processor, 2);
    pulse(&mut processor, 2);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 0);
    write(&mut processor, ICSR, 1 << 31);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 2, "NMI");
}

/// A line that stays high pends again after the handler; a falling line does not clear the pending state, ICPR does.
#[test]
fn lines_are_levels() {
    let mut processor = processor(&[NOP; 8]);
    enable(&mut processor, 0, 0);
    processor.set_interrupt_line(0, true);
    settle(&mut processor);
    assert_eq!(read(&mut processor, 0xE000_E200), 0);
    step(&mut processor, 1);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 16, "again");
    processor.set_interrupt_line(0, false);
    step(&mut processor, 1);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 0);

    write(&mut processor, 0xE000_E180, 1);
    pulse(&mut processor, 0);
    assert_eq!(read(&mut processor, 0xE000_E200), 1);
    write(&mut processor, 0xE000_E280, 1);
    assert_eq!(read(&mut processor, 0xE000_E200), 0);
    processor.set_interrupt_line(0, true);
    write(&mut processor, 0xE000_E280, 1);
    assert_eq!(
        read(&mut processor, 0xE000_E200),
        1,
        "the line is still high"
    );
}

/// B1.5.19: an interrupt masked by PRIMASK ends WFI and is taken later; a disabled one does not end it.
#[test]
fn wait_for_interrupt() {
    let mut processor = processor(&[CPSID_I, WFI, NOP, CPSIE_I, STAY]);
    processor
        .run(&mut OneRegister::default(), 1000)
        .expect("no fault");
    assert!(processor.is_asleep());
    assert_eq!((processor.cycle(), processor.instructions()), (1000, 2));
    processor.set_interrupt_line(7, true);
    processor
        .run(&mut OneRegister::default(), 1100)
        .expect("no fault");
    assert!(processor.is_asleep(), "the interrupt is not enabled");
    enable(&mut processor, 7, 0);
    step(&mut processor, 1);
    assert_eq!(
        (processor.pc(), processor.active_exception()),
        (CODE + 6, 0)
    );
    step(&mut processor, 1);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 23);
}

/// B1.5.18: SEV sets the event register; PRIMASK is respected for WFE; with SEVONPEND a new pending exception is an event.
#[test]
fn wait_for_event() {
    let mut processor = processor(&[0xBF40, CPSID_I, WFE, WFE, NOP]);
    step(&mut processor, 4);
    assert!(processor.is_asleep(), "the second time");
    enable(&mut processor, 0, 0);
    pulse(&mut processor, 0);
    settle(&mut processor);
    assert!(processor.is_asleep(), "PRIMASK");
    write(&mut processor, 0xE000_ED10, 1 << 4);
    pulse(&mut processor, 1);
    settle(&mut processor);
    assert!(!processor.is_asleep());
}

/// SCR.SLEEPONEXIT: the thread does not continue after the handler.
#[test]
fn sleep_on_exit() {
    let mut processor = processor(&[NOP, NOP]);
    write(&mut processor, 0xE000_ED10, 1 << 1);
    enable(&mut processor, 0, 0);
    pulse(&mut processor, 0);
    step(&mut processor, 1);
    assert!(processor.is_asleep());
    assert_eq!(processor.pc(), CODE);
}

/// SCR.SLEEPDEEP would stop the clocks (RM0008 4.3.4), so it is refused.
#[test]
fn deep_sleep_is_refused() {
    let mut processor = processor(&[STORE]);
    processor.set_register(0, 1 << 2);
    processor.set_register(1, 0xE000_ED10);
    let expected = FaultKind::System(0xE000_ED10, "SLEEPDEEP is not modelled");
    assert_eq!(fault(&mut processor).kind, expected);
}

/// B1.5.8: the return restores T from the frame, and there is no ARM state.
#[test]
fn return_without_thumb_bit_faults() {
    let mut processor = processor(&[NOP, NOP]);
    enable(&mut processor, 5, 0);
    pulse(&mut processor, 5);
    settle(&mut processor);
    let place = processor.register(13) + 28;
    let status = processor.word(place).expect("xPSR in the frame") & !(1 << 24);
    put_word(&mut processor, place, status);
    let fault = fault(&mut processor);
    assert!(matches!(fault.kind, FaultKind::InvalidReturn(value, _) if value == status));
    assert_eq!(fault.pc, handler(21));
}

/// PM0056 4.4.3: VECTPENDING respects BASEPRI and FAULTMASK, but not PRIMASK.
#[test]
fn vectpending_respects_basepri_and_faultmask() {
    // CPSID I; MSR BASEPRI, R0; MSR BASEPRI, R1; CPSID F.
    let mut processor = processor(&[CPSID_I, 0xF380, 0x8811, 0xF381, 0x8811, 0xB671]);
    let number = |processor: &mut CortexM3| read(processor, ICSR) >> 12 & 0x1FF;
    enable(&mut processor, 3, 0x80);
    processor.set_register(0, 0x80);
    processor.set_register(1, 0x90);
    step(&mut processor, 1);
    assert_eq!(number(&mut processor), 0);
    pulse(&mut processor, 3);
    assert_eq!(number(&mut processor), 19, "PRIMASK is ignored");
    step(&mut processor, 1);
    assert_eq!(number(&mut processor), 0, "BASEPRI is equal");
    step(&mut processor, 1);
    assert_eq!(number(&mut processor), 19, "BASEPRI is lower");
    step(&mut processor, 1);
    assert_eq!(number(&mut processor), 0, "FAULTMASK");
}

/// The thread on the process stack: SVC switches to the main stack and back; PendSV follows it.
#[test]
fn process_stack() {
    // MSR PSP, R0; MSR CONTROL, R1; SVC 3; MRS R3, CONTROL.
    let mut processor = processor(&[0xF380, 0x8809, 0xF381, 0x8814, 0xDF03, 0xF3EF, 0x8314]);
    let process = 0x2000_3000;
    processor.set_register(0, process);
    processor.set_register(1, 2);
    step(&mut processor, 2);
    assert_eq!(processor.register(13), process);
    write(&mut processor, 0xE000_ED1C, 0x4000_0000);
    write(&mut processor, 0xE000_ED20, 0x00F0_0000);
    step(&mut processor, 1);
    settle(&mut processor);
    assert_eq!(
        (processor.active_exception(), processor.register(13)),
        (11, STACK)
    );
    assert_eq!(processor.register(14), 0xFFFF_FFFD);
    assert_eq!(
        processor.word(process - 32 + 24),
        Some(CODE + 10),
        "after the SVC"
    );
    write(&mut processor, ICSR, 1 << 28);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 11);
    step(&mut processor, 1);
    settle(&mut processor);
    assert_eq!(processor.active_exception(), 14);
    step(&mut processor, 2);
    assert_eq!(
        (processor.register(13), processor.register(3)),
        (process, 2)
    );
}

#[test]
fn masked_supervisor_call_escalates() {
    let mut processor = processor(&[CPSID_I, 0xDF00]);
    assert_eq!(fault(&mut processor).kind, FaultKind::Escalation);
}

/// Arm erratum 602117: the base of LDRD R0, R1, [R0, #8] is loaded before the interrupt.
#[test]
fn interrupted_load_pair_starts_again_with_wrong_base() {
    for (restarts, base) in [(false, DATA), (true, DATA + 0x20)] {
        let mut processor = processor(&[NOP, 0xE9D0, 0x0102]);
        processor.set_restarts_loads(restarts);
        put_word(&mut processor, DATA + 8, DATA + 0x20);
        put_word(&mut processor, base + 12, 7);
        processor.set_register(0, DATA);
        enable(&mut processor, 5, 0);
        step(&mut processor, 1);
        pulse(&mut processor, 5);
        settle(&mut processor);
        assert_eq!(processor.register(0), if restarts { base } else { DATA });
        // The handler returns, and the instruction is executed.
        step(&mut processor, 2);
        assert_eq!(processor.register(1), 7);
    }
}
