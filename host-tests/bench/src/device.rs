//! One sensor: a node with the store, the motion and the CAN controller around it, driven as the firmware's main loop on a
//! board drives it.

use super::accelerometer::Accelerometer;
use super::bus::{instant, picoseconds};
use super::controller::{Controller, Interrupt};
use super::flash::Flash;
use super::hardware::{Board, Hardware, LedHistory};
use super::sensor::Sensor;
use crate::fault::{Axis, Fault};
use crate::motion::Motion;
use crate::node_type::{NodeType, STORE_BUFFER};
use crate::thermal::Cell;
use can_wire::protocol::{Event, Period, Picoseconds, Protocol};
use plumbline::can::{BitRate, Frame};
use plumbline::diagnosis::ResetCauses;
use plumbline::measure::calibration::Part;
use plumbline::measure::self_test::Working;
use plumbline::measure::{Reading, SAMPLE_PERIOD};
use plumbline::node::driver::{Driver, OneThread};
use plumbline::node::{Boot, BusEvent, BusMode, Leds, Node, Readout};
use plumbline::store::{ImageId, Store};
use plumbline::time::{Duration, Instant, after, earlier, millis, reached};
use plumbline::update::{Contact, Installed};
use std::collections::VecDeque;

/// Time to program a half-word of flash.
pub(super) const PROGRAM_TIME: Duration = Duration::from_ticks(52);

/// Time to erase a page of flash.
pub(super) const ERASE_TIME: Duration = millis(30);

/// The test fails if the node needs more than this number of turns at one time.
const TURNS_MAX: usize = 1000;

/// One sensor on the bench.
pub struct Device {
    node_type: NodeType,
    serial: u32,
    store: Store<Flash, [u8; STORE_BUFFER]>,
    motion: Box<dyn Motion>,
    accelerometer: Accelerometer,
    /// The measuring cell, if it has a heater.
    cell: Option<Cell>,
    power: Option<Powered>,
    boots: u32,
    /// What the node keeps over its restart; 0 before power-up.
    kept: u32,
    /// The causes of the next start.
    causes: ResetCauses,
    /// The program; None: there is no bootloader.
    program: Option<Installed>,
    /// The program has asked its bootloader for an update, and is off.
    contact: Option<Contact>,
    led_history: LedHistory,
}

/// State that exists while the power is on.
struct Powered {
    driver: Driver<OneThread<Box<dyn Node>, Controller>>,
    hardware: Hardware,
    next_sample: Instant,
    /// The processor is stalled until then, because flash is programmed or erased.
    stalled_until: Option<Instant>,
}

impl Powered {
    /// Sets the time that the driver reads.
    fn set_time(&mut self, now: Instant) {
        self.driver.controller_mut().set_time(now);
    }

    /// Handles the interrupts of the CAN controller. Returns false if there is none.
    fn interrupt(&mut self) -> bool {
        let mut interrupted = false;
        while let Some(interrupt) = self.driver.controller_mut().take_interrupt() {
            interrupted = true;
            match interrupt {
                Interrupt::Received(frame) => self.driver.receive(&frame),
                Interrupt::Free(unsent) => self.driver.transmitted(unsent),
            }
        }
        interrupted
    }
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
            causes: ResetCauses::POWER_ON,
            program: None,
            contact: None,
            led_history: LedHistory::default(),
        }
    }

    /// Sets the error of the oscillator of the accelerometer, in 10^-6, before the device is switched on.
    pub fn with_clock_deviation(self, deviation: i32) -> Self {
        Self {
            accelerometer: Accelerometer::new(deviation),
            ..self
        }
    }

    /// Its next start is that of the program behind a bootloader.
    pub(super) fn set_program(&mut self, program: Installed) {
        self.program = Some(program);
    }

    /// How the bootloader is reached, if the program has asked it for an update since the last call.
    pub(super) fn take_contact(&mut self) -> Option<Contact> {
        self.contact.take()
    }

    /// The product of its program.
    pub(super) fn image(&self) -> ImageId {
        self.node_type.image
    }

    /// True while the device terminates the bus.
    pub fn terminated(&self) -> bool {
        let power = self.power.as_ref();
        power.is_some_and(|power| power.hardware.terminated)
    }

    /// The duty of the device's heater in permille; 0 while the power is off.
    pub fn heater(&self) -> u16 {
        let power = self.power.as_ref();
        power.map_or(0, |power| power.hardware.heater)
    }

    /// The powered part, unless the processor is stalled.
    fn awake(&mut self) -> Option<&mut Powered> {
        self.power
            .as_mut()
            .filter(|power| power.stalled_until.is_none())
    }

    /// Handles the interrupts of the CAN controller and turns the node until there is nothing more to do.
    fn service(&mut self, now: Instant) {
        let mut turns = 0;
        while let Some(power) = &mut self.power
            && power.stalled_until.is_none()
        {
            power.set_time(now);
            power.interrupt();
            let mut board = Board {
                now,
                hardware: &mut power.hardware,
                store: &mut self.store,
                led_history: &mut self.led_history,
            };
            let more = power.driver.turn(&mut board);
            if let Some(contact) = power.hardware.contact {
                self.contact = Some(contact);
                return self.power_off(now);
            }
            if let Some(kept) = power.hardware.restart.take() {
                self.kept = kept;
                self.causes = ResetCauses::SOFTWARE;
                return self.power_cycle(now);
            }
            if !power.interrupt() && !more {
                return;
            }
            turns += 1;
            assert!(
                turns <= TURNS_MAX,
                "{}: the driver does not become idle at {now}",
                self.node_type.name
            );
        }
    }

    /// Passes a measured bit time to the node.
    fn measure(&mut self, now: Instant) {
        let Some(power) = self.awake() else { return };
        let measured = power.hardware.receive_pin.poll(now);
        let controller = power.driver.controller_mut();
        if let Some(time) = measured.filter(|_| controller.mode() == Some(BusMode::Listen)) {
            if controller.protocol().is_joining() {
                // As on the boards: the end of a frame was too short to join the bus.
                controller.report(BusEvent::Error);
            }
            controller.report(BusEvent::BitTime(time));
            self.service(now);
        }
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
        power.set_time(now);
        power.driver.supply(self.motion.supply(now));
        for reading in self.accelerometer.readings(now, &mut *self.motion) {
            let reading = self.heated(now, reading);
            if let Some(power) = &mut self.power {
                power.driver.sample(&reading);
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

    /// Reports the result of the self-test: all axes without a fault work.
    fn test(&mut self, now: Instant) {
        let defective = match self.motion.fault(now) {
            Some(Fault::Axis(axis)) => Some(axis),
            _ => None,
        };
        let Some(power) = self.awake() else { return };
        if power
            .hardware
            .test_ends
            .is_none_or(|end| !reached(now, end))
        {
            return;
        }
        power.hardware.test_ends = None;
        let working = Working {
            x: defective != Some(Axis::X),
            y: defective != Some(Axis::Y),
            z: defective != Some(Axis::Z),
        };
        power.set_time(now);
        power.driver.tested(working);
        self.service(now);
    }

    /// Runs the next step of a save; the processor is stalled while flash is programmed or erased.
    fn step(&mut self, now: Instant) {
        let due = |power: &mut Powered| {
            let step = power.hardware.next_step;
            step.is_some_and(|at| reached(now, at))
        };
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
            power.hardware.next_step = Some(end);
        } else {
            power.hardware.next_step = None;
        }
        if time > Duration::from_ticks(0) {
            power.stalled_until = Some(end);
        }
        if let Some(result) = result {
            power.hardware.stored = Some(result);
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
            self.led_history.show(now, Leds::default());
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
        let causes = core::mem::replace(&mut self.causes, ResetCauses::POWER_ON);
        let mut boot = Boot {
            kept,
            causes,
            program: self.program,
            ..self.store.boot()
        };
        boot.fit(Part::Ism330dhcx);
        let node = self.node_type.start(start, &boot);
        self.accelerometer.power_on();
        self.power = Some(Powered {
            driver: Driver::new(OneThread::new(node, Controller::new(start))),
            hardware: Hardware::default(),
            next_sample: after(start, self.node_type.first_reading),
            stalled_until: Some(start),
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
                power.hardware.next_step,
                power.hardware.test_ends,
                power.hardware.receive_pin.deadline(),
                power.driver.deadline(),
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
        }
        self.measure(now);
        self.service(now);
        self.sample(now);
        self.test(now);
        self.step(now);
        let deadline = self.awake().and_then(|power| power.driver.deadline());
        assert!(
            deadline.is_none_or(|at| !reached(now, at)),
            "{}: polled until None at {now}, yet its deadline stays at {deadline:?}",
            self.node_type.name
        );
        at
    }

    fn protocol(&self) -> Option<&Protocol> {
        let power = self.power.as_ref();
        power.map(|power| power.driver.controller().protocol())
    }

    fn next_step(&self) -> Option<Picoseconds> {
        let controller = self.power.as_ref()?.driver.controller();
        let protocol = controller.protocol();
        let offers = protocol.takes_offer() && controller.offered().is_some();
        protocol.next_event(offers)
    }

    fn offered(&self) -> Option<Frame> {
        self.power.as_ref()?.driver.controller().offered()
    }

    fn wire(&mut self, now: Picoseconds, dominant: bool) {
        let Some(power) = &mut self.power else { return };
        let controller = power.driver.controller_mut();
        if dominant {
            controller.edge(now);
        }
        if controller.mode() == Some(BusMode::Listen) {
            power.hardware.receive_pin.edge(now, dominant);
            self.measure(instant(now));
        }
    }

    fn step(&mut self, now: Picoseconds, dominant: bool) -> Option<Event> {
        let power = self.power.as_mut()?;
        let stalled = power.stalled_until.is_some();
        let event = power.driver.controller_mut().step(now, dominant, stalled)?;
        self.service(instant(now));
        Some(event)
    }

    fn skip(&mut self, period: Period, count: u64) {
        if let Some(power) = &mut self.power {
            power.driver.controller_mut().skip(period, count);
        }
    }

    fn name(&self) -> &'static str {
        self.node_type.name
    }

    fn mode(&self) -> Option<BusMode> {
        self.power.as_ref()?.driver.controller().mode()
    }

    fn rate(&self) -> Option<BitRate> {
        self.power.as_ref()?.driver.controller().rate()
    }

    fn leds(&self) -> Leds {
        let power = self.power.as_ref();
        power.map_or(Leds::default(), |power| power.hardware.leds)
    }

    fn led_history(&self) -> &VecDeque<(Instant, Leds)> {
        &self.led_history.0
    }

    fn readout(&self) -> Option<Readout> {
        Some(self.power.as_ref()?.driver.side().node().readout())
    }

    fn set_motion(&mut self, motion: Box<dyn Motion>) {
        self.motion = motion;
    }

    fn memory(&mut self) -> &Flash {
        self.store.memory()
    }

    fn flash(&mut self) -> &mut Flash {
        self.store.memory()
    }
}
