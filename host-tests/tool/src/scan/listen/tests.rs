use super::*;
use adapter::{Adapter, AdapterError, Capabilities};
use plumbline::can::standard;
use std::rc::Rc;

/// How late the computer is after each wait.
const LATE: Duration = millis(50);

/// An adapter with one frame, at a computer that is late.
struct Late {
    now: Instant,
    /// When the frame comes; None: it was read.
    frame: Option<Instant>,
    /// A late wait ends without a check of the frames that have arrived.
    is_blind: bool,
}

impl Adapter for Late {
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

    fn close(&mut self) {}

    fn send(&mut self, _: &Frame) -> Result<(), AdapterError> {
        panic!("the tool only listens");
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError> {
        let waits = self.now < until;
        if waits {
            self.now = after(until, LATE);
        }
        if (waits && self.is_blind) || self.frame.is_none_or(|at| at > self.now) {
            return Ok(None);
        }
        self.frame = None;
        let frame = Frame::data(standard(0x705), &[5]).unwrap();
        Ok(Some((self.now, frame)))
    }

    fn now(&self) -> Instant {
        self.now
    }

    fn errors(&mut self) -> Option<u64> {
        None
    }
}

/// What is heard of a frame at this time in ms.
fn heard(at: u32, is_blind: bool, listen: Listen) -> Option<Traffic> {
    let start = Instant::from_ticks(0);
    let stopped: Rc<dyn Fn() -> bool> = Rc::new(|| false);
    let late = Late {
        now: start,
        frame: Some(after(start, millis(at))),
        is_blind,
    };
    let mut link = Link::new(Box::new(late), &stopped);
    let mut terminal = Terminal {
        json: false,
        out: &mut std::io::sink(),
        notes: &mut std::io::sink(),
        confirm: &mut |_| false,
        stopped,
        bar: None,
        yes: &[],
    };
    listen(&mut link, &mut terminal)
}

type Listen = fn(&mut Link, &mut Terminal) -> Option<Traffic>;

#[test]
fn frame_before_the_end_is_received_if_the_computer_is_late() {
    const RATE: Option<BitRate> = Some(BitRate::K250);
    let step: Listen = |link, terminal| {
        let schedule = Schedule::of(&[RATE], false);
        all(link, &schedule, terminal).unwrap()
    };
    let known: Listen = |link, terminal| once(link, RATE, terminal).unwrap();
    for (end, listen) in [(1021, step), (1100, known)] {
        for is_blind in [false, true] {
            let traffic = heard(end - 10, is_blind, listen);
            let traffic = traffic.unwrap_or_else(|| panic!("{end} {is_blind}"));
            assert_eq!((traffic.rate, traffic.frames.len()), (RATE, 1));
        }
    }
}
