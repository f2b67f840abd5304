//! Block upload: exact bytes, any length and block size, lost and repeated segments, refused requests.

use super::*;

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
