//! The hardware of a sensor, which performs the actions of the node.

use crate::flash::Flash;
use crate::node_type::STORE_BUFFER;
use crate::receive_pin::ReceivePin;
use plumbline::node::Leds;
use plumbline::node::driver::{Output, Platform};
use plumbline::store::{Store, StoreError, Usage};
use plumbline::time::{Duration, Instant, after, millis};
use plumbline::update::Contact;
use std::collections::VecDeque;

/// Duration of the accelerometer self-test.
const SELF_TEST_TIME: Duration = millis(2000);

/// LED changes that are kept.
const LED_HISTORY: usize = 10_000;

/// The changes of the LEDs, with their times.
#[derive(Debug, Default)]
pub(super) struct LedHistory(pub(super) VecDeque<(Instant, Leds)>);

impl LedHistory {
    pub(super) fn show(&mut self, now: Instant, leds: Leds) {
        if self.0.len() == LED_HISTORY {
            self.0.pop_front();
        }
        self.0.push_back((now, leds));
    }
}

/// The hardware while the power is on, except the CAN controller.
#[derive(Debug, Default)]
pub(super) struct Hardware {
    pub(super) receive_pin: ReceivePin,
    pub(super) leds: Leds,
    /// The next step of a save.
    pub(super) next_step: Option<Instant>,
    /// The result of a save that has ended.
    pub(super) stored: Option<Result<(), StoreError>>,
    /// End of the accelerometer self-test.
    pub(super) test_ends: Option<Instant>,
    /// The terminating resistor is connected.
    pub(super) terminated: bool,
    /// The heater's duty in permille.
    pub(super) heater: u16,
    /// The device restarts, with what the node keeps.
    pub(super) restart: Option<u32>,
    /// The restart is that into the bootloader.
    pub(super) contact: Option<Contact>,
}

/// The hardware with the parts that outlast a power-down.
pub(super) struct Board<'a> {
    pub(super) now: Instant,
    pub(super) hardware: &'a mut Hardware,
    pub(super) store: &'a mut Store<Flash, [u8; STORE_BUFFER]>,
    pub(super) led_history: &'a mut LedHistory,
}

impl Platform for Board<'_> {
    const HAS_BOOTLOADER: bool = true;

    fn perform(&mut self, output: Output) {
        let hardware = &mut *self.hardware;
        match output {
            Output::Leds(leds) => {
                hardware.leds = leds;
                self.led_history.show(self.now, leds);
            }
            Output::Termination(connected) => hardware.terminated = connected,
            Output::Heater(permille) => hardware.heater = permille,
            Output::SelfTest => hardware.test_ends = Some(after(self.now, SELF_TEST_TIME)),
        }
    }

    fn save(&mut self, image: impl FnOnce(&mut [u8]) -> Option<usize>) {
        self.hardware.next_step = Some(self.now);
        self.store.save(image);
    }

    /// The device performs the steps, because each stalls its processor.
    fn stored(&mut self) -> Option<Result<(), StoreError>> {
        self.hardware.stored.take()
    }

    fn keep(&mut self, usage: &Usage, hour: u32) -> bool {
        let begins = self.store.keep(usage, hour);
        if begins {
            self.hardware.next_step = Some(self.now);
        }
        begins
    }

    fn restart(&mut self, kept: u32) {
        self.hardware.restart = Some(kept);
    }

    fn update(&mut self, contact: &Contact) {
        self.hardware.contact = Some(*contact);
    }
}
