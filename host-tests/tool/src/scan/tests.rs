//! Scans on an interface of Linux, which is opened as it is set.

use super::*;
use adapter::socketcan::{Interface, SocketCan};
use embedded_can::Frame as _;
use plumbline::can::standard;
use socketcan::CanFrame;
use std::cell::RefCell;
use std::rc::Rc;
use std::{io, time};

const UP: &str = r#"[{"ifname":"can0","flags":["NOARP","UP"],"link_type":"can","linkinfo":{"info_kind":"can","info_data":{"state":"ERROR-ACTIVE","bittiming":{"bitrate":250000,"sample_point":0.875}}}}]"#;
const LISTENING: &str = r#"[{"ifname":"can0","link_type":"can","linkinfo":{"info_kind":"can","info_data":{"ctrlmode":["LISTEN-ONLY"],"bittiming":{"bitrate":250000}}}}]"#;

#[derive(Default)]
struct State {
    /// What the kernel says of the interface.
    text: &'static str,
    written: Vec<String>,
    /// It comes each 50 ms.
    heartbeat: Option<CanFrame>,
    /// The time passes only while the adapter waits.
    passed: time::Duration,
}

#[derive(Clone, Default)]
struct Fake(Rc<RefCell<State>>);

impl Interface for Fake {
    fn describe(&self) -> io::Result<Option<String>> {
        Ok(Some(self.0.borrow().text.to_owned()))
    }

    fn lost(&self) -> Option<u64> {
        None
    }

    fn open(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn close(&mut self) {}

    fn write(&mut self, frame: &CanFrame) -> io::Result<()> {
        let frame = format!("{:?} {:02X?}", frame.id(), frame.data());
        self.0.borrow_mut().written.push(frame);
        Ok(())
    }

    fn read(&mut self, timeout: time::Duration) -> io::Result<Option<CanFrame>> {
        let state = &mut *self.0.borrow_mut();
        state.passed += match state.heartbeat {
            Some(_) => timeout.min(time::Duration::from_millis(50)),
            None => timeout,
        };
        Ok(state.heartbeat)
    }

    fn elapsed(&self) -> time::Duration {
        self.0.borrow().passed
    }
}

/// Scans an interface with a node that sends this heartbeat, but answers nothing. Returns the failure, the rows, and the notes.
fn scanned(text: &'static str, heartbeat: &[u8]) -> (Option<Error>, String, String, Fake) {
    let heartbeat = CanFrame::new(standard(0x70A), heartbeat);
    let fake = Fake::default();
    *fake.0.borrow_mut() = State {
        text,
        heartbeat: heartbeat.filter(|frame| !frame.data().is_empty()),
        ..State::default()
    };
    let adapter = SocketCan::new(fake.clone(), "can0").unwrap();
    let (mut out, mut notes) = (Vec::new(), Vec::new());
    let mut terminal = Terminal {
        json: false,
        out: &mut out,
        notes: &mut notes,
        confirm: &mut |_| false,
        stopped: Rc::new(|| false),
        bar: None,
        yes: &[],
    };
    let options = Options::default();
    let result = run(Box::new(adapter), options, Labels::default(), &mut terminal);
    let [out, notes] = [out, notes].map(|text| String::from_utf8(text).unwrap());
    (result.err(), out, notes, fake)
}

#[test]
fn scan_of_listening_interface_shows_what_it_heard_and_what_to_type() {
    let (failure, rows, notes, fake) = scanned(LISTENING, &[5]);
    assert_eq!(failure, None);
    assert!(rows.contains("canopen  -  address 10"), "{rows}");
    assert!(notes.contains("listen-only off"), "{notes}");
    assert!(!notes.contains("takes part"), "{notes}");
    assert!(notes.ends_with("\nnothing was sent\n"), "{notes}");
    assert!(fake.0.borrow().written.is_empty());
}

#[test]
fn scan_of_active_interface_listens_before_it_asks() {
    let (failure, rows, notes, fake) = scanned(UP, &[5]);
    assert_eq!(failure, None);
    assert!(rows.contains("canopen  -  address 10"), "{rows}");
    // Only the node that was heard is asked.
    let written = &fake.0.borrow().written;
    assert!(!written.is_empty());
    assert!(
        written.iter().all(|frame| frame.contains("1546")),
        "{written:?}"
    );
    says_that_it_takes_part(&notes);
}

/// The note is there once, with what to type.
#[track_caller]
fn says_that_it_takes_part(notes: &str) {
    let notes: Vec<&str> = notes
        .lines()
        .filter(|note| note.contains("takes part in the bus"))
        .collect();
    let commands = "ip link set can0 type can bitrate 250000 listen-only on";
    assert!(notes.len() == 1 && notes[0].contains(commands), "{notes:?}");
}

#[test]
fn scan_of_active_interface_without_traffic_says_that_it_acknowledges() {
    let (failure, _, notes, fake) = scanned(UP, &[]);
    assert_eq!(failure.unwrap().code(), "nothing-found");
    assert!(fake.0.borrow().written.is_empty());
    says_that_it_takes_part(&notes);
    let last = "nothing was sent, but the messages of other devices were acknowledged\n";
    assert!(notes.ends_with(last), "{notes}");
}
