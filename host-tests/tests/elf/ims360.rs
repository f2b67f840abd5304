//! The image of the IMS360.

use crate::rig::{blank, image};
use bench::motion::Motion;
use bench::{AdapterId, Bus, BusRate};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::{after, millis};
use stm32_sim::Microcontroller;

/// A sensor at rest and a tester on a bus with 125 kbit/s.
struct Bench {
    bus: Bus,
    tester: AdapterId,
}

impl Bench {
    /// A sensor after power-up and its boot-up message.
    fn new() -> Self {
        let level = Reading {
            acceleration: I32x3 {
                x: 0,
                y: 0,
                z: ONE_G,
            },
            angular_rate: I32x3 {
                x: 0,
                y: 10 << 16,
                z: 0,
            },
            temperature: 25_00,
            clipped: false,
        };
        let motion: Box<dyn Motion> = Box::new(level);
        let mut bus = Bus::new(BusRate::Fixed(BitRate::K125));
        bus.attach(Microcontroller::new(
            "ims360",
            image("ims360"),
            1,
            blank(),
            motion,
        ));
        let tester = bus.adapter();
        bus.open(tester, None, false);
        let mut bench = Self { bus, tester };
        assert_eq!(bench.wait(200), ["732#00"]);
        bench
    }

    /// The frames that the sensor sends within this many milliseconds.
    fn wait(&mut self, ms: u32) -> Vec<String> {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
        let frames = self.bus.take_received(self.tester).into_iter();
        frames.map(|(_, frame)| format!("{frame:?}")).collect()
    }

    /// Sends a frame with these bytes; returns the frames received within `ms` milliseconds.
    fn exchange(&mut self, id: u16, bytes: &[u8], ms: u32) -> Vec<String> {
        let frame = Frame::data(standard(id), bytes).expect("at most eight bytes");
        self.bus.send(self.tester, frame);
        self.wait(ms)
    }

    /// Reads an object of at most four bytes.
    fn read(&mut self, index: u16, sub: u8) -> String {
        let [low, high] = index.to_le_bytes();
        self.exchange(0x632, &[0x40, low, high, sub, 0, 0, 0, 0], 10)
            .concat()
    }
}

#[test]
fn image_measures_supply_and_angular_rate() {
    let mut bench = Bench::new();
    assert_eq!(bench.read(0x1000, 0), "5B2#430010009A010407");
    // 3020h:02 in 0.1 deg/s, within the tolerance of the part.
    let rate = bench.read(0x3020, 2);
    assert!(rate.starts_with("5B2#4B203002"), "{rate}");
    let rate = i64::from_str_radix(&rate[12..14], 16).expect("a byte");
    assert!((95..=105).contains(&rate), "{rate}");
    // 2020h:01 in mV.
    let supply = bench.read(0x2020, 1);
    assert!(supply.starts_with("5B2#43202001"), "{supply}");
    let supply = u32::from_str_radix(&supply[12..20], 16).expect("four bytes");
    assert!(
        (23_700..=24_300).contains(&supply.swap_bytes()),
        "{supply:08X}"
    );
    assert_eq!(bench.read(0x1001, 0), "5B2#4F01100000000000");
}

#[test]
fn image_stores_variant_and_resets_its_controller() {
    let mut bench = Bench::new();
    let written = bench.exchange(0x632, &[0x2F, 0x20, 0x31, 1, 0, 0, 0, 0], 10);
    assert_eq!(written, ["5B2#6020310100000000"]);
    let saved = bench.exchange(0x632, b"\x23\x10\x10\x01save", 300);
    assert_eq!(saved, ["5B2#6010100100000000"]);
    let reset = bench.exchange(0x632, &[0x2F, 0x10, 0x20, 1, 1, 0, 0, 0], 300);
    assert_eq!(reset, ["5B2#6010200100000000", "732#00"]);
    assert_eq!(bench.read(0x1000, 0), "5B2#430010009A010307");
    assert_eq!(bench.read(0x1A00, 0), "5B2#4F001A0001000000");
}
