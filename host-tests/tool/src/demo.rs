//! `demo:PRODUCT`: a virtual sensor inside of the program, at factory settings, in real time. Its angles change slowly.
//! `demo:PRODUCT/j1939` is one that has been switched to J1939. A user can move and break it by [`StandIn`].

mod stand_in;

pub use stand_in::StandIn;

use crate::error::{Error, RequestError};
use crate::identify;
use crate::link::Link;
use crate::master::{Protocol, factory_target, j1939};
use crate::session::Session;
use adapter::bench::BenchAdapter;
use adapter::{Adapter, AdapterError, Capabilities, Mode};
use bench::scene::{Axes, Scene};
use bench::stage::Stage;
use bench::{Bus, BusRate, Device, Flash, Geometry, NodeType};
use plumbline::can::{BitRate, Frame};
use plumbline::model::catalog::Product;
use plumbline::model::listing::j1939::J1939Tables;
use plumbline::time::{Duration, Instant, after, millis};
use std::any::Any;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::time;
use virtual_sensor::server::Unit;

/// The serial number of the sensor.
const SERIAL: u32 = 1;

/// The time in which a sensor has started.
const BOOT: Duration = millis(200);

/// The time in which a sensor in J1939 has restarted and has an address.
const CLAIM: Duration = millis(700);

/// The end of the name of a product that has been switched to J1939.
pub const J1939: &str = "/j1939";

/// The bus of the demonstration with one sensor of this product.
///
/// # Errors
/// There is no such product, or it does not have J1939.
fn bus(name: &str) -> Result<(Bus, Unit), Error> {
    let (name, is_j1939) = match name.strip_suffix(J1939) {
        Some(name) => (name, true),
        None => (name, false),
    };
    let product = identify::product(name)?;
    let tables = j1939::tables(product);
    if is_j1939 && tables.is_none() {
        return Err(RequestError::NoJ1939(name.to_owned()).into());
    }
    let node_type = NodeType::from(product);
    let mut bus = Bus::new(BusRate::Follow);
    let flash = Flash::blank(Geometry::STM32F103);
    let stage = Stage::new(Scene::sway(Axes::of(&node_type)), &[]);
    let device = Device::new(&node_type, SERIAL, flash, Box::new(stage.clone()));
    let device = bus.attach(device);
    let unit = Unit::new(name.to_owned(), device, node_type, SERIAL, stage);
    let mut booted = after(bus.now(), BOOT);
    let other = bus.adapter();
    if let Some(check) = Protocol::of(product).check {
        bus.open(other, None, false);
        booted = after(booted, check);
    }
    bus.run_until(booted);
    bus.remove(other);
    let bus = match tables.filter(|_| is_j1939) {
        Some(tables) => switched(bus, product, tables)?,
        None => bus,
    };
    Ok((bus, unit))
}

/// The bus after its sensor was switched to J1939.
fn switched(bus: Bus, product: &'static Product, tables: &J1939Tables) -> Result<Bus, Error> {
    let failed = || Error::from(RequestError::Demonstration);
    let target = factory_target(product).ok_or_else(failed)?;
    let bus = Rc::new(RefCell::new(bus));
    let never: Rc<dyn Fn() -> bool> = Rc::new(|| false);
    let mut link = Link::new(Box::new(BenchAdapter::new(&bus)), &never);
    link.open(None, Mode::Active)?;
    let mut session = Session::new(link, target, product);
    if let Some((selector, canopen)) = tables.selector {
        let entry = session.entry(selector)?;
        let mut numbers = entry.meanings.iter().map(|(number, _)| *number);
        let other = numbers.find(|number| *number != canopen);
        session.write(&[(entry, other.unwrap_or(canopen))])?;
    }
    session.save()?;
    session.restart()?;
    session.link.wait_for(CLAIM, |_| None::<()>)?;
    session.link.close();
    drop(session);
    let bus = Rc::into_inner(bus).map(RefCell::into_inner);
    bus.ok_or_else(failed)
}

/// The adapter of the demonstration.
///
/// # Errors
/// There is no such product.
pub fn adapter(product: &str) -> Result<Paced, Error> {
    let (bus, unit) = bus(product)?;
    let offset = bus.now();
    let bus = Rc::new(RefCell::new(bus));
    Ok(Paced {
        start: Some(time::Instant::now()),
        offset,
        adapter: BenchAdapter::new(&bus),
        stand_in: StandIn::new(bus, unit),
        late: VecDeque::new(),
    })
}

/// The same in virtual time, without waiting; for tests.
///
/// # Errors
/// There is no such product.
pub fn unpaced(product: &str) -> Result<Paced, Error> {
    let paced = adapter(product)?;
    Ok(Paced {
        start: None,
        ..paced
    })
}

/// An adapter whose virtual time follows the real time.
pub struct Paced {
    adapter: BenchAdapter,
    /// The real time at the start; None: it does not wait.
    start: Option<time::Instant>,
    /// The virtual time at the start.
    offset: Instant,
    stand_in: StandIn,
    /// The late frames that have arrived.
    late: VecDeque<(Instant, Frame)>,
}

impl Paced {
    /// Drops the late frames, as an adapter drops all frames that wait.
    fn drop_late(&mut self) {
        self.late.clear();
        self.stand_in.from_sensor.clear();
    }

    /// The next frame that the faults of the stand-in do not hold back.
    fn passed(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError> {
        loop {
            self.late.extend(self.stand_in.arrived());
            if let Some(late) = self.late.pop_front() {
                return Ok(Some(late));
            }
            let next = self.stand_in.from_sensor.next();
            let stop = next.map_or(until, |next| next.min(until));
            match self.adapter.receive(stop)? {
                Some((at, frame)) => {
                    if let Some(frame) = self.stand_in.from_sensor.pass(at, frame) {
                        return Ok(Some((at, frame)));
                    }
                }
                None if stop == until => return Ok(None),
                None => {}
            }
        }
    }
}

impl Adapter for Paced {
    fn capabilities(&self) -> Capabilities {
        // The bus has the rate of its sensor.
        Capabilities {
            needs_rate: false,
            ..self.adapter.capabilities()
        }
    }

    fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), AdapterError> {
        self.drop_late();
        self.adapter.open(rate, mode)
    }

    fn close(&mut self) {
        self.drop_late();
        self.adapter.close();
    }

    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError> {
        self.adapter.send(frame)
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError> {
        self.adapter.forget_log();
        let received = self.passed(until)?;
        let virtual_time = self.adapter.now().ticks() - self.offset.ticks();
        let virtual_time = time::Duration::from_micros(virtual_time);
        let ahead = self
            .start
            .and_then(|start| virtual_time.checked_sub(start.elapsed()));
        if let Some(ahead) = ahead {
            std::thread::sleep(ahead);
        }
        Ok(received)
    }

    fn now(&self) -> Instant {
        self.adapter.now()
    }

    fn errors(&mut self) -> Option<u64> {
        self.adapter.errors()
    }

    fn stand_in(&mut self) -> Option<&mut dyn Any> {
        Some(&mut self.stand_in)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::can::CanId;
    use virtual_sensor::server::{Request, Side};

    #[test]
    fn late_frame_does_not_survive_a_new_connection() {
        let mut adapter = unpaced("is2").expect("a sensor");
        let request = Frame::of(CanId::standard(0x300), [0x04, 0, 0, 0, 0, 0, 0, 0], 1);
        let mut answers = |closes: bool| {
            adapter.open(None, Mode::Active).expect("it opens");
            // The first one is answered after the boot-up messages.
            adapter.send(&request).expect("it is sent");
            let booted = after(adapter.now(), millis(1000));
            while adapter.receive(booted).expect("an adapter").is_some() {}
            let late = Request::Delay {
                count: 1,
                from: Side::Sensors,
                identifier: Some("301".to_owned()),
                seconds: 0.2,
            };
            adapter.stand_in.perform(late).expect("a fault");
            adapter.send(&request).expect("it is sent");
            let early = after(adapter.now(), millis(100));
            assert_eq!(adapter.receive(early), Ok(None));
            if closes {
                adapter.close();
                adapter.open(None, Mode::Active).expect("it opens");
            }
            let until = after(adapter.now(), millis(500));
            adapter.receive(until).expect("an adapter").is_some()
        };
        assert_eq!([answers(false), answers(true)], [true, false]);
    }
}
