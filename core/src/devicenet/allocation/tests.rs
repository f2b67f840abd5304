//! Tests of the allocation, the release and the time-outs of connections.

use super::choice::CHANGE;
use super::*;
use crate::time::millis;

const MASTER: u8 = 0x0A;
const OTHER: u8 = 0x0B;

fn at(ms: u32) -> Instant {
    Instant::from_ticks(0) + millis(ms)
}

/// A set with these choices of the master, allocated at the time 0.
fn allocated(choice: u8) -> ConnectionSet {
    let mut set = ConnectionSet::EMPTY;
    assert_eq!(set.allocate(at(0), choice, MASTER), Ok(()));
    set
}

/// The states of the explicit, the poll and the producing connection.
fn states(set: &mut ConnectionSet) -> [u8; 3] {
    let states = [
        set.explicit().state(),
        set.poll().state(),
        set.producing().state(),
    ];
    states.map(|state| state as u8)
}

fn code(result: Result<(), Failure>) -> [u8; 2] {
    let failure = result.unwrap_err();
    [failure.general, failure.additional]
}

#[test]
fn allocation_is_refused_by_first_check_that_fails() {
    for (held, choice, master, expected) in [
        (EXPLICIT, 0x00, OTHER, [0x0C, 1]),
        (EXPLICIT, 0xFF, OTHER, [0x0C, 1]),
        (EXPLICIT, EXPLICIT, OTHER, [0x0C, 1]),
        (EXPLICIT, 0x00, MASTER, [0x09, 2]),
        (0, 0x00, MASTER, [0x09, 2]),
        (0, SUPPRESS, MASTER, [0x09, 2]),
        (0, SUPPRESS | EXPLICIT | POLL, MASTER, [0x09, 2]),
        (0, SUPPRESS | EXPLICIT | 0x04, MASTER, [0x09, 2]),
        (0, 0x04, MASTER, [0x02, 2]),
        (0, EXPLICIT | 0x08, MASTER, [0x02, 2]),
        (0, EXPLICIT | 0x80, MASTER, [0x02, 2]),
        (0, 0x84 | CHANGE | CYCLIC, MASTER, [0x02, 2]),
        (0, EXPLICIT | CHANGE | CYCLIC, MASTER, [0x09, 2]),
        (0, POLL, MASTER, [0x09, 2]),
        (0, CHANGE, MASTER, [0x09, 2]),
        (0, EXPLICIT, 0x4A, [0x09, 2]),
        (EXPLICIT, EXPLICIT, MASTER, [0x0B, 2]),
        (EXPLICIT | POLL, EXPLICIT | POLL, MASTER, [0x0B, 2]),
        (EXPLICIT | POLL, POLL | CYCLIC, MASTER, [0x0B, 2]),
        (EXPLICIT | CHANGE, CYCLIC, MASTER, [0x0B, 2]),
    ] {
        let mut set = ConnectionSet::EMPTY;
        if held != 0 {
            set = allocated(held);
        }
        let before = (set.information(), states(&mut set));
        let refused = set.allocate(at(1), choice, master);
        assert_eq!(code(refused), expected, "{held:02X} {choice:02X}");
        assert_eq!((set.information(), states(&mut set)), before);
    }
}

#[test]
fn release_is_refused_by_first_check_that_fails() {
    for (held, choice, master, expected) in [
        (EXPLICIT, EXPLICIT, OTHER, [0x0C, 1]),
        (EXPLICIT, 0, OTHER, [0x0C, 1]),
        (EXPLICIT, 0, MASTER, [0x09, 2]),
        (EXPLICIT, SUPPRESS, MASTER, [0x09, 2]),
        (EXPLICIT, 0x04, MASTER, [0x02, 2]),
        (EXPLICIT, EXPLICIT | 0x08, MASTER, [0x02, 2]),
        (EXPLICIT, POLL | 0x80, MASTER, [0x02, 2]),
        (EXPLICIT, POLL, MASTER, [0x0B, 2]),
        (EXPLICIT, EXPLICIT | POLL, MASTER, [0x0B, 2]),
        (EXPLICIT | CHANGE, CYCLIC, MASTER, [0x0B, 2]),
        (0, EXPLICIT, MASTER, [0x0B, 2]),
        (0, EXPLICIT, OTHER, [0x0B, 2]),
    ] {
        let mut set = ConnectionSet::EMPTY;
        if held != 0 {
            set = allocated(held);
        }
        let before = (set.information(), states(&mut set));
        let refused = set.release(master, choice);
        assert_eq!(code(refused), expected, "{held:02X} {choice:02X}");
        assert_eq!((set.information(), states(&mut set)), before);
    }
}

#[test]
fn io_without_established_connection_is_released_with_explicit() {
    let mut set = allocated(EXPLICIT | POLL);
    assert_eq!(set.information(), [0x03, MASTER]);
    assert_eq!(states(&mut set), [3, 1, 0]);
    assert_eq!(set.release(MASTER, EXPLICIT), Ok(()));
    assert_eq!(set.information(), [0, 0xFF]);
    assert_eq!(states(&mut set), [0, 0, 0]);
}

#[test]
fn established_io_survives_release_of_explicit() {
    let mut set = allocated(EXPLICIT | POLL | CHANGE | SUPPRESS);
    assert_eq!(set.information(), [0x53, MASTER]);
    set.poll().set_rate(at(0), 100);
    assert_eq!(set.release(MASTER, EXPLICIT), Ok(()));
    assert_eq!(set.information(), [0x52, MASTER]);
    assert_eq!(states(&mut set), [0, 3, 1]);
    assert!(!set.hears(MASTER));
    assert_eq!(set.allocate(at(1), EXPLICIT, MASTER), Ok(()));
    assert_eq!(set.release(MASTER, SUPPRESS | CHANGE), Ok(()));
    assert_eq!(set.information(), [0x03, MASTER]);
    assert_eq!(states(&mut set), [3, 3, 0]);
}

#[test]
fn explicit_time_out_deletes_the_connection_and_keeps_established_io() {
    let mut set = allocated(EXPLICIT | POLL);
    set.poll().set_rate(at(0), 0);
    assert!(!set.expire(at(9_999)));
    assert!(set.expire(at(10_000)));
    assert_eq!(set.information(), [0x02, MASTER]);
    assert_eq!(states(&mut set), [0, 3, 0]);
    let other = set.allocate(at(1), EXPLICIT, OTHER);
    assert_eq!(code(other), [0x0C, 1]);
    assert_eq!(set.allocate(at(1), EXPLICIT, MASTER), Ok(()));
}

#[test]
fn explicit_time_out_without_established_io_releases_everything() {
    for defers in [false, true] {
        let mut set = allocated(EXPLICIT | POLL);
        set.set_defers(defers);
        assert!(set.expire(at(10_000)));
        assert_eq!(set.information(), [0, 0xFF]);
        assert_eq!(states(&mut set), [0, 0, 0]);
        assert!(!set.has_timed_out());
    }
}

#[test]
fn deferred_explicit_is_still_allocated_and_established_by_next_request() {
    let mut set = allocated(EXPLICIT | POLL);
    set.set_defers(true);
    set.poll().set_rate(at(0), 0);
    assert!(set.expire(at(10_000)));
    assert_eq!(states(&mut set), [5, 3, 0]);
    assert_eq!(set.information(), [0x03, MASTER]);
    let again = set.allocate(at(10_001), EXPLICIT, MASTER);
    assert_eq!(code(again), [0x0B, 2]);
    assert!(set.hears(MASTER));
    assert!(set.requested(at(20_000)));
    assert_eq!(states(&mut set), [3, 3, 0]);
    assert!(!set.requested(at(20_000)));
    assert!(!set.expire(at(29_999)));
}

#[test]
fn deferred_explicit_is_deleted_when_io_times_out() {
    let mut set = allocated(EXPLICIT | POLL);
    set.set_defers(true);
    set.poll().set_rate(at(5000), 1);
    assert!(set.expire(at(10_000)));
    assert_eq!(states(&mut set), [5, 3, 0]);
    assert!(set.expire(at(15_000)));
    assert_eq!(states(&mut set), [0, 0, 0]);
    assert_eq!(set.information(), [0, 0xFF]);
    assert!(set.has_timed_out());
}

#[test]
fn timed_out_io_can_be_released_or_allocated_again() {
    for releases in [false, true] {
        let mut set = allocated(EXPLICIT | CHANGE);
        set.explicit().set_rate(at(0), 0);
        set.producing().set_rate(at(0), 100);
        assert!(set.expire(at(10_000)));
        assert_eq!(states(&mut set), [3, 0, 4]);
        assert_eq!(set.information(), [0x01, MASTER]);
        assert!(set.has_timed_out());
        if releases {
            assert_eq!(set.release(MASTER, CHANGE), Ok(()));
            assert_eq!(states(&mut set), [3, 0, 0]);
        } else {
            assert_eq!(set.allocate(at(1), CYCLIC, MASTER), Ok(()));
            assert_eq!(states(&mut set), [3, 0, 1]);
        }
        assert!(!set.has_timed_out());
    }
}
