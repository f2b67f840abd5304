//! The objects of `profile::standard`, and layer setting services with a manufacturer-specific bit timing table.

use super::booted;

#[test]
fn standard_objects_have_the_values_of_the_product() {
    let mut t = booted();
    for (index, sub, value) in [
        (0x1000, 0, 0x0001_019A),
        (0x1001, 0, 0),
        (0x1003, 0, 0),
        (0x1005, 0, 0x80),
        (0x1014, 0, 0x9E),
        (0x1018, 0, 4),
        (0x1018, 1, 0x04D2),
        (0x1018, 2, 0x11),
        (0x1018, 3, 0x0001_0000),
        (0x1018, 4, 0x0403_0201),
        (0x1200, 0, 2),
        (0x1200, 1, 0x61E),
        (0x1200, 2, 0x59E),
    ] {
        assert_eq!(t.read(index, sub), Ok(value), "{index:04X}h:{sub:02X}");
    }
    assert_eq!(t.read_text(0x1008), "TILT-1");
}

#[test]
fn lss_and_sdo_accept_node_id_127() {
    let mut t = booted();
    t.send("7E5#0401000000000000");
    for (request, answer) in [
        ("117F000000000000", "1100000000000000"),
        ("1180000000000000", "1101000000000000"),
        ("1100000000000000", "1101000000000000"),
        ("11FF000000000000", "1100000000000000"),
    ] {
        assert_eq!(
            t.exchange(&format!("7E5#{request}")),
            [format!("7E4#{answer}")]
        );
    }
    assert_eq!(t.write(0x2000, 0, 1, 127), Ok(()));
    assert_eq!(t.write(0x2000, 0, 1, 255), Err(0x0609_0030));
}

#[test]
fn configure_bit_timing_accepts_cia_305_table_and_manufacturer_table() {
    let mut t = booted();
    t.send("7E5#0401000000000000");
    for (table, index, error, rate) in [
        (0, 3, 0, 250),
        (0, 5, 1, 250),
        (128, 1, 0, 125),
        // A reserved index, an index beyond the table, and a bit rate that the product does not permit (800 kbit/s).
        (128, 0, 1, 125),
        (128, 4, 1, 125),
        (0, 1, 1, 125),
        (128, 3, 0, 500),
        (1, 3, 1, 500),
        (129, 3, 1, 500),
    ] {
        let answer = t.exchange(&format!("7E5#13{table:02X}{index:02X}0000000000"));
        assert_eq!(
            answer,
            [format!("7E4#13{error:02X}000000000000")],
            "{table}, {index}"
        );
        assert_eq!(t.read(0x2001, 0), Ok(rate), "{table}, {index}");
    }
}
