mod pdos;

use super::*;
use crate::identify::product;
use crate::link::Link;
use crate::sheet::Sheet;
use adapter::{Adapter, AdapterError, Capabilities, Mode};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::time::{Instant, after};
use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;

const NODE: u8 = 10;
const PRE_OPERATIONAL: u8 = 0x7F;
const OPERATIONAL: u8 = 5;

/// A node that refuses writes while it stores, or in the state Operational.
struct Node {
    now: Instant,
    state: u8,
    /// It stores until then.
    stores: Instant,
    forbids_operational: bool,
    /// The next heartbeat.
    heartbeat: Instant,
    objects: BTreeMap<[u8; 3], [u8; 4]>,
    frames: VecDeque<(Instant, Frame)>,
    /// The NMT commands that it has got.
    commands: Vec<u8>,
    /// Its PDOs change only while they are off, and this object cannot be mapped.
    unmappable: Option<u32>,
    refusals: usize,
}

impl Node {
    fn period(&self) -> u32 {
        let value = self.objects.get(&[0x17, 0x10, 0]);
        value.map_or(0, |value| u32::from_le_bytes(*value))
    }

    fn answer(&mut self, request: [u8; 8]) -> [u8; 8] {
        let [command, a, b, c, value @ ..] = request;
        let key = [a, b, c];
        if command == 0x40 {
            let [v, w, x, y] = self.objects.get(&key).copied().unwrap_or_default();
            let size = match b {
                0x14..=0x1A => 0x43,
                _ if key == [0x17, 0x10, 0] => 0x4B,
                _ => 0x4F,
            };
            return [size, a, b, c, v, w, x, y];
        }
        let is_heartbeat = key == [0x17, 0x10, 0];
        let is_forbidden = self.forbids_operational && self.state == OPERATIONAL;
        if self.now < self.stores || (is_forbidden && !is_heartbeat) {
            self.refusals += 1;
            return [0x80, a, b, c, 0x22, 0, 0, 8];
        }
        if self.unmappable.is_some() && self.refuses(key, u32::from_le_bytes(value)) {
            self.refusals += 1;
            return [0x80, a, b, c, 0x30, 0, 9, 6];
        }
        self.objects.insert(key, value);
        self.heartbeat = after(self.now, millis(self.period()));
        [0x60, a, b, c, 0, 0, 0, 0]
    }
}

#[derive(Clone)]
struct Bus(Rc<RefCell<Node>>);

impl Adapter for Bus {
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

    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError> {
        let node = &mut *self.0.borrow_mut();
        match (frame.can_id().bits(), frame.bytes()) {
            (0, &[command, NODE]) => {
                node.commands.push(command);
                match command {
                    1 => node.state = OPERATIONAL,
                    128 => node.state = PRE_OPERATIONAL,
                    _ => {}
                }
            }
            (0x60A, bytes) => {
                let answer = node.answer(bytes.try_into().unwrap());
                let frame = Frame::data(standard(0x58A), &answer).unwrap();
                let at = after(node.now, millis(1));
                node.frames.push_back((at, frame));
            }
            _ => {}
        }
        Ok(())
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError> {
        let node = &mut *self.0.borrow_mut();
        if let Some(received) = node.frames.pop_front() {
            node.now = node.now.max(received.0);
            return Ok(Some(received));
        }
        if node.period() != 0 && node.heartbeat <= until {
            node.now = node.now.max(node.heartbeat);
            node.heartbeat = after(node.now, millis(node.period()));
            let frame = Frame::data(standard(0x70A), &[node.state]).unwrap();
            return Ok(Some((node.now, frame)));
        }
        node.now = node.now.max(until);
        Ok(None)
    }

    fn now(&self) -> Instant {
        self.0.borrow().now
    }

    fn errors(&mut self) -> Option<u64> {
        None
    }
}

/// A session with a node that has this sheet.
fn session(node: &Rc<RefCell<Node>>, sheet: Sheet) -> Session {
    let never: Rc<dyn Fn() -> bool> = Rc::new(|| false);
    let link = Link::new(Box::new(Bus(node.clone())), &never);
    Session::with_sheet(
        link,
        crate::master::Target::Canopen(crate::master::Node(NODE)),
        sheet,
    )
}

/// Writes a setting to a node in this state, which stores for some time. Returns the result and the node.
fn written(
    state: u8,
    stores: u32,
    forbids_operational: bool,
    heartbeat: u32,
) -> (Result<(), Error>, Rc<RefCell<Node>>) {
    let start = Instant::from_ticks(0);
    let node = Rc::new(RefCell::new(Node {
        now: start,
        state,
        stores: after(start, millis(stores)),
        forbids_operational,
        heartbeat: after(start, millis(heartbeat)),
        objects: BTreeMap::from([([0x17, 0x10, 0], heartbeat.to_le_bytes())]),
        frames: VecDeque::new(),
        commands: Vec::new(),
        unmappable: None,
        refusals: 0,
    }));
    let mut session = session(&node, Sheet::of(product("jn2101").unwrap()));
    let settings = session.sheet.settings();
    let filter = settings.filter(|entry| entry.name == "filter");
    let values: Values = filter.map(|entry| (entry.clone(), 1)).collect();
    assert_eq!(values.len(), 1);
    let result = write(&mut session, &values);
    (result, node)
}

#[test]
fn tool_waits_for_a_node_that_stores_and_sends_no_command() {
    for heartbeat in [0, 200] {
        let (result, node) = written(PRE_OPERATIONAL, 700, false, heartbeat);
        let node = node.borrow();
        assert_eq!(result, Ok(()), "{heartbeat}");
        assert_eq!(node.commands, [0; 0], "{heartbeat}");
        assert!(node.refusals > 3, "{}", node.refusals);
        assert_eq!(node.period(), heartbeat);
    }
}

#[test]
fn operational_node_that_forbids_a_write_is_pre_operational_meanwhile() {
    for heartbeat in [0, 200] {
        let (result, node) = written(OPERATIONAL, 0, true, heartbeat);
        let node = node.borrow();
        assert_eq!(result, Ok(()), "{heartbeat}");
        assert_eq!(node.commands, [128, 1], "{heartbeat}");
        assert_eq!(node.period(), heartbeat);
    }
}

#[test]
fn node_that_stays_in_a_wrong_state_ends_the_write() {
    let (result, node) = written(PRE_OPERATIONAL, 60_000, false, 200);
    assert_eq!(result.unwrap_err().code(), "wrong-state");
    assert_eq!(node.borrow().commands, [0; 0]);
    assert!(node.borrow().now < Instant::from_ticks(5_000_000));
}
