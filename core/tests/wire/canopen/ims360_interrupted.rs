//! Transfers and settings of the IMS360 that are interrupted: lost and repeated frames, a master that stops, layer setting services (LSS)
//! in the middle of a transfer, and mapping changes in operational. No hang, no wrong byte, the abort of CiA 301.

use crate::tester::canopen::{abort, in_g};
use crate::tester::ims360::{Ims360Tester, booted};

const TOGGLE: u32 = 0x0503_0000;
const TIME_OUT: u32 = 0x0504_0000;
const UNKNOWN: u32 = 0x0504_0001;
const ACCESS: u32 = 0x0601_0000;

/// The serial number, 2000h:01: two segments.
const SERIAL: &str = "4000200100000000";
const SIZE: &str = "4100200108000000";
const SEGMENTS: [(&str, &str); 2] = [
    ("6000000000000000", "0036373330353938"),
    ("7000000000000000", "1D35000000000000"),
];

/// Reads the serial number completely.
fn assert_reads(tester: &mut Ims360Tester) {
    assert_eq!(tester.sdo(SERIAL), SIZE);
    for (request, reply) in SEGMENTS {
        assert_eq!(tester.sdo(request), reply);
    }
}

/// The master has lost an answer and repeats its request, or its request was lost and it goes on.
#[test]
fn segment_that_is_repeated_or_skipped_is_aborted() {
    let [first, second] = SEGMENTS;
    let mut tester = booted();
    for wrong in [first.0, second.0] {
        assert_eq!(tester.sdo(SERIAL), SIZE);
        if wrong == first.0 {
            assert_eq!(tester.sdo(first.0), first.1);
        }
        assert_eq!(tester.sdo(wrong), abort("002001", TOGGLE), "{wrong}");
        assert_eq!(tester.sdo(first.0), abort("000000", UNKNOWN), "it is over");
        assert_reads(&mut tester);
    }
}

#[test]
fn repeated_initiation_starts_the_transfer_again() {
    let mut tester = booted();
    assert_eq!(tester.sdo(SERIAL), SIZE);
    assert_eq!(tester.sdo(SEGMENTS[0].0), SEGMENTS[0].1);
    assert_reads(&mut tester);
}

#[test]
fn segmented_write_that_is_repeated_is_aborted_and_writes_nothing() {
    let mut tester = booted();
    for _ in 0..2 {
        assert_eq!(tester.sdo("2110320004000000"), "6010320000000000");
    }
    assert_eq!(tester.sdo("0A01000000000000"), "2000000000000000");
    assert_eq!(tester.sdo("0A01000000000000"), abort("103200", TOGGLE));
    assert_eq!(tester.read(0x3210, 0), Ok(0));
    assert_eq!(tester.sdo("2110320004000000"), "6010320000000000");
    assert_eq!(tester.sdo("07E8030000000000"), "2000000000000000");
    assert_eq!(tester.read(0x3210, 0), Ok(1000));
}

#[test]
fn master_that_stops_in_a_segmented_transfer_gets_time_out_after_1_s() {
    for (requests, object) in [
        (&[SERIAL][..], "002001"),
        (&[SERIAL, SEGMENTS[0].0], "002001"),
        (&["2110320004000000"], "103200"),
        (&["2110320004000000", "0A01000000000000"], "103200"),
    ] {
        let mut tester = booted();
        for request in requests {
            tester.sdo(request);
        }
        let expected = format!("5B2#{}", abort(object, TIME_OUT));
        assert_eq!(tester.wait_text(2_000), [(1_000, expected)], "{requests:?}");
        assert_eq!(tester.read(0x3210, 0), Ok(0));
        assert_reads(&mut tester);
    }
}

/// Switch state global, configuration; configure node-ID 60; waiting.
const NODE_ID_60: [&str; 3] = [
    "7E5#0401000000000000",
    "7E5#113C000000000000",
    "7E5#0400000000000000",
];

/// Object 1008h, upload in blocks of one segment: the transfer waits for the acknowledgement of the only segment.
#[test]
fn new_node_id_by_lss_in_a_block_upload_acts_with_the_reset_and_ends_the_upload() {
    let mut tester = booted();
    assert_eq!(
        tester.exchange("632#A408100001000000"),
        ["5B2#C608100006000000"]
    );
    let [configuration, node_id, waiting] = NODE_ID_60;
    assert_eq!(tester.exchange(configuration), [""; 0]);
    assert_eq!(
        tester.exchange("632#A300000000000000"),
        ["5B2#81494D5333363000"]
    );
    assert_eq!(tester.exchange(node_id), ["7E4#1100000000000000"]);
    assert_eq!(tester.exchange(waiting), [""; 0]);
    let ended = ["5B2#C500000000000000".to_string()];
    let mut end = tester.exchange("632#A201010000000000");
    // The CRC has its own tests.
    end[0].replace_range(6..10, "0000");
    assert_eq!(end, ended);
    assert_eq!(tester.exchange("000#8232"), ["73C#00"]);
    assert_eq!(tester.exchange("632#A100000000000000"), [""; 0]);
    tester.node_id = 60;
    assert_eq!(tester.sdo("A100000000000000"), abort("000000", UNKNOWN));
    assert_reads(&mut tester);
}

#[test]
fn activation_of_a_bit_rate_in_a_transfer_is_silent_and_ends_it() {
    let mut tester = booted();
    tester.write(0x1017, 0, 2, 10).unwrap();
    tester.write(0x1800, 2, 1, 1).unwrap();
    tester.send("000#0132");
    assert_eq!(tester.sdo(SERIAL), SIZE);
    tester.send("7E5#0401000000000000");
    let timing = tester.exchange("7E5#1300040000000000");
    assert_eq!(timing, ["7E4#1300000000000000"]);
    // 250 kbit/s after 50 ms.
    tester.send("7E5#1532000000000000");
    for request in ["632#6000000000000000", "080#", "1B2#R8"] {
        assert_eq!(tester.exchange(request), [""; 0], "{request}");
    }
    assert_eq!(tester.wait_text(99), []);
    assert_eq!(tester.wait_text(1), [(1, "732#00".to_string())]);
    let [(first, _), _] = SEGMENTS;
    assert_eq!(tester.sdo(first), abort("000000", UNKNOWN));
    assert_reads(&mut tester);
}

/// 6.1.3 step by step in operational, with each wrong step before the right one, and a SYNC after each.
#[test]
fn mapping_change_in_operational_sends_old_or_new_bytes_and_nothing_else() {
    let mut tester = booted();
    tester.force = in_g([0.0, 0.5, 0.866]);
    tester.settle_at([0.0, 0.5, 0.866]);
    let lateral = tester.read(0x6120, 0).unwrap().to_le_bytes();
    let lateral: String = lateral.map(|byte| format!("{byte:02X}")).concat();
    for number in [0x1800, 0x1801] {
        tester.write(number, 2, 1, 1).unwrap();
    }
    tester.write(0x1801, 1, 4, 0x2B2).unwrap();
    tester.send("000#0132");
    let first = format!("1B2#00000000{lateral}");
    let whole = format!("2B2#00000000{lateral}");
    tester.map(1, &[0x6110_0020, 0x6120_0020]);
    assert_eq!(tester.exchange("080#"), [first.as_str(), &whole]);

    let (x, y) = (0x6110_0020, 0x6120_0020);
    let sub = [(0x1A01, 0, 1, 1), (0x1A01, 1, 4, y), (0x1A01, 0, 1, 0)];
    for (index, sub, size, value) in sub {
        assert_eq!(tester.write(index, sub, size, value), Err(ACCESS), "valid");
        assert_eq!(tester.exchange("080#"), [first.as_str(), &whole]);
    }
    let off = [
        (0x1801, 1, 4, 0x8000_02B2, Ok(())),
        (0x1A01, 1, 4, y, Err(ACCESS)),
        (0x1A01, 0, 1, 0, Ok(())),
        (0x1A01, 1, 4, 0x6111_0008, Err(0x0604_0041)),
        (0x1A01, 1, 4, y, Ok(())),
        (0x1A01, 2, 4, x, Ok(())),
        (0x1A01, 3, 4, x, Ok(())),
        (0x1A01, 0, 1, 3, Err(0x0604_0042)),
        (0x1A01, 0, 1, 1, Ok(())),
    ];
    for (index, sub, size, value, result) in off {
        let written = tester.write(index, sub, size, value);
        assert_eq!(written, result, "{index:04X}h:{sub} = {value:08X}h");
        assert_eq!(tester.exchange("080#"), [first.as_str()], "TPDO 2 is off");
    }
    assert_eq!(tester.write(0x1801, 1, 4, 0x2B2), Ok(()));
    let new = format!("2B2#{lateral}");
    assert_eq!(tester.exchange("080#"), [first.as_str(), &new]);
    assert_eq!(tester.exchange("2B2#R4"), [new.as_str()]);
}
