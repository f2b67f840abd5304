use super::*;
use crate::master::canopen::{nmt, sdo};
use crate::master::devicenet::explicit as devicenet;
use crate::master::fsc::request as fsc;
use adapter::{AdapterError, Capabilities};
use plumbline::can::standard;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

mod busy;

/// Frames that have come, and answers to requests by their first byte.
#[derive(Default)]
pub(crate) struct Script {
    received: VecDeque<Frame>,
    pub answers: Vec<(u8, Vec<Frame>)>,
    /// Answers to the requests one after the other.
    replies: VecDeque<Vec<Frame>>,
    sent: Vec<Frame>,
    /// The time of the last frame.
    sent_at: u64,
    closed_at: u64,
    /// The number of unanswered frames at which the adapter refuses the next frame; None: it refuses none.
    places: Option<usize>,
    kept: usize,
    is_refused: bool,
    /// How late the computer is after a wait, in us.
    pub late: u64,
    reads: u32,
    now: u64,
}

/// An adapter with a script.
#[derive(Clone, Default)]
pub(crate) struct Scripted(pub Rc<RefCell<Script>>);

impl Adapter for Scripted {
    fn capabilities(&self) -> Capabilities {
        Capabilities {
            listen_only: true,
            sets_rate: true,
            needs_rate: true,
            reports_errors: false,
        }
    }

    fn open(&mut self, _: Option<BitRate>, _: Mode) -> Result<(), AdapterError> {
        Ok(())
    }

    fn close(&mut self) {
        let script = &mut *self.0.borrow_mut();
        script.closed_at = script.now;
        script.kept = 0;
    }

    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError> {
        let script = &mut *self.0.borrow_mut();
        script.sent.push(*frame);
        script.sent_at = script.now;
        script.kept += 1;
        script.is_refused = script.places.is_some_and(|places| script.kept > places);
        script
            .received
            .extend(script.replies.pop_front().into_iter().flatten());
        let answers = script.answers.iter();
        for (_, frames) in answers.filter(|(code, _)| frame.bytes().first() == Some(code)) {
            script.received.extend(frames);
        }
        Ok(())
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError> {
        let script = &mut *self.0.borrow_mut();
        // A frame counts as received now, though it came earlier.
        let now = Instant::from_ticks(script.now + 1);
        if std::mem::take(&mut script.is_refused) {
            return Err(AdapterError::FrameRefused("the adapter".to_owned()));
        }
        if let Some(frame) = script.received.pop_front() {
            script.kept = 0;
            return Ok(Some((now, frame)));
        }
        script.reads += 1;
        assert!(script.reads < 10_000, "an endless loop");
        script.now = script.now.max(until.ticks()) + script.late;
        Ok(None)
    }

    fn now(&self) -> Instant {
        Instant::from_ticks(self.0.borrow().now)
    }

    fn errors(&mut self) -> Option<u64> {
        None
    }
}

pub(crate) fn link(adapter: &Scripted) -> Link {
    let never: Rc<dyn Fn() -> bool> = Rc::new(|| false);
    Link::new(Box::new(adapter.clone()), &never)
}

pub(crate) fn frame(id: u16, bytes: &[u8]) -> Frame {
    Frame::data(standard(id), bytes).unwrap()
}

#[test]
fn late_answer_is_not_used_for_the_next_request() {
    let adapter = Scripted::default();
    let mut link = link(&adapter);
    let late = frame(0x301, &[0x15, 0, 100, 0]);
    adapter.0.borrow_mut().received = VecDeque::from([late, late]);
    let answer = frame(0x301, &[0x15, 0, 250, 0]);
    adapter.0.borrow_mut().answers = vec![(0x15, vec![answer])];
    let sensor = fsc::Sensor {
        request: plumbline::can::CanId::standard(0x300),
        reply: None,
    };
    let reply = fsc::ask(&mut link, sensor, 0x15, &[], fsc::ANSWER).unwrap();
    assert_eq!(reply.unwrap().data, [250, 0]);
}

#[test]
fn sdo_answer_of_another_object_is_not_taken() {
    let adapter = Scripted::default();
    let mut link = link(&adapter);
    let late = frame(0x58A, &[0x43, 0x18, 0x10, 1, 1, 2, 3, 4]);
    let answer = frame(0x58A, &[0x43, 0x18, 0x10, 2, 5, 6, 7, 8]);
    adapter.0.borrow_mut().answers = vec![(0x40, vec![late, answer])];
    let read = sdo::Server::of(10).read(&mut link, 0x1018, 2).unwrap();
    assert_eq!(read, sdo::Answer::Done(vec![5, 6, 7, 8]));
    assert_eq!(adapter.0.borrow().sent.len(), 1, "no abort");
    // A late end of a segmented transfer, then the abort of the transfer that the tool waits for.
    let late = frame(0x58A, &[0x0F, 0, 0, 0, 0, 0, 0, 0]);
    let other = frame(0x58A, &[0x80, 0x18, 0x10, 1, 0, 0, 2, 6]);
    let own = frame(0x58A, &[0x80, 0x18, 0x10, 9, 0x11, 0, 9, 6]);
    adapter.0.borrow_mut().answers = vec![(0x40, vec![late, other, own])];
    let read = sdo::Server::of(10).read(&mut link, 0x1018, 9).unwrap();
    assert_eq!(read, sdo::Answer::Aborted(0x0609_0011));
}

#[test]
fn short_reply_after_a_boot_up_message_does_not_panic() {
    let adapter = Scripted::default();
    let mut link = link(&adapter);
    let booted = frame(0x301, &[0xFF, 0, 0, 3, 0, 0, 0x44, 3]);
    let short = frame(0x301, &[0x03, 0, 1, 2, 3]);
    adapter.0.borrow_mut().answers = vec![(0x03, vec![booted, booted, short])];
    let sensor = fsc::Sensor {
        request: plumbline::can::CanId::standard(0x310),
        reply: None,
    };
    let target = crate::master::Target::Fsc(sensor);
    let found = crate::identify::ask(&mut link, target, millis(100)).unwrap();
    assert!(found.is_none());
}

#[test]
fn last_frame_without_answer_leaves_the_adapter_before_it_is_closed() {
    for (rate, wait) in [(BitRate::K10, 35_000), (BitRate::K250, 20_600)] {
        let adapter = Scripted::default();
        let mut link = link(&adapter);
        link.open(Some(rate), Mode::Active).unwrap();
        nmt::send(&mut link, nmt::START, 10).unwrap();
        link.close();
        let script = adapter.0.borrow();
        // 20 ms for the adapter, and 150 bits.
        let waited = script.closed_at - script.sent_at;
        assert!(
            (wait - 1000..60_000).contains(&waited),
            "{rate:?} {waited} us"
        );
    }
    // A frame with an answer has left.
    let adapter = Scripted::default();
    let mut link = link(&adapter);
    let answer = frame(0x301, &[0x15, 0]);
    adapter.0.borrow_mut().answers = vec![(0x15, vec![answer])];
    let question = frame(0x300, &[0x15]);
    link.ask(&question, millis(10), |_| Some(())).unwrap();
    link.close();
    let script = adapter.0.borrow();
    assert!(script.closed_at - script.sent_at < 1000);
}

/// Answers of node 10 to SDO requests.
fn sdo_answers(answers: &[[u8; 8]]) -> VecDeque<Vec<Frame>> {
    let answers = answers.iter();
    answers.map(|bytes| vec![frame(0x58A, bytes)]).collect()
}

#[test]
fn sdo_segments_without_data_end_the_transfer() {
    let adapter = Scripted::default();
    let mut link = link(&adapter);
    let begin = [0x41, 0x08, 0x10, 0, 9, 0, 0, 0];
    let [even, odd] = [0x0E, 0x1E].map(|command| [command, 0, 0, 0, 0, 0, 0, 0]);
    adapter.0.borrow_mut().replies = sdo_answers(&[begin, even, odd, even, odd]);
    let read = sdo::Server::of(10).read(&mut link, 0x1008, 0).unwrap();
    assert_eq!(read, sdo::Answer::Aborted(0x0504_0001));
    let script = adapter.0.borrow();
    let last = script.sent.last().unwrap().bytes();
    assert_eq!(last, [0x80, 0x08, 0x10, 0, 1, 0, 4, 5]);
    drop(script);
    // The last segment can be empty.
    adapter.0.borrow_mut().replies = sdo_answers(&[
        begin,
        [0x00, 1, 2, 3, 4, 5, 6, 7],
        [0x1F, 0, 0, 0, 0, 0, 0, 0],
    ]);
    let read = sdo::Server::of(10).read(&mut link, 0x1008, 0).unwrap();
    assert_eq!(read, sdo::Answer::Done(vec![1, 2, 3, 4, 5, 6, 7]));
}

/// The response of the slave with MAC ID 63 to "get" in these fragments.
fn fragments(fragments: &[&[u8]]) -> devicenet::Response {
    let adapter = Scripted::default();
    let mut link = link(&adapter);
    let slave = devicenet::Slave { mac: 63 };
    let header = 0x80 | slave.master();
    let part = |data: &&[u8]| vec![frame(0x5FB, &[&[header], *data].concat())];
    adapter.0.borrow_mut().replies = fragments.iter().map(part).collect();
    let path = devicenet::Path {
        class: 1,
        instance: 1,
    };
    slave.get(&mut link, path, 7).unwrap()
}

#[test]
fn devicenet_fragments_without_data_or_out_of_order_end_the_response() {
    use devicenet::Response::{Done, Silent};
    let [first, second, last]: [&[u8]; 3] = [&[0x00, 0x8E, 1, 2], &[0x41, 3, 4], &[0x82, 5]];
    assert_eq!(fragments(&[first, second, last]), Done(vec![1, 2, 3, 4, 5]));
    // The acknowledge was lost.
    let repeated = [first, second, second, last, last];
    assert_eq!(fragments(&repeated), Done(vec![1, 2, 3, 4, 5]));
    assert_eq!(fragments(&[first, last]), Silent);
    assert_eq!(fragments(&[first, &[0x41], &[0x42], &[0x43], last]), Silent);
    assert_eq!(fragments(&[second; 10]), Silent);
}

#[test]
fn heartbeat_time_of_a_node_is_put_back_if_an_answer_is_lost() {
    let written: &[Frame] = &[frame(0x58A, &[0x60, 0x17, 0x10, 0, 0, 0, 0, 0])];
    let read = frame(0x58A, &[0x4B, 0x17, 0x10, 0, 0, 0, 0, 0]);
    let beat = frame(0x70A, &[5]);
    let begin = || vec![vec![read], [written, &[beat]].concat()];
    for lost in 0..3 {
        let adapter = Scripted::default();
        let mut link = link(&adapter);
        let silence = vec![Vec::new(); lost];
        adapter.0.borrow_mut().replies = [begin(), silence, vec![written.to_vec()]].concat().into();
        let state = nmt::state(&mut link, 10).unwrap();
        assert_eq!(
            state,
            Some(nmt::State::Operational),
            "{lost} answers are lost"
        );
        let sent = adapter.0.borrow().sent.len();
        assert_eq!(sent, 3 + lost);
    }
    // The answer to the write of the own time is lost.
    let adapter = Scripted::default();
    let mut link = link(&adapter);
    let replies = vec![vec![read], Vec::new(), written.to_vec()];
    adapter.0.borrow_mut().replies = replies.into();
    assert_eq!(nmt::state(&mut link, 10).unwrap(), None);
    let last = *adapter.0.borrow().sent.last().unwrap();
    assert_eq!(last.bytes(), [0x2B, 0x17, 0x10, 0, 0, 0, 0, 0]);
    let adapter = Scripted::default();
    let mut link = crate::link::tests::link(&adapter);
    adapter.0.borrow_mut().replies = begin().into();
    let failure = nmt::state(&mut link, 10).unwrap_err();
    assert_eq!(failure.code(), "not-put-back");
    assert!(
        failure.to_string().contains("write 0 ms to 1017h"),
        "{}",
        failure.to_string()
    );
}

#[test]
fn zero_point_is_set_once_though_its_reply_is_lost() {
    let product = crate::identify::product("is2").unwrap();
    let plumbline::model::catalog::Protocol::Fsc(tables) = &product.protocol else {
        panic!("is2 has function select codes");
    };
    let adapter = Scripted::default();
    let mut link = link(&adapter);
    adapter.0.borrow_mut().answers = vec![(0x02, vec![frame(0x301, &[0x02, 0])])];
    let sensor = fsc::Sensor {
        request: plumbline::can::CanId::standard(0x300),
        reply: None,
    };
    fsc::earlier(&mut link, sensor, tables).expect("a status");
    let failure = fsc::command(&mut link, sensor, tables, 0x28, &[], fsc::WRITTEN).unwrap_err();
    assert_eq!(failure.code(), "no-answer");
    let script = adapter.0.borrow();
    let sent: Vec<&[u8]> = script.sent.iter().map(Frame::bytes).collect();
    assert_eq!(sent, [&[0x02][..], &[0x28]]);
}

#[test]
fn adapter_with_few_buffers_continues_without_answers() {
    let ask = |places: usize, answers: bool| {
        let adapter = Scripted::default();
        let mut link = link(&adapter);
        link.open(Some(BitRate::K250), Mode::Active).unwrap();
        adapter.0.borrow_mut().places = Some(places);
        if answers {
            adapter.0.borrow_mut().answers = vec![(99, vec![frame(0x301, &[99])])];
        }
        let asked: Result<Vec<Option<()>>, Error> = (0..100)
            .map(|code| link.ask(&frame(0x300, &[code]), millis(10), |_| Some(())))
            .collect();
        asked
    };
    for places in [1, 3, 8, 64] {
        let asked = ask(places, true).unwrap();
        assert_eq!(asked.iter().position(Option::is_some), Some(99), "{places}");
    }
    // It takes no frame at all.
    assert_eq!(ask(0, false).unwrap_err().code(), "frame-refused");
}
