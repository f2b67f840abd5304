//! The bus with free-running sensors, such as simulated microcontrollers: led to the bit rate, kept in step.

use bench::motion::Motion;
use bench::script::{frame, ms};
use bench::{Bus, BusRate, Flash, ReceivePin, Sensor, Source};
use can_wire::protocol::{BitTiming, Event, Picoseconds, Protocol};
use plumbline::can::{BitRate, Frame};
use plumbline::node::{BusMode, Leds, Readout};
use plumbline::time::Instant;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

/// In picoseconds. The firmware checks its controller once a millisecond.
const MILLISECOND: Picoseconds = 1_000_000_000;

/// The time that each firmware has reached.
type Clocks = Rc<RefCell<Vec<Picoseconds>>>;

/// A firmware with a main loop that runs once a millisecond; a change of the bit rate takes one more millisecond.
struct Firmware {
    protocol: Protocol,
    time: Picoseconds,
    number: usize,
    clocks: Clocks,
    detects: bool,
    rate: BitRate,
    receive_pin: ReceivePin,
    joining: bool,
    heard: Vec<Frame>,
    outbox: VecDeque<Frame>,
    led_history: VecDeque<(Instant, Leds)>,
    flash: Flash,
}

impl Firmware {
    fn new(number: usize, clocks: &Clocks, detects: bool) -> Self {
        clocks.borrow_mut().push(0);
        Self {
            protocol: Protocol::default(),
            time: 0,
            number,
            clocks: clocks.clone(),
            detects,
            rate: if detects { BitRate::K10 } else { BitRate::K250 },
            receive_pin: ReceivePin::default(),
            joining: true,
            heard: Vec::new(),
            outbox: VecDeque::new(),
            led_history: VecDeque::new(),
            flash: Flash::default(),
        }
    }

    /// Runs the main loop once; true when the controller has changed.
    fn main_loop(&mut self) -> bool {
        if self.joining {
            self.joining = false;
            let timing = BitTiming::of(self.rate);
            self.protocol.join(self.time, timing, self.detects);
            return true;
        }
        if !self.detects {
            return false;
        }
        if !self.heard.is_empty() {
            self.detects = false;
        } else {
            let now = Instant::from_ticks(self.time / 1_000_000);
            match self.receive_pin.poll(now) {
                Some(time) if time.nearest_rate() != self.rate => self.rate = time.nearest_rate(),
                _ => return false,
            }
        }
        self.protocol.leave();
        self.joining = true;
        true
    }
}

impl Sensor for Firmware {
    fn power_on(&mut self, _: Instant) {}
    fn power_off(&mut self, _: Instant) {}
    fn is_on(&self) -> bool {
        true
    }
    fn boots(&self) -> u32 {
        1
    }
    fn next_event(&self) -> Option<Picoseconds> {
        Some((self.time / MILLISECOND + 1) * MILLISECOND)
    }
    fn runs_freely(&self) -> bool {
        true
    }
    fn advance(&mut self, now: Picoseconds) -> Picoseconds {
        while self.time < now {
            let next = (self.time / MILLISECOND + 1) * MILLISECOND;
            self.time = next.min(now);
            self.clocks.borrow_mut()[self.number] = self.time;
            if self.time < next {
                continue;
            }
            // No other sensor is ahead of one that acts.
            let first = self.clocks.borrow().iter().max().copied();
            let ahead = first.unwrap_or_default() - self.time;
            assert!(ahead <= 1_000_000, "{ahead} ps ahead");
            if self.main_loop() {
                break;
            }
        }
        self.time.min(now)
    }
    fn protocol(&self) -> Option<&Protocol> {
        Some(&self.protocol)
    }
    fn next_step(&self) -> Option<Picoseconds> {
        let offers = self.protocol.takes_offer() && !self.outbox.is_empty();
        self.protocol.next_event(offers)
    }
    fn offered(&self) -> Option<Frame> {
        self.outbox.front().copied()
    }
    fn wire(&mut self, now: Picoseconds, dominant: bool) {
        if dominant {
            self.protocol.edge(now);
        }
        self.receive_pin.edge(now, dominant);
    }
    fn step(&mut self, now: Picoseconds, dominant: bool) -> Option<Event> {
        let event = self.protocol.step(now, dominant, self.offered())?;
        match event {
            Event::Received(frame) => self.heard.push(frame),
            Event::Transmitted => {
                self.outbox.pop_front();
            }
            _ => {}
        }
        Some(event)
    }
    fn name(&self) -> &'static str {
        "firmware"
    }
    fn mode(&self) -> Option<BusMode> {
        let listens = self.protocol.is_silent();
        self.protocol.is_on().then_some(if listens {
            BusMode::Listen
        } else {
            BusMode::Normal
        })
    }
    fn rate(&self) -> Option<BitRate> {
        self.protocol.is_on().then_some(self.rate)
    }
    fn leds(&self) -> Leds {
        Leds::default()
    }
    fn led_history(&self) -> &VecDeque<(Instant, Leds)> {
        &self.led_history
    }
    fn readout(&self) -> Option<Readout> {
        None
    }
    fn set_motion(&mut self, _: Box<dyn Motion>) {}
    fn memory(&mut self) -> &Flash {
        &self.flash
    }
    fn flash(&mut self) -> &mut Flash {
        &mut self.flash
    }
}

#[test]
fn slow_firmware_detects_each_rate() {
    for rate in BitRate::ALL {
        let mut bus = Bus::new(BusRate::Fixed(rate));
        let device = bus.attach(Firmware::new(0, &Clocks::default(), true));
        let (plc, other) = (bus.adapter(), bus.adapter());
        bus.open(plc, None, false);
        bus.open(other, None, false);
        bus.run_until(ms(100));
        bus.lead_detection();
        bus.run_until(ms(160));
        assert_eq!(bus.device(device).rate(), Some(rate));
        bus.send(plc, frame(0x7FF, &[]));
        bus.run_until(ms(300));
        assert_eq!(bus.device(device).mode(), Some(BusMode::Normal), "{rate:?}");
        assert_eq!(bus.device(device).rate(), Some(rate));
        let log = bus.take_log();
        assert_eq!((log.len(), log[0].start), (1, 160 * MILLISECOND));
        for adapter in [plc, other] {
            assert_eq!(bus.disturbed(Source::Adapter(adapter)), 0, "{rate:?}");
        }
    }
}

#[test]
fn following_bus_waits_until_firmware_listens_at_250_kbit() {
    // For any start time: the bus may have to lead the firmware, or the firmware may be about to move on.
    for start in (0..200).step_by(7) {
        let mut bus = Bus::new(BusRate::Follow);
        let device = bus.attach(Firmware::new(0, &Clocks::default(), true));
        let client = bus.adapter();
        bus.open(client, Some(BitRate::M1), false);
        bus.run_until(ms(10 + start));
        bus.send(client, frame(0x7FF, &[]));
        bus.run_until(ms(10 + start + 60));
        assert_eq!(bus.device(device).mode(), Some(BusMode::Normal), "{start}");
        assert_eq!(bus.device(device).rate(), Some(BitRate::K250));
        assert_eq!(bus.take_log().len(), 1);
    }
}

#[test]
fn free_running_sensors_stay_synchronized() {
    let clocks = Clocks::default();
    let mut bus = Bus::new(BusRate::Wire);
    let mut devices = Vec::new();
    for number in 0..3 {
        let mut firmware = Firmware::new(number, &clocks, false);
        for count in 0..10 {
            let frame = frame(0x300 + number as u32, &[count, 0, 0xFF]);
            firmware.outbox.push_back(frame);
        }
        devices.push(bus.attach(firmware));
    }
    bus.run_until(ms(50));
    let ids: Vec<_> = bus.take_log().iter().map(|one| one.frame.id()).collect();
    assert_eq!(ids.len(), 30);
    assert!(ids.is_sorted(), "lowest identifier first: {ids:?}");
    for device in devices {
        assert_eq!(bus.disturbed(Source::Device(device)), 0);
    }
}
