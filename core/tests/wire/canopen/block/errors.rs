//! Time-outs, aborts, other services beside a block transfer, bus-off, and a write that saves.

use super::*;

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
        while t.node.poll(t.now).is_some() {}
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
