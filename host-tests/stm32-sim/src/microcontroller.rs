//! The microcontroller on its board: runs processor and peripherals together, handles power and reset, and attaches to the bus of
//! the bench as a [`Sensor`].
//!
//! The processor runs until a peripheral has an event, or an access to a register may have changed the state of others. A fault stops the
//! program with a panic that names the place, unless [`Microcontroller::take_faults`] has selected the handler of the program.

mod disturbance;
mod frozen;
mod noted;
mod on_the_bus;
mod probe;

use super::board;
use super::bxcan::BxCan;
use super::cortex_m::timing::Buses;
use super::cortex_m::{CortexM3, Fault};
use super::elf::Image;
use super::flash::Work;
use super::ism330dhcx::Noise;
use super::peripherals::Peripherals;
use super::rcc::ResetCause;
use super::signature::unique_id;
use super::silicon::Silicon;
use bench::motion::Motion;
use bench::thermal::Heated;
use bench::{Flash, NodeType, Sensor};
use can_wire::protocol::Picoseconds;
use noted::Noted;
use plumbline::node::Leds;
use plumbline::time::Instant;
use std::any::Any;
use std::cell::Cell;
use std::collections::{BTreeSet, VecDeque};
use std::fmt::Display;
use std::rc::Rc;

/// The first interrupt of the CAN controller; its four lines follow each other (RM0008, table 63; RM0390, table 38).
const CAN_INTERRUPTS: u8 = 19;

/// The number of the exception NMI.
const NMI: u16 = 2;

/// The number of the interrupt of TIM4.
const TIM4_INTERRUPT: u8 = 30;

/// LED changes that are kept.
const LED_HISTORY: usize = 10_000;

/// The number of starts that are kept.
const RESETS: usize = 1000;

/// A microcontroller with its program.
pub struct Microcontroller {
    name: &'static str,
    image: Rc<Image>,
    core: CortexM3,
    io: Peripherals,
    /// The measuring cell, if the product has a heater.
    heated: Option<Heated>,
    on: bool,
    boots: u32,
    resets: Vec<Reset>,
    leds: Leds,
    led_history: VecDeque<(Instant, Leds)>,
    lowest_stack: u32,
    /// The parameter pages may have been changed from outside.
    parameters_touched: bool,
    reported: Reported,
    /// A program that cannot continue is reported.
    reports_stop: bool,
    stopped: Option<String>,
    /// A fault starts its handler in the program.
    takes_faults: bool,
    faults: Vec<String>,
    /// A debugger halts the processor.
    halted: bool,
    /// What the peripherals say until the next access to them.
    noted: Cell<Option<Noted>>,
    /// The peripherals may have been changed from outside.
    disturbed: bool,
}

/// A start of the program, and the outputs just before it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Reset {
    /// The simulated time of the reset.
    pub at: Picoseconds,
    /// What caused the reset.
    pub cause: ResetCause,
    /// TXD was dominant at that time, which would disturb the bus.
    pub dominant: bool,
    /// The duty of the heater in permille.
    pub heater: u16,
}

/// The violations that have been reported: the count in either list, and their kinds.
#[derive(Default)]
struct Reported {
    io: usize,
    can: usize,
    kinds: BTreeSet<(String, String)>,
}

impl Microcontroller {
    /// A microcontroller that is not switched on, with this program and this serial number. The image determines which one, and the
    /// accelerometer: the one whose driver it has.
    ///
    /// # Panics
    /// When the parameter memory is that of another microcontroller.
    pub fn new(
        name: &'static str,
        image: Rc<Image>,
        serial: u32,
        flash: Flash,
        motion: Box<dyn Motion>,
    ) -> Self {
        let board = image.board();
        let mut io = Peripherals::new(board, unique_id(serial), flash, motion);
        if let Some(content) = image.slot() {
            io.flash.open_slot(content);
        }
        if image.address_of("imu::adxl355").is_some() {
            io.fit_adxl355();
        }
        let new = Self {
            name,
            image,
            core: CortexM3::with(board.chip().facts().processor, board.memory()),
            io,
            heated: None,
            on: false,
            boots: 0,
            resets: Vec::new(),
            leds: Leds::default(),
            led_history: VecDeque::new(),
            lowest_stack: u32::MAX,
            parameters_touched: true,
            reported: Reported::default(),
            reports_stop: false,
            stopped: None,
            takes_faults: false,
            faults: Vec::new(),
            halted: false,
            noted: Cell::new(None),
            disturbed: false,
        };
        new.with_silicon(&Silicon::genuine(board))
    }

    /// The same with the behaviour of this silicon.
    pub fn with_silicon(mut self, silicon: &Silicon) -> Self {
        self.core.set_silicon(silicon.processor, silicon.memories);
        self.core.set_restarts_loads(silicon.restarts_loads);
        self.load_program();
        self.io.set_silicon(silicon);
        self.parameters_touched = true;
        self
    }

    /// Writes the program into the flash.
    fn load_program(&mut self) {
        for segment in self.image.segments() {
            let address = segment.load_address;
            let loaded = self.core.load(address, &segment.bytes);
            assert!(loaded, "parse has checked the segments: {address:#010x}");
        }
    }

    /// The same with an accelerometer without random noise ([`Noise::Alternating`]).
    pub fn quiet(mut self) -> Self {
        self.io.imu.set_noise(Noise::Alternating);
        if let Some(part) = &mut self.io.adxl355 {
            part.set_noise(Noise::Alternating);
        }
        self
    }

    /// A microcontroller that is not switched on, with the program of this node type and its accelerometer in the measuring cell.
    pub fn of_type(
        node_type: &NodeType,
        image: Rc<Image>,
        serial: u32,
        flash: Flash,
        motion: Box<dyn Motion>,
    ) -> Self {
        let heated = node_type.cell.map(Heated::new);
        let motion = match &heated {
            Some(heated) => heated.around(motion),
            None => motion,
        };
        Self {
            heated,
            ..Self::new(node_type.name, image, serial, flash, motion)
        }
    }

    /// When the program cannot continue, the microcontroller switches off and [`stopped`](Self::stopped) has the reason. Without
    /// this call it panics, which ends a test.
    pub fn report_stop(&mut self) {
        self.reports_stop = true;
    }

    /// From now on a fault starts its handler in the program, as on the chip. Without this call the program stops.
    pub fn take_faults(&mut self) {
        self.takes_faults = true;
    }

    /// The faults that the program's handlers have taken, one sentence each.
    pub fn faults(&self) -> &[String] {
        &self.faults
    }

    /// The reason why the program could not continue, as one sentence.
    pub fn stopped(&self) -> Option<&str> {
        self.stopped.as_deref()
    }

    /// The microcontroller of a sensor; None for a host build.
    pub fn of(sensor: &dyn Sensor) -> Option<&Self> {
        (sensor as &dyn Any).downcast_ref()
    }

    /// The microcontroller of a sensor, mutable; None for a host build.
    pub fn of_mut(sensor: &mut dyn Sensor) -> Option<&mut Self> {
        (sensor as &mut dyn Any).downcast_mut()
    }

    /// The program that it executes.
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// The processor, to read registers and memory.
    pub fn core(&self) -> &CortexM3 {
        &self.core
    }

    /// The processor, to change registers and memory.
    pub fn core_mut(&mut self) -> &mut CortexM3 {
        &mut self.core
    }

    /// The peripherals, to read their registers.
    pub fn io(&self) -> &Peripherals {
        &self.io
    }

    /// The peripherals, mutable, to set faults.
    pub fn io_mut(&mut self) -> &mut Peripherals {
        self.forget();
        self.disturbed = true;
        &mut self.io
    }

    /// The CAN controller, to read its state.
    pub fn can(&self) -> &BxCan {
        &self.io.can
    }

    /// The violations of the reference manual's rules by the program, one sentence each; the first thousand of the CAN controller
    /// and of the other peripherals.
    pub fn violations(&self) -> Vec<String> {
        let io = self.io.violations().iter().map(ToString::to_string);
        let can = self.io.can.violations().iter().map(ToString::to_string);
        io.chain(can).collect()
    }

    /// The new [`violations`](Self::violations) since the last call; repeated ones are omitted.
    pub fn take_new_violations(&mut self) -> Vec<String> {
        let reported = &mut self.reported;
        let (io, can) = (self.io.violations(), self.io.can.violations());
        let mut new = Vec::new();
        for violation in &io[reported.io..] {
            let kind = (violation.register.clone(), violation.reason.to_owned());
            if reported.kinds.insert(kind) {
                new.push(violation.to_string());
            }
        }
        for violation in &can[reported.can..] {
            let kind = (violation.register.to_owned(), violation.reason.clone());
            if reported.kinds.insert(kind) {
                new.push(violation.to_string());
            }
        }
        (reported.io, reported.can) = (io.len(), can.len());
        new
    }

    /// The first thousand starts, oldest first; [`boots`](Sensor::boots) counts all.
    pub fn resets(&self) -> &[Reset] {
        &self.resets
    }

    /// The peak stack usage in bytes, with interrupts, over all starts.
    pub fn peak_stack(&self) -> u32 {
        let top = self.core.word(FLASH_START).unwrap_or_default();
        top - self.lowest_stack.min(self.core.lowest_stack()).min(top)
    }

    /// The lowest address that the stack has reached.
    pub fn lowest_stack(&self) -> u32 {
        self.lowest_stack.min(self.core.lowest_stack())
    }

    /// The pages that the bootloader can change, to set their fuse and faults; None without a bootloader.
    pub fn slot(&mut self) -> Option<&mut Flash> {
        self.parameters_touched = true;
        self.io.flash.slot_mut()
    }

    /// True while the sensor terminates the bus.
    pub fn terminated(&self) -> bool {
        self.on && board::terminated(self.io.board(), &self.io.gpio)
    }

    /// The duty of the heater in permille; 0 while the power is off.
    pub fn heater(&self) -> u16 {
        // RM0008, DBG_TIMx_STOP: "the outputs are disabled". The resistor at the pin keeps the switch off.
        if !self.on || self.halted && self.io.dbgmcu.stops_tim3() {
            0
        } else {
            let io = &self.io;
            board::heater(io.board(), &io.gpio, &io.afio, &io.tim3)
        }
    }

    /// The time of the processor.
    fn time(&self) -> Picoseconds {
        self.io.now(self.core.cycle())
    }

    /// A reset that leaves the power on.
    fn reset(&mut self, cause: ResetCause) {
        if self.resets.len() < RESETS {
            self.resets.push(Reset {
                at: self.time(),
                cause,
                dominant: self.is_dominant(),
                heater: self.heater(),
            });
        }
        self.boots += 1;
        if cause != ResetCause::PowerOn {
            // The stack before a power-up was recorded at power-off; before the first power-up there was none.
            self.lowest_stack = self.lowest_stack();
        }
        self.core.reset();
        if cause != ResetCause::PowerOn {
            self.io.reset(self.core.cycle(), cause);
        }
        self.forget();
        self.note_clocks();
        self.note_leds();
    }

    /// Copies the parameter pages to the memory of the processor.
    fn load_parameters(&mut self) {
        if std::mem::take(&mut self.parameters_touched) {
            let bytes = self.io.flash.parameters().bytes();
            let start = self.io.board().facts().parameters.start;
            let loaded = self.core.load(start, bytes);
            assert!(
                loaded || !self.core.has_flash(start),
                "the parameter pages are in flash"
            );
            if let Some(slot) = self.io.flash.slot() {
                let start = self.io.board().facts().slot.start;
                let loaded = self.core.load(start, slot.bytes());
                assert!(loaded, "the slot is in flash");
            }
        }
    }

    /// Handles the changes in the peripherals after an access or an event.
    fn settle(&mut self) {
        let cycle = self.core.cycle();
        self.disturbed = false;
        self.io.settle(cycle);
        self.forget();
        if let Some(work) = self.io.flash.take_work() {
            let changed = match work {
                Work::Program {
                    address,
                    width,
                    value,
                    ..
                } => self
                    .core
                    .load(address, &value.to_le_bytes()[..width.bytes()]),
                Work::Erase { page, size, .. } => self.core.erase(page, size),
                Work::Failed { .. } => true,
            };
            assert!(changed, "the parameters are in flash");
            let cycles = self.io.rcc.timebase().cycles(work.duration());
            self.core.occupy_flash(cycles);
        }
        self.note_clocks();
        self.set_lines();
        self.note_leds();
        if self.io.watchdog_has_expired(self.core.cycle()) {
            self.reset(ResetCause::Watchdog);
        }
        if self.io.flash.power_is_cut() {
            self.switch_off();
        }
        if self.io.pwr.goes_down(self.time()) {
            // The pins are inputs until the supply returns.
            self.io.reset(self.core.cycle(), ResetCause::PowerOn);
            self.forget();
            self.note_leds();
        }
    }

    /// The wait states and clocks that the firmware has set up.
    fn note_clocks(&mut self) {
        let rcc = &self.io.rcc;
        let ratio = |clock: u32| (rcc.hclk() / clock) as u8;
        let buses = Buses {
            apb1: ratio(rcc.pclk1()),
            apb2: ratio(rcc.pclk2()),
        };
        self.core.set_memories(self.io.flash.timing(), buses);
    }

    fn set_lines(&mut self) {
        // The handler of NMI starts again until the failure is cleared (RM0008, section 7.2.7).
        if self.io.rcc.nmi() && self.core.active_exception() != NMI {
            self.core.raise_nmi();
        }
        for (interrupt, high) in (CAN_INTERRUPTS..).zip(self.io.can.lines()) {
            self.core.set_interrupt_line(interrupt, high);
        }
        let lines = [
            (TIM4_INTERRUPT, self.io.tim4_interrupt()),
            (
                self.io.board().facts().spi.interrupt(),
                self.io.spi_interrupt(),
            ),
        ];
        for (interrupt, high) in lines {
            self.core.set_interrupt_line(interrupt, high);
        }
    }

    fn note_leds(&mut self) {
        let leds = if self.on {
            self.noted().leds
        } else {
            Leds::default()
        };
        if leds == self.leds {
            return;
        }
        self.leds = leds;
        if self.led_history.len() == LED_HISTORY {
            self.led_history.pop_front();
        }
        let now = Instant::from_ticks(self.time().div_ceil(1_000_000));
        self.led_history.push_back((now, leds));
    }

    fn switch_off(&mut self) {
        self.lowest_stack = self.lowest_stack();
        self.on = false;
        // A frame on the wire is aborted.
        self.io.can.reset();
        self.note_leds();
    }

    /// A fault of the program: starts its handler, or ends the run.
    fn fault(&mut self, fault: &Fault) {
        if self.takes_faults && self.core.take_fault(fault) {
            let place = self.place(fault.pc);
            self.faults.push(format!("{place}: {}", fault.kind));
        } else {
            self.stop(fault.pc, &fault.kind);
        }
    }

    /// An address of the program with its function.
    fn place(&self, pc: u32) -> String {
        let function = self.image.name_of(pc);
        let function = function.map(|(function, offset)| format!(", {function}+{offset:#x}"));
        format!("{pc:#010x}{}", function.unwrap_or_default())
    }

    /// Ends the run at this address of the program.
    fn stop(&mut self, pc: u32, reason: impl Display) {
        let sentence = format!("{} stopped at {}: {reason}", self.name, self.place(pc));
        assert!(self.reports_stop, "{sentence}");
        self.stopped = Some(sentence);
        self.switch_off();
    }
}

/// The start of flash, with the vector table.
const FLASH_START: u32 = 0x0800_0000;
