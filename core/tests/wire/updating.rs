//! Requests that enter the bootloader (U1 to U4): each protocol has one only behind a bootloader, and otherwise answers as the original does.

use crate::tester::devicenet::{MAC_3, power_up};
use crate::tester::fsc::request;
use crate::tester::{Tester, canopen, fsc, ims360, j1939};
use plumbline::can::{BitRate, CanId, Frame, standard};
use plumbline::node::{Action, Node};
use plumbline::update::{Contact, Element, Hardware, Installed};

const CRC: u32 = 0x4433_2211;
const PROGRAM: Installed = Installed {
    crc: CRC,
    hardware: Hardware::new(2, Element::Adxl355),
};
/// Bits 0 to 14 are the board, bit 15 is the element.
const HARDWARE: u32 = 0x8002;
/// The serial number of the chip in these tests.
const SERIAL: u32 = 0x0403_0201;

/// The node after power-up behind a bootloader.
fn behind<N: Node>(mut tester: Tester<N>) -> Tester<N> {
    tester.sent();
    tester.program = Some(PROGRAM);
    tester.power_cycle();
    tester
}

/// Whether the last frames have led to a restart, and the contact data for the bootloader.
fn leaves<N: Node>(tester: &Tester<N>) -> (bool, Option<Contact>) {
    let restarts = tester.actions.contains(&Action::Restart);
    (restarts, tester.node.contact())
}

#[test]
fn canopen_node_stops_its_program_only_behind_a_bootloader() {
    let mut t = canopen::booted();
    for object in [0x1F50, 0x1F51, 0x1F56, 0x1F57] {
        assert_eq!(t.read(object, 1), Err(0x0602_0000), "{object:04X}h");
    }
    assert_eq!(t.write(0x1F51, 1, 1, 0), Err(0x0602_0000));
    assert_eq!(leaves(&t), (false, None));

    let mut t = behind(canopen::power_up());
    assert_eq!(t.sent_text(), ["70A#00"]);
    let highest = [0x1F51, 0x1F56, 0x1F57].map(|object| t.read(object, 0));
    assert_eq!(highest, [Ok(1), Ok(2), Ok(1)]);
    assert_eq!(t.read(0x1F51, 1), Ok(1));
    assert_eq!(t.read(0x1F51, 2), Err(0x0609_0011));
    assert_eq!(t.read(0x1F56, 1), Ok(CRC));
    assert_eq!(t.read(0x1F56, 2), Ok(HARDWARE));
    assert_eq!(t.read(0x1F56, 3), Err(0x0609_0011));
    // Clients with CiA 302 wait until all bits are 0.
    assert_eq!(t.read(0x1F57, 1), Ok(0));
    // Only the bootloader takes a program.
    assert_eq!(t.read(0x1F50, 1), Err(0x0602_0000));
    assert_eq!(t.write(0x1F51, 1, 1, 1), Ok(()));
    assert_eq!(t.write(0x1F51, 1, 1, 2), Err(0x0609_0030));
    assert_eq!(t.write(0x1F51, 1, 2, 0), Err(0x0607_0012));
    // Segmented, of one byte and of two.
    assert_eq!(t.exchange("60A#21511F0101000000"), ["58A#80511F0100000106"]);
    assert_eq!(t.exchange("60A#21511F0102000000"), ["58A#80511F0112000706"]);
    assert_eq!(t.write(0x1F56, 1, 4, 0), Err(0x0601_0002));
    assert_eq!(t.write(0x1F56, 2, 4, 0), Err(0x0601_0002));
    assert_eq!(leaves(&t), (false, None));
    assert_eq!(t.write(0x1F51, 1, 1, 0), Ok(()));
    let contact = Contact {
        rate: BitRate::K125,
        request: CanId::standard(0x60A),
        reply: CanId::standard(0x58A),
        boot_up: CanId::standard(0x70A),
        vendor: 0x6D66_6900,
        product_code: 1,
        serial: SERIAL,
    };
    assert_eq!(leaves(&t), (true, Some(contact)));
}

#[test]
fn canopen_node_restarts_without_an_update_after_other_requests() {
    let mut t = behind(ims360::booted());
    t.sent();
    assert_eq!(t.write(0x2010, 1, 1, 1), Ok(()));
    assert_eq!(t.wait_text(101), [(100, "732#00".to_owned())]);
    assert_eq!(leaves(&t), (false, None));
}

/// No heartbeat and no TPDO follows the reply.
#[test]
fn operational_node_sends_nothing_after_the_reply() {
    let mut t = behind(ims360::booted());
    t.sent();
    assert_eq!(t.write(0x1017, 0, 2, 10), Ok(()));
    t.send("000#0132");
    t.sent();
    assert_eq!(t.exchange("632#2F511F0100000000"), ["5B2#60511F0100000000"]);
    assert_eq!(t.wait_text(300), []);
    assert!(leaves(&t).0);
}

#[test]
fn function_select_code_60h_enters_the_bootloader_only_where_there_is_one() {
    const FLASH: [u8; 6] = [0x60, 0x46, 0x4C, 0x41, 0x53, 0x48];
    let mut t = fsc::is2();
    let refused = t.ask(&FLASH);
    assert_eq!(refused[0], 0x60);
    assert_ne!(refused[1] & 0x08, 0, "CmdParamError");
    assert_eq!(leaves(&t), (false, None));

    let mut t = behind(fsc::is2());
    t.receive(Frame::data(standard(0x7FF), &[]).unwrap());
    t.sent();
    let [0x60, _, program @ ..] = &t.ask(&[0x60])[..] else {
        panic!("no reply");
    };
    assert_eq!(*program, [0x11, 0x22, 0x33, 0x44, 0x02, 0x80]);
    // Another signature is refused.
    assert_ne!(t.ask(&request(0x60, b"FLASA"))[1] & 0x08, 0);
    assert_eq!(leaves(&t), (false, None));
    assert_eq!(t.ask(&FLASH).len(), 2);
    let (restarts, contact) = leaves(&t);
    let contact = contact.expect("an update");
    assert!(restarts);
    assert_eq!(contact.serial, SERIAL);
    assert_eq!(contact.boot_up, contact.reply);
}

#[test]
fn j1939_enters_the_bootloader_with_the_identifiers_of_client_and_sensor() {
    let stop = "2F511F0100000000";
    let mut t = j1939::claimed();
    assert_eq!(t.parameter(stop), "80511F0100000206");
    let mut t = behind(j1939::claimed());
    t.wait(250);
    t.sent();
    assert_eq!(t.parameter("40561F0100000000"), "43561F0111223344");
    assert_eq!(t.parameter("40561F0200000000"), "43561F0202800000");
    assert_eq!(t.parameter(stop), "60511F0100000000");
    assert_eq!(t.wait_text(500), []);
    let (restarts, contact) = leaves(&t);
    let contact = contact.expect("an update");
    assert!(restarts);
    assert_eq!(contact.request, CanId::extended(0x18EF_8021));
    assert_eq!(contact.reply, CanId::extended(0x18EF_2180));
    assert_eq!(contact.boot_up, contact.reply);
}

#[test]
fn devicenet_service_32h_of_the_identity_object_enters_the_bootloader_only_where_there_is_one() {
    let mut t = power_up(Some(MAC_3));
    t.wait(2001);
    t.sent();
    t.allocate(1);
    for body in ["320101", "320101424F4F54"] {
        assert_eq!(t.explicit(body), "9408FF", "service not supported");
    }

    let mut t = behind(power_up(Some(MAC_3)));
    t.wait(2001);
    t.sent();
    t.allocate(1);
    assert_eq!(t.explicit("320101"), "B2112233440280");
    assert_eq!(t.explicit("320101424F4F"), "9420FF");
    assert_eq!(t.explicit("320101424F4F50"), "9420FF");
    assert_eq!(
        t.explicit("320100"),
        "9408FF",
        "the class has no such service"
    );
    assert_eq!(leaves(&t), (false, None));
    assert_eq!(t.explicit("320101424F4F54"), "B2");
    assert_eq!(t.wait_text(500), []);
    let (restarts, contact) = leaves(&t);
    let contact = contact.expect("an update");
    assert!(restarts);
    assert_eq!(contact.request, CanId::standard(0x41C));
    assert_eq!(contact.reply, CanId::standard(0x41B));
    assert_eq!(contact.boot_up, contact.reply);
}
