//! A device behind the bootloader of the core: its program can be replaced over CAN, with power cuts.
//!
//! A program is its CRC here: all programs of a device run the same node.

mod loading;
mod pages;

use crate::bus::{instant, picoseconds};
use crate::device::Device;
use crate::flash::Flash;
use crate::motion::Motion;
use crate::sensor::Sensor;
use can_wire::protocol::{Event, Period, Picoseconds, Protocol};
use loading::Loading;
use pages::Pages;
use plumbline::can::{BitRate, Frame};
use plumbline::node::{BusMode, Leds, Readout};
use plumbline::time::Instant;
use plumbline::update::{Element, Program, Record, header};
use std::collections::VecDeque;

/// What runs.
enum Runs {
    /// The program, or nothing while the power is off.
    Program(Box<Pages>),
    /// The bootloader.
    Bootloader(Box<Loading>),
}

/// A device with a bootloader.
pub struct Updatable {
    device: Device,
    runs: Runs,
    /// The starts of the bootloader that were not starts of the program.
    waits: u32,
}

impl Updatable {
    /// A device with the program of this image file; it is not switched on.
    ///
    /// # Panics
    /// The file is not an image file for the board of the bench.
    pub fn new(device: Device, file: &[u8]) -> Self {
        let mut pages = Pages::blank();
        pages.load(file);
        Self {
            device,
            runs: Runs::Program(Box::new(pages)),
            waits: 0,
        }
    }

    /// The flash of the program, to cause faults.
    pub fn program_flash(&mut self) -> &mut Flash {
        match &mut self.runs {
            Runs::Program(pages) => &mut pages.0,
            Runs::Bootloader(loading) => loading.flash(),
        }
    }

    /// Whether the bootloader waits for a client.
    pub fn is_in_bootloader(&self) -> bool {
        matches!(self.runs, Runs::Bootloader(_))
    }

    /// The flash of the program, while no bootloader runs.
    fn take_pages(&mut self) -> Pages {
        let none = Runs::Program(Box::new(Pages::blank()));
        match std::mem::replace(&mut self.runs, none) {
            Runs::Program(pages) => *pages,
            Runs::Bootloader(loading) => loading.into_pages(),
        }
    }

    /// Starts as the bootloader of a board: the program, or the bootloader if the program has asked for it or is not complete.
    fn start(&mut self, now: Instant, asked: Option<Record>) {
        let mut pages = self.take_pages();
        let program = Program::of(&pages).committed(&mut pages);
        if let (None, Some(header)) = (asked, program.header()) {
            self.device.set_program(header.installed());
            self.runs = Runs::Program(Box::new(pages));
            self.device.power_on(now);
            return;
        }
        if let Some(record) = &asked {
            // If the flash fails, the record of this start is sufficient.
            let _ = pages.keep(record);
        }
        let record = asked.or_else(|| pages.newest_record());
        self.runs = match record.filter(|_| !pages.0.is_cut()) {
            Some(record) => Runs::Bootloader(Box::new(Loading::start(now, pages, program, record))),
            None => Runs::Program(Box::new(pages)),
        };
        self.waits += 1;
    }

    /// Goes on after the device or the bootloader has acted: a restart into the other one, or a power cut.
    fn follow(&mut self, now: Instant) {
        if let Some(contact) = self.device.take_contact() {
            let record = Record::new(
                self.device.image(),
                Element::Ism330dhcx,
                &contact,
                header::crc,
            );
            self.start(now, Some(record));
        }
        if self.program_flash().is_cut() {
            self.power_off(now);
        } else if let Runs::Bootloader(loading) = &mut self.runs
            && loading.takes_restart()
        {
            self.start(now, None);
        }
    }

    fn loading(&self) -> Option<&Loading> {
        match &self.runs {
            Runs::Bootloader(loading) => Some(loading),
            Runs::Program(_) => None,
        }
    }
}

impl Sensor for Updatable {
    fn power_on(&mut self, now: Instant) {
        self.program_flash().power_on();
        self.start(now, None);
    }

    fn power_off(&mut self, now: Instant) {
        self.device.power_off(now);
        let pages = self.take_pages();
        self.runs = Runs::Program(Box::new(pages));
    }

    fn is_on(&self) -> bool {
        self.device.is_on() || self.is_in_bootloader()
    }

    fn boots(&self) -> u32 {
        self.device.boots() + self.waits
    }

    fn next_event(&self) -> Option<Picoseconds> {
        match self.loading() {
            Some(loading) => Some(picoseconds(loading.next_event())),
            None => self.device.next_event(),
        }
    }

    fn advance(&mut self, at: Picoseconds) -> Picoseconds {
        match &mut self.runs {
            Runs::Bootloader(loading) => loading.advance(instant(at)),
            Runs::Program(_) => {
                self.device.advance(at);
            }
        }
        self.follow(instant(at));
        at
    }

    fn protocol(&self) -> Option<&Protocol> {
        match self.loading() {
            Some(loading) => Some(loading.controller.protocol()),
            None => self.device.protocol(),
        }
    }

    fn next_step(&self) -> Option<Picoseconds> {
        match self.loading() {
            Some(loading) => {
                let offers = loading.controller.offered().is_some();
                let protocol = loading.controller.protocol();
                protocol.next_event(offers && protocol.takes_offer())
            }
            None => self.device.next_step(),
        }
    }

    fn offered(&self) -> Option<Frame> {
        match self.loading() {
            Some(loading) => loading.controller.offered(),
            None => self.device.offered(),
        }
    }

    fn wire(&mut self, now: Picoseconds, dominant: bool) {
        match &mut self.runs {
            Runs::Bootloader(loading) if dominant => loading.controller.edge(now),
            Runs::Bootloader(_) => {}
            Runs::Program(_) => self.device.wire(now, dominant),
        }
    }

    fn step(&mut self, now: Picoseconds, dominant: bool) -> Option<Event> {
        let event = match &mut self.runs {
            Runs::Bootloader(loading) => loading.step(now, dominant),
            Runs::Program(_) => self.device.step(now, dominant),
        };
        self.follow(instant(now));
        event
    }

    fn skip(&mut self, period: Period, count: u64) {
        match &mut self.runs {
            Runs::Bootloader(loading) => loading.controller.skip(period, count),
            Runs::Program(_) => self.device.skip(period, count),
        }
    }

    fn name(&self) -> &'static str {
        self.device.name()
    }

    fn mode(&self) -> Option<BusMode> {
        match self.loading() {
            Some(loading) => loading.controller.mode(),
            None => self.device.mode(),
        }
    }

    fn rate(&self) -> Option<BitRate> {
        match self.loading() {
            Some(loading) => loading.controller.rate(),
            None => self.device.rate(),
        }
    }

    fn leds(&self) -> Leds {
        match self.loading() {
            Some(loading) => loading.leds(),
            None => self.device.leds(),
        }
    }

    fn led_history(&self) -> &VecDeque<(Instant, Leds)> {
        self.device.led_history()
    }

    fn readout(&self) -> Option<Readout> {
        self.device.readout()
    }

    fn set_motion(&mut self, motion: Box<dyn Motion>) {
        self.device.set_motion(motion);
    }

    fn memory(&mut self) -> &Flash {
        self.device.memory()
    }

    fn flash(&mut self) -> &mut Flash {
        self.device.flash()
    }
}
