//! The messages of the scenario for the JN2101: CANopen with FIR filters, programming key and self-test.

use super::{Filter, Message, Protocol, asked};
use bench::BusRate;
use plumbline::time::millis;

/// An SDO request to the factory node id of the JN2101.
const fn sdo(data: &'static [u8; 8]) -> Message {
    Message(0x60A, data)
}

/// Saves all parameters: "save" to 1010h:01.
const SAVE: Message = sdo(b"\x23\x10\x10\x01save");

/// The FIR filter at 10 Hz (2043h).
const TEN_HERTZ: Message = sdo(&[0x2F, 0x43, 0x20, 0, 1, 0, 0, 0]);

const fn fir(settings: &'static [Message], load: &'static str) -> Filter {
    Filter { settings, load }
}

/// CANopen with the objects of the JN2101 (section 14 of its manual).
pub(super) const JN2101: Protocol = Protocol {
    modules: &["plumbline::canopen::"],
    bus: BusRate::Follow,
    preparation: &asked([
        // 1000 kbit/s.
        sdo(&[0x2B, 0x01, 0x20, 0, 0xE8, 0x03, 0, 0]),
        // Operational after each boot-up message.
        sdo(&[0x23, 0x80, 0x1F, 0, 8, 0, 0, 0]),
        // The second TPDO by its timer only, which is switched off.
        sdo(&[0x2B, 0x01, 0x18, 5, 0, 0, 0, 0]),
        sdo(&[0x2F, 0x01, 0x18, 2, 254, 0, 0, 0]),
        SAVE,
        // Reset node, after which both settings are in effect.
        Message(0x000, &[0x81, 0]),
    ]),
    boot_up: 1,
    begin: &[],
    online: millis(0),
    connection: &[],
    emergency: Some(0x08A),
    // Longitudinal, 16 bits.
    read: sdo(&[0x40, 0x10, 0x60, 0, 0, 0, 0, 0]),
    // The timer of the first TPDO, 20 ms; it is effective only with another transmission type.
    write: sdo(&[0x2B, 0x00, 0x18, 5, 20, 0, 0, 0]),
    // Command, index and subindex.
    read_code: 4,
    sync: Message(0x080, &[]),
    sync_code: 0,
    filters: &[
        Filter {
            settings: &[sdo(&[0x2F, 0x43, 0x20, 0, 0, 0, 0, 0])],
            load: "load_off",
        },
        fir(&[TEN_HERTZ], "load_fir_10"),
        fir(&[sdo(&[0x2F, 0x43, 0x20, 0, 2, 0, 0, 0])], "load_fir_5"),
        fir(&[sdo(&[0x2F, 0x43, 0x20, 0, 3, 0, 0, 0])], "load_fir_1"),
        fir(&[sdo(&[0x2F, 0x43, 0x20, 0, 4, 0, 0, 0])], "load_fir_half"),
    ],
    slowest_filter: Some(TEN_HERTZ),
    others: &[
        sdo(&[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x01, 0x10, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x03, 0x10, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x05, 0x10, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x18, 0x10, 1, 0, 0, 0, 0]),
        sdo(&[0x40, 0x18, 0x10, 4, 0, 0, 0, 0]),
        sdo(&[0x40, 0x20, 0x60, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x10, 0x61, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x20, 0x61, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x80, 0x40, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x81, 0x40, 0, 0, 0, 0, 0]),
        // The programming key, in segments; the last request is beyond its end.
        sdo(&[0x40, 0x00, 0x30, 0, 0, 0, 0, 0]),
        sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x70, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x70, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x70, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x70, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x70, 0, 0, 0, 0, 0, 0, 0]),
        // Terminating resistor and heating, off and on.
        sdo(&[0x2F, 0x45, 0x20, 0, 0, 0, 0, 0]),
        sdo(&[0x2F, 0x45, 0x20, 0, 1, 0, 0, 0]),
        sdo(&[0x2F, 0x41, 0x20, 0, 0, 0, 0, 0]),
        sdo(&[0x2F, 0x41, 0x20, 0, 1, 0, 0, 0]),
        // All other angle definitions, then that of the factory.
        sdo(&[0x2F, 0x44, 0x20, 0, 1, 0, 0, 0]),
        sdo(&[0x2F, 0x44, 0x20, 0, 2, 0, 0, 0]),
        sdo(&[0x2F, 0x44, 0x20, 0, 3, 0, 0, 0]),
        sdo(&[0x2F, 0x44, 0x20, 0, 0, 0, 0, 0]),
        // Teach-in and zero point, on and off.
        sdo(&[0x2F, 0x42, 0x20, 0, 1, 0, 0, 0]),
        sdo(&[0x2F, 0x42, 0x20, 0, 2, 0, 0, 0]),
        sdo(&[0x2F, 0x46, 0x20, 0, 1, 0, 0, 0]),
        sdo(&[0x2F, 0x46, 0x20, 0, 2, 0, 0, 0]),
        // Heartbeat, off.
        sdo(&[0x2B, 0x17, 0x10, 0, 0, 0, 0, 0]),
        // An object that does not exist.
        sdo(&[0x40, 0x77, 0x77, 0, 0, 0, 0, 0]),
    ],
    services: &[],
    j1939: None,
    // The first TPDO every 5 ms.
    cyclic: &[
        sdo(&[0x2B, 0x00, 0x18, 5, 5, 0, 0, 0]),
        sdo(&[0x2F, 0x00, 0x18, 2, 254, 0, 0, 0]),
    ],
    not_cyclic: &[sdo(&[0x2F, 0x00, 0x18, 2, 1, 0, 0, 0])],
    // The self-test, which runs during the saves.
    set_up: &[sdo(&[0x2F, 0x04, 0x40, 1, 1, 0, 0, 0])],
    saves: &[SAVE],
    saves_later: millis(0),
    load: &[sdo(b"\x23\x11\x10\x01load")],
    restart: &[sdo(&[0x2F, 0x02, 0x20, 0, 1, 0, 0, 0])],
};
