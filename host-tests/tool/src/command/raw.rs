//! `raw`: one request of the user.

use super::bus::Bus;
use crate::connect;
use crate::error::Error;
use crate::link::Link;
use crate::ops;
use crate::output::Terminal;
use adapter::Mode;

/// Sends one request and prints the answer. With an address and a bit rate of the command line the sensor is not asked for anything else.
pub(super) fn raw(bus: &mut Bus, request: &str, terminal: &mut Terminal) -> Result<(), Error> {
    let wanted = bus.wanted(terminal)?;
    let adapter = bus.adapter()?;
    let (mut link, target) = match (wanted.target, wanted.rate) {
        (Some(target), Some(rate)) if !wanted.is_remembered => {
            let mut link = Link::new(adapter, &terminal.stopped);
            link.open(Some(rate), Mode::Active)?;
            (link, target)
        }
        _ => {
            let (link, found) = connect::find(adapter, &wanted, terminal)?;
            (link, found.target)
        }
    };
    bus.is_found = true;
    let report = ops::raw::send(&mut link, target, request)?;
    link.close();
    terminal.report(&report)
}
