//! COB-IDs that a master can change (CiA 301, 7.5.2.5, 7.5.2.17 and 7.5.2.37) and defaults that follow the node-ID.

use crate::tester::mapped::*;
use plumbline::can::standard;

const VALUE: u32 = 0x0609_0030;
const STATE: u32 = 0x0800_0022;

#[test]
fn cob_id_of_tpdo_changes_while_disabled_before_or_after() {
    let mut t = mapped();
    assert_eq!(t.write(0x1800, 1, 4, 0x1C5), Err(VALUE), "valid");
    assert_eq!(t.write(0x1800, 1, 4, 0x1B2), Ok(()), "no change");
    assert_eq!(t.write(0x1800, 1, 4, 0x4000_01B2), Ok(()), "without RTR");
    assert_eq!(t.write(0x1800, 1, 4, 0x8000_01C5), Ok(()), "disabled after");
    assert_eq!(t.write(0x1800, 1, 4, 0x1C6), Ok(()), "disabled before");
    assert_eq!(t.read(0x1800, 1), Ok(0x1C6));
    assert!(t.accepts(standard(0x1C6)) && !t.accepts(standard(0x1C5)));
}

#[test]
fn restricted_or_long_identifier_of_tpdo_is_refused() {
    let mut t = mapped();
    t.write(0x1800, 1, 4, 0x8000_0000).unwrap();
    assert_eq!(t.read(0x1800, 1), Ok(0x8000_0000));
    for id in [
        0x000, 0x080, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x6FF, 0x701, 0x7FF,
    ] {
        assert_eq!(t.write(0x1800, 1, 4, id), Err(VALUE), "{id:03X}h");
        assert_eq!(t.write(0x1800, 1, 4, 0x8000_0000 | id), Ok(()), "{id:03X}h");
    }
    for id in [0x081, 0x100, 0x181, 0x580, 0x600, 0x680, 0x6DF, 0x700] {
        assert_eq!(t.write(0x1800, 1, 4, id), Ok(()), "{id:03X}h");
        t.write(0x1800, 1, 4, 0x8000_0000).unwrap();
    }
    for id in [
        0x2000_01C5,
        0xA000_01C5,
        0x0000_0800,
        0x8000_0800,
        0x9000_0000,
    ] {
        assert_eq!(t.write(0x1800, 1, 4, id), Err(VALUE), "{id:08X}h");
        assert_eq!(t.read(0x1800, 1), Ok(0x8000_0000));
    }
}

#[test]
fn default_cob_ids_follow_node_id_and_others_stay() {
    let mut t = mapped();
    t.write(0x1801, 1, 4, 0xC000_02B2).unwrap();
    t.write(0x1802, 1, 4, 0x8000_0280).unwrap();
    t.write(0x1803, 1, 4, 0x8000_02B2).unwrap();
    t.write(0x2000, 0, 1, 7).unwrap();
    assert_eq!(
        t.read(0x1800, 1),
        Ok(0x1B2),
        "the node-ID is not in force yet"
    );
    t.store();
    t.power_cycle();
    assert_eq!(t.sent_text(), ["707#00"]);
    t.node_id = 7;
    assert_eq!(t.read(0x1800, 1), Ok(0x187));
    assert_eq!(t.read(0x1801, 1), Ok(0xC000_0287));
    assert_eq!(t.read(0x1802, 1), Ok(0x8000_0280));
    assert_eq!(t.read(0x1803, 1), Ok(0x8000_02B2));
    assert_eq!(t.read(0x1014, 0), Ok(0x87));
}

#[test]
fn emergency_has_cob_id_of_11_or_29_bits() {
    let mut t = mapped();
    let fault = |t: &mut MappedTester| t.wait_without_samples(200).last().unwrap().1;
    for id in [0x4000_00B2, 0x8000_0800, 0xC000_0000] {
        assert_eq!(t.write(0x1014, 0, 4, id), Err(VALUE), "{id:08X}h");
    }
    assert_eq!(t.write(0x1014, 0, 4, 0x080), Err(VALUE));
    assert_eq!(t.write(0x1014, 0, 4, 0x0C5), Ok(()), "in one write");
    assert_eq!(format!("{:?}", fault(&mut t)), "0C5#0050010100000000");
    t.wait(10);
    t.write(0x1014, 0, 4, 0x3234_5678).unwrap();
    assert_eq!(t.read(0x1014, 0), Ok(0x3234_5678));
    assert_eq!(format!("{:?}", fault(&mut t)), "12345678#0050010100000000");
    t.wait(10);
    t.write(0x1014, 0, 4, 0xB234_5678).unwrap();
    assert_eq!(t.wait_without_samples(200), []);
}

#[test]
fn cob_ids_of_sync_and_emergency_change_in_pre_operational_only() {
    let mut t = mapped();
    t.send("000#0132");
    assert_eq!(t.write(0x1005, 0, 4, 0x81), Err(STATE));
    assert_eq!(t.write(0x1014, 0, 4, 0x8000_00B2), Err(STATE));
    assert_eq!(t.write(0x1005, 0, 4, 0x80), Ok(()), "in force");
    assert_eq!(t.write(0x1014, 0, 4, 0xB2), Ok(()), "in force");
    assert_eq!(t.write(0x1800, 1, 4, 0x8000_01B2), Ok(()));
    t.send("000#8032");
    assert_eq!(t.write(0x1005, 0, 4, 0x81), Ok(()));
    assert_eq!(t.write(0x1014, 0, 4, 0x8000_00B2), Ok(()));
}

#[test]
fn sync_with_an_identifier_of_a_valid_tpdo_or_of_the_emergency_is_not_consumed() {
    let mut t = mapped();
    t.write(0x1800, 2, 1, 1).unwrap();
    t.write(0x1005, 0, 4, 0x2B2).unwrap();
    t.send("000#0132");
    assert_eq!(t.exchange("2B2#").len(), 1, "TPDO 2 is disabled");
    t.map(1, &[0x3000_0008]);
    assert_eq!(t.exchange("2B2#"), [""; 0]);
    assert_eq!(t.exchange("2B2#R1"), ["2B2#04"]);
    t.write(0x1801, 1, 4, 0x8000_02B2).unwrap();
    assert_eq!(t.exchange("2B2#").len(), 1);
    t.send("000#8032");
    t.write(0x1014, 0, 4, 0x2B2).unwrap();
    t.send("000#0132");
    assert_eq!(t.exchange("2B2#"), [""; 0]);
}

#[test]
fn tpdo_disabled_with_new_identifier_leaves_queue() {
    let mut t = mapped();
    t.write(0x1800, 2, 1, 1).unwrap();
    t.write(0x1801, 1, 4, 0x8000_01C5).unwrap();
    t.send("000#0132");
    t.send("080#");
    // The reply is sent, the TPDO with the identifier before is not.
    assert_eq!(t.write(0x1800, 1, 4, 0x8000_01C5), Ok(()));
    assert_eq!(t.sent_text(), [""; 0]);
}

#[test]
fn remote_frame_is_answered_by_tpdo_that_is_sent() {
    let mut t = mapped();
    t.push([1, 2, 0]);
    t.map(1, &[0x3000_0008]);
    // The first TPDO is disabled and has the same identifier.
    t.write(0x1800, 1, 4, 0x8000_02B2).unwrap();
    t.send("000#0132");
    assert_eq!(t.exchange("2B2#R1"), ["2B2#04"]);
    t.write(0x1801, 1, 4, 0x4000_02B2).unwrap();
    assert_eq!(t.exchange("2B2#R1"), [""; 0]);
}
