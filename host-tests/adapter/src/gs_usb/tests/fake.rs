//! A candleLight adapter at the level of its USB transfers, with a virtual bus if wanted.

use super::super::{Layout, Usb};
use crate::bench::{BenchAdapter, SharedBus};
use crate::{Adapter, Mode};
use plumbline::can::{BitRate, CanId, Frame};
use plumbline::time::{Duration as Span, after};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;
use std::time::Duration;

/// An interface descriptor with this number, number of endpoints and class.
pub const fn interface(number: u8, endpoints: u8, class: u8) -> [u8; 9] {
    [9, 4, number, 0, endpoints, class, 0xFF, 0xFF, 0]
}

/// An endpoint descriptor with this address, type (2 bulk, 3 interrupt) and packet size.
pub const fn endpoint(address: u8, kind: u8, packet: u8) -> [u8; 7] {
    [7, 5, address, kind, packet, 0, 0]
}

/// The configuration of a candleLight adapter: the CAN interface, and one for its update.
pub const CANDLE_LIGHT: [u8; 50] = [
    9, 2, 50, 0, 2, 1, 0, 0x80, 75, //
    9, 4, 0, 0, 2, 0xFF, 0xFF, 0xFF, 0, //
    7, 5, 0x81, 2, 32, 0, 0, //
    7, 5, 0x02, 2, 32, 0, 0, //
    9, 4, 1, 0, 0, 0xFE, 1, 1, 0, //
    9, 0x21, 0x0B, 0xFF, 0, 0, 8, 0x1A, 1,
];

/// A request that the adapter has received: request, value, data.
pub type Request = (u8, u16, Vec<u8>);

/// What the adapter is and does.
pub struct State {
    /// The words of BT_CONST.
    pub constants: Vec<u32>,
    pub layout: Option<Layout>,
    pub requests: Vec<Request>,
    pub is_running: bool,
    /// The transfers to it.
    pub written: Vec<Vec<u8>>,
    /// The transfers from it.
    pub transfers: VecDeque<Vec<u8>>,
    /// Another node acknowledges its frames.
    pub is_acknowledged: bool,
    /// It takes no frame.
    pub is_stuck: bool,
    pub is_unplugged: bool,
    /// State and error counters.
    pub counters: [u32; 3],
    /// The bus, and the bit timing of its adapter.
    pub bus: Option<BenchAdapter>,
    timing: Vec<u32>,
}

/// The adapter of the test and of [`super::super::GsUsb`].
#[derive(Clone)]
pub struct Fake(pub Rc<RefCell<State>>);

impl Fake {
    /// A candleLight adapter with a clock of 48 MHz and these features.
    pub fn new(features: u32) -> Self {
        Self(Rc::new(RefCell::new(State {
            constants: vec![features, 48_000_000, 1, 16, 1, 8, 4, 1, 1024, 1],
            layout: None,
            requests: Vec::new(),
            is_running: false,
            written: Vec::new(),
            transfers: VecDeque::new(),
            is_acknowledged: true,
            is_stuck: false,
            is_unplugged: false,
            counters: [0; 3],
            bus: None,
            timing: Vec::new(),
        })))
    }

    /// One on this bus.
    pub fn on(bus: &SharedBus) -> Self {
        let fake = Self::new(1);
        fake.0.borrow_mut().bus = Some(BenchAdapter::new(bus));
        fake
    }

    /// The requests since the last call.
    pub fn requests(&self) -> Vec<Request> {
        std::mem::take(&mut self.0.borrow_mut().requests)
    }

    /// The transfers to it since the last call.
    pub fn written(&self) -> Vec<Vec<u8>> {
        std::mem::take(&mut self.0.borrow_mut().written)
    }

    /// It sends this transfer.
    pub fn transfer(&self, bytes: &[u8]) {
        self.0.borrow_mut().transfers.push_back(bytes.to_vec());
    }
}

impl State {
    fn plugged(&self) -> io::Result<()> {
        match self.is_unplugged {
            true => Err(io::ErrorKind::ConnectionAborted.into()),
            false => Ok(()),
        }
    }

    fn start(&mut self, flags: u32) {
        self.is_running = true;
        let mode = if flags & 1 != 0 {
            Mode::Listen
        } else {
            Mode::Active
        };
        let [propagation, phase_1, phase_2, _, prescaler] = self.timing[..] else {
            panic!("started without a bit timing");
        };
        let clocks = prescaler * (1 + propagation + phase_1 + phase_2);
        let mut rates = BitRate::ALL.into_iter();
        let rate = rates.find(|rate| rate.bits_per_second() * clocks == self.constants[1]);
        if let Some(bus) = &mut self.bus {
            bus.open(Some(rate.expect("an exact rate")), mode).unwrap();
        }
    }

    fn stop(&mut self) {
        self.is_running = false;
        if let Some(bus) = &mut self.bus {
            bus.close();
        }
    }
}

fn words(bytes: &[u8]) -> Vec<u32> {
    let words = bytes.chunks_exact(4);
    words
        .map(|word| u32::from_le_bytes(word.try_into().unwrap()))
        .collect()
}

impl Usb for Fake {
    fn configuration(&self) -> Vec<u8> {
        CANDLE_LIGHT.to_vec()
    }

    fn claim(&mut self, layout: &Layout) -> io::Result<()> {
        self.0.borrow_mut().layout = Some(*layout);
        Ok(())
    }

    fn control_out(&mut self, request: u8, value: u16, data: &[u8]) -> io::Result<()> {
        let mut state = self.0.borrow_mut();
        state.plugged()?;
        state.requests.push((request, value, data.to_vec()));
        let words = words(data);
        match (request, &words[..]) {
            (0, [0x0000_BEEF]) => {}
            (1, [_, _, _, _, _]) => {
                assert!(!state.is_running, "bit timing after the start");
                state.timing = words;
            }
            (2, [0, _]) => state.stop(),
            (2, [1, flags]) => state.start(*flags),
            _ => return Err(io::ErrorKind::ConnectionReset.into()),
        }
        Ok(())
    }

    fn control_in(&mut self, request: u8, value: u16, length: u16) -> io::Result<Vec<u8>> {
        let state = self.0.borrow();
        state.plugged()?;
        let words = match (request, value) {
            (4, 0) => &state.constants[..],
            (14, 0) => &state.counters[..],
            _ => return Err(io::ErrorKind::ConnectionReset.into()),
        };
        let bytes = words.iter().flat_map(|word| word.to_le_bytes());
        Ok(bytes.take(length.into()).collect())
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut state = self.0.borrow_mut();
        state.plugged()?;
        if state.is_stuck {
            return Err(io::ErrorKind::TimedOut.into());
        }
        assert!(state.is_running);
        state.written.push(bytes.to_vec());
        if state.is_acknowledged {
            state.transfers.push_back(bytes.to_vec());
        }
        let id = CanId::from_bits(words(bytes)[1]);
        let frame = Frame::data(id.into(), &bytes[12..12 + usize::from(bytes[8])]);
        match &mut state.bus {
            Some(bus) => bus.send(&frame.unwrap()).map_err(io::Error::other),
            None => Ok(()),
        }
    }

    fn read(&mut self, timeout: Duration) -> io::Result<Option<Vec<u8>>> {
        let mut state = self.0.borrow_mut();
        state.plugged()?;
        if let Some(bytes) = state.transfers.pop_front() {
            return Ok(Some(bytes));
        }
        let is_running = state.is_running;
        let Some(bus) = state.bus.as_mut().filter(|_| is_running) else {
            std::thread::sleep(timeout);
            return Ok(None);
        };
        // In the time of the bus: it waits for nothing.
        let until = after(bus.now(), Span::from_ticks(timeout.as_micros() as u64));
        let received = bus.receive(until).map_err(io::Error::other)?;
        Ok(received.map(|(_, frame)| {
            let mut bytes = vec![0xFF; 4];
            bytes.extend(frame.can_id().bits().to_le_bytes());
            bytes.extend([frame.dlc() as u8, 0, 0, 0]);
            bytes.extend(frame.bytes());
            bytes.resize(20, 0);
            bytes
        }))
    }
}
