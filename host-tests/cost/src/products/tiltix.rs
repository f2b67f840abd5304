//! The messages of the scenario for the TILTIX: DeviceNet with explicit, poll and change-of-state connections at 500 kbit/s.

use super::{Filter, Message, Protocol, asked};
use bench::BusRate;
use plumbline::time::millis;

/// A request of the master 0Ah on the explicit connection of the factory MAC ID.
const fn request(data: &'static [u8]) -> Message {
    Message(0x5FC, data)
}

/// The size of the moving average (84h).
const AVERAGE_OFF: Message = request(&[0x0A, 0x10, 0x65, 1, 0x84, 0]);
const AVERAGE_250: Message = request(&[0x0A, 0x10, 0x65, 1, 0x84, 250]);

/// The weight of the recursive filter (85h).
const RECURSIVE_OFF: Message = request(&[0x0A, 0x10, 0x65, 1, 0x85, 0, 0]);
const RECURSIVE_990: Message = request(&[0x0A, 0x10, 0x65, 1, 0x85, 0xDE, 0x03]);
/// The highest weight: the angle stays constant.
const HOLD: Message = request(&[0x0A, 0x10, 0x65, 1, 0x85, 0xE8, 0x03]);

/// DeviceNet with the objects of the TILTIX (section 5.1 of its manual).
pub(super) const DEVICENET: Protocol = Protocol {
    modules: &["plumbline::devicenet::"],
    bus: BusRate::Follow,
    preparation: &asked([
        // 500 kbit/s, then a reset.
        request(&[0x0A, 0x10, 3, 1, 2, 2]),
        request(&[0x0A, 0x05, 1, 1]),
    ]),
    boot_up: 1,
    begin: &[],
    online: millis(2200),
    connection: &[
        // Explicit and poll; both do not time out.
        Message(0x5FE, &[0x0A, 0x4B, 3, 1, 3, 0x0A]),
        request(&[0x0A, 0x10, 5, 1, 9, 0, 0]),
        request(&[0x0A, 0x10, 5, 2, 9, 0, 0]),
        // The first poll also ends the wait for it.
        Message(0x5FD, &[]),
    ],
    emergency: None,
    // Slope long16.
    read: request(&[0x0A, 0x0E, 0x65, 1, 0x72]),
    write: request(&[0x0A, 0x10, 0x65, 1, 0x84, 50]),
    // Header and service.
    read_code: 2,
    // A poll command.
    sync: Message(0x5FD, &[]),
    sync_code: 0,
    filters: &[
        Filter {
            settings: &[AVERAGE_OFF, RECURSIVE_OFF],
            load: "load_off",
        },
        Filter {
            settings: &[RECURSIVE_990, AVERAGE_250],
            load: "load_average",
        },
    ],
    slowest_filter: Some(AVERAGE_250),
    others: &[
        // Identity; the product name in fragments, of which two are acknowledged.
        request(&[0x0A, 0x0E, 1, 1, 4]),
        request(&[0x0A, 0x0E, 1, 1, 6]),
        request(&[0x0A, 0x0E, 1, 1, 7]),
        request(&[0x8A, 0xC0, 0]),
        request(&[0x8A, 0xC1, 0]),
        // DeviceNet, assembly, connection, acknowledge handler.
        request(&[0x0A, 0x0E, 3, 1, 5]),
        request(&[0x0A, 0x0E, 4, 0x67, 3]),
        request(&[0x0A, 0x0E, 5, 2, 14]),
        request(&[0x0A, 0x0E, 0x2B, 1, 1]),
        request(&[0x0A, 0x0E, 0x65, 1, 0x78]),
        // Inversion and scaling, preset, 0.1 deg and back.
        request(&[0x0A, 0x10, 0x65, 1, 0x73, 3]),
        request(&[0x0A, 0x10, 0x65, 1, 0x75, 1]),
        request(&[0x0A, 0x10, 0x65, 1, 0x75, 0]),
        request(&[0x0A, 0x10, 0x65, 1, 0x71, 100, 0]),
        request(&[0x0A, 0x10, 0x65, 1, 0x71, 10, 0]),
        request(&[0x0A, 0x10, 0x65, 1, 0x73, 0]),
        // A COS connection without acknowledgement compares the values. Its first message follows the second answer.
        HOLD,
        request(&[0x0A, 0x4B, 3, 1, 0x50, 0x0A]),
        request(&[0x0A, 0x10, 5, 4, 9, 0, 0]),
        request(&[0x0A, 0x10, 0x65, 1, 0x87, 1]),
        request(&[0x0A, 0x4C, 3, 1, 0x10]),
        // An object that does not exist.
        request(&[0x0A, 0x0E, 0x77, 1, 1]),
    ],
    services: &[],
    j1939: None,
    // A cyclic connection without acknowledgement, every 5 ms.
    cyclic: &[
        request(&[0x0A, 0x4B, 3, 1, 0x60, 0x0A]),
        request(&[0x0A, 0x10, 5, 4, 9, 5, 0]),
    ],
    not_cyclic: &[request(&[0x0A, 0x4C, 3, 1, 0x20])],
    // Recovery from bus-off.
    set_up: &[request(&[0x0A, 0x10, 3, 1, 3, 1])],
    saves: &[
        request(&[0x0A, 0x10, 0x65, 1, 0x84, 10]),
        request(&[0x0A, 0x10, 0x65, 1, 0x84, 11]),
    ],
    saves_later: millis(500),
    // Resets of type 1 and 0.
    load: &[request(&[0x0A, 0x05, 1, 1, 1])],
    restart: &[request(&[0x0A, 0x05, 1, 1])],
};
