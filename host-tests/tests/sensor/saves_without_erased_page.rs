//! The number of saves between two saves that have no erased page. Such a save erases a page first, and the flash stalls the processor for
//! up to 40 ms: this is the only exception to the time of an answer. A start erases a page ahead, so these saves recur only while the power
//! stays on. `host-tests/cost/README.md` has the numbers beside the time of the answer.

use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, NodeType};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::measure::{Calibration, Reading};
use plumbline::model::catalog::{self, Protocol};
use plumbline::store::{Owner, Store};
use plumbline::time::{after, millis};

const SERIAL: u32 = 1;

/// The number of pages that are filled.
const PAGES: usize = 6;

/// A buffer for the parameters of every product.
const BUFFER: usize = 512;

/// A sensor that has booted on a bus with a tester.
struct Bench {
    bus: Bus,
    device: DeviceId,
    tester: AdapterId,
    save: Frame,
    /// True if this is the reply to a save that has succeeded.
    is_saved: fn(&[u8]) -> bool,
}

impl Bench {
    fn new(name: &str, memory: Flash) -> Self {
        let frame = |id, data: &[u8]| Frame::data(standard(id), data).expect("at most 8 bytes");
        let product = catalog::find(name).expect("a product");
        let (rate, save, is_saved): (_, _, fn(&[u8]) -> bool) = match product.protocol {
            // Table 17: the status has neither EepromError nor CmdParamError.
            Protocol::Fsc(_) => (
                BitRate::M1,
                frame(0x300, b"\x50SAVE"),
                |reply| matches!(reply, [0x50, status, ..] if status & 0x0C == 0),
            ),
            // "save" to 1010h:01 of the factory's node-ID, 50 or 10.
            Protocol::Canopen(_) => (
                BitRate::K125,
                frame(
                    if name == "ims360" { 0x632 } else { 0x60A },
                    b"\x23\x10\x10\x01save",
                ),
                |reply| reply.starts_with(&[0x60, 0x10, 0x10, 0x01]),
            ),
            // It has no request that saves; `devicenet_saves` counts its erases.
            Protocol::Devicenet(_) | Protocol::J1939(_) => panic!("{name} saves after each change"),
        };
        let mut bus = Bus::new(BusRate::Fixed(rate));
        let node_type = NodeType::find(name).expect("a product");
        let motion = Box::new(Reading::default());
        let device = bus.attach(Device::new(&node_type, SERIAL, memory, motion));
        let tester = bus.adapter();
        bus.open(tester, None, false);
        let mut bench = Self {
            bus,
            device,
            tester,
            save,
            is_saved,
        };
        bench.boot();
        // The usage of the device is kept.
        bench.run(11_000);
        bench
    }

    /// Waits until the sensor has found the bit rate and booted. It is silent until it has received a frame.
    fn boot(&mut self) {
        self.bus.lead_detection();
        self.run(100);
        let unused = Frame::data(standard(0x7FE), &[]).expect("it has no data");
        self.bus.send(self.tester, unused);
        self.run(100);
    }

    fn run(&mut self, ms: u32) {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
    }

    /// Saves, which must succeed; true if the save has erased a page.
    fn erases(&mut self) -> bool {
        let before = self.bus.device_mut(self.device).flash().erased();
        self.bus.take_received(self.tester);
        self.bus.send(self.tester, self.save);
        self.run(100);
        let received = self.bus.take_received(self.tester);
        let mut replies = received.iter().map(|(_, frame)| frame.bytes());
        assert!(replies.any(self.is_saved), "{received:?}");
        let erased = self.bus.device_mut(self.device).flash().erased() - before;
        assert!(erased <= 1, "{erased} pages in one save");
        erased == 1
    }

    /// Switches the sensor off and on.
    fn restart(&mut self) {
        self.bus.power_cycle(self.device);
        self.boot();
    }
}

/// A memory with a calibration.
fn calibrated(name: &str) -> Flash {
    let product = catalog::find(name).expect("a product");
    let owner = Owner {
        image: product.image,
        layout: product.layout,
        serial: SERIAL,
    };
    let calibration = Calibration::new([1000, 2000, 3000], [[0; 3]; 3], [0; 3]);
    let mut store = Store::<_, [u8; BUFFER]>::open(Flash::default(), owner);
    store.calibrate(&calibration.expect("within the ranges"));
    while store.step().is_none() {}
    store.into_memory()
}

/// Asserts that a save erases a page after exactly so many saves that do not, the first time after `first` saves.
#[track_caller]
fn assert_saves(name: &str, memory: Flash, first: usize, between: usize) {
    let mut bench = Bench::new(name, memory);
    let mut expected = first;
    for page in 0..PAGES {
        let saves = (0..).take_while(|_| !bench.erases()).count();
        assert_eq!(saves, expected, "{name}, page {page}");
        expected = between;
    }
}

/// The two pages of 1 KiB of the Blue Pill. A record of `is2` has 40 bytes, one of `is1` also 40, one of `jn2101` 80, that of the usage 44.
/// The pages of the products tell users these numbers, plus one.
#[test]
fn exact_number_of_saves_lies_between_two_without_an_erased_page() {
    for (name, between) in [
        ("is1", 23),
        ("is2", 23),
        ("is2tk", 23),
        ("jn2101", 11),
        ("ims360", 2),
    ] {
        // Blank memory: both pages.
        assert_saves(name, Flash::default(), 2 * (between + 1), between);
    }
}

/// A calibration takes 68 bytes of each page, and is there from the start.
#[test]
fn exact_number_of_saves_with_calibration_lies_between_two_without_an_erased_page() {
    for (name, between) in [("is1", 21), ("is2", 21), ("is2tk", 21), ("jn2101", 10)] {
        assert_saves(name, calibrated(name), 2 * (between + 1), between);
    }
}

/// A start erases a page ahead. If the sensor restarts whenever half a page is full, no save erases.
#[test]
fn no_save_erases_within_half_a_page_after_a_start() {
    for (name, half) in [("is2", 12), ("jn2101", 6)] {
        let mut bench = Bench::new(name, Flash::default());
        for start in 0..4 * PAGES {
            for save in 0..half {
                assert!(!bench.erases(), "{name}: save {save} after start {start}");
            }
            bench.restart();
        }
    }
}

/// While a page is erased, the controller keeps three frames: the newest one takes the place of the third.
#[test]
fn erase_loses_the_frames_between_the_first_two_and_the_last() {
    let mut bench = Bench::new("is2", Flash::default());
    for save in 0..48 {
        assert!(!bench.erases(), "save {save}");
    }
    bench.bus.take_received(bench.tester);
    let before = bench.bus.device_mut(bench.device).flash().erased();
    bench.bus.send(bench.tester, bench.save);
    let reads = [0x10, 0x11, 0x12, 0x13, 0x14, 0x15];
    for code in reads {
        let read = Frame::data(standard(0x300), &[code]).expect("one byte");
        bench.bus.send(bench.tester, read);
    }
    bench.run(30);
    assert_eq!(bench.bus.take_received(bench.tester), [], "it erases");
    bench.run(100);
    let erased = bench.bus.device_mut(bench.device).flash().erased();
    assert_eq!(erased - before, 1);
    let received = bench.bus.take_received(bench.tester);
    let codes: Vec<u8> = received.iter().map(|(_, reply)| reply.bytes()[0]).collect();
    assert_eq!(codes, [0x10, 0x11, 0x15, 0x50]);
}
