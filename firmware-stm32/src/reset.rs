//! A panic or a hard fault restarts the sensor. With `defmt` the reason is logged first.

use core::panic::PanicInfo;
use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};

#[panic_handler]
fn panic(_info: &PanicInfo) -> ! {
    #[cfg(feature = "defmt")]
    defmt::error!("{}", defmt::Display2Format(_info));
    SCB::sys_reset()
}

// SAFETY: cortex-m-rt requires `unsafe` because a hard fault can occur anywhere, also inside a critical section. The handler uses
// only the log, which can be corrupted in the worst case, and does not return.
#[exception]
unsafe fn HardFault(_frame: &ExceptionFrame) -> ! {
    error!("hard fault at {=u32:#x}", _frame.pc());
    SCB::sys_reset()
}
