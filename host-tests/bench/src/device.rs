//! One sensor: a node with the store, the motion and the CAN controller around it, driven as the firmware's main loop on a
//! board drives it.

use super::accelerometer::Accelerometer;
use super::bus::{instant, picoseconds};
use super::controller::Controller;
use super::flash::Flash;
use super::receive_pin::ReceivePin;
use super::sensor::Sensor;
use crate::motion::Motion;
use crate::node_type::{NodeType, STORE_BUFFER};
use crate::thermal::Cell;
use can_wire::protocol::{Event, Period, Picoseconds, Protocol};
use plumbline::can::{BitRate, Frame};
use plumbline::measure::self_test::Working;
use plumbline::measure::{Reading, SAMPLE_PERIOD};
use plumbline::node::{Action, Boot, BusEvent, BusMode, Leds, Node, Readout};
use plumbline::store::Store;
use plumbline::time::{Duration, Instant, after, earlier, millis, reached};
use std::collections::VecDeque;

/// Time to program a half-word of flash.
const PROGRAM_TIME: Duration = Duration::from_ticks(52);

/// Time to erase a page of flash.
const ERASE_TIME: Duration = millis(30);

/// Longest wait of a restart for an empty mailbox: a frame without acknowledge must not block the restart.
const RESTART_PATIENCE: Duration = millis(200);

/// Number of actions in one poll loop after which the node is treated as stuck.
const ACTIONS_MAX: usize = 1000;

/// Duration of the accelerometer self-test.
const SELF_TEST_TIME: Duration = millis(2000);

/// LED changes that are kept.
const LED_HISTORY: usize = 10_000;

/// One sensor on the bench.
pub struct Device {
    node_type: NodeType,
    serial: u32,
    store: Store<Flash, STORE_BUFFER>,
    motion: Box<dyn Motion>,
    accelerometer: Accelerometer,
    /// The measuring cell, if it has a heater.
    cell: Option<Cell>,
    power: Option<Powered>,
    boots: u32,
    /// What the node keeps over its restart; 0 before power-up.
    kept: u32,
    led_history: VecDeque<(Instant, Leds)>,
}

/// State that exists while the power is on.
struct Powered {
    node: Box<dyn Node>,
    controller: Controller,
    receive_pin: ReceivePin,
    leds: Leds,
    next_sample: Instant,
    /// The next step of a save.
    next_step: Option<Instant>,
    /// The processor is stalled until then, because flash is programmed or erased.
    stalled_until: Option<Instant>,
    /// End of the accelerometer self-test.
    test_ends: Option<Instant>,
    /// The terminating resistor is connected.
    terminated: bool,
    /// The heater's duty in permille.
    heater: u16,
    /// Latest time of a requested restart, which waits for an empty mailbox.
    restart_by: Option<Instant>,
}

impl Device {
    /// A sensor that is not switched on; [`Bus::attach`](super::Bus::attach) does that.
    pub fn new(node_type: &NodeType, serial: u32, flash: Flash, motion: Box<dyn Motion>) -> Self {
        Self {
            node_type: *node_type,
            serial,
            store: Store::open(flash, node_type.owner(serial)),
            motion,
            accelerometer: Accelerometer::new(0),
            cell: node_type.cell.map(Cell::new),
            power: None,
            boots: 0,
            kept: 0,
            led_history: VecDeque::new(),
        }
    }

    /// Sets the error of the oscillator of the accelerometer, in 10^-6, before the device is switched on.
    pub fn with_clock_deviation(self, deviation: i32) -> Self {
        Self {
            accelerometer: Accelerometer::new(deviation),
            ..self
        }
    }

    /// True while the device terminates the bus.
    pub fn terminated(&self) -> bool {
        self.power.as_ref().is_some_and(|power| power.terminated)
    }

    /// The duty of the device's heater in permille; 0 while the power is off.
    pub fn heater(&self) -> u16 {
        self.power.as_ref().map_or(0, |power| power.heater)
    }

    /// The powered part, unless the processor is stalled.
    fn awake(&mut self) -> Option<&mut Powered> {
        self.power
            .as_mut()
            .filter(|power| power.stalled_until.is_none())
    }

    /// Passes events and frames of the CAN controller to the node while it accepts them.
    fn service(&mut self, now: Instant) {
        self.settle(now);
        while let Some(power) = self.awake() {
            if let Some(event) = power.controller.take_event() {
                power.node.bus(now, event);
            } else if power.node.ready()
                && let Some(frame) = power.controller.take_received()
            {
                power.node.receive(now, &frame);
            } else {
                break;
            }
            self.settle(now);
        }
    }

    /// Passes a measured bit time to the node.
    fn measure(&mut self, now: Instant) {
        let Some(power) = self.awake() else { return };
        let measured = power.receive_pin.poll(now);
        if let Some(time) = measured.filter(|_| power.controller.mode() == Some(BusMode::Listen)) {
            if power.controller.protocol.is_joining() {
                // As on the boards: the end of a frame was too short to join the bus.
                power.node.bus(now, BusEvent::Error);
            }
            power.node.bus(now, BusEvent::BitTime(time));
            self.settle(now);
        }
    }

    /// Polls the node until it returns None, then fills the mailbox.
    fn settle(&mut self, now: Instant) {
        if let Some(power) = self.awake() {
            if power.controller.take_unsent() {
                power.node.bus(now, BusEvent::Unsent);
            }
            if power.controller.mailbox_free() {
                power.node.sent(now);
            }
        }
        let mut actions = 0;
        while let Some(power) = self.awake()
            && let Some(action) = power.node.poll(now)
        {
            actions += 1;
            assert!(
                actions <= ACTIONS_MAX,
                "{}: poll never returns None, its last answer at {now} is {action:?}",
                self.node_type.name
            );
            self.perform(now, action);
        }
        let Some(power) = self.awake() else { return };
        let once = power.node.sends_once();
        if power.controller.mailbox_free()
            && let Some(frame) = power.node.transmit(now)
        {
            power.controller.load(frame, once);
        }
        let sent = power.controller.mailbox_empty();
        // As on the boards, a running save ends first.
        let saves = power.next_step.is_some();
        if !saves && power.restart_by.is_some_and(|by| sent || reached(now, by)) {
            self.kept = power.node.kept();
            self.power_cycle(now);
        }
    }

    fn perform(&mut self, now: Instant, action: Action) {
        let Some(power) = &mut self.power else { return };
        match action {
            Action::Bus(mode, rate) => {
                let mut filters = Vec::new();
                power.node.filters(&mut |filter| filters.push(filter));
                let controller = &mut power.controller;
                if power.node.changes_filters() && controller.is_at(mode, rate) {
                    controller.refilter(filters);
                } else {
                    controller.configure(picoseconds(now), mode, rate, filters);
                }
            }
            Action::Recover => power.controller.protocol.recover(picoseconds(now)),
            Action::Leds(leds) => {
                power.leds = leds;
                self.show(now, leds);
            }
            Action::Save => {
                power.next_step = Some(now);
                self.store.save(|buffer| power.node.image(buffer));
            }
            Action::Restart => power.restart_by = Some(after(now, RESTART_PATIENCE)),
            Action::Termination(connected) => power.terminated = connected,
            Action::Heater(permille) => power.heater = permille,
            Action::SelfTest => power.test_ends = Some(after(now, SELF_TEST_TIME)),
        }
    }

    fn show(&mut self, now: Instant, leds: Leds) {
        if self.led_history.len() == LED_HISTORY {
            self.led_history.pop_front();
        }
        self.led_history.push_back((now, leds));
    }

    /// Takes the samples that are due. After a stall, all readings come at once.
    fn sample(&mut self, now: Instant) {
        let Some(power) = self.power.as_mut().filter(|p| p.stalled_until.is_none()) else {
            return;
        };
        if !reached(now, power.next_sample) {
            return;
        }
        while reached(now, power.next_sample) {
            power.next_sample = after(power.next_sample, SAMPLE_PERIOD);
        }
        power.node.supply(now, self.motion.supply(now));
        for reading in self.accelerometer.readings(now, &mut *self.motion) {
            let reading = self.heated(now, reading);
            if let Some(power) = &mut self.power {
                power.node.sample(now, &reading);
            }
        }
        self.service(now);
    }

    /// The reading at the temperature of the measuring cell.
    fn heated(&mut self, now: Instant, reading: Reading) -> Reading {
        let duty = self.heater();
        match &mut self.cell {
            Some(cell) => cell.reading(now, duty, reading),
            None => reading,
        }
    }

    /// Reports the result of the self-test: all axes work.
    fn test(&mut self, now: Instant) {
        let Some(power) = self.awake() else { return };
        if power.test_ends.is_none_or(|end| !reached(now, end)) {
            return;
        }
        power.test_ends = None;
        let working = Working {
            x: true,
            y: true,
            z: true,
        };
        power.node.tested(now, working);
        self.service(now);
    }

    /// Runs the next step of a save; the processor is stalled while flash is programmed or erased.
    fn step(&mut self, now: Instant) {
        let due = |power: &mut Powered| power.next_step.is_some_and(|at| reached(now, at));
        if !self.awake().is_some_and(due) {
            return;
        }
        let before = self.flash_work();
        let result = self.store.step();
        let time = self.flash_time(before);
        if self.cut_off(now) {
            return;
        }
        let Some(power) = &mut self.power else { return };
        let end = after(now, time);
        if result.is_none() {
            power.next_step = Some(end);
        } else {
            power.next_step = None;
        }
        if time > Duration::from_ticks(0) {
            power.stalled_until = Some(end);
        }
        if let Some(result) = result {
            power.node.stored(now, result);
            self.service(now);
        }
    }

    /// Bytes programmed and pages erased so far.
    fn flash_work(&mut self) -> (u64, u64) {
        let flash = self.store.memory();
        (flash.programmed(), flash.erased())
    }

    /// Duration of the flash operations since `before`.
    fn flash_time(&mut self, before: (u64, u64)) -> Duration {
        let (programmed, erased) = self.flash_work();
        let half_words = (programmed - before.0).div_ceil(2);
        let ticks = half_words * PROGRAM_TIME.ticks() + (erased - before.1) * ERASE_TIME.ticks();
        Duration::from_ticks(ticks)
    }

    /// Switches the device off when the fuse of its memory has blown.
    fn cut_off(&mut self, now: Instant) -> bool {
        let cut = self.store.memory().is_cut();
        if cut {
            self.power_off(now);
        }
        cut
    }
}

impl Sensor for Device {
    fn power_off(&mut self, now: Instant) {
        // A running save stays incomplete.
        if self.power.take().is_some() {
            self.show(now, Leds::default());
        }
    }

    /// Scans the store, erases ahead and starts the node.
    fn power_on(&mut self, now: Instant) {
        let mut flash = core::mem::take(self.store.memory());
        flash.power_on();
        self.store = Store::open(flash, self.node_type.owner(self.serial));
        let before = self.flash_work();
        self.store.prepare();
        let start = after(now, self.flash_time(before));
        self.boots += 1;
        let kept = core::mem::take(&mut self.kept);
        let boot = Boot {
            kept,
            ..self.store.boot()
        };
        let node = (self.node_type.start)(&self.node_type, start, &boot);
        self.accelerometer.power_on();
        self.power = Some(Powered {
            node,
            controller: Controller::new(),
            receive_pin: ReceivePin::default(),
            leds: Leds::default(),
            next_sample: after(start, self.node_type.first_reading),
            next_step: None,
            stalled_until: Some(start),
            test_ends: None,
            terminated: false,
            heater: 0,
            restart_by: None,
        });
        self.cut_off(now);
    }

    /// The device switches off when the fuse of the [`Flash`] blows.
    fn is_on(&self) -> bool {
        self.power.is_some()
    }

    fn boots(&self) -> u32 {
        self.boots
    }

    fn next_event(&self) -> Option<Picoseconds> {
        let power = self.power.as_ref()?;
        let next = power.stalled_until.or_else(|| {
            [
                Some(power.next_sample),
                power.next_step,
                power.test_ends,
                power.restart_by,
                power.receive_pin.deadline(),
                power.node.deadline(),
            ]
            .into_iter()
            .fold(None, earlier)
        });
        next.map(picoseconds)
    }

    fn advance(&mut self, at: Picoseconds) -> Picoseconds {
        let now = instant(at);
        let Some(power) = &mut self.power else {
            return at;
        };
        if power.stalled_until.is_some_and(|until| reached(now, until)) {
            power.stalled_until = None;
            power.controller.drain_fifo();
        }
        self.measure(now);
        self.service(now);
        self.sample(now);
        self.test(now);
        self.step(now);
        let deadline = self.awake().and_then(|power| power.node.deadline());
        assert!(
            deadline.is_none_or(|at| !reached(now, at)),
            "{}: polled until None at {now}, yet its deadline stays at {deadline:?}",
            self.node_type.name
        );
        at
    }

    fn protocol(&self) -> Option<&Protocol> {
        self.power.as_ref().map(|power| &power.controller.protocol)
    }

    fn next_step(&self) -> Option<Picoseconds> {
        let controller = &self.power.as_ref()?.controller;
        let protocol = &controller.protocol;
        let offers = protocol.takes_offer() && controller.offered().is_some();
        protocol.next_event(offers)
    }

    fn offered(&self) -> Option<Frame> {
        self.power.as_ref()?.controller.offered()
    }

    fn wire(&mut self, now: Picoseconds, dominant: bool) {
        let Some(power) = &mut self.power else { return };
        if dominant {
            power.controller.protocol.edge(now);
        }
        if power.controller.mode() == Some(BusMode::Listen) {
            power.receive_pin.edge(now, dominant);
            self.measure(instant(now));
        }
    }

    fn step(&mut self, now: Picoseconds, dominant: bool) -> Option<Event> {
        let power = self.power.as_mut()?;
        let controller = &mut power.controller;
        let offered = controller.offered();
        let event = controller.protocol.step(now, dominant, offered)?;
        let stalled = power.stalled_until.is_some();
        controller.note(now, event, stalled);
        self.service(instant(now));
        Some(event)
    }

    fn skip(&mut self, period: Period, count: u64) {
        if let Some(power) = &mut self.power {
            power.controller.protocol.skip(period, count);
        }
    }

    fn name(&self) -> &'static str {
        self.node_type.name
    }

    fn mode(&self) -> Option<BusMode> {
        self.power.as_ref()?.controller.mode()
    }

    fn rate(&self) -> Option<BitRate> {
        self.power.as_ref()?.controller.rate()
    }

    fn leds(&self) -> Leds {
        let power = self.power.as_ref();
        power.map_or(Leds::default(), |power| power.leds)
    }

    fn led_history(&self) -> &VecDeque<(Instant, Leds)> {
        &self.led_history
    }

    fn readout(&self) -> Option<Readout> {
        Some(self.power.as_ref()?.node.readout())
    }

    fn set_motion(&mut self, motion: Box<dyn Motion>) {
        self.motion = motion;
    }

    fn flash(&mut self) -> &mut Flash {
        self.store.memory()
    }
}
