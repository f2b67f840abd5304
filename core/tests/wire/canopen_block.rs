//! SDO block transfer (CiA 301, 7.2.4.3.8 to 7.2.4.3.16): both directions with exact bytes, lost and repeated frames, errors and
//! the order of the frames of other services.

use crate::tester::Tester;
use crate::tester::canopen::{abort, frame, write_request};
use crate::tester::gauge::{Gauge, TEXT, booted, text};
use crc::{CRC_16_XMODEM, Crc};
use plumbline::node::{BusEvent, BusState, Node};
use proptest::prelude::*;

const NOTHING: [&str; 0] = [];
/// Initiates the upload of 2100h with CRC in blocks of 127 segments.
const UPLOAD: &str = "632#A40021007F000000";
const START: &str = "632#A300000000000000";
const END: &str = "632#A100000000000000";
/// Index and sub-index of 2100h in an abort.
const OBJECT: &str = "002100";
const TIME_OUT: u32 = 0x0504_0000;
const COMMAND: u32 = 0x0504_0001;
const BLOCK_SIZE: u32 = 0x0504_0002;
const SEQUENCE_NUMBER: u32 = 0x0504_0003;
const CRC: u32 = 0x0504_0004;

fn crc(data: &[u8]) -> u16 {
    Crc::<u16>::new(&CRC_16_XMODEM).checksum(data)
}

fn aborted(code: u32) -> Vec<String> {
    vec![format!("5B2#{}", abort(OBJECT, code))]
}

fn request(bytes: &[u8]) -> String {
    let data: String = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    format!("632#{data:0<16}")
}

/// The segments of data, numbered from 1 in each block.
fn segments(data: &[u8], block: usize) -> Vec<[u8; 8]> {
    let count = data.len().div_ceil(7).max(1);
    let segment = |place: usize| {
        let mut bytes = [0; 8];
        bytes[0] = (place % block + 1) as u8 | if place + 1 == count { 0x80 } else { 0 };
        let rest = &data[7 * place..];
        let used = rest.len().min(7);
        bytes[1..=used].copy_from_slice(&rest[..used]);
        bytes
    };
    (0..count).map(segment).collect()
}

fn replies(frames: &[[u8; 8]]) -> Vec<String> {
    let reply = |bytes: &[u8; 8]| request(bytes).replace("632#", "5B2#");
    frames.iter().map(reply).collect()
}

/// A gauge whose text has this length.
fn with_text(length: usize) -> Tester<Gauge> {
    let mut t = booted();
    t.write(0x2101, 0, 1, length as u32).unwrap();
    t
}

fn acknowledge(t: &mut Tester<Gauge>, number: u8, size: u8) -> Vec<String> {
    t.exchange(&request(&[0xA2, number, size]))
}

/// The message for the end of an upload of data.
fn upload_end(data: &[u8], has_crc: bool) -> Vec<String> {
    let unused = (7 - data.len() % 7) % 7;
    let unused = if data.is_empty() { 7 } else { unused };
    let [low, high] = if has_crc { crc(data) } else { 0 }.to_le_bytes();
    replies(&[[0xC1 | (unused as u8) << 2, low, high, 0, 0, 0, 0, 0]])
}

/// The message of the client for the end of a download.
fn download_end(data: &[u8], crc: u16) -> String {
    let unused = (7 - data.len() % 7) % 7;
    let unused = if data.is_empty() { 7 } else { unused };
    let [low, high] = crc.to_le_bytes();
    request(&[0xC1 | (unused as u8) << 2, low, high])
}

fn initiate_download(length: usize) -> String {
    request(&[0xC6, 0x00, 0x21, 0x00, length as u8])
}

const ACCEPTED: &str = "5B2#A40021001F000000";
const WRITTEN: &str = "5B2#A100000000000000";

#[test]
fn upload_of_constant_text_has_bytes_of_cia_301() {
    let mut t = booted();
    for (request, sent) in [
        ("632#A408100004000000", &["5B2#C60810000E000000"][..]),
        (START, &["5B2#0147617567652077", "5B2#8269746820 4C5353"]),
        ("632#A202040000000000", &["5B2#C1"]),
        (END, &[]),
    ] {
        let reply = t.exchange(request);
        assert_eq!(reply.len(), sent.len(), "{reply:?}");
        for (reply, sent) in reply.iter().zip(sent) {
            assert!(reply.starts_with(&sent.replace(' ', "")), "{reply} {sent}");
        }
    }
    // CRC-16/XMODEM of "123456789" is 31C3h.
    assert_eq!(crc(b"123456789"), 0x31C3);
    assert_eq!(
        t.exchange(END),
        [format!("5B2#{}", abort("000000", COMMAND))]
    );
}

#[test]
fn upload_of_any_length_in_any_block_size_has_all_bytes() {
    for length in [0, 1, 4, 6, 7, 8, 14, 24, 249, TEXT] {
        for size in [1, 2, 3, 35, 36, 126, 127] {
            let mut t = with_text(length);
            let data = text(length);
            let initiated = t.exchange(&request(&[0xA4, 0x00, 0x21, 0x00, size]));
            assert_eq!(
                initiated,
                replies(&[[0xC6, 0, 0x21, 0, length as u8, 0, 0, 0]])
            );
            let segments = segments(&data, size.into());
            let mut sent = t.exchange(START);
            for block in segments.chunks(size.into()) {
                assert_eq!(sent, replies(block), "{length} {size}");
                sent = acknowledge(&mut t, block.len() as u8, size);
            }
            assert_eq!(sent, upload_end(&data, true), "{length} {size}");
            assert_eq!(t.exchange(END), NOTHING);
            assert_eq!(t.wait(2000), []);
        }
    }
}

#[test]
fn upload_without_crc_sends_crc_0_and_ignores_protocol_switch_threshold() {
    let mut t = booted();
    let data = text(24);
    assert_eq!(t.exchange("632#A00021000AFF0000").len(), 1);
    assert_eq!(t.exchange(START), replies(&segments(&data, 10)));
    assert_eq!(acknowledge(&mut t, 4, 1), upload_end(&data, false));
}

#[test]
fn number_is_read_and_written_in_one_segment() {
    let mut t = booted();
    assert_eq!(t.exchange("632#A418100201000000"), ["5B2#C618100204000000"]);
    let data = [0x9F, 0x86, 0x01, 0x00];
    assert_eq!(t.exchange(START), ["5B2#819F860100000000"]);
    assert_eq!(acknowledge(&mut t, 1, 1), upload_end(&data, true));
    t.send(END);

    assert_eq!(t.exchange("632#C617100002000000"), ["5B2#A41710001F000000"]);
    assert_eq!(t.exchange("632#81E8030000000000"), ["5B2#A2011F0000000000"]);
    assert_eq!(
        t.exchange(&download_end(&[0xE8, 3], crc(&[0xE8, 3]))),
        [WRITTEN]
    );
    assert_eq!(t.read(0x1017, 0), Ok(1000));
}

#[test]
fn block_size_changes_between_blocks() {
    let mut t = with_text(100);
    let data = text(100);
    let mut rest = segments(&data, 1000);
    t.send(UPLOAD);
    assert_eq!(t.sent().len(), 1);
    let mut size = 127_usize;
    // The first block is refused as a whole.
    assert_eq!(t.exchange(START), replies(&rest));
    let mut number = 0;
    for next in [3, 1, 5, 4, 127] {
        let sent = acknowledge(&mut t, number, next);
        size = usize::from(next).min(rest.len());
        let block: Vec<_> = rest.drain(..size).enumerate().collect();
        let block: Vec<_> = block
            .into_iter()
            .map(|(place, mut bytes)| {
                bytes[0] = (place + 1) as u8 | bytes[0] & 0x80;
                bytes
            })
            .collect();
        assert_eq!(sent, replies(&block));
        number = size as u8;
    }
    assert!(rest.is_empty());
    assert_eq!(
        acknowledge(&mut t, size as u8, 127),
        upload_end(&data, true)
    );
}

#[test]
fn lost_segments_of_upload_are_repeated() {
    let data = text(60);
    for received in 0..9 {
        let mut t = with_text(60);
        t.send(UPLOAD);
        t.sent();
        assert_eq!(t.exchange(START).len(), 9);
        let sent = acknowledge(&mut t, received, 127);
        let rest = &data[7 * usize::from(received)..];
        assert_eq!(sent, replies(&segments(rest, 127)), "{received}");
        let sent = acknowledge(&mut t, 9 - received, 127);
        assert_eq!(sent, upload_end(&data, true));
    }
}

#[test]
fn repeated_requests_of_upload_change_nothing() {
    let mut t = with_text(20);
    let data = text(20);
    t.send("632#A400210002000000");
    t.sent();
    t.send(START);
    assert_eq!(t.exchange(START), replies(&segments(&data, 2)[..2]));
    let next = request(&[0xA2, 2, 2]);
    t.send(&next);
    assert_eq!(t.exchange(&next), replies(&segments(&data, 2)[2..]));
    let last = request(&[0xA2, 1, 2]);
    t.send(&last);
    assert_eq!(t.exchange(&last), upload_end(&data, true));
}

#[test]
fn block_size_0_or_above_127_is_aborted() {
    for size in [0, 128, 255] {
        let mut t = booted();
        let initiate = request(&[0xA4, 0x00, 0x21, 0x00, size]);
        assert_eq!(t.exchange(&initiate), aborted(BLOCK_SIZE));
        t.send("632#A400210002000000");
        t.sent();
        t.exchange(START);
        assert_eq!(acknowledge(&mut t, 2, size), aborted(BLOCK_SIZE));
        assert_eq!(t.wait(2000), []);
    }
}

#[test]
fn acknowledgement_above_sent_segments_is_aborted() {
    let mut t = with_text(60);
    t.send("632#A400210005000000");
    t.sent();
    t.exchange(START);
    assert_eq!(acknowledge(&mut t, 6, 5), aborted(SEQUENCE_NUMBER));
    let none = format!("5B2#{}", abort("000000", COMMAND));
    assert_eq!(acknowledge(&mut t, 5, 5), [none]);
}

#[test]
fn commands_out_of_order_are_aborted() {
    for requests in [
        &[UPLOAD, END][..],
        &[UPLOAD, "632#A2017F0000000000"],
        &[UPLOAD, START, END],
        &[UPLOAD, START, "632#C100000000000000"],
        &[UPLOAD, START, "632#6000000000000000"],
        &[UPLOAD, "632#0000000000000000"],
    ] {
        let mut t = booted();
        let (last, first) = requests.split_last().unwrap();
        first.iter().for_each(|request| {
            t.exchange(request);
        });
        assert_eq!(t.exchange(last), aborted(COMMAND), "{requests:?}");
    }
}

#[test]
fn objects_that_cannot_be_accessed_are_aborted_at_once() {
    let mut t = booted();
    for (request, object, code) in [
        ("632#A400300004000000", "003000", 0x0602_0000),
        ("632#A418100904000000", "181009", 0x0609_0011),
        ("632#C600300004000000", "003000", 0x0602_0000),
        ("632#C618100404000000", "181004", 0x0601_0002),
        ("632#C6002100FB000000", "002100", 0x0607_0012),
        ("632#C617100004000000", "171000", 0x0607_0012),
        ("632#C617100001000000", "171000", 0x0607_0013),
    ] {
        let expected = format!("5B2#{}", abort(object, code));
        assert_eq!(t.exchange(request), [expected], "{request}");
    }
}

/// Writes a text by block transfer; `lose` tells which frames of the client are lost. Returns the last reply.
fn download(t: &mut Tester<Gauge>, data: &[u8], mut lose: impl FnMut() -> bool) -> Vec<String> {
    assert_eq!(t.exchange(&initiate_download(data.len())), [ACCEPTED]);
    let count = data.len().div_ceil(7).max(1);
    let mut received = 0;
    let mut all_lost = false;
    while received < count {
        let block: Vec<_> = segments(&data[7 * received..], 31)
            .into_iter()
            .take(31)
            .collect();
        for (place, bytes) in block.iter().enumerate() {
            let ends = place + 1 == block.len();
            let lost = lose();
            // A client gives up if it loses all segments twice.
            if lost && !ends && !(all_lost && place == 0) {
                continue;
            }
            let sent = t.exchange(&request(bytes));
            assert_eq!(sent.len(), usize::from(ends), "{sent:?}");
            if ends {
                let reply = frame(&sent[0]);
                let &[0xA2, number, 31, 0, 0, 0, 0, 0] = reply.bytes() else {
                    panic!("{sent:?}");
                };
                received += usize::from(number);
                all_lost = number == 0;
            }
        }
    }
    t.exchange(&download_end(data, crc(data)))
}

#[test]
fn download_of_any_length_writes_all_bytes() {
    for length in [0, 1, 6, 7, 8, 14, 100, 216, 217, 218, 224, TEXT] {
        let mut t = booted();
        let data = text(length);
        assert_eq!(download(&mut t, &data, || false), [WRITTEN], "{length}");
        assert_eq!(t.read(0x2101, 0), Ok(length as u32));
        assert_eq!(t.wait(2000), []);
    }
}

#[test]
fn lost_segments_of_download_are_requested_again() {
    for lost in 0..35 {
        let mut t = booted();
        let mut place = 0;
        let lose = || {
            place += 1;
            place == lost || place == lost + 2
        };
        assert_eq!(download(&mut t, &text(TEXT), lose), [WRITTEN], "{lost}");
        assert_eq!(t.read(0x2101, 0), Ok(TEXT as u32));
    }
}

#[test]
fn repeated_segments_of_download_change_nothing() {
    let mut t = booted();
    let data = text(230);
    t.exchange(&initiate_download(data.len()));
    for bytes in segments(&data, 31) {
        let sent = t.exchange(&request(&bytes));
        assert_eq!(
            sent.len(),
            usize::from(bytes[0] == 31 || bytes[0] & 0x80 != 0)
        );
        assert_eq!(t.exchange(&request(&bytes)), NOTHING, "repeated");
    }
    assert_eq!(t.exchange(&download_end(&data, crc(&data))), [WRITTEN]);
    assert_eq!(t.read(0x2101, 0), Ok(230));
}

#[test]
fn download_without_size_or_crc_is_accepted() {
    for command in [0xC0, 0xC2, 0xC4] {
        let mut t = booted();
        let size = if command == 0xC2 { 10 } else { 0 };
        let initiate = request(&[command, 0x00, 0x21, 0x00, size]);
        assert_eq!(t.exchange(&initiate), [ACCEPTED]);
        let data = text(10);
        for bytes in segments(&data, 31) {
            t.exchange(&request(&bytes));
        }
        let sum = if command == 0xC4 { crc(&data) } else { 0x5555 };
        assert_eq!(t.exchange(&download_end(&data, sum)), [WRITTEN]);
        assert_eq!(t.read(0x2101, 0), Ok(10));
    }
}

#[test]
fn wrong_crc_or_length_is_aborted_and_changes_nothing() {
    let data = text(10);
    for (announced, sum, code) in [
        (10, crc(&data) ^ 1, CRC),
        (11, crc(&data), 0x0607_0010),
        (9, crc(&data), 0x0607_0010),
    ] {
        let mut t = booted();
        t.exchange(&initiate_download(announced));
        for bytes in segments(&data, 31) {
            t.exchange(&request(&bytes));
        }
        assert_eq!(t.exchange(&download_end(&data, sum)), aborted(code));
        assert_eq!(t.read(0x2101, 0), Ok(24));
    }
    // The application refuses the text.
    let mut t = booted();
    assert_eq!(download(&mut t, &[1, 2, 3], || false), aborted(0x0609_0030));
    assert_eq!(t.read(0x2101, 0), Ok(24));
}

#[test]
fn download_longer_than_object_is_aborted() {
    let mut t = booted();
    assert_eq!(t.exchange("632#C400210000000000"), [ACCEPTED]);
    let replies: Vec<_> = segments(&[7; 300], 31)
        .iter()
        .flat_map(|bytes| t.exchange(&request(bytes)))
        .take(2)
        .collect();
    assert_eq!(replies[0], "5B2#A21F1F0000000000");
    assert_eq!(replies[1..], aborted(0x0607_0012));
}

#[test]
fn segment_number_that_is_not_valid_is_aborted() {
    for command in [0x00, 0x60, 0x7F, 0xA1, 0xA2, 0xE0, 0xFF] {
        let mut t = booted();
        t.exchange(&initiate_download(24));
        t.exchange("632#0102030405060708");
        let sent = t.exchange(&request(&[command]));
        assert_eq!(sent, aborted(SEQUENCE_NUMBER), "{command:02X}");
        assert_eq!(t.wait(2000), []);
    }
}

#[test]
fn client_that_stops_gets_time_out() {
    let stops: [&[&str]; 7] = [
        &[UPLOAD],
        &[UPLOAD, START],
        &["632#A400210002000000", START, "632#A202020000000000"],
        &[UPLOAD, START, "632#A2047F0000000000"],
        &["632#C600210018000000"],
        &["632#C600210018000000", "632#0100000000000000"],
        &["632#C600210007000000", "632#8100000000000000"],
    ];
    for requests in stops {
        let mut t = booted();
        for request in requests {
            t.exchange(request);
            t.wait(999);
        }
        let sent = t.wait_text(1);
        let expected: Vec<_> = aborted(TIME_OUT)
            .into_iter()
            .map(|text| (1, text))
            .collect();
        assert_eq!(sent, expected, "{requests:?}");
        assert_eq!(t.wait(3000), []);
        assert_eq!(t.read(0x2101, 0), Ok(24));
    }
}

#[test]
fn segments_out_of_sequence_do_not_delay_time_out() {
    let mut t = booted();
    t.exchange(&initiate_download(100));
    for _ in 0..9 {
        assert_eq!(t.wait(100), []);
        assert_eq!(t.exchange("632#0500000000000000"), NOTHING);
    }
    assert_eq!(t.wait_text(200)[0].1, aborted(TIME_OUT)[0]);
}

#[test]
fn abort_of_client_ends_transfer() {
    for requests in [
        &[UPLOAD][..],
        &[UPLOAD, START],
        &["632#C600210018000000"],
        &["632#C600210018000000", "632#0100000000000000"],
        &["632#C600210007000000", "632#8100000000000000"],
    ] {
        let mut t = booted();
        for request in requests {
            t.exchange(request);
        }
        assert_eq!(t.exchange("632#8000210000000405"), NOTHING);
        assert_eq!(t.wait(3000), []);
        assert_eq!(t.read(0x1000, 0), Ok(0x0001_019A));
    }
}

#[test]
fn another_transfer_is_served_in_the_middle_of_a_block_transfer() {
    let begun: [&[&str]; 5] = [
        &[UPLOAD],
        &[UPLOAD, START],
        &["632#C600210018000000"],
        &["632#C600210018000000", "632#0100000000000000"],
        &["632#C600210007000000", "632#8100000000000000"],
    ];
    for requests in begun {
        let begin = || {
            let mut t = booted();
            for request in requests {
                t.exchange(request);
            }
            t
        };
        let mut t = begin();
        assert_eq!(t.read(0x1000, 0), Ok(0x0001_019A), "{requests:?}");
        assert_eq!(t.wait(3000), [], "the block transfer has ended");
        let mut t = begin();
        assert_eq!(t.write(0x1017, 0, 2, 500), Ok(()));
        assert_eq!(begin().read_text(0x1008), "Gauge with LSS");
        let mut t = begin();
        assert_eq!(t.exchange(UPLOAD), ["5B2#C600210018000000"]);
        assert_eq!(t.exchange(START), replies(&segments(&text(24), 127)));
        let mut t = begin();
        assert_eq!(download(&mut t, &text(9), || false), [WRITTEN]);
    }
}

#[test]
fn segments_of_upload_leave_room_for_other_services() {
    let mut t = with_text(TEXT);
    t.send("000#0132");
    t.sent();
    t.send(UPLOAD);
    t.sent();
    t.send(START);
    // At most one segment is queued, so a TPDO or an answer waits for one frame.
    for number in 1..10 {
        t.send("080#");
        t.send("732#R1");
        t.send("7E5#4C00000000000000");
        let mut next = || format!("{:?}", t.node.transmit(t.now).unwrap());
        let segment = next();
        assert!(
            segment.starts_with(&format!("5B2#{number:02X}")),
            "{segment}"
        );
        assert_eq!(
            [next(), next()],
            [
                "1B2#FEFF",
                if number % 2 == 1 { "732#05" } else { "732#85" }
            ]
        );
        t.wait_without_samples(0);
        t.node.poll(t.now);
    }
}

#[test]
fn stopped_state_ends_upload() {
    let mut t = with_text(TEXT);
    t.send(UPLOAD);
    t.sent();
    t.send(START);
    t.send("000#0232");
    assert!(t.sent().len() <= 1);
    assert_eq!(t.wait(3000), []);
    t.send("000#8032");
    assert_eq!(t.read(0x1000, 0), Ok(0x0001_019A));
}

#[test]
fn upload_pauses_in_bus_off() {
    let mut t = with_text(TEXT);
    t.send(UPLOAD);
    t.sent();
    t.send(START);
    t.bus(BusEvent::State(BusState::BusOff));
    assert_eq!(t.wait(500), []);
    t.bus(BusEvent::State(BusState::Active));
    let sent = t.sent_text();
    let segments = replies(&segments(&text(TEXT), 127));
    let segments_sent: Vec<_> = sent
        .into_iter()
        .filter(|text| text.starts_with("5B2#"))
        .collect();
    assert_eq!(segments_sent, segments);
}

#[test]
fn lss_and_segments_of_a_block_do_not_disturb_each_other() {
    let mut t = booted();
    let data = text(100);
    t.send("7E5#0401000000000000");
    t.exchange(&initiate_download(data.len()));
    for bytes in segments(&data, 31) {
        t.exchange(&request(&bytes));
        assert_eq!(t.exchange("7E5#5E00000000000000"), ["7E4#5E32000000000000"]);
    }
    assert_eq!(t.exchange(&download_end(&data, crc(&data))), [WRITTEN]);
}

#[test]
fn write_that_saves_is_confirmed_after_the_save() {
    let mut t = booted();
    t.memory_works = None;
    let save = 0x6576_6173_u32.to_le_bytes();
    assert_eq!(t.exchange("632#C610100104000000"), ["5B2#A41010011F000000"]);
    let [a, b, c, d] = save;
    assert_eq!(t.exchange(&request(&[0x81, a, b, c, d])).len(), 1);
    assert_eq!(t.exchange(&download_end(&save, crc(&save))), NOTHING);
    let again = write_request(0x1010, 1, 4, 0x6576_6173);
    assert_eq!(t.sdo(&again), abort("101001", 0x0800_0022));
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), [WRITTEN]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// A text crosses in both directions with any lost segments, and has no wrong byte.
    #[test]
    fn text_arrives_with_any_lost_segments(
        length in 0..=TEXT,
        size in 1..=127_u8,
        losses in prop::collection::vec(any::<bool>(), 200),
    ) {
        let mut t = with_text(0);
        let data = text(length);
        let mut losses = losses.into_iter();
        let mut lose = || losses.next().unwrap_or(false);
        prop_assert_eq!(download(&mut t, &data, &mut lose), [WRITTEN]);
        prop_assert_eq!(t.read(0x2101, 0), Ok(length as u32));

        let mut received = Vec::new();
        t.exchange(&request(&[0xA4, 0x00, 0x21, 0x00, size]));
        let mut sent = t.exchange(START);
        // The numbers of all segments are lower than the command of the end.
        while frame(&sent[0]).bytes()[0] < 0xC0 {
            let mut expected = 1;
            for text in &sent {
                let segment = frame(text);
                let (number, data) = segment.bytes().split_first().unwrap();
                if number & 0x7F == expected && !lose() {
                    received.extend_from_slice(data);
                    expected += 1;
                }
            }
            sent = acknowledge(&mut t, expected - 1, size);
        }
        received.truncate(length);
        prop_assert_eq!(&received, &data);
        prop_assert_eq!(sent, upload_end(&data, true));
    }

    /// Any SDO frames: at most one reply that is not a segment, and the server still answers.
    #[test]
    fn random_frames_have_at_most_one_reply_and_server_answers(
        frames in prop::collection::vec(
            (prop::sample::select(vec![
                0xA0_u8, 0xA1, 0xA2, 0xA3, 0xA4, 0xC0, 0xC1, 0xC2, 0xC6, 0xDD, 0x80, 0x81, 0x82, 0x01, 0x02, 0x03, 0x1F, 0x9F,
                0x40, 0x60, 0x21, 0x23, 0x00, 0x10, 0xFF,
            ]), prop::sample::select(vec![0x2100_u16, 0x2101, 0x1008, 0x1017, 0x0102, 0x7F02]), any::<[u8; 5]>(), 0..600_u64),
            0..60,
        ),
    ) {
        let mut t = booted();
        for (command, index, mut rest, wait) in frames {
            let [low, high] = index.to_le_bytes();
            rest[0] %= 2;
            rest[2..].iter_mut().for_each(|byte| *byte %= 4);
            let mut bytes = vec![command, low, high];
            bytes.extend(rest);
            let sent = t.exchange(&request(&bytes));
            let replies = sent.len();
            prop_assert!(replies <= 1 || sent.iter().all(|text| text.starts_with("5B2#")));
            prop_assert!(replies <= 127);
            t.wait(wait);
        }
        t.wait(1000);
        t.sent();
        prop_assert_eq!(t.read(0x1000, 0), Ok(0x0001_019A));
    }
}
