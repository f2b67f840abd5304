//! The two halves of a node under a driver that handles frames at a higher priority than readings: a frame waits until the node can take
//! it, and no action is lost. The time is always 0.

use crate::tester::canopen::frame;
use plumbline::application::Values;
use plumbline::can::{BitRate, Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::model::gemac::is1tk::{self, Is1tk};
use plumbline::model::gemac::is2::{self, Is2};
use plumbline::model::jn2101::Jn2101;
use plumbline::node::{Action, Boot, BusMode, CommunicationOf, Node, ProductNode, Task};
use plumbline::time::Instant;

const NOW: Instant = Instant::from_ticks(0);

const LEVEL: Reading = Reading {
    acceleration: I32x3 {
        x: 0,
        y: 0,
        z: ONE_G,
    },
    angular_rate: I32x3 { x: 0, y: 0, z: 0 },
    temperature: 0,
    clipped: false,
};

/// Requests of FSC: SAVE, LOAD, RESET, a write of the filter (27h), and a read of it (17h).
const SAVE: &str = "300#5053415645";
const LOAD: &str = "300#404C4F4144";
const RESET: &str = "300#FF5245534554";
const WRITE: &str = "300#27D00701";
const READ: &str = "300#17";

/// The next action after all steps of the timers.
fn action<N: ProductNode>(node: &mut CommunicationOf<N>) -> Option<Action> {
    while node.tick(NOW) {}
    node.action(NOW)
}

/// Passes a frame to the node, which must be ready.
fn receive<N: ProductNode>(node: &mut CommunicationOf<N>, text: &str) {
    assert!(node.ready(), "{text}");
    node.receive(NOW, &frame(text));
    while node.proceed() {}
}

fn sent<N: ProductNode>(node: &mut CommunicationOf<N>) -> Vec<String> {
    let frames = std::iter::from_fn(|| node.transmit());
    frames.map(|frame| format!("{frame:?}")).collect()
}

/// An IS2 that has detected the bit rate and sent its boot-up messages.
fn is2() -> Is2 {
    let mut node = Is2::new(&is2::BP_CL, NOW, &Boot::default());
    start(&mut node);
    node
}

fn start(node: &mut impl Node) {
    node.sample(NOW, &LEVEL);
    node.receive(NOW, &Frame::data(standard(0x7FF), &[]).unwrap());
    while node.poll(NOW).is_some() {}
    while node.transmit(NOW).is_some() {}
}

/// The read waits until the application has applied the values of an earlier write. Its reply contains these values.
#[test]
fn frame_waits_until_parameters_of_earlier_write_are_applied() {
    let mut node = is2();
    let (communication, acquisition) = node.halves();
    receive::<Is2>(communication, WRITE);
    assert!(!communication.ready());
    let task = communication.task(NOW).unwrap();
    assert!(matches!(task, Task::Apply(_)));
    let values = acquisition.perform(NOW, &task);
    assert!(!communication.ready(), "not published yet");
    communication.finish(NOW, &task, &values);
    assert!(communication.task(NOW).is_none());
    receive::<Is2>(communication, READ);
    assert_eq!(sent::<Is2>(communication), ["301#2702", "301#1702D00701"]);
}

#[test]
fn frame_waits_for_change_of_bit_rate() {
    let mut node = Jn2101::new(NOW, &Boot::default());
    node.sample(NOW, &LEVEL);
    let (communication, _) = node.halves();
    assert!(!communication.ready());
    assert_eq!(communication.transmit(), None);
    let change = Action::Bus(BusMode::Normal, BitRate::K125);
    assert_eq!(action::<Jn2101>(communication), Some(change));
    assert!(communication.ready());
    assert_eq!(sent::<Jn2101>(communication), ["70A#00"]);
}

#[test]
fn node_takes_no_frame_during_restart() {
    let mut node = is2();
    let (communication, acquisition) = node.halves();
    receive::<Is2>(communication, RESET);
    assert!(!communication.ready());
    let task = communication.task(NOW).unwrap();
    assert!(matches!(task, Task::Stale));
    let values = acquisition.perform(NOW, &task);
    communication.finish(NOW, &task, &values);
    assert_eq!(action::<Is2>(communication), Some(Action::Restart));
    assert!(!communication.ready());
}

/// Two requests wait for the end of a save. A later frame must not overtake them.
#[test]
fn frames_that_waited_for_save_are_handled_before_later_frames() {
    let mut node = is2();
    let (communication, acquisition) = node.halves();
    receive::<Is2>(communication, SAVE);
    assert_eq!(action::<Is2>(communication), Some(Action::Save));
    receive::<Is2>(communication, LOAD);
    assert!(communication.ready(), "one request waits");
    receive::<Is2>(communication, SAVE);
    assert!(!communication.ready(), "two requests wait");
    communication.stored(NOW, Ok(()));
    assert!(!communication.ready(), "the requests that waited are next");
    assert!(communication.resume(NOW));
    assert_eq!(action::<Is2>(communication), Some(Action::Save));
    assert!(!communication.resume(NOW), "the factory values are saved");
    // A read is answered during the save.
    receive::<Is2>(communication, READ);
    communication.stored(NOW, Ok(()));
    assert!(!communication.ready());
    assert!(!communication.resume(NOW), "not applied yet");
    let task = communication.task(NOW).unwrap();
    let values = acquisition.perform(NOW, &task);
    communication.finish(NOW, &task, &values);
    assert!(!communication.ready(), "the last request is next");
    assert!(communication.resume(NOW));
    assert!(communication.ready());
    assert_eq!(action::<Is2>(communication), Some(Action::Save));
    communication.stored(NOW, Ok(()));
    assert!(communication.ready() && !communication.resume(NOW));
    assert_eq!(
        sent::<Is2>(communication),
        ["301#5003", "301#1703D00702", "301#4003", "301#5003"]
    );
}

/// A frame can be handled between any two steps of the timers.
#[test]
fn save_that_begins_between_two_steps_is_not_lost() {
    for steps in 0..4 {
        let mut node = is2();
        let (communication, acquisition) = node.halves();
        // New values request the steps of the timers.
        let values = acquisition.sample(NOW, &Reading::default());
        communication.publish(NOW, &values);
        let more = (0..steps).all(|_| communication.tick(NOW));
        receive::<Is2>(communication, SAVE);
        if more {
            while communication.tick(NOW) {}
        }
        let mut actions: Vec<_> = communication.action(NOW).into_iter().collect();
        while !communication.is_idle(NOW) {
            actions.extend(action::<Is2>(communication));
        }
        assert_eq!(actions, [Action::Save], "{steps} steps");
    }
}

/// The heater is off during a restart, also if a value is published after the application has stopped.
#[test]
fn values_during_restart_do_not_switch_heater_on() {
    let mut node = Is1tk::new(&is1tk::METAL, NOW, &Boot::default());
    start(&mut node);
    let (communication, acquisition) = node.halves();
    let cold = Reading {
        temperature: 20_00,
        ..Reading::default()
    };
    let heating = acquisition.sample(NOW, &cold);
    communication.renew(&heating);
    communication.sampled(NOW);
    assert!(heating.outputs().heater() > Some(0));
    receive::<Is1tk>(communication, RESET);
    let task = communication.task(NOW).unwrap();
    let values = acquisition.perform(NOW, &task);
    communication.finish(NOW, &task, &values);
    assert_eq!(action::<Is1tk>(communication), Some(Action::Heater(0)));
    communication.publish(NOW, &heating);
    communication.renew(&heating);
    communication.sampled(NOW);
    while communication.transmit().is_some() {}
    assert_eq!(action::<Is1tk>(communication), Some(Action::Restart));
    assert_eq!(action::<Is1tk>(communication), None);
}
