//! A stand-in for a model while the firmware is developed: answers 300h with 301h, saves on 302h, restarts on 303h.

use plumbline::can::{BitRate, Filter, Filters, Frame, standard};
use plumbline::measure::Reading;
use plumbline::node::{Action, BusEvent, BusMode, BusState, Leds, Node, Readout};
use plumbline::store::{ImageId, Loaded, Payload, StoreError};
use plumbline::time::{Instant, after, millis, reached};

/// Its image.
pub const IMAGE: ImageId = ImageId(0xFFFF);
/// Bytes in its payload.
pub const PAYLOAD: usize = 72;

/// The node.
pub struct Dummy {
    actions: heapless::Deque<Action, 8>,
    frames: heapless::Deque<Frame, 8>,
    recover: Option<Instant>,
    count: u32,
    x: i32,
}

impl Dummy {
    /// Starts it.
    pub fn new(_now: Instant, loaded: Loaded, serial: u32) -> Self {
        let mut actions = heapless::Deque::new();
        let _ = actions.push_back(Action::Bus(BusMode::Listen, BitRate::K10));
        let count = loaded
            .payload
            .and_then(|p| p.first_chunk::<4>().map(|b| u32::from_le_bytes(*b)))
            .unwrap_or(0);
        let mut frames = heapless::Deque::new();
        let _ = Frame::data(standard(0x700), &serial.to_le_bytes()).map(|f| frames.push_back(f));
        Self {
            actions,
            frames,
            recover: None,
            count,
            x: 0,
        }
    }
    fn send(&mut self, id: u16, data: &[u8]) {
        if let Some(f) = Frame::data(standard(id), data) {
            let _ = self.frames.push_back(f);
        }
    }
}

impl Node for Dummy {
    fn ready(&self) -> bool {
        self.frames.len() < 4
    }
    fn receive(&mut self, _: Instant, frame: &Frame) {
        let id = match frame.id() {
            embedded_can::Id::Standard(id) => id.as_raw(),
            _ => 0,
        };
        match id {
            0x7F0 | 0x300 if id == 0x7F0 || frame.bytes().get(1..) == Some(&[0, 0xEE]) => {
                let rate = frame
                    .bytes()
                    .first()
                    .and_then(|i| BitRate::ALL.get(usize::from(*i)));
                let listen = frame.bytes().get(1) == Some(&1);
                if let Some(rate) = rate {
                    let mode = if listen {
                        BusMode::Listen
                    } else {
                        BusMode::Normal
                    };
                    let _ = self.actions.push_back(Action::Bus(mode, *rate));
                }
            }
            0x302 => {
                self.count += 1;
                let _ = self.actions.push_back(Action::Save);
            }
            0x303 => {
                self.send(0x304, &[]);
                let _ = self.actions.push_back(Action::Restart);
            }
            _ => self.send(0x301, frame.bytes()),
        }
    }
    fn sample(&mut self, _: Instant, reading: &Reading) {
        self.x = reading.acceleration.x;
    }
    fn bus(&mut self, now: Instant, event: BusEvent) {
        match event {
            BusEvent::State(BusState::BusOff) => self.recover = Some(after(now, millis(50))),
            BusEvent::State(BusState::Active) => self.send(0x305, &[]),
            BusEvent::Overrun => self.send(0x306, &[]),
            BusEvent::Error => {
                let _ = self.actions.push_back(Action::Leds(Leds {
                    run: true,
                    error: true,
                }));
            }
            _ => {}
        }
    }
    fn stored(&mut self, _: Instant, result: Result<(), StoreError>) {
        let count = self.count.to_le_bytes();
        self.send(0x307, &[result.is_ok() as u8, count[0]]);
    }
    fn poll(&mut self, now: Instant) -> Option<Action> {
        if self.recover.is_some_and(|at| reached(now, at)) {
            self.recover = None;
            return Some(Action::Recover);
        }
        self.actions.pop_front()
    }
    fn transmit(&mut self, _: Instant) -> Option<Frame> {
        self.frames.pop_front()
    }
    fn deadline(&self) -> Option<Instant> {
        self.recover
    }
    fn filters(&self) -> Filters {
        [0x300, 0x302, 0x303, 0x7F0]
            .into_iter()
            .map(|id| Filter::exact(standard(id)))
            .collect()
    }
    fn image(&self) -> Payload {
        let mut p = Payload::new();
        let _ = p.resize(PAYLOAD, 0);
        for (a, b) in p.iter_mut().zip(self.count.to_le_bytes()) {
            *a = b;
        }
        p
    }
    fn readout(&self) -> Readout {
        Readout { x: self.x, y: None }
    }
}
