//! `demo:PRODUCT`: a virtual sensor inside of the program, at factory settings, in real time. It sways slowly.

use super::bench::BenchAdapter;
use super::{Adapter, Capabilities, Mode};
use crate::failure::Failure;
use crate::identify;
use bench::motion::Motion;
use bench::{Bus, BusRate, Device, Flash, Geometry, NodeType};
use plumbline::can::{BitRate, Frame};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::model::catalog::Protocol;
use plumbline::time::{Duration, Instant, after, millis};
use std::cell::RefCell;
use std::f64::consts::TAU;
use std::rc::Rc;
use std::time;

/// The serial number of the sensor.
const SERIAL: u32 = 1;

/// The time in which a sensor has started.
const BOOT: Duration = millis(200);

/// The time of the duplicate MAC ID check of DeviceNet, which another node must acknowledge.
const CHECK: Duration = millis(2500);

/// The period of the sway, in s.
const PERIOD: f64 = 20.0;

/// A slow sway of both axes about the level position.
struct Sway;

impl Motion for Sway {
    fn reading(&mut self, now: Instant) -> Reading {
        let phase = TAU * now.ticks() as f64 / 1e6 / PERIOD;
        let (x, y) = (
            (15.0 * phase.sin()).to_radians(),
            (8.0 * (2.0 * phase).sin()).to_radians(),
        );
        let (gx, gy) = (x.sin(), y.sin());
        let up = [-gx, gy, (1.0 - gx * gx - gy * gy).max(0.0).sqrt()];
        let [x, y, z] = up.map(|part| (part * f64::from(ONE_G)) as i32);
        Reading {
            acceleration: I32x3 { x, y, z },
            temperature: 25_00,
            ..Reading::default()
        }
    }
}

/// The bus of the demonstration with one sensor of this product.
///
/// # Errors
/// There is no such product.
pub fn bus(product: &str) -> Result<Bus, Failure> {
    let product = identify::product(product)?;
    let node_type = NodeType::from(product);
    let mut bus = Bus::new(BusRate::Follow);
    let flash = Flash::blank(Geometry::STM32F103);
    bus.attach(Device::new(&node_type, SERIAL, flash, Box::new(Sway)));
    let mut booted = after(bus.now(), BOOT);
    let other = bus.adapter();
    if let Protocol::Devicenet(_) = product.protocol {
        bus.open(other, None, false);
        booted = after(booted, CHECK);
    }
    bus.run_until(booted);
    bus.remove(other);
    Ok(bus)
}

/// The adapter of the demonstration.
///
/// # Errors
/// There is no such product.
pub fn adapter(product: &str) -> Result<Paced, Failure> {
    let bus = bus(product)?;
    let offset = bus.now();
    let bus = Rc::new(RefCell::new(bus));
    Ok(Paced {
        start: time::Instant::now(),
        offset,
        adapter: BenchAdapter::new(&bus),
    })
}

/// An adapter whose virtual time follows the real time.
pub struct Paced {
    adapter: BenchAdapter,
    start: time::Instant,
    /// The virtual time at the start.
    offset: Instant,
}

impl Adapter for Paced {
    fn capabilities(&self) -> Capabilities {
        // The bus has the rate of its sensor.
        Capabilities {
            needs_rate: false,
            ..self.adapter.capabilities()
        }
    }

    fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), Failure> {
        self.adapter.open(rate, mode)
    }

    fn close(&mut self) {
        self.adapter.close();
    }

    fn send(&mut self, frame: &Frame) -> Result<(), Failure> {
        self.adapter.send(frame)
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, Failure> {
        let received = self.adapter.receive(until)?;
        let virtual_time = self.adapter.now().ticks() - self.offset.ticks();
        let ahead = time::Duration::from_micros(virtual_time).checked_sub(self.start.elapsed());
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
}
