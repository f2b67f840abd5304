//! A driver for the MCP2515, a CAN controller on SPI (Microchip DS20001801), with one thread. `main` tries it with the registers of the
//! chip in memory.
//!
//! The crystal has 16 MHz. The chip leaves bus-off without being asked, so the driver keeps it in configuration mode until
//! [`Controller::recover`]. It has two masks for all filters, fewer than some products need, so it receives all frames: the node ignores
//! those that do not pass. It does not measure the bit time, so a product that detects the bit rate needs a fixed one.

mod chip;

use chip::Chip;
use embedded_hal::spi::{Operation, SpiDevice};
use plumbline::can::{BitRate, CanId, Frame, standard};
use plumbline::measure::{Reading, SAMPLE_PERIOD};
use plumbline::model::jn2101::Jn2101;
use plumbline::node::driver::{
    Change, Controller, Driver, Filters, Mailboxes, OneThread, Output, Platform,
};
use plumbline::node::{Boot, BusEvent, BusMode, BusState, ProductNode};
use plumbline::{store::StoreError, time::Instant};

/// Instructions of the SPI: the first byte of each transfer.
const WRITE: u8 = 0x02;
const READ: u8 = 0x03;
const BIT_MODIFY: u8 = 0x05;
const LOAD_TXB0: u8 = 0x40;
const RTS_TXB0: u8 = 0x81;
const READ_RXB0: u8 = 0x90;
const READ_STATUS: u8 = 0xA0;

/// Registers.
const CANSTAT: u8 = 0x0E;
const CANCTRL: u8 = 0x0F;
const CNF3: u8 = 0x28;
const CANINTF: u8 = 0x2C;
const EFLG: u8 = 0x2D;
const TXB0CTRL: u8 = 0x30;
const RXB0CTRL: u8 = 0x60;

/// CANCTRL.REQOP and CANSTAT.OPMOD.
const MODE: u8 = 0xE0;
const NORMAL: u8 = 0x00;
const LISTEN: u8 = 0x60;
const CONFIGURATION: u8 = 0x80;
/// READ STATUS: RX0IF and TX0REQ. TXB0CTRL: TXREQ.
const RX0IF: u8 = 1 << 0;
const TX0REQ: u8 = 1 << 2;
const TXREQ: u8 = 1 << 3;
/// CANINTF.MERRF: an error in a frame.
const MERRF: u8 = 1 << 7;
/// EFLG: RX1OVR and RX0OVR, TXBO, TXEP and RXEP, EWARN.
const OVERRUN: u8 = 0xC0;
const BUS_OFF: u8 = 1 << 5;
const PASSIVE: u8 = 0x18;
const WARNING: u8 = 1 << 0;
/// RXB0CTRL.RXM: all frames.
const ALL_FRAMES: u8 = 0x60;

/// The chip. `clock` is the time of the board in microseconds.
struct Mcp2515<S> {
    spi: S,
    clock: u64,
    /// The requested mode: a value of REQOP. None before the first one.
    mode: Option<u8>,
    /// What follows when the chip is in configuration mode: CNF1 to CNF3, and the mode.
    next: Option<([u8; 3], u8)>,
    state: BusState,
    /// The mailbox waits, as read by the last [`Self::poll`].
    sends: bool,
}

impl<S: SpiDevice> Mcp2515<S> {
    fn new(spi: S) -> Self {
        Self {
            spi,
            clock: 0,
            mode: None,
            next: None,
            state: BusState::Active,
            sends: false,
        }
    }

    /// A read after this instruction. A board without the chip reads as 0.
    fn read<const N: usize>(&mut self, instruction: &[u8]) -> [u8; N] {
        let mut bytes = [0; N];
        let parts = &mut [Operation::Write(instruction), Operation::Read(&mut bytes)];
        let result = self.spi.transaction(parts);
        result.map_or([0; N], |()| bytes)
    }

    fn write(&mut self, bytes: &[u8]) {
        // The next poll shows what the chip has done.
        let _ = self.spi.write(bytes);
    }

    fn modify(&mut self, register: u8, mask: u8, bits: u8) {
        self.write(&[BIT_MODIFY, register, mask, bits]);
    }

    fn request(&mut self, mode: u8) {
        self.mode = Some(mode);
        self.modify(CANCTRL, MODE, mode);
    }

    /// Reads the status. Returns whether the mailbox has become free, and the next received frame.
    fn poll(&mut self) -> (bool, Option<Frame>) {
        let [status] = self.read(&[READ_STATUS]);
        let sent = self.sends && status & TX0REQ == 0;
        self.sends = status & TX0REQ != 0;
        // The read of the buffer clears RX0IF.
        let frame = (status & RX0IF != 0).then(|| frame(self.read(&[READ_RXB0])));
        (sent, frame.flatten())
    }
}

impl<S: SpiDevice> Mailboxes for Mcp2515<S> {
    fn now(&self) -> Instant {
        Instant::from_ticks(self.clock)
    }
    fn is_idle(&self) -> bool {
        !self.sends
    }
    fn put(&mut self, frame: &Frame, _once: bool) {
        self.write(&buffer(frame));
        self.write(&[RTS_TXB0]);
        self.sends = true;
    }
    fn abort(&mut self) {
        self.modify(TXB0CTRL, TXREQ, 0);
    }
}

impl<S: SpiDevice> Controller for Mcp2515<S> {
    fn open(&mut self, mode: BusMode, rate: BitRate, _filters: Filters<'_>) {
        let mode = match mode {
            BusMode::Normal => NORMAL,
            BusMode::Listen => LISTEN,
        };
        self.next = Some((timing(rate), mode));
        self.request(CONFIGURATION);
    }
    fn change(&mut self) -> Change {
        if let Some(([cnf1, cnf2, cnf3], mode)) = self.next {
            let [status] = self.read(&[READ, CANSTAT]);
            if status & MODE != CONFIGURATION {
                // The chip finishes a frame first.
                return Change::Leaving;
            }
            self.next = None;
            self.write(&[WRITE, CNF3, cnf3, cnf2, cnf1, 0, 0, 0]); // with CANINTE, CANINTF and EFLG
            self.write(&[WRITE, RXB0CTRL, ALL_FRAMES]);
            self.request(mode);
        }
        let [status] = self.read(&[READ, CANSTAT]);
        match self.mode {
            // In bus-off.
            None | Some(CONFIGURATION) => Change::Done,
            Some(mode) if status & MODE == mode => Change::Done,
            Some(_) => Change::Joining,
        }
    }
    fn recover(&mut self) {
        self.request(NORMAL);
    }
    fn event(&mut self) -> Option<BusEvent> {
        let [flags, errors] = self.read(&[READ, CANINTF]);
        if errors & OVERRUN != 0 {
            self.modify(EFLG, OVERRUN, 0);
            return Some(BusEvent::Overrun);
        }
        if self.mode == Some(LISTEN) {
            self.modify(CANINTF, MERRF, 0);
            return (flags & MERRF != 0).then_some(BusEvent::Error);
        }
        let state = match errors {
            _ if errors & BUS_OFF != 0 => BusState::BusOff,
            _ if errors & PASSIVE != 0 => BusState::Passive,
            _ if errors & WARNING != 0 => BusState::Warning,
            _ => BusState::Active,
        };
        if state == self.state {
            return None;
        }
        self.state = state;
        if state == BusState::BusOff {
            self.request(CONFIGURATION);
        }
        Some(BusEvent::State(state))
    }
}

/// CNF1 to CNF3. A bit has 16, 10 or 8 time quanta, and its sample point is at 75 to 80 %.
fn timing(rate: BitRate) -> [u8; 3] {
    // A time quantum has twice as many clocks of the crystal as the prescaler says.
    let clocks = 8_000_000 / rate.bits_per_second();
    let quanta = [16, 10, 8]
        .into_iter()
        .find(|it| clocks.is_multiple_of(*it));
    let quanta = quanta.expect("all bit rates have one");
    let second = quanta / 4;
    let first = (quanta - second) / 2;
    let propagation = quanta - 1 - first - second;
    let prescaler = clocks / quanta;
    [
        (prescaler - 1) as u8,
        0x80 | (first as u8 - 1) << 3 | (propagation as u8 - 1),
        second as u8 - 1,
    ]
}

/// LOAD TX BUFFER with a frame: SIDH, SIDL, EID8, EID0, DLC and data.
fn buffer(frame: &Frame) -> [u8; 14] {
    let (id, is_extended) = match frame.id() {
        embedded_can::Id::Standard(id) => (u32::from(id.as_raw()) << 18, false),
        embedded_can::Id::Extended(id) => (id.as_raw(), true),
    };
    let mut bytes = [0; 14];
    bytes[0] = LOAD_TXB0;
    bytes[1] = (id >> 21) as u8;
    bytes[2] = (id >> 13) as u8 & 0xE0 | u8::from(is_extended) << 3 | (id >> 16) as u8 & 0b11;
    bytes[3] = (id >> 8) as u8;
    bytes[4] = id as u8;
    bytes[5] = frame.dlc() as u8 | u8::from(frame.is_remote()) << 6;
    bytes[6..6 + frame.bytes().len()].copy_from_slice(frame.bytes());
    bytes
}

/// The frame of a receive buffer.
fn frame([sidh, sidl, eid8, eid0, dlc, data @ ..]: [u8; 13]) -> Option<Frame> {
    let base = u16::from(sidh) << 3 | u16::from(sidl) >> 5;
    let (id, is_remote) = if sidl & 1 << 3 != 0 {
        let rest = u32::from(sidl & 0b11) << 16 | u32::from(eid8) << 8 | u32::from(eid0);
        (
            CanId::extended(u32::from(base) << 18 | rest),
            dlc & 1 << 6 != 0,
        )
    } else {
        (CanId::standard(base), sidl & 1 << 4 != 0)
    };
    // A data length code of 9 to 15 means 8 bytes.
    let length = (dlc & 0xF).min(8);
    if is_remote {
        return Frame::remote(id.into(), length.into());
    }
    Some(Frame::of(id, data, length))
}

/// The rest of the board, which has no memory.
struct Board;
impl Platform for Board {
    fn perform(&mut self, output: Output) {
        println!("{output:?}");
    }
    fn save(&mut self, _image: impl FnOnce(&mut [u8]) -> Option<usize>) {}
    fn stored(&mut self) -> Option<Result<(), StoreError>> {
        Some(Err(StoreError))
    }
    fn restart(&mut self, _kept: u32) {}
}

/// An iteration of the main loop. Call it every millisecond at least, and at once when the pin INT of the chip is low.
fn iterate<N, S>(driver: &mut Driver<OneThread<&mut N, Mcp2515<S>>>, reading: Option<&Reading>)
where
    N: ProductNode,
    S: SpiDevice,
{
    if let Some(reading) = reading {
        driver.sample(reading);
    }
    let (sent, received) = driver.controller_mut().poll();
    if sent {
        driver.transmitted(false);
    }
    if let Some(frame) = received {
        driver.receive(&frame);
    }
    while driver.turn(&mut Board) {}
}

fn main() {
    let mut node = Jn2101::INITIAL;
    node.start(Instant::from_ticks(0), &Boot::default());
    let controller = Mcp2515::new(Chip::default());
    let mut driver = Driver::new(OneThread::new(&mut node, controller));
    let mut sent = Vec::new();
    for (id, data) in [
        (0x000, &[][..]),
        (0x60A, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]), // read 1000h
        (0x60A, &[0x2B, 0x01, 0x20, 0, 0xF4, 1, 0, 0]), // 500 kbit/s
        (0x000, &[0x82, 0]),                         // reset communication
    ] {
        let frame = Frame::data(standard(id), data).expect("a frame");
        driver.controller_mut().spi.receive(&frame);
        for _ in 0..20 {
            driver.controller_mut().clock += SAMPLE_PERIOD.ticks();
            iterate(&mut driver, Some(&Reading::default()));
            sent.extend(driver.controller_mut().spi.send());
        }
    }
    for frame in &sent {
        println!("{frame:?}");
    }
    let answers = |frame: &&Frame| frame.bytes().starts_with(&[0x43, 0x00, 0x10, 0]);
    assert_eq!(sent.iter().filter(answers).count(), 1, "the device type");
    let boots = |frame: &&Frame| **frame == Frame::of(standard(0x70A), [0; 8], 1);
    assert_eq!(
        sent.iter().filter(boots).count(),
        2,
        "before and after the reset"
    );
    let chip = &mut driver.controller_mut().spi;
    assert_eq!(chip.registers[0x28..0x2B], [0x03, 0xAC, 0x00], "500 kbit/s");
    // In bus-off, the chip leaves the bus until the node recovers, here at once.
    let before = chip.configurations;
    chip.registers[usize::from(EFLG)] = BUS_OFF;
    iterate(&mut driver, None);
    let chip = &driver.controller_mut().spi;
    assert_eq!(chip.configurations, before + 1);
    assert_eq!(chip.registers[usize::from(CANSTAT)], NORMAL);
}
