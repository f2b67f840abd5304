//! Checks of the faults that emergency messages announce.

use crate::canopen::emcy::{Cause, FaultBit, bits_of, is_same};
use crate::mistake::Mistake;
use crate::walk::each;

const ERROR_RESET: &str = "the emergency error code 0000h is the error reset";

/// Checks the faults with a bit in the status byte, and the momentary ones.
#[track_caller]
pub(super) const fn check(faults: &[FaultBit; 8], events: &[FaultBit]) {
    each!(place, fault in faults => {
        let mistake = Mistake::row("fault", place).at(fault.origin);
        mistake.unless(matches!(fault.cause, Cause::Never) || fault.code != 0, ERROR_RESET);
        each!(other in faults.split_at(place).0 => {
            mistake.unless(!is_alike(other.cause, fault.cause), "another bit has this cause");
        });
    });
    each!(place, event in events => {
        let mistake = Mistake::row("event", place).at(event.origin);
        mistake.unless(
            matches!(event.cause, Cause::Overrun | Cause::BusOff),
            "its cause is `Overrun` or `BusOff`",
        );
        mistake.unless(event.code != 0, ERROR_RESET);
        mistake.unless(
            bits_of(faults, event.cause) == 0,
            "a bit of the status byte has this cause",
        );
        each!(other in events.split_at(place).0 => {
            mistake.unless(!is_same(other.cause, event.cause), "another event has this cause");
        });
    });
}

/// Whether both are the same cause.
const fn is_alike(one: Cause, other: Cause) -> bool {
    match (one, other) {
        (Cause::Application(one), Cause::Application(other)) => one.0 == other.0,
        _ => is_same(one, other),
    }
}
