//! A bus with one sensor and two masters, in virtual time.

use crate::random::Random;
use crate::{Failure, program};
use adapter::Mode;
use adapter::bench::{BenchAdapter, SharedBus};
use bench::motion::Motion;
use bench::scene::Axes;
use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, Geometry, NodeType, Updatable};
use plumbline::can::Frame;
use plumbline::model::catalog::{self, PRODUCTS, Product};
use plumbline::time::{Duration, Instant, after, millis};
use plumbline::update::header::{COMMIT, PLACE, SIZE};
use plumbline_tool::error::Error;
use plumbline_tool::image::ImageFile;
use plumbline_tool::link::Link;
use plumbline_tool::master::{Protocol, Target, factory_target};
use plumbline_tool::ops::update;
use plumbline_tool::output::Terminal;
use plumbline_tool::session::Session;
use std::any::Any;
use std::cell::RefCell;
use std::rc::Rc;

/// The serial number of the sensor.
const SERIAL: u32 = 1;

/// In this time a sensor that was switched on answers. The duplicate MAC ID check of DeviceNet takes two seconds of it.
const START: Duration = millis(4000);

/// The number of frames that are shown after a failure.
const LAST: usize = 24;

/// The name of a product in its second protocol ends with this.
const J1939: &str = "/j1939";

/// The names of all kinds of sensors: the products, and those that can be switched to J1939 also with that.
pub fn kinds() -> Vec<String> {
    let names = PRODUCTS.iter().map(|product| product.name.to_owned());
    let switched = PRODUCTS.iter().filter(|product| second(product).is_some());
    names
        .chain(switched.map(|product| format!("{}{J1939}", product.name)))
        .collect()
}

/// J1939 of a product that has another protocol as delivered.
fn second(product: &Product) -> Option<&'static Protocol> {
    let own = Protocol::named("j1939").filter(|protocol| protocol.is_of(product));
    own.filter(|protocol| *protocol != Protocol::of(product))
}

/// A sensor on its bus.
pub struct Stand {
    /// The bus.
    pub bus: SharedBus,
    /// The sensor.
    pub device: DeviceId,
    /// What it is mounted for.
    pub axes: Axes,
    /// The masters, each with a session of its own.
    pub masters: [Session; 2],
    /// The number of the master whose turn it is.
    pub turn: usize,
    /// Sends frames of other nodes.
    stranger: AdapterId,
    /// The sensor was switched to its second protocol.
    is_switched: bool,
    /// Its program.
    pub program: ImageFile,
}

impl Stand {
    /// A new sensor of this kind with a random program, which answers.
    ///
    /// # Errors
    /// It does not answer, or cannot be switched to its second protocol.
    pub fn new(kind: &str, random: &mut Random) -> Result<Self, Failure> {
        let name = kind.strip_suffix(J1939).unwrap_or(kind);
        let product = catalog::find(name).ok_or_else(|| Failure::Kind(kind.to_owned()))?;
        let target = factory_target(product).ok_or_else(|| Failure::Kind(kind.to_owned()))?;
        let node_type = NodeType::from(product);
        let axes = Axes::of(&node_type);
        let mut bus = Bus::new(BusRate::Follow);
        let flash = Flash::blank(Geometry::STM32F103);
        let device = Device::new(&node_type, SERIAL, flash, Box::new(bench::script::LEVEL));
        let program = program::any(random, product);
        let device = bus.attach(Updatable::new(device, &program.bytes));
        let stranger = bus.adapter();
        bus.open(stranger, None, false);
        let bus = Rc::new(RefCell::new(bus));
        let masters = [
            master(&bus, target, product)?,
            master(&bus, target, product)?,
        ];
        let mut stand = Self {
            bus,
            device,
            axes,
            masters,
            turn: 0,
            stranger,
            is_switched: kind != name,
            program,
        };
        stand.return_to_protocol()?;
        Ok(stand)
    }

    /// A sensor with the factory settings answers, and is switched to its second protocol if this is about that.
    ///
    /// # Errors
    /// It does not answer.
    pub fn return_to_protocol(&mut self) -> Result<(), Failure> {
        let product = self.master().sheet.product;
        let target =
            factory_target(product).ok_or_else(|| Failure::Kind(product.name.to_owned()))?;
        for master in &mut self.masters {
            master.moved(target);
        }
        self.wait_for_start()?;
        match self.is_switched {
            true => self.switch(product),
            false => Ok(()),
        }
    }

    /// Switches the sensor to its second protocol.
    fn switch(&mut self, product: &'static Product) -> Result<(), Failure> {
        let wrong = || Failure::Kind(format!("{}{J1939}", product.name));
        let protocol = second(product).ok_or_else(wrong)?;
        let roles = (protocol.roles)(product).ok_or_else(wrong)?;
        let selector = plumbline_tool::master::j1939::tables(product)
            .and_then(|tables| tables.selector)
            .ok_or_else(wrong)?;
        let session = self.master();
        let entry = session.entry(selector.0)?;
        let mut numbers = entry.meanings.iter().map(|(number, _)| *number);
        let other = numbers
            .find(|number| *number != selector.1)
            .ok_or_else(wrong)?;
        let address = session.read(&session.entry(roles.address)?)?;
        session.write(&[(entry, other)])?;
        session.save()?;
        session.restart()?;
        let target = (roles.target)(address)?;
        for master in &mut self.masters {
            master.moved(target);
        }
        self.wait_for_start()
    }

    /// The session of the master whose turn it is.
    pub fn master(&mut self) -> &mut Session {
        &mut self.masters[self.turn]
    }

    /// The other master goes on. A connection of DeviceNet belongs to one master.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn change_master(&mut self) -> Result<(), Error> {
        self.master().release()?;
        self.turn = 1 - self.turn;
        Ok(())
    }

    /// The present time.
    pub fn now(&self) -> Instant {
        self.bus.borrow().now()
    }

    /// Lets the time pass. The masters forget the frames that they receive.
    ///
    /// # Errors
    /// An adapter fails.
    pub fn wait(&mut self, time: Duration) -> Result<(), Error> {
        for master in 0..self.masters.len() {
            let until = after(
                self.now(),
                if master == self.turn {
                    time
                } else {
                    Duration::from_ticks(0)
                },
            );
            let link = &mut self.masters[master].link;
            while link.receive(until)?.is_some() {}
        }
        let mut bus = self.bus.borrow_mut();
        bus.take_log();
        bus.take_received(self.stranger);
        Ok(())
    }

    /// Switches the sensor off and on, and waits until it answers.
    ///
    /// # Errors
    /// It does not answer.
    pub fn power_cycle(&mut self) -> Result<(), Failure> {
        self.bus.borrow_mut().power_cycle(self.device);
        self.wait_for_start()
    }

    /// Waits until the sensor answers after a start.
    ///
    /// # Errors
    /// It does not answer within four seconds.
    pub fn wait_for_start(&mut self) -> Result<(), Failure> {
        for master in &mut self.masters {
            let target = master.target;
            master.moved(target);
        }
        let end = after(self.now(), START);
        loop {
            let session = self.master();
            let found = session.target.identify(&mut session.link, millis(100))?;
            if let Some(found) = found {
                session.release()?;
                // With the identifier of its replies, if the protocol has none that is fixed.
                for master in &mut self.masters {
                    master.moved(found.target);
                }
                return Ok(());
            }
            if self.now() > end {
                return Err(Failure::Silent);
            }
        }
    }

    /// The sensor has another motion from now on.
    pub fn set_motion(&mut self, motion: Box<dyn Motion>) {
        self.bus
            .borrow_mut()
            .device_mut(self.device)
            .set_motion(motion);
    }

    /// Changes the memory of the sensor.
    pub fn flash<T>(&mut self, change: impl FnOnce(&mut Flash) -> T) -> T {
        change(self.bus.borrow_mut().device_mut(self.device).flash())
    }

    /// The sensor with its bootloader.
    fn updatable<T>(&mut self, run: impl FnOnce(&mut Updatable) -> T) -> T {
        let mut bus = self.bus.borrow_mut();
        let sensor: &mut dyn Any = bus.device_mut(self.device);
        run(sensor.downcast_mut().expect("the sensor of the stand"))
    }

    /// Changes the memory of the program.
    pub fn program_flash<T>(&mut self, change: impl FnOnce(&mut Flash) -> T) -> T {
        self.updatable(|sensor| change(sensor.program_flash()))
    }

    /// Whether each byte of a program is in its memory.
    pub fn has_program(&mut self, image: &ImageFile) -> bool {
        let (header, body) = image.bytes.split_at(SIZE);
        self.program_flash(|flash| {
            let is_there = |from: usize, bytes: &[u8]| flash.bytes()[from..].starts_with(bytes);
            is_there(0, &body[..PLACE])
                && is_there(PLACE, &header[..COMMIT - PLACE])
                && is_there(PLACE + SIZE, &body[PLACE + SIZE..])
        })
    }

    /// Whether the sensor waits in its bootloader.
    pub fn is_in_bootloader(&mut self) -> bool {
        self.updatable(|sensor| sensor.is_in_bootloader())
    }

    /// Replaces the program of the sensor, which can wait in its bootloader.
    ///
    /// # Errors
    /// The sensor refuses, or does not answer.
    pub fn load(&mut self, image: &ImageFile) -> Result<(), Error> {
        let is_running = !self.is_in_bootloader();
        let session = self.master();
        if is_running {
            update::check(session, image)?;
            update::enter(session)?;
        }
        let (mut out, mut notes) = (Vec::new(), Vec::new());
        let mut terminal = Terminal {
            json: false,
            out: &mut out,
            notes: &mut notes,
            confirm: &mut |_| false,
            yes: &[],
            stopped: Rc::new(|| false),
            bar: None,
        };
        let target = session.target;
        update::load(session, target, image, true, &mut terminal).map(|_| ())
    }

    /// The last frames on the bus, each with its time in seconds.
    pub fn last_frames(&self) -> Vec<String> {
        let log = self.bus.borrow_mut().take_log();
        let last = log.iter().skip(log.len().saturating_sub(LAST));
        last.map(|logged| {
            let seconds = logged.at.ticks() as f64 / 1e6;
            format!("({seconds:.6}) {:?}", logged.frame)
        })
        .collect()
    }

    /// Another node sends a frame as soon as the bus is free.
    pub fn send_as_stranger(&mut self, frame: Frame) {
        self.bus.borrow_mut().send(self.stranger, frame);
    }
}

/// A master with an open adapter.
fn master(bus: &SharedBus, target: Target, product: &'static Product) -> Result<Session, Error> {
    let never: Rc<dyn Fn() -> bool> = Rc::new(|| false);
    let mut link = Link::new(Box::new(BenchAdapter::new(bus)), &never);
    link.open(None, Mode::Active)?;
    Ok(Session::new(link, target, product))
}
