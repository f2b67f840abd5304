//! A panic, a fault or an unexpected exception restarts the sensor: CAN_TX is made recessive, the heater is switched off, the reason
//! is logged with `defmt`, then the microcontroller is reset.
//!
//! An NMI is such an exception: the clock security system has detected that HSE has stopped. After the reset, the board waits for
//! HSE with the error LED on.

use crate::board;
use core::arch::naked_asm;
use core::panic::PanicInfo;
use cortex_m::peripheral::SCB;
use cortex_m_rt::exception;

#[panic_handler]
fn panic(_info: &PanicInfo) -> ! {
    board::make_safe();
    #[cfg(feature = "defmt")]
    defmt::error!("{}", defmt::Display2Format(_info));
    SCB::sys_reset()
}

// SAFETY: cortex-m-rt requires `unsafe` because NMI can occur anywhere, also inside a critical section. The handler resets two peripherals,
// writes the log, which can be corrupted in the worst case, and does not return.
#[exception]
unsafe fn DefaultHandler(_number: i16) -> ! {
    board::make_safe();
    error!(
        "unexpected exception {=i16} (-14 is NMI: HSE failure)",
        _number
    );
    SCB::sys_reset()
}

/// The entry of a hard fault. After an overflow of the stack, the stack pointer is not in RAM: the handler starts with an empty
/// stack.
// SAFETY: the linker script of cortex-m-rt expects the handler by this name. It does not return.
#[unsafe(no_mangle)]
#[unsafe(naked)]
unsafe extern "C" fn HardFault() -> ! {
    naked_asm!(
        "mov r0, sp",
        "ldr r1, =_stack_start",
        "mov sp, r1",
        "b {}",
        sym hard_fault,
    )
}

/// Handles a hard fault. `_frame` is the address of the exception frame.
extern "C" fn hard_fault(_frame: usize) -> ! {
    board::make_safe();
    #[cfg(feature = "defmt")]
    log_fault(_frame);
    SCB::sys_reset()
}

/// Logs the address of the instruction, if the frame is in RAM.
#[cfg(feature = "defmt")]
fn log_fault(frame: usize) {
    if frame < 0x2000_0000 {
        defmt::error!("hard fault: stack overflow");
        return;
    }
    // SAFETY: the processor has written the frame at this address.
    let frame = unsafe { &*(frame as *const cortex_m_rt::ExceptionFrame) };
    defmt::error!("hard fault at {=u32:#x}", frame.pc());
}
