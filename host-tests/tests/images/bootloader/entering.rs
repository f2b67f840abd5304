//! A running program enters the bootloader over its own protocol, and another program starts. Parameters, identifiers and bit rate stay.

use super::client::Client;
use super::{BOOT_UP, RATE, START, VERSION, file, sensor, sensor_with, slot};
use crate::rig::{REPLY, Rig, SET, baud_rate_code, data, fsc, saved};
use plumbline::can::{BitRate, CanId};
use plumbline::update::Contact;
use stm32_sim::rcc::ResetCause;

/// The longest time from the reply of the program to the first message of the bootloader in ms.
const ENTRY: u64 = 30;

/// A program and its successor.
pub fn files(name: &str) -> [Vec<u8>; 2] {
    [file(name, VERSION), file(name, VERSION + 1)]
}

/// Sends a frame and returns the data of the reply.
#[track_caller]
pub fn ask(rig: &mut Rig, (request, reply): (u16, u16), bytes: &[u8]) -> Vec<u8> {
    rig.bus.send(rig.tester, data(request, bytes));
    rig.expect(reply, 60).bytes().to_vec()
}

/// The program restarts into the bootloader, whose first message is this one. It takes the file over these identifiers and starts it.
#[track_caller]
fn update(rig: &mut Rig, (request, reply): (u16, u16), first: (u16, &[u8]), file: &[u8]) {
    rig.expect_reset(ResetCause::Software);
    let (id, message) = first;
    assert_eq!(rig.expect(id, ENTRY), data(id, message));
    let contact = Contact {
        rate: RATE,
        request: CanId::standard(request),
        reply: CanId::standard(reply),
        boot_up: CanId::standard(id),
        vendor: 0,
        product_code: 0,
        serial: 0,
    };
    let mut client = Client::of_known(rig, &contact);
    assert_eq!(client.number(0x1000, 0), 0, "the bootloader");
    client.download(file).unwrap();
    client.control(1);
    rig.expect_reset(ResetCause::Software);
}

/// The CRC of the body of a file.
fn crc_of(file: &[u8]) -> &[u8] {
    &file[20..24]
}

/// Element and board of the image: an ISM330DHCX (bit 15), Blue Pill.
const HARDWARE: [u8; 2] = [1, 0];

#[test]
fn jn2101_takes_a_program_over_canopen_and_keeps_its_parameters() {
    let [old, new] = files("jn2101");
    let ids = (0x60A, 0x58A);
    let mut rig = sensor("jn2101", Some(slot(&old)), RATE);
    rig.expect(BOOT_UP, START);
    let write = ask(&mut rig, ids, &[0x2B, 0x17, 0x10, 0, 0xD0, 7, 0, 0]);
    assert_eq!(write, [0x60, 0x17, 0x10, 0, 0, 0, 0, 0]);
    let save = ask(&mut rig, ids, b"\x23\x10\x10\x01save");
    assert_eq!(save, [0x60, 0x10, 0x10, 1, 0, 0, 0, 0]);
    let stop = ask(&mut rig, ids, &[0x2F, 0x51, 0x1F, 1, 0, 0, 0, 0]);
    assert_eq!(stop, [0x60, 0x51, 0x1F, 1, 0, 0, 0, 0]);
    update(&mut rig, ids, (BOOT_UP, &[0]), &new);
    rig.expect(BOOT_UP, START);
    let crc = ask(&mut rig, ids, &[0x40, 0x56, 0x1F, 1, 0, 0, 0, 0]);
    assert_eq!(crc[4..], *crc_of(&new));
    let hardware = ask(&mut rig, ids, &[0x40, 0x56, 0x1F, 2, 0, 0, 0, 0]);
    assert_eq!(hardware[4..6], HARDWARE);
    let time = ask(&mut rig, ids, &[0x40, 0x17, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(time, [0x4B, 0x17, 0x10, 0, 0xD0, 7, 0, 0]);
}

#[test]
fn is2_takes_a_program_with_code_60h_and_keeps_its_parameters() {
    let [old, new] = files("is2");
    let memory = saved("is2", &[&[fsc::WRITE_BAUD_RATE, baud_rate_code(RATE)]]);
    let mut rig = sensor_with("is2", Some(slot(&old)), RATE, memory);
    rig.boot_up();
    rig.write_time(777);
    rig.save();
    let reply = ask(&mut rig, (SET, REPLY), b"\x60FLASH");
    assert_eq!(reply.len(), 2, "{reply:02X?}");
    update(&mut rig, (SET, REPLY), (REPLY, b"\x60BOOT"), &new);
    rig.boot_up();
    assert_eq!(rig.read_time(), 777);
    let reply = ask(&mut rig, (SET, REPLY), b"\x60");
    assert_eq!(reply[2..], [crc_of(&new), &HARDWARE].concat());
}

/// The explicit connection ends. After the update the sensor checks its MAC ID again.
#[test]
fn tiltix080_takes_a_program_with_service_32h() {
    let [old, new] = files("tiltix080");
    let ids = (0x5FC, 0x5FB);
    let check = |rig: &mut Rig| {
        rig.expect(0x5FF, 1200);
        rig.expect(0x5FF, 1200);
        rig.run(1100);
        let allocated = ask(rig, (0x5FE, 0x5FB), &[0x0A, 0x4B, 3, 1, 1, 0x0A]);
        assert_eq!(allocated, [0x0A, 0xCB, 0]);
    };
    let mut rig = sensor("tiltix080", Some(slot(&old)), BitRate::K125);
    check(&mut rig);
    let reply = ask(&mut rig, ids, b"\x0A\x32\x01\x01BOOT");
    assert_eq!(reply, [0x0A, 0xB2]);
    update(&mut rig, ids, (0x5FB, b"\x60BOOT"), &new);
    check(&mut rig);
    let reply = ask(&mut rig, ids, &[0x0A, 0x32, 1, 1]);
    assert_eq!(reply, [&[0x0A, 0xB2], crc_of(&new), &HARDWARE].concat());
}
