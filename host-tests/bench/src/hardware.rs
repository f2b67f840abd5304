//! The hardware of a sensor, which performs the actions of the node.

use crate::bus::picoseconds;
use crate::controller::Controller;
use crate::flash::Flash;
use crate::node_type::STORE_BUFFER;
use crate::receive_pin::ReceivePin;
use plumbline::can::{BitRate, Filter};
use plumbline::node::driver::Platform;
use plumbline::node::{Action, BusEvent, BusMode, Leds};
use plumbline::store::Store;
use plumbline::time::{Duration, Instant, after, millis};
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

/// The hardware while the power is on.
#[derive(Debug)]
pub(super) struct Hardware {
    pub(super) controller: Controller,
    pub(super) receive_pin: ReceivePin,
    pub(super) leds: Leds,
    /// The change of the mode that the node has requested.
    change: Option<(BusMode, BitRate)>,
    /// The next step of a save.
    pub(super) next_step: Option<Instant>,
    /// End of the accelerometer self-test.
    pub(super) test_ends: Option<Instant>,
    /// The terminating resistor is connected.
    pub(super) terminated: bool,
    /// The heater's duty in permille.
    pub(super) heater: u16,
    /// The device restarts, with what the node keeps.
    pub(super) restart: Option<u32>,
}

impl Hardware {
    /// The hardware at power-up, at the time `now`.
    pub(super) fn new(now: Instant) -> Self {
        Self {
            controller: Controller::new(now),
            receive_pin: ReceivePin::default(),
            leds: Leds::default(),
            change: None,
            next_step: None,
            test_ends: None,
            terminated: false,
            heater: 0,
            restart: None,
        }
    }
}

/// The hardware with the parts that outlast a power-down.
pub(super) struct Board<'a> {
    pub(super) now: Instant,
    pub(super) hardware: &'a mut Hardware,
    pub(super) store: &'a mut Store<Flash, [u8; STORE_BUFFER]>,
    pub(super) led_history: &'a mut LedHistory,
}

fn list(filters: impl FnOnce(&mut dyn FnMut(Filter))) -> Vec<Filter> {
    let mut list = Vec::new();
    filters(&mut |filter| list.push(filter));
    list
}

impl Platform for Board<'_> {
    fn step(&mut self, filters: impl FnOnce(&mut dyn FnMut(Filter))) -> bool {
        let controller = &mut self.hardware.controller;
        if let Some((mode, rate)) = self.hardware.change.take() {
            controller.configure(picoseconds(self.now), mode, rate, list(filters));
        }
        controller.has_joined()
    }

    fn event(&mut self) -> Option<BusEvent> {
        self.hardware.controller.take_event()
    }

    fn refilter(&mut self, filters: impl FnOnce(&mut dyn FnMut(Filter))) {
        self.hardware.controller.refilter(list(filters));
    }

    fn perform(&mut self, action: Action) {
        let hardware = &mut *self.hardware;
        match action {
            Action::Bus(mode, rate) => hardware.change = Some((mode, rate)),
            Action::Recover => hardware.controller.recover(picoseconds(self.now)),
            Action::Leds(leds) => {
                hardware.leds = leds;
                self.led_history.show(self.now, leds);
            }
            Action::Termination(connected) => hardware.terminated = connected,
            Action::Heater(permille) => hardware.heater = permille,
            Action::SelfTest => hardware.test_ends = Some(after(self.now, SELF_TEST_TIME)),
            // The driver calls the methods below.
            Action::Save | Action::Restart => {}
        }
    }

    fn save(&mut self, image: impl FnOnce(&mut [u8]) -> Option<usize>) {
        self.hardware.next_step = Some(self.now);
        self.store.save(image);
    }

    fn restart(&mut self, kept: u32) {
        self.hardware.restart = Some(kept);
    }
}
