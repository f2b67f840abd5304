//! A full bus, and frames that wait for a mailbox.

use crate::rig::*;
use bench::Source;
use can_wire::frame_length::{INTERMISSION, frame_bits};
use plumbline::can::{BitRate, Frame, extended, standard};

#[test]
fn waiting_replies_are_sent_once_and_in_order() {
    let mut rig = Rig::booted_with(
        "is2",
        BitRate::K250,
        &[
            &[fsc::WRITE_CYCLIC_TIME, 3, 0],
            &[fsc::WRITE_CYCLIC_MODE, 1],
        ],
    );
    rig.run(20);
    rig.frames();
    // 25 frames of the sensor are destroyed (25 times 8 is less than bus-off) while it receives requests.
    rig.bus.corrupt(25, Some(Source::Device(rig.sensor)));
    let requests: Vec<u8> = (0..3).flat_map(|_| 0x10..=0x19).collect();
    for request in &requests {
        rig.send(&[*request]);
    }
    rig.run(200);
    let own = Source::Device(rig.sensor);
    let begin = rig
        .log
        .iter()
        .position(|logged| logged.frame == data(SET, &[0x10]));
    let waiting = rig.log[begin.expect("a request")..].iter();
    let waited = waiting.take_while(|logged| logged.source != own).count();
    assert!(waited >= 10, "replies have not waited: {waited}");

    let frames = rig.frames();
    let is_cyclic = |frame: &&Frame| frame.bytes()[0] == fsc::INCLINATION;
    let (cyclic, replies): (Vec<&Frame>, Vec<_>) = frames.iter().partition(is_cyclic);
    let codes: Vec<u8> = replies.iter().map(|frame| frame.bytes()[0]).collect();
    assert_eq!(codes, requests);
    let counters: Vec<u8> = cyclic.iter().map(|frame| frame.bytes()[6]).collect();
    assert!(counters.len() > 20);
    assert!(
        counters
            .windows(2)
            .all(|pair| (1..128).contains(&pair[1].wrapping_sub(pair[0])))
    );
    let distinct: std::collections::BTreeSet<&u8> = counters.iter().collect();
    assert_eq!(distinct.len(), counters.len(), "no counter is sent twice");
}

/// Without acknowledgement two frames wait in the mailboxes. The newest value replaces the others in the queue.
#[test]
fn waiting_cyclic_messages_use_two_mailboxes() {
    let mut rig = Rig::booted_with(
        "is2",
        BitRate::K250,
        &[
            &[fsc::WRITE_CYCLIC_TIME, 5, 0],
            &[fsc::WRITE_CYCLIC_MODE, 1],
        ],
    );
    rig.run(20);
    let tester = rig.tester;
    rig.bus.close(tester);
    let last = rig.frames().last().expect("a cyclic message").bytes()[6];
    rig.run(50);
    assert_eq!(rig.frames(), []);
    rig.bus.open(tester, Some(BitRate::K250), false);
    rig.run(3);
    let counters = rig.frames().into_iter();
    let waited: Vec<u8> = counters
        .map(|frame| frame.bytes()[6].wrapping_sub(last))
        .collect();
    assert_eq!(waited, [1, 2, 10]);
}

#[test]
fn full_bus_loses_no_reply() {
    const TIME: u64 = 300;
    let mut rig = Rig::booted("is2", BitRate::M1);
    rig.run(10);
    rig.frames();
    let [strong, weak, passing] = [(); 3].map(|()| {
        let adapter = rig.bus.adapter();
        rig.bus.open(adapter, Some(BitRate::M1), false);
        adapter
    });
    rig.run(1);
    let start = rig.log.len();
    let mut polls = 0;
    for at in 0..TIME {
        rig.bus.send(strong, data(0x010, &[0; 8]));
        rig.bus.send(
            strong,
            Frame::data(extended(0x0C0_0300), &[at as u8]).expect("a frame"),
        );
        while rig.bus.queued(weak) < 20 {
            rig.bus.send(weak, data(0x7EE, &[0xA5; 4]));
            rig.bus
                .send(weak, Frame::remote(standard(0x555), 8).expect("a frame"));
        }
        // These pass the hardware filters; the sensor ignores them (core/src/model/gemac/README.md, G11 and G26).
        rig.bus.send(passing, data(SYNC, &[1]));
        rig.bus
            .send(passing, Frame::remote(standard(SET), 2).expect("a frame"));
        if at % 2 == 0 {
            rig.send(&[fsc::INCLINATION]);
            polls += 1;
        }
        rig.run(1);
    }
    let bits = |logged: &bench::Logged| u64::from(frame_bits(&logged.frame) + INTERMISSION);
    let load: u64 = rig.log[start..].iter().map(bits).sum();
    println!("the bus was busy for {load} of {TIME}000 bits");
    assert!(load * 100 >= TIME * 1000 * 97, "{load}");
    assert_eq!(rig.bus.disturbed(Source::Device(rig.sensor)), 0);
    // Closing an adapter aborts its frame.
    for adapter in [strong, weak, passing] {
        rig.bus.close(adapter);
    }
    rig.run(10);
    let replies = rig.frames();
    assert_eq!(replies.len(), polls);
    assert!(
        replies
            .iter()
            .all(|reply| reply.bytes()[0] == fsc::INCLINATION)
    );
    assert_eq!(rig.microcontroller().can().overruns(), 0);
}
