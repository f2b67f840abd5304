//! A scripted node for the tests of the bench itself.
//!
//! With serial number n it boots at 250 kbit/s (or detects the rate), sends a boot-up frame `10n#` with the content of the
//! memory, and answers commands on `20n`. A journal records all its inputs.

use crate::{Device, Flash, NodeType, Starts};
use plumbline::can::{BitRate, Filter, Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::node::{Action, Boot, BusEvent, BusMode, BusState, Leds, Node, Readout};
use plumbline::store::{ImageId, StoreError};
use plumbline::time::{Duration, Instant, after, millis, reached};
use std::cell::RefCell;
use std::collections::VecDeque;

/// The size of the parameters of the scripted node.
pub const PAYLOAD: usize = 40;

/// Commands in the first byte of a frame `20n`.
pub mod command {
    /// Reply with the same data on `30n`.
    pub const ECHO: u8 = 1;
    /// Save parameters filled with the second byte; reply on `30n` with 00h, or with FFh when that failed.
    pub const SAVE: u8 = 2;
    /// Reply on `30n`, then restart.
    pub const RESTART: u8 = 3;
    /// Send the number of frames in the second byte, with identifiers 10n.
    pub const BURST: u8 = 4;
    /// Refuse further frames for the milliseconds in the second byte.
    pub const PAUSE: u8 = 5;
    /// Go to the bit rate with the index of the second byte.
    pub const RATE: u8 = 6;
}

/// An input of a node.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Entry {
    /// The node has received this frame.
    Frame(Frame),
    /// An event on the bus.
    Event(BusEvent),
    /// The accelerometer has a reading.
    Sample,
    /// A save has ended with this result.
    Stored(Result<(), StoreError>),
}

thread_local! {
    static JOURNAL: RefCell<Vec<(u32, Instant, Entry)>> = const { RefCell::new(Vec::new()) };
}

/// The inputs of the node with this serial number, without samples.
pub fn journal(serial: u32) -> Vec<(Instant, Entry)> {
    JOURNAL.with_borrow(|journal| {
        journal
            .iter()
            .filter(|(of, _, entry)| *of == serial && *entry != Entry::Sample)
            .map(|(_, at, entry)| (*at, *entry))
            .collect()
    })
}

/// The times at which the node with this serial number got its samples.
pub fn samples(serial: u32) -> Vec<Instant> {
    JOURNAL.with_borrow(|journal| {
        journal
            .iter()
            .filter(|(of, _, entry)| *of == serial && *entry == Entry::Sample)
            .map(|(_, at, _)| *at)
            .collect()
    })
}

/// The bus states reported to the node with this serial number.
pub fn states(serial: u32) -> Vec<BusState> {
    journal(serial)
        .into_iter()
        .filter_map(|(_, entry)| match entry {
            Entry::Event(BusEvent::State(state)) => Some(state),
            _ => None,
        })
        .collect()
}

/// The scripted node at a fixed rate.
pub const FIXED: NodeType = NodeType {
    name: "fixed",
    article: None,
    image: ImageId::new(0x7E57),
    layout: 1,
    cell: None,
    first_reading: millis(0),
    starts: Starts::Function(|_, boot| Box::new(Script::new(boot, false))),
};

/// The scripted node with automatic bit rate detection.
pub const DETECTING: NodeType = NodeType {
    name: "detecting",
    starts: Starts::Function(|_, boot| Box::new(Script::new(boot, true))),
    ..FIXED
};

/// A node whose `poll` never returns None.
pub const ENDLESS: NodeType = NodeType {
    name: "endless",
    starts: Starts::Function(|_, boot| {
        let mut script = Script::new(boot, false);
        script.endless = true;
        Box::new(script)
    }),
    ..FIXED
};

/// A sensor in level position.
pub const LEVEL: Reading = Reading {
    acceleration: I32x3 {
        x: 0,
        y: 0,
        z: ONE_G,
    },
    angular_rate: I32x3 { x: 0, y: 0, z: 0 },
    temperature: 2500,
    clipped: false,
};

/// A device with a blank memory.
pub fn device(node_type: &NodeType, serial: u32) -> Device {
    Device::new(node_type, serial, Flash::default(), Box::new(LEVEL))
}

/// A data frame with an 11-bit identifier.
pub fn frame(id: u32, data: &[u8]) -> Frame {
    Frame::data(standard(id as u16), data).unwrap()
}

/// The point in time `us` microseconds after power-up.
pub fn us(us: u64) -> Instant {
    Instant::from_ticks(us)
}

/// The point in time `ms` milliseconds after power-up.
pub fn ms(ms: u64) -> Instant {
    us(ms * 1000)
}

struct Script {
    serial: u32,
    detecting: bool,
    /// The rate at which it listens while it detects.
    rate: BitRate,
    actions: VecDeque<Action>,
    outbox: VecDeque<Frame>,
    /// The parameters that it saves.
    image: Vec<u8>,
    paused_until: Option<Instant>,
    saving: bool,
    endless: bool,
}

impl Script {
    fn new(boot: &Boot, detecting: bool) -> Self {
        let serial = boot.serial;
        let mut script = Self {
            serial,
            detecting,
            rate: BitRate::K10,
            actions: VecDeque::new(),
            outbox: VecDeque::new(),
            image: Vec::new(),
            paused_until: None,
            saving: false,
            endless: false,
        };
        let first = boot.parameters.and_then(<[u8]>::first);
        let held = [first.copied().unwrap_or(0xFF), u8::from(boot.damaged)];
        script.outbox.push_back(frame(0x100 + serial, &held));
        script.actions.push_back(if detecting {
            Action::Bus(BusMode::Listen, script.rate)
        } else {
            Action::Bus(BusMode::Normal, BitRate::K250)
        });
        script
    }

    fn note(&self, now: Instant, entry: Entry) {
        JOURNAL.with_borrow_mut(|journal| journal.push((self.serial, now, entry)));
    }

    fn reply(&mut self, data: &[u8]) {
        self.outbox.push_back(frame(0x300 + self.serial, data));
    }
}

impl Node for Script {
    fn ready(&self) -> bool {
        self.paused_until.is_none() && !self.saving
    }

    fn receive(&mut self, now: Instant, received: &Frame) {
        self.note(now, Entry::Frame(*received));
        if self.detecting {
            self.detecting = false;
            self.actions
                .push_back(Action::Bus(BusMode::Normal, self.rate));
            return;
        }
        match *received.bytes() {
            [command::ECHO, ..] => self.reply(received.bytes()),
            [command::SAVE, value] => {
                self.image = vec![value; PAYLOAD];
                self.actions.push_back(Action::Save);
                self.saving = true;
            }
            [command::RESTART] => {
                self.reply(&[]);
                self.actions.push_back(Action::Restart);
            }
            [command::BURST, count] => {
                for number in 0..count {
                    let burst = frame(0x100 + self.serial, &[number]);
                    self.outbox.push_back(burst);
                }
            }
            [command::PAUSE, ms] => {
                self.paused_until = Some(after(now, Duration::from_ticks(u64::from(ms) * 1000)));
            }
            [command::RATE, index] => {
                let rate = BitRate::ALL[usize::from(index)];
                self.actions.push_back(Action::Bus(BusMode::Normal, rate));
            }
            _ => {}
        }
    }

    fn sample(&mut self, now: Instant, _: &Reading) {
        self.note(now, Entry::Sample);
    }

    fn bus(&mut self, now: Instant, event: BusEvent) {
        self.note(now, Entry::Event(event));
        match event {
            BusEvent::BitTime(time) if self.detecting && time.nearest_rate() != self.rate => {
                self.rate = time.nearest_rate();
                self.actions
                    .push_back(Action::Bus(BusMode::Listen, self.rate));
            }
            BusEvent::State(state) => {
                self.actions.push_back(Action::Leds(Leds {
                    run: true,
                    error: state != BusState::Active,
                    ..Leds::default()
                }));
                if state == BusState::BusOff {
                    self.actions.push_back(Action::Recover);
                }
            }
            _ => {}
        }
    }

    fn stored(&mut self, now: Instant, result: Result<(), StoreError>) {
        self.note(now, Entry::Stored(result));
        self.saving = false;
        self.reply(&[if result.is_ok() { 0 } else { 0xFF }]);
    }

    fn poll(&mut self, now: Instant) -> Option<Action> {
        if self.paused_until.is_some_and(|until| reached(now, until)) {
            self.paused_until = None;
        }
        if self.endless {
            return Some(Action::Leds(Leds::default()));
        }
        self.actions.pop_front()
    }

    fn transmit(&mut self, _: Instant) -> Option<Frame> {
        self.outbox.pop_front()
    }

    fn deadline(&self) -> Option<Instant> {
        self.paused_until
    }

    fn filters(&self, accept: &mut dyn FnMut(Filter)) {
        accept(Filter::exact(standard(0x200 + self.serial as u16)));
    }

    fn image(&self, buffer: &mut [u8]) -> Option<usize> {
        buffer.get_mut(..PAYLOAD)?.copy_from_slice(&self.image);
        Some(PAYLOAD)
    }

    fn readout(&self) -> Readout {
        Readout { x: 0, y: None }
    }
}
