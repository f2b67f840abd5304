//! Requests and refusals of the FSC sensors on the wire: these bytes in, those bytes out (manual 9.5, 9.7, 9.10).
//!
//! Sections and tables are those of the English manual of 2021.

#![allow(
    clippy::inconsistent_digit_grouping,
    reason = "article numbers as they are printed"
)]

mod tester;

use plumbline::can::{Frame, extended, standard};
use plumbline::fsc::table::Field;
use plumbline::fsc::{Model, Product};
use plumbline::measure::ONE_G;
use plumbline::model::is1::{self, OneAxis};
use plumbline::model::is2::{self, TwoAxes};
use plumbline::node::Action;
use tester::*;

/// Each write that must be accepted, with the code that reads it back.
const ACCEPTED: &[(u8, &[u8])] = &[
    (0x20, &[0x61, 0x03, 0, 0x80]),
    (0x20, &[0xFF, 0x07, 0, 0]),
    (0x20, &[0, 0, 0, 0]),
    (0x20, &[0x00, 0x03, 0, 0x80]),
    (0x21, &[0xFF, 0xFF, 0xFF, 0x9F]),
    (0x22, &[0x80, 0, 0, 0]),
    (0x23, &[0]),
    (0x23, &[10]),
    (0x24, &[0]),
    (0x24, &[1]),
    (0x25, &[1, 0]),
    (0x25, &[0xFF, 0xFF]),
    (0x27, &[100, 0, 0]),
    (0x27, &[0xA8, 0x61, 0]),
    (0x27, &[100, 0, 1]),
    (0x27, &[0xA8, 0x61, 1]),
    (0x27, &[100, 0, 2]),
    (0x27, &[0x40, 0x1F, 2]),
    (0x28, &[0x28, 0x23]),
    (0x28, &[0xD8, 0xDC]),
    (0x29, &[0x28, 0x23]),
    (0x29, &[0xD8, 0xDC]),
];

/// Each write that must be refused.
const REFUSED: &[(u8, &[u8])] = &[
    (0x20, &[0x01, 0x03, 0, 0]),       // the Reply-Parameter-ID
    (0x20, &[0x00, 0x01, 0, 0]),       // the Sync-ID
    (0x21, &[0x00, 0x03, 0, 0]),       // the Set-Parameter-ID
    (0x22, &[0x01, 0x03, 0, 0]),       // the Reply-Parameter-ID
    (0x20, &[0x00, 0x08, 0, 0]),       // 12 bits in an 11-bit identifier
    (0x20, &[0x00, 0x04, 0, 0x40]),    // a bit between identifier and format
    (0x20, &[0xFF, 0xFF, 0xFF, 0xBF]), // 30 bits in a 29-bit identifier
    (0x23, &[11]),
    (0x24, &[2]),
    (0x25, &[0, 0]),
    (0x26, &[2]),
    (0x27, &[99, 0, 0]),
    (0x27, &[99, 0, 1]),
    (0x27, &[0xA9, 0x61, 0]),
    (0x27, &[0xA9, 0x61, 1]),
    (0x27, &[0x41, 0x1F, 2]),
    (0x27, &[0xD0, 0x07, 3]),
    (0x28, &[0x29, 0x23]),
    (0x28, &[0xD7, 0xDC]),
    (0x29, &[0x29, 0x23]),
    (0x29, &[0x00, 0x80]),
    // Too short.
    (0x20, &[0x00, 0x04, 0]),
    (0x21, &[]),
    (0x23, &[]),
    (0x25, &[1]),
    (0x26, &[]),
    (0x27, &[0xD0, 0x07]),
    (0x28, &[1]),
    (0x29, &[1]),
    // Signatures.
    (0x40, b"LOA"),
    (0x40, b"load"),
    (0x40, &[]),
    (0x50, b"SAV"),
    (0x50, b"LOAD"),
    // Codes that do not exist.
    (0x01, &[]),
    (0x05, &[]),
    (0x0F, &[]),
    (0x1A, &[]),
    (0x2A, &[0, 0]),
    (0x30, &[]),
    (0x60, b"SAVE"),
    (0xFE, &[]),
];

#[test]
fn every_code_reads_what_tables_18_and_19_say() {
    let mut tester = is2();
    let s = DELIVERED;
    for (request, reply) in [
        (0x00, vec![0x00, s, 0, 0, 0, 0]),
        (0x02, vec![0x02, s]),
        (0x03, vec![0x03, s, 0x96, 0x2D, 0x23, 0, 1, 0]),
        (0x04, vec![0x04, s, 1, 2, 3, 4, 0x44, 0x03]),
        (0x10, vec![0x10, s, 0x00, 0x03, 0, 0]),
        (0x11, vec![0x11, s, 0x01, 0x03, 0, 0]),
        (0x12, vec![0x12, s, 0x00, 0x01, 0, 0]),
        (0x13, vec![0x13, s, 0]),
        (0x14, vec![0x14, s, 0]),
        (0x15, vec![0x15, s, 250, 0]),
        (0x16, vec![0x16, s, 0]),
        (0x17, vec![0x17, s, 0xD0, 0x07, 2]),
        (0x18, vec![0x18, s, 0, 0]),
        (0x19, vec![0x19, s, 0, 0]),
        (0xFF, vec![0xFF, s, 0x00, 0x03, 0, 0, 0x44, 0x03]),
    ] {
        assert_eq!(tester.ask(&[request]), reply);
        // Further data bytes are discarded.
        if request != 0xFF {
            assert_eq!(tester.ask(&[request, 1, 2, 3, 4, 5, 6, 7]), reply);
        }
    }
}

#[test]
fn the_one_axis_sensor_has_an_unsigned_angle_and_no_y() {
    let mut tester = is1();
    assert_eq!(tester.ask(&[0x00]), [0x00, DELIVERED, 0, 0]);
    tester.rest(-ONE_G, 0, 0); // a quarter turn to the left: 270 deg
    assert_eq!(tester.ask(&[0x00]), [0x00, DELIVERED, 0x78, 0x69]);
    assert_eq!(tester.ask(&[0x03])[2..6], 2_305_030_u32.to_le_bytes());
    for code in [0x19, 0x29] {
        assert_eq!(
            tester.ask(&[code, 0, 0]),
            [code, DELIVERED | CMD_PARAM_ERROR]
        );
        tester.ask(&[0x02]);
    }
}

#[test]
fn every_boundary_value_is_accepted_and_read_back() {
    for (code, data) in ACCEPTED {
        let mut tester = is2();
        assert_eq!(tester.ask(&request(*code, data)).len(), 2);
        let reply = tester.ask(&[code - 0x10]);
        assert_eq!(reply[2..], **data, "{code:02X}h");
        assert_eq!(reply[1] & CMD_PARAM_ERROR, 0);
    }
}

#[test]
fn every_refusal_is_told_once_and_changes_nothing() {
    for (code, data) in REFUSED {
        let mut tester = is2();
        let all = |tester: &mut Tester<TwoAxes>| {
            (0x10..=0x19)
                .map(|code| tester.ask(&[code]))
                .collect::<Vec<_>>()
        };
        let before = all(&mut tester);
        let status = DELIVERED | CMD_PARAM_ERROR;
        assert_eq!(
            tester.ask(&request(*code, data)),
            [*code, status],
            "{code:02X}h {data:02X?}"
        );
        // Sticky until the status has been read.
        assert_eq!(tester.ask(&[0x10])[1], status);
        assert_eq!(tester.ask(&[0x02]), [0x02, status]);
        assert_eq!(tester.ask(&[0x02]), [0x02, DELIVERED]);
        assert_eq!(all(&mut tester), before);
        assert!(
            !tester.actions.contains(&Action::Save) && !tester.actions.contains(&Action::Restart)
        );
    }
}

#[test]
fn a_frame_without_data_sets_the_error_and_has_no_reply() {
    let mut tester = is2();
    tester.silent(&[]);
    assert_eq!(tester.ask(&[0x02]), [0x02, DELIVERED | CMD_PARAM_ERROR]);
}

#[test]
fn remote_frames_and_other_identifiers_are_ignored() {
    let mut tester = is2();
    for frame in [
        Frame::remote(standard(0x300), 1),
        Frame::remote(standard(0x100), 0),
        Frame::data(extended(0x300), &[0]),
        Frame::data(extended(0x100), &[]),
        Frame::data(standard(0x301), &[0]),
        Frame::data(standard(0x100), &[0]), // a sync frame has no data
    ] {
        tester.receive(frame.unwrap());
        assert_eq!(tester.sent(), []);
    }
    assert_eq!(tester.ask(&[0x02]), [0x02, DELIVERED]);
}

#[test]
fn status_bits_follow_the_parameters() {
    let mut tester = is2();
    // The reply to a write shows the status after it.
    assert_eq!(tester.ask(&[0x23, 6]), [0x23, 0]);
    assert_eq!(tester.ask(&[0x23, 0]), [0x23, DELIVERED]);
    assert_eq!(tester.ask(&[0x25, 1, 0]), [0x25, AUTOBAUD]);
    assert_eq!(tester.ask(&[0x25, 250, 0]), [0x25, DELIVERED]);
}

/// The tables that descriptors are written from say what the device does.
fn the_tables_are_the_devices<M: Model>(product: &'static Product) {
    let size = |fields: &[Field]| {
        fields
            .iter()
            .map(|field| usize::from(field.size))
            .sum::<usize>()
    };
    let mut tester: Tester<M> = Tester::online(product);
    tester.ask(&[0x26, 1]); // with the counter in 00h
    for function in M::FUNCTIONS {
        if function.signature.is_empty() || function.fsc == 0xFF {
            assert_eq!(
                tester.ask(&[function.fsc]).len(),
                2 + size(function.reply),
                "{}",
                function.name
            );
        } else {
            let reply = tester.ask(&request(function.fsc, function.signature));
            assert_eq!(reply.len(), 2 + size(function.reply), "{}", function.name);
            assert_eq!(reply[1] & CMD_PARAM_ERROR, 0, "{}", function.name);
        }
    }
    for parameter in M::PARAMETERS {
        let reply = tester.ask(&[parameter.read_code()]);
        assert_eq!(
            reply.len(),
            2 + size(parameter.fields),
            "{}",
            parameter.name
        );
        assert_eq!(
            reply[2..],
            parameter.factory.to_le_bytes()[..size(parameter.fields)]
        );
        let written = tester.ask(&request(parameter.write_code(), &reply[2..]));
        assert_eq!(written[1] & CMD_PARAM_ERROR, 0, "{}", parameter.name);
    }
    tester.silent(b"\xFFRESET");
    assert!(tester.actions.contains(&Action::Restart));
}

#[test]
fn every_row_of_the_tables_is_what_the_device_does() {
    the_tables_are_the_devices::<OneAxis>(&is1::BP_CL);
    the_tables_are_the_devices::<TwoAxes>(&is2::BP_CL);
}

#[test]
fn article_numbers_are_those_of_table_26() {
    let articles = |products: &[&Product]| -> Vec<_> {
        products
            .iter()
            .map(|product| (product.name, product.article))
            .collect()
    };
    assert_eq!(
        articles(&is1::PRODUCTS),
        [
            ("IS1BP360-C-CL", 23050_30),
            ("IS1MA360-C-BL", 25000_00),
            ("IS1BP360-C-BL", 25050_30),
            ("IS1SP360-C-BL", 23060_00),
            ("IS1SP360-C-BL-10", 23060_10),
        ]
    );
    assert_eq!(
        articles(&is2::PRODUCTS),
        [
            ("IS2BP090-C-CL", 23054_30),
            ("IS2MA090-C-BL", 25004_00),
            ("IS2BP090-C-BL", 25054_30),
            ("IS2SP090-C-BL", 23064_00),
            ("IS2SP090-C-BL-10", 23064_10),
        ]
    );
}
