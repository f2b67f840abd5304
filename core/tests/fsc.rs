//! What the manual says of the FSC sensors, on the wire: these bytes in, those bytes out.
//!
//! Sections and tables are those of the English manual of 2021.

mod tester;

use plumbline::can::{BitRate, Frame, extended, standard};
use plumbline::measure::ONE_G;
use plumbline::model::is1::{self, OneAxis};
use plumbline::model::is2::{self, TwoAxes};
use plumbline::model::{is1d, is2d};
use plumbline::node::{Action, BusEvent, BusMode, BusState, Leds, Node};
use plumbline::store::{Loaded, Payload, StoreError};
use tester::Tester;

/// DefaultParam and AutobaudDetection, as delivered.
const DELIVERED: u8 = 0x03;
const AUTOBAUD: u8 = 0x02;
const CMD_PARAM_ERROR: u8 = 0x08;
const EEPROM_ERROR: u8 = 0x04;

fn is2() -> Tester<TwoAxes> {
    Tester::online(&is2::BP_CL)
}

fn is1() -> Tester<OneAxis> {
    let mut tester = Tester::online(&is1::BP_CL);
    tester.rest(0, ONE_G, 0);
    tester
}

#[test]
fn boot_up_comes_twice_after_the_frame_that_reveals_the_rate() {
    let mut tester: Tester<TwoAxes> = Tester::power_up(&is2::BP_CL);
    assert_eq!(
        tester.actions,
        [
            Action::Leds(Leds {
                run: true,
                error: false
            }),
            Action::Bus(BusMode::Listen, BitRate::K250)
        ]
    );
    assert_eq!(tester.wait(10_000), [], "silent while it searches");
    tester.bus(BusEvent::Error);
    let Some(&Action::Bus(BusMode::Listen, rate)) = tester.actions.last() else {
        panic!("{:?}", tester.actions)
    };
    // A poll reveals the rate: it is not answered, the sensor was silent.
    tester.receive(Frame::data(standard(0x300), &[0]).unwrap());
    assert!(tester.actions.contains(&Action::Bus(BusMode::Normal, rate)));
    let boot_up = Frame::data(
        standard(0x301),
        &[0xFF, DELIVERED, 0x00, 0x03, 0, 0, 0x44, 0x03],
    )
    .unwrap();
    assert_eq!(tester.sent(), [boot_up, boot_up]);
    assert_eq!(
        tester.leds,
        Leds {
            run: true,
            error: false
        }
    );
}

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
fn older_types_write_their_version_as_a_number() {
    let mut tester: Tester<TwoAxes> = Tester::online(&is2d::PLASTIC);
    assert_eq!(tester.ask(&[0x04])[6..], [103, 0]);
    let mut tester: Tester<OneAxis> = Tester::online(&is1d::PLASTIC);
    assert_eq!(tester.ask(&[0xFF])[6..], [103, 0]);
}

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

fn request(code: u8, data: &[u8]) -> Vec<u8> {
    [&[code], data].concat()
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

#[test]
fn identifiers_wait_for_the_restart_and_clash_with_written_ones() {
    let mut tester = is2();
    tester.ask(&[0x20, 0x00, 0x04, 0, 0]); // 400h from the next restart on
    tester.ask(&[0x22, 0x00, 0x03, 0, 0]); // 300h is free now
    assert_eq!(tester.ask(&[0x12])[2..], [0x00, 0x03, 0, 0]);
    // 300h is still the identifier in force, and the alive frame names it.
    assert_eq!(
        tester.ask(&[0xFF]),
        [0xFF, AUTOBAUD, 0x00, 0x03, 0, 0, 0x44, 0x03]
    );
    // Without a save the restart brings the old ones back.
    tester.silent(b"\xFFRESET");
    assert!(tester.actions.contains(&Action::Restart));
    tester.power_cycle();
    assert_eq!(tester.memory, None);
}

#[test]
fn saved_parameters_are_in_force_after_a_power_cycle() {
    let mut tester = is2();
    tester.ask(&[0x20, 0x61, 0x03, 0, 0x80]);
    tester.ask(&[0x21, 0x62, 0x03, 0, 0x80]);
    tester.ask(&[0x23, 7]);
    assert_eq!(tester.ask(b"\x50SAVE and more"[..8].into()), [0x50, 0]);
    tester.actions.clear();
    tester.power_cycle();
    assert!(
        tester
            .actions
            .contains(&Action::Bus(BusMode::Normal, BitRate::K500))
    );
    let boot_up =
        Frame::data(extended(0x362), &[0xFF, 0, 0x61, 0x03, 0, 0x80, 0x44, 0x03]).unwrap();
    assert_eq!(tester.sent(), [boot_up, boot_up]);
    tester.receive(Frame::data(extended(0x361), &[0x00]).unwrap());
    assert_eq!(
        tester.sent(),
        [Frame::data(extended(0x362), &[0, 0, 0, 0, 0, 0]).unwrap()]
    );
    let filters = tester.sensor.filters();
    assert!(filters.iter().any(|filter| filter.accepts(extended(0x361))));
    assert!(filters.iter().any(|filter| filter.accepts(standard(0x100))));
    assert!(!filters.iter().any(|filter| filter.accepts(standard(0x300))));
}

#[test]
fn load_acts_at_once_but_for_identifiers_and_baud_rate() {
    let mut tester = is2();
    for write in [
        &[0x20, 0, 4, 0, 0][..],
        &[0x23, 6],
        &[0x28, 100, 0],
        &[0x25, 10, 0],
        &[0x26, 1],
    ] {
        tester.ask(write);
    }
    tester.ask(b"\x50SAVE");
    tester.power_cycle();
    tester.sent();
    tester.receive(Frame::data(standard(0x400), b"\x40LOAD").unwrap());
    assert_eq!(
        tester.sent(),
        [Frame::data(standard(0x301), &[0x40, DELIVERED]).unwrap()]
    );
    assert_eq!(tester.wait(1000), [], "cyclic mode is off");
    // 400h is in force until the restart; what is read is the factory value.
    tester.receive(Frame::data(standard(0x400), &[0x10]).unwrap());
    assert_eq!(tester.sent()[0].bytes(), [0x10, DELIVERED, 0, 3, 0, 0]);
    tester.power_cycle();
    assert!(
        tester
            .actions
            .contains(&Action::Bus(BusMode::Listen, BitRate::K250))
    );
}

#[test]
fn a_memory_that_fails_is_told_and_nothing_changes() {
    let mut tester = is2();
    tester.ask(&[0x28, 100, 0]);
    tester.memory_works = Some(false);
    let status = AUTOBAUD | CMD_PARAM_ERROR | EEPROM_ERROR;
    assert_eq!(tester.ask(b"\x50SAVE"), [0x50, status]);
    assert_eq!(tester.ask(&[0x02]), [0x02, status]);
    assert_eq!(tester.ask(&[0x02]), [0x02, AUTOBAUD]);
    assert_eq!(tester.ask(b"\x40LOAD"), [0x40, status]);
    assert_eq!(tester.ask(&[0x18])[2..], [100, 0]);
}

#[test]
fn damaged_memory_gives_factory_values_and_the_error() {
    let damaged = Loaded {
        payload: None,
        damaged: true,
    };
    // An image whose values are not permitted, behind a CRC that is right.
    let nonsense = Loaded {
        payload: Payload::from_slice(&[0xEE; 60]).ok(),
        damaged: false,
    };
    for loaded in [damaged, nonsense] {
        let mut tester: Tester<TwoAxes> = Tester::with_memory(&is2::BP_CL, loaded);
        tester.receive(Frame::data(standard(0x300), &[0]).unwrap());
        assert_eq!(
            tester.sent()[0].bytes()[..2],
            [0xFF, DELIVERED | EEPROM_ERROR]
        );
        assert_eq!(tester.ask(&[0x02]), [0x02, DELIVERED | EEPROM_ERROR]);
        assert_eq!(tester.ask(&[0x02]), [0x02, DELIVERED]);
    }
}

#[test]
fn a_save_stalls_nothing_but_the_next_save() {
    let mut tester = is2();
    tester.memory_works = None;
    tester.silent(b"\x50SAVE");
    // Polls and syncs are answered while the memory works.
    assert_eq!(tester.ask(&[0x00])[0], 0x00);
    tester.receive(Frame::data(standard(0x100), &[]).unwrap());
    assert_eq!(tester.sent().len(), 1);
    // A second save and a reset wait for the first one.
    tester.silent(b"\x50SAVE");
    assert!(!tester.sensor.ready());
    tester.finish_save(Ok(()));
    assert!(tester.sensor.ready());
    assert_eq!(tester.sent().len(), 1);
    tester.silent(b"\xFFRESET");
    assert!(!tester.actions.contains(&Action::Restart));
    tester.finish_save(Err(StoreError));
    assert_eq!(tester.sent()[0].bytes()[0], 0x50);
    tester.wait(0);
    assert!(tester.actions.contains(&Action::Restart));
}

#[test]
fn alive_frames_and_resets() {
    let mut tester = is2();
    let alive = |status| [0xFF, status, 0x00, 0x03, 0, 0, 0x44, 0x03];
    assert_eq!(tester.ask(&[0xFF]), alive(DELIVERED));
    for data in [&b"R"[..], b"RESE", b"RESEt", b"reset", b"LOAD"] {
        assert_eq!(
            tester.ask(&request(0xFF, data)),
            alive(DELIVERED | CMD_PARAM_ERROR)
        );
        tester.ask(&[0x02]);
    }
    assert!(!tester.actions.contains(&Action::Restart));
    // Replies still in the queue go out before the restart.
    tester.receive(Frame::data(standard(0x300), &[0x02]).unwrap());
    tester.receive(Frame::data(standard(0x300), b"\xFFRESET!!").unwrap());
    assert!(!tester.actions.contains(&Action::Restart));
    assert_eq!(tester.sent().len(), 1);
    assert_eq!(tester.actions.last(), Some(&Action::Restart));
    assert_eq!(tester.leds, Leds::default());
}

#[test]
fn the_three_modes_work_at_once() {
    let mut tester = is2();
    let s = AUTOBAUD;
    assert_eq!(tester.ask(&[0x25, 10, 0]), [0x25, s]);
    assert_eq!(tester.ask(&[0x26, 1]), [0x26, s]);
    // The counter is in every reply while cyclic mode is on, and starts at 0.
    assert_eq!(tester.ask(&[0x00]), [0, s, 0, 0, 0, 0, 0, 0]);
    let start = tester.now.ticks() / 1000;
    let frames = tester.wait(35);
    let expected = |period: u8| {
        (
            start + u64::from(period) * 10,
            vec![0, s, 0, 0, 0, 0, period, 0],
        )
    };
    let got: Vec<_> = frames
        .iter()
        .map(|(ms, frame)| (*ms, frame.bytes().to_vec()))
        .collect();
    assert_eq!(got, [expected(1), expected(2), expected(3)]);
    tester.receive(Frame::data(standard(0x100), &[]).unwrap());
    assert_eq!(tester.sent()[0].bytes(), [0, s, 0, 0, 0, 0, 3, 0]);
    // On again changes nothing, off takes the counter away, on again starts at 0.
    tester.ask(&[0x26, 1]);
    assert_eq!(tester.ask(&[0x00])[6..], [3, 0]);
    tester.ask(&[0x26, 0]);
    assert_eq!(tester.ask(&[0x00]), [0, s, 0, 0, 0, 0]);
    tester.ask(&[0x26, 1]);
    assert_eq!(tester.ask(&[0x00])[6..], [0, 0]);
}

#[test]
fn a_cyclic_value_that_could_not_be_sent_gives_way_to_the_newest() {
    let mut tester = is2();
    tester.ask(&[0x25, 10, 0]);
    tester.ask(&[0x26, 1]);
    for _ in 0..1000 {
        tester.now += plumbline::time::millis(10);
        assert_eq!(tester.sensor.poll(tester.now), None);
    }
    let sent = tester.sent();
    assert_eq!(sent.len(), 1);
    assert_eq!(sent[0].bytes()[6..], 1000_u16.to_le_bytes());
}

#[test]
fn cyclic_mode_is_saved_and_begins_after_boot_up() {
    let mut tester = is2();
    tester.ask(&[0x26, 1]);
    tester.ask(b"\x50SAVE");
    tester.power_cycle();
    assert_eq!(tester.wait(5000), [], "silent until it has heard traffic");
    tester.receive(Frame::data(standard(0x7FF), &[]).unwrap());
    let start = tester.now.ticks() / 1000;
    let frames = tester.wait(260);
    let times: Vec<_> = frames
        .iter()
        .map(|(ms, frame)| (*ms - start, frame.bytes()[0]))
        .collect();
    assert_eq!(times, [(0, 0xFF), (0, 0xFF), (250, 0)]);
    assert_eq!(frames[2].1.bytes()[6..], [1, 0]);
}

#[test]
fn zero_point_adjustment_adds_the_offset() {
    let mut tester = is2();
    // -30 deg about Y: X is asin(0.5) = 30 deg with g = (-ux, uy, uz).
    tester.rest(-ONE_G / 2, 0, 232_471_924);
    assert_eq!(tester.ask(&[0x00])[2..], [0xB8, 0x0B, 0, 0]);
    tester.ask(&[0x28, 0x9C, 0xFF]); // -1.00 deg
    assert_eq!(tester.ask(&[0x00])[2..4], 2900_i16.to_le_bytes());
    // The sum is kept within +-90 deg.
    tester.ask(&[0x28, 0x28, 0x23]);
    assert_eq!(tester.ask(&[0x00])[2..4], 9000_i16.to_le_bytes());
    // Automatic: the negative measured value, whatever the offset was.
    assert_eq!(tester.ask(&[0x28]), [0x28, AUTOBAUD]);
    assert_eq!(tester.ask(&[0x18])[2..], (-3000_i16).to_le_bytes());
    assert_eq!(tester.ask(&[0x00])[2..], [0, 0, 0, 0]);
    tester.ask(&[0x29]);
    assert_eq!(tester.ask(&[0x19])[2..], [0, 0]);
}

#[test]
fn the_one_axis_zero_offset_wraps() {
    let mut tester = is1();
    tester.rest(ONE_G, 0, 0); // 90 deg
    tester.ask(&[0x28, 0x9F, 0x8C]); // 359.99 deg
    assert_eq!(tester.ask(&[0x00])[2..], 8999_u16.to_le_bytes());
    assert_eq!(
        tester.ask(&[0x28, 0xA0, 0x8C])[1] & CMD_PARAM_ERROR,
        CMD_PARAM_ERROR
    );
    tester.ask(&[0x28]);
    assert_eq!(tester.ask(&[0x18])[2..], 27_000_u16.to_le_bytes());
    assert_eq!(tester.ask(&[0x00])[2..], [0, 0]);
}

#[test]
fn sensor_errors_come_and_go_with_the_measured_angle() {
    let status = |tester: &mut Tester<TwoAxes>| tester.ask(&[0x02])[1];
    let mut tester = is2();
    // Up vector at 84.9 and 85.1 deg about each axis; sin and cos from a table.
    let (inside, outside) = ((267_373_000, 23_863_000), (267_454_000, 22_929_000));
    tester.rest(inside.0, 0, inside.1);
    assert_eq!(status(&mut tester), DELIVERED);
    tester.rest(outside.0, 0, outside.1);
    assert_eq!(status(&mut tester), DELIVERED | 0x10);
    tester.rest(0, -outside.0, outside.1);
    assert_eq!(status(&mut tester), DELIVERED | 0x20);
    // The zero offset does not matter.
    tester.ask(&[0x29]);
    assert_eq!(status(&mut tester) & 0x30, 0x20);
    tester.rest(0, 0, ONE_G);
    assert_eq!(status(&mut tester) & 0x30, 0);
    // A basic line sensor ends at 80 deg.
    let mut basic: Tester<TwoAxes> = Tester::online(&is2::SP_BL);
    basic.rest(inside.0, 0, inside.1);
    assert_eq!(status(&mut basic), DELIVERED | 0x10);
    // Clipping counts for both axes, for 100 ms.
    tester.reading(0, 0, ONE_G, true);
    assert_eq!(status(&mut tester) & 0x30, 0x30);
    for _ in 0..20 {
        tester.reading(0, 0, ONE_G, false);
    }
    assert_eq!(status(&mut tester) & 0x30, 0);
}

#[test]
fn the_cross_slope_of_one_axis_ends_at_45_deg() {
    let mut tester = is1();
    tester.rest(0, 190_000_000, 189_000_000);
    assert_eq!(tester.ask(&[0x02]), [0x02, DELIVERED]);
    tester.rest(0, 189_000_000, 190_000_000);
    assert_eq!(tester.ask(&[0x02]), [0x02, DELIVERED | 0x10]);
    tester.rest(0, ONE_G, 0);
    assert_eq!(tester.ask(&[0x02]), [0x02, DELIVERED]);
}

#[test]
fn bus_off_is_left_only_with_automatic_recovery() {
    let mut tester = is2();
    tester.bus(BusEvent::State(BusState::Warning));
    assert_eq!(
        tester.leds,
        Leds {
            run: true,
            error: true
        },
        "single flash"
    );
    tester.wait(200);
    assert_eq!(
        tester.leds,
        Leds {
            run: true,
            error: false
        }
    );
    tester.bus(BusEvent::State(BusState::BusOff));
    assert_eq!(
        tester.leds,
        Leds {
            run: true,
            error: true
        }
    );
    tester.wait(10_000);
    assert_eq!(
        tester.leds,
        Leds {
            run: true,
            error: true
        }
    );
    assert!(!tester.actions.contains(&Action::Recover));
    tester.bus(BusEvent::State(BusState::Active));
    assert_eq!(tester.sensor.transmit(tester.now), None);

    let mut tester = is2();
    tester.ask(&[0x24, 1]);
    tester.receive(Frame::data(standard(0x300), &[0x02]).unwrap());
    tester.bus(BusEvent::State(BusState::BusOff));
    assert!(tester.actions.contains(&Action::Recover));
    assert_eq!(tester.sent(), [], "off the bus");
    tester.bus(BusEvent::State(BusState::Active));
    assert_eq!(tester.sent().len(), 1, "the reply was kept");
    assert_eq!(
        tester.leds,
        Leds {
            run: true,
            error: false
        }
    );
}

#[test]
fn a_burst_of_requests_loses_no_reply() {
    let mut tester = is2();
    let mut asked = 0_u32;
    let mut answered = 0;
    while asked < 1000 {
        // The bus is busy with requests as long as the sensor takes them in.
        while tester.sensor.ready() && asked < 1000 {
            tester.receive(Frame::data(standard(0x300), &[0x10]).unwrap());
            asked += 1;
        }
        answered += tester.sent().len();
    }
    assert_eq!(answered, 1000);
}
