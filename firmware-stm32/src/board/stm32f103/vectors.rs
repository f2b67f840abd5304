//! The interrupt vectors, up to the last one that is used. The table of the PAC has 60.

use super::pac::Interrupt;
use super::{CAN_RECEIVE_INTERRUPT, CAN_TRANSMIT_INTERRUPT, PULSE_INTERRUPT};

type Handler = unsafe extern "C" fn();

unsafe extern "C" {
    /// The handler of cortex-m-rt for interrupts that are not used.
    fn DefaultHandler();
    /// The handlers that [`firmware`](crate::firmware) defines.
    fn CAN_RECEIVE();
    fn CAN_TRANSMIT();
    /// The handler of [`pulse_interrupt`](crate::pulse_interrupt), in products that detect the bit rate.
    fn TIM4();
}

/// The interrupts that are used, with their handlers.
const HANDLERS: [(Interrupt, Handler); 3] = [
    (CAN_RECEIVE_INTERRUPT, CAN_RECEIVE),
    (CAN_TRANSMIT_INTERRUPT, CAN_TRANSMIT),
    (PULSE_INTERRUPT, TIM4),
];

/// The number of vectors, up to the last one that is used.
const COUNT: usize = {
    let mut count = 0;
    let mut next = 0;
    while next < HANDLERS.len() {
        if HANDLERS[next].0 as usize >= count {
            count = HANDLERS[next].0 as usize + 1;
        }
        next += 1;
    }
    count
};

/// The vectors. cortex-m-rt specifies name and section.
// SAFETY: the linker script of cortex-m-rt expects function pointers in this section, in the order of the interrupts.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [Handler; COUNT] = {
    let mut vectors = [DefaultHandler as Handler; COUNT];
    let mut next = 0;
    while next < HANDLERS.len() {
        let (interrupt, handler) = HANDLERS[next];
        vectors[interrupt as usize] = handler;
        next += 1;
    }
    vectors
};
