//! A chip with less memory than its name says, for example an STM32F103C6 with the print of a C8: 10 KiB of RAM, 32 KiB of flash. Without this
//! check, the first use of the stack would be a fault before the watchdog runs: the sensor would send nothing and light no LED.
//!
//! The check runs before all other code, thus without a stack. The sizes in the electronic signature are not used, because they are wrong on
//! some clones.

use super::{pac, set_pins, switch_on};
use crate::board::{PARAMETERS, StatusLeds};
use core::arch::naked_asm;
use plumbline::node::Leds;

/// The last word of the flash that the program uses.
const FLASH_LAST: usize = PARAMETERS + 2 * 1024 - 4;

/// Compares the memories with what the program needs: reads the last word of both, then writes its address to the last word of each KiB of
/// the stack and of the RAM, and compares them, because a chip can repeat a smaller RAM. The last word of the RAM keeps its value. The stack has
/// none yet.
///
/// FAULTMASK and CCR.BFHFNMIGN let a read where no memory is have no effect but its flag in CFSR (PM0056, 4.4.7). This is only so for precise
/// faults, and the fault of a store can be another one: so nothing is written before both reads have succeeded.
///
/// # Safety
/// Only for [`firmware`](crate::firmware): it runs after a reset, before the RAM is initialised. Generic, so that it is compiled for a program
/// only: the bootloader has no room for it.
// SAFETY: cortex-m-rt needs no register afterwards but LR.
#[unsafe(naked)]
pub unsafe extern "C" fn check_memories<N>() {
    naked_asm!(
        "ldr r0, =0xE000ED14", // CCR
        "ldr r1, [r0]",
        "orr r2, r1, #0x100", // BFHFNMIGN
        "cpsid f",
        "str r2, [r0]",
        "dsb",
        "ldr r2, =_mailbox + 60",
        "ldr r3, [r2]",
        "ldr r4, ={flash_last}",
        "ldr r4, [r4]",
        "dsb",
        "ldr r4, [r0, #0x14]", // CFSR
        "cbnz r4, 3f",
        "str r2, [r2]",
        "ldr r5, =_stack_start",
        "ldr r4, =_stack_end + 1020",
        "1:",
        "str r4, [r4]",
        "add r4, r4, #1024",
        "cmp r4, r5",
        "blo 1b",
        "ldr r6, [r2]",
        "cmp r6, r2",
        "bne 3f",
        "ldr r4, =_stack_end + 1020",
        "2:",
        "ldr r6, [r4]",
        "cmp r6, r4",
        "bne 3f",
        "add r4, r4, #1024",
        "cmp r4, r5",
        "blo 2b",
        "str r3, [r2]",
        "str r1, [r0]",
        "dsb",
        "cpsie f",
        "bx lr",
        // The smallest STM32F103 has 6 KiB of RAM.
        "3:",
        "ldr r0, =_stack_end + 4096",
        "mov sp, r0",
        "b {report}",
        flash_last = const FLASH_LAST,
        report = sym report::<N>,
    )
}

/// Lights the run LED and the error LED, and stays off the bus. There is no watchdog, because a restart would not help.
#[expect(
    clippy::extra_unused_type_parameters,
    reason = "compiled where it is used, as `check_memories`"
)]
extern "C" fn report<N>() -> ! {
    // SAFETY: no other code runs.
    let device = unsafe { pac::Peripherals::steal() };
    switch_on(&device.RCC);
    set_pins(&device.AFIO, &device.GPIOA, &device.GPIOB, &device.GPIOC);
    StatusLeds.show(Leds {
        run: true,
        error: true,
        ..Leds::default()
    });
    loop {
        cortex_m::asm::nop();
    }
}
