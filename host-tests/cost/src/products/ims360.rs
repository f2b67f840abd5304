//! The messages of the scenario for the IMS360: CANopen with LSS, block transfer, dynamic mapping and the Kalman filter, and
//! J1939.

use super::{Filter, J1939, Message, Protocol, Service, Step, asked};
use bench::BusRate;
use plumbline::time::millis;

/// An SDO request to the factory node-ID.
const fn sdo(data: &'static [u8; 8]) -> Message {
    Message(0x632, data)
}

/// A request of the LSS master.
const fn lss(data: &'static [u8; 8]) -> Message {
    Message(0x7E5, data)
}

/// Saves all parameters: "save" to 1010h:01.
const SAVE: Message = sdo(b"\x23\x10\x10\x01save");

/// Selects the Kalman filter (3110h:02).
const KALMAN: Message = sdo(&[0x2F, 0x10, 0x31, 2, 1, 0, 0, 0]);

/// Selects the low-pass filter (3110h:02).
const LOW_PASS: Message = sdo(&[0x2F, 0x10, 0x31, 2, 0, 0, 0, 0]);

/// 3111h: 0.1 Hz, and 2 Hz, at which the samples are measured.
const TENTH_HERTZ: Message = sdo(&[0x2B, 0x11, 0x31, 0, 100, 0, 0, 0]);
const TWO_HERTZ: Message = sdo(&[0x2B, 0x11, 0x31, 0, 0xD0, 0x07, 0, 0]);

/// Parameters in J1939, from 21h to the factory address.
const fn parameter(data: &'static [u8; 8]) -> Message {
    Message(0x18EF_8021, data)
}

const VEHICLE: J1939 = J1939 {
    // 3100h:01, save, restart.
    change: &[
        sdo(&[0x2F, 0x00, 0x31, 1, 1, 0, 0, 0]),
        SAVE,
        sdo(&[0x2F, 0x10, 0x20, 1, 1, 0, 0, 0]),
    ],
    off: parameter(&[0x2B, 0x04, 0x21, 1, 0, 0, 0, 0]),
    on: parameter(&[0x2B, 0x04, 0x21, 1, 10, 0, 0, 0]),
    contention: Message(0x18EE_FF80, &[0xFF; 8]),
    requests: &[
        // SSI2.
        ("j1939_request", Message(0x18EA_8021, &[0x29, 0xF0, 0])),
        // Longitudinal, 32 bits.
        (
            "j1939_parameter",
            parameter(&[0x40, 0x10, 0x61, 0, 0, 0, 0, 0]),
        ),
    ],
};

/// CANopen with the objects of the IMS360 (chapter 7 of its manual).
pub(in super::super) const IMS360: Protocol = Protocol {
    modules: &["plumbline::canopen::", "plumbline::j1939::"],
    bus: BusRate::Follow,
    preparation: &asked([
        // 1 Mbit/s.
        sdo(&[0x23, 0x01, 0x20, 0, 0x40, 0x42, 0x0F, 0]),
        // TPDO 1 every 100 ms, so that the start of the node has a reply.
        sdo(&[0x2B, 0x00, 0x18, 5, 100, 0, 0, 0]),
        // All four TPDOs have both angles.
        sdo(&[0x23, 0x01, 0x1A, 1, 0x20, 0, 0x10, 0x61]),
        sdo(&[0x23, 0x01, 0x1A, 2, 0x20, 0, 0x20, 0x61]),
        sdo(&[0x2F, 0x01, 0x1A, 0, 2, 0, 0, 0]),
        sdo(&[0x23, 0x01, 0x18, 1, 0xB2, 0x02, 0, 0]),
        sdo(&[0x23, 0x02, 0x1A, 1, 0x20, 0, 0x10, 0x61]),
        sdo(&[0x23, 0x02, 0x1A, 2, 0x20, 0, 0x20, 0x61]),
        sdo(&[0x2F, 0x02, 0x1A, 0, 2, 0, 0, 0]),
        sdo(&[0x23, 0x02, 0x18, 1, 0xB2, 0x03, 0, 0]),
        sdo(&[0x23, 0x03, 0x1A, 1, 0x20, 0, 0x10, 0x61]),
        sdo(&[0x23, 0x03, 0x1A, 2, 0x20, 0, 0x20, 0x61]),
        sdo(&[0x2F, 0x03, 0x1A, 0, 2, 0, 0, 0]),
        sdo(&[0x23, 0x03, 0x18, 1, 0xB2, 0x04, 0, 0]),
        SAVE,
        // Reset node, after which the bit rate is in effect; then operational.
        Message(0x000, &[0x81, 0]),
        Message(0x000, &[0x01, 0]),
        // TPDO 1 with each SYNC.
        sdo(&[0x2F, 0x00, 0x18, 2, 1, 0, 0, 0]),
        sdo(&[0x2B, 0x00, 0x18, 5, 0, 0, 0, 0]),
    ]),
    boot_up: 1,
    // Operational.
    begin: &[Message(0x000, &[0x01, 0])],
    online: millis(0),
    connection: &[],
    emergency: Some(0x0B2),
    // Longitudinal, 32 bits.
    read: sdo(&[0x40, 0x10, 0x61, 0, 0, 0, 0, 0]),
    // The timer of the first TPDO, 20 ms; it is effective only with another transmission type.
    write: sdo(&[0x2B, 0x00, 0x18, 5, 20, 0, 0, 0]),
    // Command, index and subindex.
    read_code: 4,
    sync: Message(0x080, &[]),
    sync_code: 0,
    filters: &[
        Filter {
            settings: &[sdo(&[0x2F, 0x10, 0x31, 1, 0, 0, 0, 0])],
            load: "load_off",
        },
        // 0.1 Hz, 25 Hz, 2 Hz.
        Filter {
            settings: &[
                sdo(&[0x2F, 0x10, 0x31, 1, 1, 0, 0, 0]),
                TENTH_HERTZ,
                sdo(&[0x2B, 0x11, 0x31, 0, 0xA8, 0x61, 0, 0]),
                TWO_HERTZ,
            ],
            load: "load_butterworth",
        },
        // 0.1 Hz, 8 Hz, 2 Hz.
        Filter {
            settings: &[
                sdo(&[0x2F, 0x10, 0x31, 1, 2, 0, 0, 0]),
                TENTH_HERTZ,
                sdo(&[0x2B, 0x11, 0x31, 0, 0x40, 0x1F, 0, 0]),
                TWO_HERTZ,
            ],
            load: "load_critically_damped",
        },
        // Q = 0.0001, then the factory's 0.001.
        Filter {
            settings: &[
                KALMAN,
                sdo(&[0x2F, 0x12, 0x31, 2, 0xFC, 0, 0, 0]),
                sdo(&[0x2F, 0x12, 0x31, 2, 0xFD, 0, 0, 0]),
            ],
            load: "load_fusion",
        },
    ],
    slowest_filter: Some(KALMAN),
    others: &[
        KALMAN,
        LOW_PASS,
        sdo(&[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x01, 0x10, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x03, 0x10, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x05, 0x10, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x18, 0x10, 4, 0, 0, 0, 0]),
        sdo(&[0x40, 0x20, 0x20, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x00, 0x30, 1, 0, 0, 0, 0]),
        sdo(&[0x40, 0x20, 0x61, 0, 0, 0, 0, 0]),
        // The device name, in segments.
        sdo(&[0x40, 0x08, 0x10, 0, 0, 0, 0, 0]),
        sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]),
        // Offsets and zero point.
        sdo(&[0x23, 0x10, 0x32, 0, 100, 0, 0, 0]),
        sdo(&[0x2F, 0x00, 0x32, 0, 3, 0, 0, 0]),
        // A mapping of a valid TPDO is refused.
        sdo(&[0x2F, 0x01, 0x1A, 0, 0, 0, 0, 0]),
        // Heartbeat, off.
        sdo(&[0x2B, 0x17, 0x10, 0, 0, 0, 0, 0]),
        // An object that does not exist.
        sdo(&[0x40, 0x77, 0x77, 0, 0, 0, 0, 0]),
    ],
    services: &[
        // The node-ID, in the state LSS configuration.
        Service {
            row: "lss_median",
            before: &[Step::Told(lss(&[0x04, 1, 0, 0, 0, 0, 0, 0]))],
            message: lss(&[0x5E, 0, 0, 0, 0, 0, 0, 0]),
            after: &[Step::Told(lss(&[0x04, 0, 0, 0, 0, 0, 0, 0]))],
        },
        // The device name with CRC: the block has one segment.
        Service {
            row: "block_median",
            before: &[Step::Asked(sdo(&[0xA4, 0x08, 0x10, 0, 127, 0, 0, 0]))],
            message: sdo(&[0xA3, 0, 0, 0, 0, 0, 0, 0]),
            after: &[
                Step::Asked(sdo(&[0xA2, 1, 127, 0, 0, 0, 0, 0])),
                Step::Told(sdo(&[0xA1, 0, 0, 0, 0, 0, 0, 0])),
            ],
        },
    ],
    j1939: Some(&VEHICLE),
    // The first TPDO every 5 ms.
    cyclic: &[
        sdo(&[0x2B, 0x00, 0x18, 5, 5, 0, 0, 0]),
        sdo(&[0x2F, 0x00, 0x18, 2, 254, 0, 0, 0]),
    ],
    not_cyclic: &[sdo(&[0x2F, 0x00, 0x18, 2, 1, 0, 0, 0])],
    // Recovery from bus-off.
    set_up: &[sdo(&[0x2F, 0x00, 0x31, 2, 1, 0, 0, 0])],
    saves: &[SAVE],
    saves_later: millis(0),
    load: &[sdo(b"\x23\x11\x10\x01load")],
    restart: &[sdo(&[0x2F, 0x10, 0x20, 1, 1, 0, 0, 0])],
};
