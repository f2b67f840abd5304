//! A panic or a hard fault restarts the sensor: nobody is there to press a button. With `defmt` the reason is logged first.

use core::panic::PanicInfo;
use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};

#[panic_handler]
fn panic(_info: &PanicInfo) -> ! {
    #[cfg(feature = "defmt")]
    defmt::error!("{}", defmt::Display2Format(_info));
    SCB::sys_reset()
}

// SAFETY: cortex-m-rt wants `unsafe` here because a hard fault can come anywhere, also inside a critical section; the handler
// relies on nothing but the log, which would at worst be garbled, and does not return.
#[exception]
unsafe fn HardFault(_frame: &ExceptionFrame) -> ! {
    error!("hard fault at {=u32:#x}", _frame.pc());
    SCB::sys_reset()
}
