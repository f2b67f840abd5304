//! The IMS360, which only a Nucleo-F446RE has behind a bootloader: an update in CANopen and in J1939.

use super::entering::{ask, files};
use super::*;

/// The first message with the factory node-ID, 50.
const FIRST: u16 = 0x732;
const IDS: (u16, u16) = (0x632, 0x5B2);

/// Downloads the file over the identifiers of this contact, and lets the sensor copy and start it.
#[track_caller]
fn update(rig: &mut Rig, contact: &Contact, file: &[u8]) {
    let mut client = Client::of_known(rig, contact);
    assert_eq!(client.number(0x1000, 0), 0, "the bootloader");
    client.download(file).unwrap();
    client.control(1);
    // The restart of the client, and that after the copy.
    rig.expect_reset(ResetCause::Software);
    rig.expect_reset(ResetCause::Software);
}

fn is_updated_in_canopen() {
    let [old, new] = files("ims360");
    let mut rig = sensor("ims360", Some(slot(&old)), RATE);
    rig.expect(FIRST, 250);
    let stop = ask(&mut rig, IDS, &[0x2F, 0x51, 0x1F, 1, 0, 0, 0, 0]);
    assert_eq!(stop, [0x60, 0x51, 0x1F, 1, 0, 0, 0, 0]);
    rig.expect_reset(ResetCause::Software);
    assert_eq!(rig.expect(FIRST, 30), data(FIRST, &[0]));
    let contact = Contact {
        request: CanId::standard(IDS.0),
        reply: CanId::standard(IDS.1),
        ..known(RATE)
    };
    update(&mut rig, &contact, &new);
    rig.expect(FIRST, 3000);
    let crc = ask(&mut rig, IDS, &[0x40, 0x56, 0x1F, 1, 0, 0, 0, 0]);
    assert_eq!(crc[4..], new[20..24]);
}

/// Protocol and address are stored: the bootloader answers at this address, and the new program claims it.
fn is_updated_in_j1939_at_another_address_than_as_delivered() {
    let [old, new] = files("ims360");
    let mut rig = sensor("ims360", Some(slot(&old)), RATE);
    rig.expect(FIRST, 250);
    rig.download(0x2102, 0, [0xA0]);
    rig.change_to_j1939();
    rig.run(400);
    let contact = Contact {
        request: CanId::extended(0x18EF_A021),
        reply: CanId::extended(0x18EF_21A0),
        ..known(RATE)
    };
    let stop = rig.parameter(0xA0, "2F511F0100000000");
    assert_eq!(stop, "60511F0100000000");
    rig.expect_reset(ResetCause::Software);
    assert_eq!(rig.wait_text(30), ["18EF21A0#60424F4F54"]);
    update(&mut rig, &contact, &new);
    let sent = rig.wait_text(3000);
    assert_eq!(sent.first().map(|text| &text[..8]), Some("18EEFFA0"));
    let crc: String = new[20..24].iter().map(|it| format!("{it:02X}")).collect();
    let read = rig.parameter(0xA0, "40561F0100000000");
    assert_eq!(read, format!("43561F01{crc}"));
}

mod nucleo_f446 {
    on! {
        crate::rig::on_the_nucleo:
        is_updated_in_canopen,
        is_updated_in_j1939_at_another_address_than_as_delivered
    }
}
