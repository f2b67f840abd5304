//! An slcan adapter on a bus with a frame in each read.

use super::super::Link;
use crate::scan::listen::collect;
use adapter::Mode;
use adapter::slcan::{Slcan, Stream};
use plumbline::can::{Frame, standard};
use plumbline::time::millis;
use std::cell::Cell;
use std::rc::Rc;
use std::{io, time};

/// More reads than all waits of a test take.
const MAX_READS: u32 = 2000;

/// A stream that answers each line with CR. When these are read, each read has a frame and takes 1 ms or more.
#[derive(Clone, Default)]
struct Busy {
    answers: Rc<Cell<usize>>,
    is_open: Rc<Cell<bool>>,
    reads: Rc<Cell<u32>>,
}

impl Stream for Busy {
    fn read(&mut self, bytes: &mut [u8], timeout: time::Duration) -> io::Result<usize> {
        let answers = self.answers.take();
        if answers > 0 {
            bytes[..answers].fill(b'\r');
            return Ok(answers);
        }
        let step = time::Duration::from_millis(1);
        if !self.is_open.get() {
            std::thread::sleep(timeout.min(step));
            return Ok(0);
        }
        std::thread::sleep(step);
        self.reads.set(self.reads.get() + 1);
        assert!(self.reads.get() < MAX_READS, "a wait does not end");
        let frame = b"t70A100\r";
        bytes[..frame.len()].copy_from_slice(frame);
        Ok(frame.len())
    }

    fn write(&mut self, _: &[u8]) -> io::Result<()> {
        self.answers.set(self.answers.get() + 1);
        Ok(())
    }
}

/// An open link to a busy bus, and the number of its reads.
fn link() -> (Link, Rc<Cell<u32>>) {
    let stream = Busy::default();
    let stopped: Rc<dyn Fn() -> bool> = Rc::new(|| false);
    let adapter = Slcan::new(stream.clone(), "test");
    let mut link = Link::new(Box::new(adapter), &stopped);
    link.open(None, Mode::Active).unwrap();
    stream.is_open.set(true);
    (link, stream.reads)
}

#[test]
fn waits_end_on_a_bus_with_a_frame_in_each_read() {
    let (mut link, reads) = link();
    let frames = collect(&mut link, millis(50)).unwrap();
    assert!((1..=50).contains(&frames.len()), "{}", frames.len());
    let question = Frame::data(standard(0x300), &[3]).unwrap();
    let answer = link.ask(&question, millis(50), |_| None::<()>).unwrap();
    assert_eq!(answer, None);
    // 50 ms, 10 ms for old frames, 50 ms and 100 ms for the answer, with at most a read in each ms.
    let reads = reads.get();
    assert!(reads < 300, "{reads}");
}

#[test]
fn question_on_a_bus_with_a_frame_in_each_read_is_sent_at_once() {
    let (mut link, reads) = link();
    let question = Frame::data(standard(0x300), &[3]).unwrap();
    // Each read takes 1 ms or more, so the load of the computer can only make them fewer.
    link.ask(&question, millis(0), |_| Some(())).unwrap();
    let reads = reads.get();
    assert!(reads < 50, "{reads}");
}
