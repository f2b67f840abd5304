//! Prints how fast this computer simulates the wire: `cargo run --release -p bench --example bus_speed`.

use bench::script::*;
use bench::{Bus, BusRate};
use plumbline::can::BitRate;
use std::time::Instant;

const RATE: BusRate = BusRate::Fixed(BitRate::K250);

/// The simulated time in s.
const SECONDS: u64 = 10;

fn main() {
    let mut bus = Bus::new(RATE);
    bus.attach(device(&FIXED, 1));
    let start = Instant::now();
    bus.run_until(ms(1000 * SECONDS));
    println!(
        "one device on an idle wire: {:?} for a second",
        start.elapsed() / SECONDS as u32
    );

    let mut bus = Bus::new(RATE);
    for serial in 1..=3 {
        bus.attach(device(&FIXED, serial));
    }
    let adapter = bus.adapter();
    bus.open(adapter, None, false);
    (0..100_000).for_each(|_| bus.send(adapter, frame(0x7FF, &[0x55; 8])));
    let start = Instant::now();
    bus.run_until(ms(1000 * SECONDS));
    assert!(bus.queued(adapter) > 0, "the wire was not always busy");
    // The assistant of the bus is the fifth controller.
    let bits = 5.0 * SECONDS as f64 * 250e3;
    let rate = bits / start.elapsed().as_secs_f64() / 1e6;
    println!("five controllers on a busy wire: {rate:.1} million bits of a controller per second");
}
