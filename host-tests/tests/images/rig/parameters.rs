//! Identifiers and codes of the manual, and parameter memories with these parameters.

use super::{SERIAL, chip, data, node_type, tilt};
use bench::{Bus, BusRate, Device, Flash};
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;

/// Factory identifiers (manual, table 17).
pub const SET: u16 = 0x300;
pub const REPLY: u16 = 0x301;
pub const SYNC: u16 = 0x100;

/// Function select codes (manual, table 17).
pub mod fsc {
    pub const INCLINATION: u8 = 0x00;
    pub const STATUS: u8 = 0x02;
    pub const READ_CYCLIC_TIME: u8 = 0x15;
    pub const WRITE_BAUD_RATE: u8 = 0x23;
    pub const WRITE_BUS_OFF_RECOVERY: u8 = 0x24;
    pub const WRITE_CYCLIC_TIME: u8 = 0x25;
    pub const WRITE_CYCLIC_MODE: u8 = 0x26;
    pub const WRITE_FILTER: u8 = 0x27;
    pub const ZERO_X: u8 = 0x28;
    pub const SAVE: [u8; 5] = *b"\x50SAVE";
    pub const RESET: [u8; 6] = *b"\xFFRESET";
    pub const ALIVE: u8 = 0xFF;
}

/// Bits of the status byte (manual, tables 14 and 15).
pub mod status {
    pub const EEPROM_ERROR: u8 = 1 << 2;
    pub const CMD_PARAM_ERROR: u8 = 1 << 3;
    pub const SENSOR_ERROR_X: u8 = 1 << 4;
    pub const SENSOR_ERROR_Y: u8 = 1 << 5;
}

/// The code of a bit rate in the parameter of table 17 (section 9.10.3).
pub fn baud_rate_code(rate: BitRate) -> u8 {
    match rate {
        BitRate::K10 => 1,
        BitRate::K20 => 2,
        BitRate::K50 => 3,
        BitRate::K100 => 4,
        BitRate::K125 => 5,
        BitRate::K250 => 6,
        BitRate::K500 => 7,
        BitRate::K800 => 8,
        BitRate::M1 => 9,
        BitRate::K62_5 => 10,
    }
}

pub fn blank() -> Flash {
    Flash::blank(chip().facts().geometry)
}

/// A parameter memory with these parameters, each as the data of the frame that writes it. A sensor built for the PC saves them
/// in the same format; the pages of the microcontroller can be larger.
pub fn saved(name: &str, parameters: &[&[u8]]) -> Flash {
    let memory = saved_on_pc(name, parameters);
    let from = memory.geometry().page_size;
    let geometry = chip().facts().geometry;
    let mut bytes = vec![0xFF; geometry.size()];
    let pages = bytes.chunks_mut(geometry.page_size);
    for (page, content) in pages.zip(memory.bytes().chunks(from)) {
        page[..from].copy_from_slice(content);
    }
    Flash::with_content(geometry, bytes)
}

/// The memory of a sensor built for the PC with these parameters.
pub fn saved_on_pc(name: &str, parameters: &[&[u8]]) -> Flash {
    let mut bus = Bus::new(BusRate::Fixed(BitRate::M1));
    let node_type = node_type(name);
    let device = bus.attach(Device::new(
        &node_type,
        SERIAL,
        Flash::default(),
        tilt(name, 0.0, 0.0),
    ));
    let tester = bus.adapter();
    bus.open(tester, None, false);
    bus.lead_detection();
    bus.run_until(Instant::from_ticks(100_000));
    bus.send(tester, data(SET, &[]));
    bus.run_until(Instant::from_ticks(110_000));
    for parameter in parameters.iter().copied().chain([&fsc::SAVE[..]]) {
        bus.send(tester, data(SET, parameter));
    }
    bus.run_until(Instant::from_ticks(200_000));
    let received = bus.take_received(tester);
    let is_reply = |frame: &Frame| frame.bytes()[0] == fsc::SAVE[0];
    let reply = received.iter().find(|(_, frame)| is_reply(frame));
    let (_, reply) = reply.expect("the reply to SAVE");
    assert_eq!(reply.bytes()[1] & status::CMD_PARAM_ERROR, 0);
    Flash::new(bus.device_mut(device).flash().bytes().to_vec())
}

/// A parameter memory with this fixed bit rate.
pub fn fixed(name: &str, rate: BitRate) -> Flash {
    saved(name, &[&[fsc::WRITE_BAUD_RATE, baud_rate_code(rate)]])
}
