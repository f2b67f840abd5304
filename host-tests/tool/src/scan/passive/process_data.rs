use super::*;
use crate::master::canopen;
use plumbline::can::Frame;
use plumbline::can::{extended, standard};
use plumbline::time::Instant;

fn timed(frames: impl IntoIterator<Item = Frame>) -> Vec<(Instant, Frame)> {
    let times = (0..).map(|place| Instant::from_ticks(10_000 * place));
    times.zip(frames).collect()
}

fn frame(id: u16, bytes: &[u8]) -> Frame {
    Frame::data(standard(id), bytes).unwrap()
}

/// Address and text of the nodes.
fn of(frames: impl IntoIterator<Item = Frame>) -> Vec<(String, String)> {
    told(&Bus::of(&timed(frames)))
}

fn told(bus: &Bus) -> Vec<(String, String)> {
    let nodes = by_process_data(bus).into_iter().map(|own| own.heard);
    let told = nodes.map(|own| {
        (
            own.address.unwrap_or_default(),
            own.text.unwrap_or_default(),
        )
    });
    told.collect()
}

fn cyclic(text: &str) -> Vec<(String, String)> {
    vec![(String::new(), format!("GEMAC, {text}"))]
}

fn slave(text: &str) -> Vec<(String, String)> {
    vec![("5".to_owned(), text.to_owned())]
}

fn node(node: u8, id: u16) -> (String, String) {
    (node.to_string(), format!("likely, by a TPDO ({id:03X}h)"))
}

/// A frame of an IS2 in cyclic mode with this counter: X = 90 deg, Y = -90 deg.
fn two_axes(counter: u16) -> Frame {
    let [low, high] = counter.to_le_bytes();
    frame(0x6A6, &[0, 1, 0x28, 0x23, 0xD8, 0xDC, low, high])
}

/// A frame of an IS1 in cyclic mode with this counter: 359.99 deg.
fn one_axis(counter: u16) -> Frame {
    let [low, high] = counter.to_le_bytes();
    let bytes = [0, 1, 0x9F, 0x8C, low, high];
    Frame::data(extended(0x1234_5678), &bytes).unwrap()
}

#[test]
fn cyclic_frames_of_both_kinds_show_the_reply_id() {
    for start in [7, u16::MAX] {
        let two = [start, start.wrapping_add(1)].map(two_axes);
        assert_eq!(of(two), cyclic("2 angles at 6A6h"));
    }
    assert_eq!(of([1, 2, 3].map(one_axis)), cyclic("1 angle at 12345678h"));
}

#[test]
fn frame_without_code_counter_or_angle_is_not_of_cyclic_mode() {
    assert_eq!(of([two_axes(7)]), [], "once");
    assert_eq!(of([7, 7].map(two_axes)), [], "a reply to a poll");
    assert_eq!(of([7, 8, 10].map(two_axes)), [], "a leap");
    assert_eq!(of([7, 8, 9, 11, 11, 12, 13].map(two_axes)).len(), 1, "lost");
    let with = |change: fn(&mut [u8; 8])| {
        of([7, 8].map(|counter| {
            let mut bytes: [u8; 8] = two_axes(counter).bytes().try_into().unwrap();
            change(&mut bytes);
            frame(0x6A6, &bytes)
        }))
    };
    assert_eq!(with(|bytes| bytes[0] = 2), [], "another code");
    assert_eq!(with(|bytes| bytes[2] = 0x29), [], "90.01 deg");
    assert_eq!(with(|bytes| bytes[4] = 0xD7), [], "-90.01 deg");
    let outside = [1, 2].map(|counter| frame(0x6A6, &[0, 1, 0xA0, 0x8C, counter, 0]));
    assert_eq!(of(outside), [], "360 deg");
    let longer = [1, 2].map(|counter| frame(0x6A6, &[0, 1, 0, 0, 0, counter, 0]));
    assert_eq!(of(longer), [], "7 bytes");
}

#[test]
fn slave_with_polls_or_acknowledges_is_certain() {
    let (poll, response) = (frame(0x42D, &[]), frame(0x3C5, &[1, 2, 3, 4]));
    let sure = slave("I/O of another master");
    assert_eq!(of([poll, response, poll, response]), sure);
    assert_eq!(of([response, poll, response, poll, response]), sure);
    // A response without a poll is none.
    assert!(!of([response; 5]).contains(&sure[0]));
    assert!(!of([response, response, poll, poll]).contains(&sure[0]));
    let (change, acknowledge) = (frame(0x345, &[1, 2]), frame(0x42A, &[]));
    assert_eq!(of([change, acknowledge, change, acknowledge]), sure);
    let likely = slave("likely, by its I/O messages");
    assert_eq!(of([change; 2]), likely);
    assert_eq!(of([change]), []);
}

#[test]
fn slave_is_not_seen_on_a_bus_with_other_identifiers() {
    let (poll, response) = (frame(0x42D, &[]), frame(0x3C5, &[1, 2, 3, 4]));
    let polled = [poll, response, poll, response];
    for other in [
        frame(0x185, &[1]),
        Frame::data(extended(0x18FE_CA80), &[]).unwrap(),
    ] {
        let nodes = of(polled.into_iter().chain([other]));
        assert!(
            !nodes.iter().any(|(_, text)| text.contains("I/O")),
            "{nodes:?}"
        );
    }
}

#[test]
fn tpdo_of_constant_length_on_a_bus_of_canopen_shows_a_node() {
    let pdo = |id| frame(id, &[1, 2, 3, 4]);
    assert_eq!(of([pdo(0x18A); 2]), [node(10, 0x18A)]);
    // Its second TPDO adds nothing, another node does.
    let tpdos = [0x18A, 0x28A, 0x18A, 0x28A, 0x4FF, 0x4FF, 0x20A].map(pdo);
    let with = |sign: Frame| of(tpdos.into_iter().chain([sign]));
    for sign in [
        frame(0, &[1, 0]),
        frame(0x080, &[]),
        frame(0x080, &[7]),
        frame(0x70A, &[5]),
    ] {
        assert_eq!(with(sign), [node(10, 0x18A), node(127, 0x4FF)], "{sign:?}");
    }
    // All have one node-ID.
    assert_eq!(of([0x18A, 0x28A, 0x18A, 0x20A].map(pdo)), [node(10, 0x18A)]);
    assert_eq!(of([pdo(0x18A)]), [], "once");
    assert_eq!(of([pdo(0x18A), frame(0x18A, &[1])]), [], "two lengths");
    for other in [0x123, 0x200, 0x680, 0x700, 0x7DF] {
        let frames = [pdo(0x18A), pdo(0x18A), pdo(other), frame(0x70A, &[5])];
        assert_eq!(of(frames), [], "{other:X}");
    }
    for id in [0x180, 0x20A, 0x30A, 0x40A, 0x50A, 0x58A] {
        assert_eq!(of([pdo(id); 2]), [], "{id:X}");
    }
}

#[test]
fn tpdos_of_several_nodes_without_canopen_frames_show_no_node() {
    let machine = [0x1F0, 0x2E1, 0x493].map(|id| frame(id, &[1, 2, 3, 4]));
    assert_eq!(of([machine, machine].concat()), []);
    // These are no NMT command, SYNC or heartbeat.
    for other in [
        frame(0, &[3, 0]),
        frame(0, &[1, 128]),
        frame(0, &[1]),
        frame(0x080, &[1, 2]),
        frame(0x70A, &[1]),
        frame(0x70A, &[5, 5]),
    ] {
        let all = [&machine[..], &machine, &[other]].concat();
        assert_eq!(of(all), [], "{other:?}");
    }
}

#[test]
fn counter_of_another_device_is_no_cyclic_mode() {
    // 8 bytes with a counter at their end, and no other data.
    let counted =
        |id: u32, counter: u8| Frame::data(extended(id), &[0, 2, 0, 0, 0, 0, counter, 0]).unwrap();
    let frames = |id: u32, count: u8| (0..count).map(move |place| counted(id, place));
    // A group of J1939 for all nodes.
    for id in [0x18FF_1234, 0x19F0_1234] {
        assert_eq!(of(frames(id, 4)), [], "{id:X}");
        assert_eq!(of(frames(id, 5)).len(), 1, "{id:X}");
    }
    assert_eq!(of(frames(0x1800_1234, 2)).len(), 1);
    // Another identifier is on the bus.
    let other = frame(0x123, &[1]);
    for (count, rows) in [(2, 0), (4, 0), (5, 1)] {
        let all = (0..count).map(two_axes).chain([other]);
        assert_eq!(of(all).len(), rows, "{count}");
    }
    // The identifier as delivered.
    let delivered = |counter| frame(0x301, two_axes(counter).bytes());
    assert_eq!(of([delivered(1), other, delivered(2)]).len(), 1);
    // Another protocol is sure.
    let is_other = |frames: &[Frame]| {
        let frames = timed(frames.iter().copied());
        let mut bus = Bus::of(&frames);
        bus.sure = vec![&canopen::PROTOCOL];
        told(&bus)
    };
    let moved: Vec<Frame> = (0..9).map(two_axes).collect();
    assert_eq!(is_other(&moved), []);
    assert_eq!(is_other(&[delivered(1), delivered(2)]).len(), 1);
    let tpdo: Vec<Frame> = moved.iter().map(|own| frame(0x185, own.bytes())).collect();
    assert_eq!(
        is_other(&tpdo),
        [node(5, 0x185)],
        "as if it were no counter"
    );
    let io = [frame(0x42D, &[]), frame(0x3C5, &[1, 2])];
    let owned = of([&moved[..], &io, &io].concat());
    assert_eq!(owned, slave("I/O of another master"));
}

#[test]
fn reserved_bit_of_the_status_is_not_of_cyclic_mode() {
    let of_status = |status: u8| {
        let frames = [7, 8].map(|counter| frame(0x6A6, &[0, status, 0, 0, 0, 0, counter, 0]));
        of(frames).len()
    };
    assert_eq!(of_status(0x7F), 1);
    assert_eq!(of_status(0x80), 0);
}

#[test]
fn counter_without_period_is_not_of_cyclic_mode() {
    let at = |times: &[u64]| {
        let frames = times.iter().zip(1..);
        let frames: Vec<(Instant, Frame)> = frames
            .map(|(time, counter)| (Instant::from_ticks(time * 1000), two_axes(counter)))
            .collect();
        told(&Bus::of(&frames)).len()
    };
    assert_eq!(at(&[0, 200, 400, 600, 800, 1000]), 1);
    // Frames that the adapter collects.
    assert_eq!(at(&[0, 0, 0, 16, 16, 16, 32, 32, 32]), 1);
    assert_eq!(at(&[0, 200, 420, 610, 800, 1030]), 1);
    // Messages that are sent when something changes.
    assert_eq!(at(&[0, 30, 60, 500, 900, 1000]), 0);
    assert_eq!(at(&[0, 700, 720, 740, 760, 1000]), 0);
}
