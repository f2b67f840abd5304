use super::*;
use adapter::bench::BenchAdapter;
use adapter::{Adapter, Mode};
use bench::{AdapterId, Bus, BusRate};
use plumbline::can::{BitRate, extended};
use std::cell::RefCell;
use std::rc::Rc;

/// A bus with another node, and a link of the tool.
fn bus() -> (Rc<RefCell<Bus>>, AdapterId, Link) {
    let mut bus = Bus::new(BusRate::Fixed(BitRate::K250));
    let other = bus.adapter();
    bus.open(other, Some(BitRate::K250), false);
    let bus = Rc::new(RefCell::new(bus));
    let never: Rc<dyn Fn() -> bool> = Rc::new(|| false);
    let adapter: Box<dyn Adapter> = Box::new(BenchAdapter::new(&bus));
    let mut link = Link::new(adapter, &never);
    link.open(Some(BitRate::K250), Mode::Active).unwrap();
    (bus, other, link)
}

fn frame(id: u32, bytes: &[u8]) -> Frame {
    Frame::data(extended(id), bytes).unwrap()
}

/// The frames that the other node has received.
fn heard(bus: &Rc<RefCell<Bus>>, other: AdapterId) -> Vec<String> {
    let frames = bus.borrow_mut().take_received(other);
    frames
        .iter()
        .map(|(_, frame)| format!("{frame:?}"))
        .collect()
}

#[test]
fn address_is_claimed_only_when_it_is_needed() {
    let (bus, other, mut link) = bus();
    assert_eq!(nodes(&mut link).unwrap(), []);
    assert_eq!(heard(&bus, other), ["18EAFFFE#00EE00"]);
    assert_eq!(link.own_address().unwrap(), 249);
    let seen = heard(&bus, other);
    assert_eq!(seen[0], "18EAFFFE#00EE00");
    assert!(seen[1].starts_with("18EEFFF9#"), "{seen:?}");
    assert_eq!(seen.len(), 2);
    assert_eq!(link.own_address().unwrap(), 249);
    assert_eq!(heard(&bus, other), [""; 0], "once");
}

#[test]
fn address_in_use_is_left_to_its_owner() {
    let (bus, other, mut link) = bus();
    // The claims of others come while the tool asks who is there.
    let name = [1, 0, 0, 0, 0, 0, 0, 0];
    bus.borrow_mut().send(other, frame(0x18EE_FFF9, &name));
    assert_eq!(link.own_address().unwrap(), 250);
    heard(&bus, other);
    // A lower NAME wins: the tool takes another address at once.
    bus.borrow_mut().send(other, frame(0x18EE_FFFA, &name));
    link.wait_for(millis(20), |_| None::<()>).unwrap();
    let seen = heard(&bus, other);
    assert!(seen[0].starts_with("18EEFF80#"), "{seen:?}");
    let next = link.own_address().unwrap();
    assert!((128..=247).contains(&next), "{next}");
    heard(&bus, other);
    // A higher NAME does not: the tool defends its address. It answers who asks.
    let claim = 0x18EE_FF00 | u32::from(next);
    bus.borrow_mut().send(other, frame(claim, &[0xFF; 8]));
    bus.borrow_mut()
        .send(other, frame(0x18EA_FF21, &[0, 0xEE, 0]));
    link.wait_for(millis(20), |_| None::<()>).unwrap();
    let seen = heard(&bus, other);
    let own = format!("{claim:08X}#");
    assert_eq!(seen.len(), 2, "{seen:?}");
    assert!(seen.iter().all(|frame| frame.starts_with(&own)), "{seen:?}");
}
