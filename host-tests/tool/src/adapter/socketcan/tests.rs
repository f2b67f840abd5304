use super::*;
use plumbline::can::standard;
use plumbline::time::{after, millis};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

#[derive(Default)]
struct State {
    text: Option<&'static str>,
    missing: bool,
    open: bool,
    written: Vec<String>,
    frames: VecDeque<CanFrame>,
}

#[derive(Clone, Default)]
struct Fake(Rc<RefCell<State>>);

impl Interface for Fake {
    fn describe(&self) -> io::Result<Option<String>> {
        let state = self.0.borrow();
        if state.missing {
            return Err(io::ErrorKind::NotFound.into());
        }
        Ok(state.text.map(str::to_owned))
    }

    fn open(&mut self) -> io::Result<()> {
        self.0.borrow_mut().open = true;
        Ok(())
    }

    fn close(&mut self) {
        self.0.borrow_mut().open = false;
    }

    fn write(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.0
            .borrow_mut()
            .written
            .push(format!("{:?} {:02X?}", frame.id(), frame.data()));
        Ok(())
    }

    fn read(&mut self, timeout: time::Duration) -> io::Result<Option<CanFrame>> {
        let frame = self.0.borrow_mut().frames.pop_front();
        if frame.is_none() {
            std::thread::sleep(timeout);
        }
        Ok(frame)
    }
}

const UP: &str = "3: can0: <NOARP,UP> state UP\n link/can\n can state ERROR-ACTIVE\n bitrate 250000 sample-point 0.875";
const LISTENING: &str =
    "3: can0: <NOARP,UP>\n can <LISTEN-ONLY> state ERROR-ACTIVE\n bitrate 250000";

fn adapter(text: Option<&'static str>) -> (SocketCan<Fake>, Fake) {
    let fake = Fake::default();
    fake.0.borrow_mut().text = text;
    (SocketCan::new(fake.clone(), "can0").unwrap(), fake)
}

#[test]
fn interface_that_does_not_only_listen_is_not_opened_for_listening() {
    let (mut adapter, fake) = adapter(Some(UP));
    let failure = adapter.open(Some(BitRate::K250), Mode::Listen).unwrap_err();
    assert_eq!(failure.code, "no-listen-only");
    assert!(
        failure
            .message
            .contains("ip link set can0 type can bitrate 250000 listen-only on")
    );
    assert!(!fake.0.borrow().open);
}

#[test]
fn interface_with_another_rate_is_refused_with_what_to_type() {
    let (mut adapter, fake) = adapter(Some(UP));
    let failure = adapter.open(Some(BitRate::K125), Mode::Active).unwrap_err();
    assert_eq!((failure.code, failure.kind.exit_code()), ("wrong-rate", 4));
    assert!(failure.message.contains("bitrate 125000"));
    assert!(!fake.0.borrow().open);
    adapter.open(Some(BitRate::K250), Mode::Active).unwrap();
    assert!(fake.0.borrow().open);
}

#[test]
fn listening_interface_is_opened_for_listening_only() {
    let (mut adapter, fake) = adapter(Some(LISTENING));
    assert_eq!(
        adapter.open(None, Mode::Active).unwrap_err().code,
        "only-listens"
    );
    adapter.open(None, Mode::Listen).unwrap();
    assert!(
        adapter
            .send(&Frame::data(standard(1), &[2]).unwrap())
            .is_err()
    );
    assert!(fake.0.borrow().written.is_empty());
}

#[test]
fn frames_pass_in_both_directions() {
    let (mut adapter, fake) = adapter(Some(UP));
    adapter.open(None, Mode::Active).unwrap();
    adapter
        .send(&Frame::data(standard(0x300), &[0x10]).unwrap())
        .unwrap();
    assert_eq!(fake.0.borrow().written.len(), 1);
    let id = standard(0x301);
    fake.0
        .borrow_mut()
        .frames
        .push_back(CanFrame::new(id, &[1, 2]).unwrap());
    let until = after(adapter.now(), millis(20));
    let (_, frame) = adapter.receive(until).unwrap().unwrap();
    assert_eq!(format!("{frame:?}"), "301#0102");
    assert_eq!(adapter.receive(until).unwrap(), None);
}

#[test]
fn missing_interface_names_the_next_step() {
    let fake = Fake::default();
    fake.0.borrow_mut().missing = true;
    let failure = SocketCan::new(fake, "can7").err().unwrap();
    assert!(failure.message.contains("ip link"), "{failure}");
}
