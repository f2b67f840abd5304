//! What the bus and the processor's run often ask of the peripherals. It is stored until an access, an event or a test may have
//! changed it.

use super::Microcontroller;
use crate::board;
use crate::peripherals::Driver;
use plumbline::node::Leds;

/// The answers of the peripherals.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noted {
    /// The cycle of the next event.
    pub(super) next_event: Option<u64>,
    /// The CAN controller is connected to the bus.
    pub(super) is_connected: bool,
    /// What drives the pin TXD.
    pub(super) driver: Driver,
    pub(super) leds: Leds,
}

impl Microcontroller {
    /// The answers of the peripherals.
    pub(super) fn noted(&self) -> Noted {
        if let Some(noted) = self.noted.get() {
            return noted;
        }
        let io = &self.io;
        let noted = Noted {
            next_event: io.next_event(),
            is_connected: io.can_is_connected(),
            driver: io.driver(),
            leds: board::leds(io.board(), &io.gpio),
        };
        self.noted.set(Some(noted));
        noted
    }

    /// The peripherals may have changed.
    pub(super) fn forget(&self) {
        self.noted.set(None);
    }

    /// True when a peripheral has something to do.
    pub(super) fn is_due(&self) -> bool {
        let cycle = self.core.cycle();
        let event = self.noted().next_event;
        // NMI starts again after its handler.
        self.disturbed || self.io.rcc.nmi() || event.is_some_and(|event| event <= cycle)
    }
}
