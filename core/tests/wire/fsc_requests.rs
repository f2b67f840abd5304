//! Requests and replies of the FSC sensors, accepted and refused (manual 9.5, 9.7, 9.10).
//!
//! Section and table numbers refer to the English manual of 2021.

use plumbline::application::Application;
use plumbline::can::{Frame, extended, standard};
use plumbline::fsc::table::{Operation, Source};
use plumbline::fsc::{Article, Product};
use plumbline::measure::ONE_G;
use plumbline::model::catalog;
use plumbline::model::gemac::is1::{self, OneAxis};
use plumbline::model::gemac::is2::{self, TwoAxes};
use plumbline::node::Action;
use plumbline::param::Table;

type TableOf<P> = <<P as Product>::Application as Application>::Table;
use crate::tester::fsc::*;

/// The writes that must be accepted, with the code that reads the value back.
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

/// The writes that must be refused.
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
fn read_codes_return_values_of_tables_18_and_19() {
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
        // Further data bytes are ignored.
        if request != 0xFF {
            assert_eq!(tester.ask(&[request, 1, 2, 3, 4, 5, 6, 7]), reply);
        }
    }
}

#[test]
fn one_axis_sensor_has_unsigned_angle_and_no_y() {
    let mut tester = is1();
    assert_eq!(tester.ask(&[0x00]), [0x00, DELIVERED, 0, 0]);
    tester.rest(-ONE_G, 0, 0); // 90 deg to the left: 270 deg
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
fn boundary_values_are_accepted_and_read_back() {
    for (code, data) in ACCEPTED {
        let mut tester = is2();
        assert_eq!(tester.ask(&request(*code, data)).len(), 2);
        let reply = tester.ask(&[code - 0x10]);
        assert_eq!(reply[2..], **data, "{code:02X}h");
        assert_eq!(reply[1] & CMD_PARAM_ERROR, 0);
    }
}

#[test]
fn refused_request_sets_error_once_and_changes_nothing() {
    for (code, data) in REFUSED {
        let mut tester = is2();
        let all = |tester: &mut FscTester<TwoAxes>| {
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
        // Sticky until the status is read.
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
fn frame_without_data_sets_error_without_reply() {
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
fn status_bits_follow_parameters() {
    let mut tester = is2();
    // The reply to a write contains the status after the write.
    assert_eq!(tester.ask(&[0x23, 6]), [0x23, 0]);
    assert_eq!(tester.ask(&[0x23, 0]), [0x23, DELIVERED]);
    assert_eq!(tester.ask(&[0x25, 1, 0]), [0x25, AUTOBAUD]);
    assert_eq!(tester.ask(&[0x25, 250, 0]), [0x25, DELIVERED]);
}

/// Checks that the device matches the tables from which descriptors are generated.
fn check_tables<P: Product>(article: &'static Article) {
    let parameters = TableOf::<P>::PARAMETERS;
    let quantities = <P::Application as Application>::QUANTITIES;
    let size = |source: Source| usize::from(source.data_type(parameters, quantities).size());
    let mut tester: FscTester<P> = online(article);
    tester.ask(&[0x26, 1]); // with the counter in 00h
    for function in P::FUNCTIONS {
        let name = function.name;
        let expected = 2 + function
            .reply
            .iter()
            .map(|field| size(field.source))
            .sum::<usize>();
        if function.signature.is_empty() || function.operation == Operation::Alive {
            assert_eq!(tester.ask(&[function.code]).len(), expected, "{name}");
        } else {
            let reply = tester.ask(&request(function.code, function.signature));
            assert_eq!(reply.len(), expected, "{name}");
            assert_eq!(reply[1] & CMD_PARAM_ERROR, 0, "{name}");
        }
    }
    for access in P::ACCESS {
        let reply = tester.ask(&[access.read]);
        let factory = access.parameters.iter().flat_map(|id| {
            let bytes = parameters[usize::from(id.0)].factory.to_le_bytes();
            bytes.into_iter().take(size(Source::Parameter(*id)))
        });
        assert_eq!(reply[2..], factory.collect::<Vec<u8>>(), "{}", access.name);
        let written = tester.ask(&request(access.write, &reply[2..]));
        assert_eq!(written[1] & CMD_PARAM_ERROR, 0, "{}", access.name);
    }
    tester.silent(b"\xFFRESET");
    assert!(tester.actions.contains(&Action::Restart));
}

#[test]
fn replies_match_all_rows_of_tables() {
    check_tables::<OneAxis>(&is1::BP_CL);
    check_tables::<TwoAxes>(&is2::BP_CL);
}

#[test]
fn article_numbers_match_table_26() {
    let articles = |product: &str| -> Vec<_> {
        let product = catalog::find(product).unwrap();
        let pair = |article: catalog::Article| (article.name, article.number);
        product.articles().map(pair).collect()
    };
    assert_eq!(
        articles("is1"),
        [
            ("IS1BP360-C-CL", "PR-23050-30"),
            ("IS1MA360-C-BL", "PR-25000-00"),
            ("IS1BP360-C-BL", "PR-25050-30"),
            ("IS1SP360-C-BL", "PR-23060-00"),
            ("IS1SP360-C-BL-10", "PR-23060-10"),
        ]
    );
    assert_eq!(
        articles("is2"),
        [
            ("IS2BP090-C-CL", "PR-23054-30"),
            ("IS2MA090-C-BL", "PR-25004-00"),
            ("IS2BP090-C-BL", "PR-25054-30"),
            ("IS2SP090-C-BL", "PR-23064-00"),
            ("IS2SP090-C-BL-10", "PR-23064-10"),
        ]
    );
}
