//! Virtual sensors whose time is faster than that of the computer.
//!
//! The time of the bus passes only while the tool waits for it, so the load of the computer changes no result. It is slowed down only to
//! leave the processor to others while the tool polls a sensor without an end.

use super::hooked::{Hook, Hooked, Received, paced};
use adapter::Adapter;
use plumbline::time::Instant;
use plumbline_tool::error::Error;
use plumbline_tool::{demo, port};

/// The adapter of a port; one with a virtual sensor does not wait for the clock of the computer.
pub fn connect(port: &str) -> Result<Box<dyn Adapter>, Error> {
    match port.strip_prefix("demo:") {
        Some(product) => Ok(Hooked::new(demo::unpaced(product)?, Fast)),
        None => port::connect(port),
    }
}

struct Fast;

impl Hook for Fast {
    fn receive(&mut self, adapter: &mut dyn Adapter, until: Instant) -> Received {
        paced(adapter, until)
    }
}
