//! Virtual sensors whose time is faster than that of the computer.
//!
//! The time of the bus passes only while the tool waits for it, so the load of the computer changes no result. It is slowed down only to
//! leave the processor to others while the tool polls a sensor without an end.

use adapter::{Adapter, AdapterError, Capabilities, Mode};
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;
use plumbline_tool::error::Error;
use plumbline_tool::{demo, port};
use std::any::Any;
use std::thread;
use std::time::Duration;

/// How much faster the time of the bus passes than that of the computer.
const SPEEDUP: u64 = 20;

/// The adapter of a port; one with a virtual sensor does not wait for the clock of the computer.
pub fn connect(port: &str) -> Result<Box<dyn Adapter>, Error> {
    match port.strip_prefix("demo:") {
        Some(product) => Ok(Box::new(Fast(demo::unpaced(product)?))),
        None => port::connect(port),
    }
}

struct Fast(demo::Paced);

impl Adapter for Fast {
    fn capabilities(&self) -> Capabilities {
        self.0.capabilities()
    }

    fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), AdapterError> {
        self.0.open(rate, mode)
    }

    fn close(&mut self) {
        self.0.close();
    }

    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError> {
        self.0.send(frame)
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError> {
        let start = self.now();
        let received = self.0.receive(until)?;
        let passed = self.now().ticks() - start.ticks();
        thread::sleep(Duration::from_micros(passed / SPEEDUP));
        Ok(received)
    }

    fn now(&self) -> Instant {
        self.0.now()
    }

    fn errors(&mut self) -> Option<u64> {
        self.0.errors()
    }

    fn stand_in(&mut self) -> Option<&mut dyn Any> {
        self.0.stand_in()
    }
}
