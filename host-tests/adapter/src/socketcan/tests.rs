use super::*;
use plumbline::can::standard;
use plumbline::time::{after, millis};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use texts::Cause as _;

#[derive(Default)]
struct State {
    text: Option<&'static str>,
    missing: bool,
    is_down: bool,
    lost: Option<u64>,
    open: bool,
    written: Vec<String>,
    frames: VecDeque<CanFrame>,
    /// The time passes only while the adapter waits.
    passed: time::Duration,
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

    fn lost(&self) -> Option<u64> {
        self.0.borrow().lost
    }

    fn open(&mut self) -> io::Result<()> {
        if self.0.borrow().is_down {
            return Err(io::Error::other("Network is down"));
        }
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
        let state = &mut *self.0.borrow_mut();
        let frame = state.frames.pop_front();
        if frame.is_none() {
            state.passed += timeout;
        }
        Ok(frame)
    }

    fn elapsed(&self) -> time::Duration {
        self.0.borrow().passed
    }
}

const UP: &str = r#"[{"ifname":"can0","flags":["NOARP","UP"],"link_type":"can","linkinfo":{"info_kind":"can","info_data":{"state":"ERROR-ACTIVE","bittiming":{"bitrate":250000,"sample_point":0.875}}}}]"#;
const LISTENING: &str = r#"[{"ifname":"can0","link_type":"can","linkinfo":{"info_kind":"can","info_data":{"ctrlmode":["LISTEN-ONLY"],"bittiming":{"bitrate":250000}}}}]"#;

fn adapter(text: Option<&'static str>) -> (SocketCan<Fake>, Fake) {
    let fake = Fake::default();
    fake.0.borrow_mut().text = text;
    (SocketCan::new(fake.clone(), "can0").unwrap(), fake)
}

#[test]
fn interface_that_does_not_only_listen_is_not_opened_for_listening() {
    let (mut adapter, fake) = adapter(Some(UP));
    let failure = adapter.open(Some(BitRate::K250), Mode::Listen).unwrap_err();
    assert_eq!(failure.code(), "no-listen-only");
    assert!(
        failure
            .to_string()
            .contains("ip link set can0 type can bitrate 250000 listen-only on")
    );
    assert!(!fake.0.borrow().open);
}

#[test]
fn interface_with_another_rate_is_refused_with_what_to_type() {
    let (mut adapter, fake) = adapter(Some(UP));
    let failure = adapter.open(Some(BitRate::K125), Mode::Active).unwrap_err();
    assert_eq!(
        (failure.code(), failure.kind().exit_code()),
        ("wrong-rate", 4)
    );
    assert!(failure.to_string().contains("bitrate 125000"));
    assert!(!fake.0.borrow().open);
    adapter.open(Some(BitRate::K250), Mode::Active).unwrap();
    assert!(fake.0.borrow().open);
}

#[test]
fn listening_interface_is_opened_for_listening_only() {
    let (mut adapter, fake) = adapter(Some(LISTENING));
    assert_eq!(
        adapter.open(None, Mode::Active).unwrap_err().code(),
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
fn lost_frames_are_counted_since_the_interface_was_opened() {
    let (mut adapter, fake) = adapter(Some(UP));
    adapter.open(None, Mode::Active).unwrap();
    assert_eq!(adapter.overruns(), None);
    fake.0.borrow_mut().lost = Some(40);
    adapter.open(None, Mode::Active).unwrap();
    assert_eq!(adapter.overruns(), Some(0));
    fake.0.borrow_mut().lost = Some(43);
    assert_eq!(adapter.overruns(), Some(3));
}

#[test]
fn missing_interface_names_the_next_step() {
    let fake = Fake::default();
    fake.0.borrow_mut().missing = true;
    let failure = SocketCan::new(fake, "can7").err().unwrap();
    assert!(failure.to_string().contains("ip link"), "{failure}");
}

/// Needs `sudo ip link add dev vcan0 type vcan; sudo ip link set vcan0 up`.
#[test]
fn frames_pass_between_two_sockets_of_a_virtual_interface() {
    if !std::path::Path::new("/sys/class/net/vcan0").exists() {
        // Written directly to standard error, which the test harness does not capture.
        let _ = io::Write::write_all(&mut io::stderr(), b"skipped: there is no interface vcan0\n");
        return;
    }
    let [mut one, mut other] = [(); 2].map(|()| {
        let mut adapter = connect("vcan0").unwrap();
        adapter.open(Some(BitRate::K250), Mode::Active).unwrap();
        adapter
    });
    for frame in [
        Frame::data(standard(0x300), &[3]),
        Frame::data(
            plumbline::can::extended(0x18EA_FFFE),
            &[1, 2, 3, 4, 5, 6, 7, 8],
        ),
        Frame::remote(standard(0x701), 1),
    ] {
        let frame = frame.unwrap();
        one.send(&frame).unwrap();
        let until = after(other.now(), millis(10_000));
        let (_, received) = other.receive(until).unwrap().unwrap();
        assert_eq!(received, frame);
    }
}

#[test]
fn rate_of_the_open_interface_is_reported() {
    let (mut adapter, _) = adapter(Some(UP));
    assert_eq!(adapter.rate(), None);
    adapter.open(None, Mode::Active).unwrap();
    assert_eq!(adapter.rate(), Some(BitRate::K250));
    let virtual_one = r#"[{"link_type":"can","linkinfo":{"info_kind":"vcan"}}]"#;
    for text in [None, Some(virtual_one)] {
        let (mut adapter, _) = super::tests::adapter(text);
        adapter.open(None, Mode::Active).unwrap();
        assert_eq!(adapter.rate(), None, "{text:?}");
    }
}

/// What happens when an interface is opened to listen, and to take part at 125 kbit/s.
fn opened(text: &'static str) -> [Option<AdapterError>; 2] {
    [Mode::Listen, Mode::Active].map(|mode| {
        let (mut adapter, _) = adapter(Some(text));
        adapter.open(Some(BitRate::K125), mode).err()
    })
}

#[test]
fn interface_without_a_wire_is_opened_at_each_rate_by_its_kind_only() {
    let kind = |text| opened(text).map(|failure| failure.map(|own| own.code()));
    for text in [
        r#"[{"ifname":"bus7","link_type":"can","linkinfo":{"info_kind":"vcan"}}]"#,
        r#"[{"ifname":"vx0","link":"vx1","link_type":"can","linkinfo":{"info_kind":"vxcan"}}]"#,
        r#"[{"ifname":"can0","link_type":"can","linkinfo":{"info_kind":"vxcan","info_data":{}}}]"#,
    ] {
        assert_eq!(kind(text), [None, None], "{text}");
    }
    for text in [
        r#"[{"ifname":"vcan0","link_type":"can","linkinfo":{"info_kind":"can","info_data":{"bittiming":{"bitrate":250000}}}}]"#,
        r#"[{"ifname":"can0","ifalias":"vcan of the crane","link_type":"can","linkinfo":{"info_kind":"can","info_data":{"ctrlmode":["ONE-SHOT"],"bittiming_bitrate":250000,"bitrate_const":[125000,250000]}}}]"#,
    ] {
        let expected = [Some("no-listen-only"), Some("wrong-rate")];
        assert_eq!(kind(text), expected, "{text}");
    }
}

#[test]
fn advice_for_an_interface_is_one_that_its_kind_permits() {
    let old = r#"[{"ifname":"slcan0","link_type":"can"}]"#;
    let [listening, active] = opened(old);
    let listening = listening.unwrap();
    assert_eq!(listening.code(), "no-listen-only");
    assert!(!listening.to_string().contains("type can"), "{listening}");
    assert_eq!(active, None);
    let virtual_one = r#"[{"link_type":"can","linkinfo":{"info_kind":"vxcan"}}]"#;
    for (text, command) in [
        (old, "Type: sudo ip link set can0 up"),
        (virtual_one, "Type: sudo ip link set can0 up"),
        (UP, "type can bitrate 250000 listen-only off"),
    ] {
        let (mut adapter, fake) = adapter(Some(text));
        fake.0.borrow_mut().is_down = true;
        let failure = adapter.open(Some(BitRate::K250), Mode::Active).unwrap_err();
        assert!(failure.to_string().contains(command), "{failure}");
    }
}

#[test]
fn interface_of_another_network_is_no_adapter() {
    let fake = Fake::default();
    fake.0.borrow_mut().text = Some(r#"[{"ifname":"eth0","link_type":"ether"}]"#);
    let failure = SocketCan::new(fake, "eth0").err().unwrap();
    assert!(
        failure.to_string().contains("not a CAN interface"),
        "{failure}"
    );
}
