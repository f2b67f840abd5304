//! `scan` with an adapter that needs time to open.

use super::rig::Rig;
use adapter::Mode;
use bench::{Bus, BusRate};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::time::{after, millis};
use std::rc::Rc;

#[test]
fn silent_bus_is_listened_to_within_thirteen_seconds() {
    let mut rig = Rig::new(BusRate::Wire);
    // 3 ms for each of three answers.
    rig.opening = 9;
    let start = rig.bus.borrow().now();
    assert_eq!(rig.fails("scan"), (3, "nothing-found".to_owned()));
    let time = (rig.bus.borrow().now().ticks() - start.ticks()) / 1000;
    assert!((12_000..12_800).contains(&time), "{time} ms");
    assert_eq!(*rig.modes.borrow(), [Mode::Listen; 80]);
}

#[test]
fn message_at_the_border_of_two_steps_at_one_rate_is_heard() {
    const RATE: BitRate = BitRate::K250;
    for offset in (0..80).step_by(10) {
        let mut rig = Rig::new(BusRate::Wire);
        rig.listen(RATE);
        // The other one acknowledges, so the message comes once.
        let [sender, _] = [(); 2].map(|()| {
            let mut bus = rig.bus.borrow_mut();
            let id = bus.adapter();
            bus.open(id, Some(RATE), false);
            id
        });
        rig.opening = 50;
        // The opening, and the first step of 1021 ms.
        let at = after(rig.bus.borrow().now(), millis(50 + 1000 + offset));
        let message = Frame::data(standard(0x123), &[1]).unwrap();
        let happens = move |bus: &mut Bus| bus.send(sender, message);
        rig.events.push((at, Rc::new(happens)));
        let ended = rig.tool("--rate 250 scan");
        assert_eq!(ended.code, 3, "{offset} {ended:?}");
        assert!(ended.notes.contains("(123h)"), "{offset} {ended:?}");
        assert_eq!(*rig.modes.borrow(), [Mode::Listen], "{offset}");
        assert_eq!(rig.witnessed(), [message], "{offset}");
    }
}
