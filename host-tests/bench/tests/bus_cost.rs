//! Computing time of the simulated wire.

use bench::script::*;
use bench::{Bus, BusRate};
use plumbline::can::BitRate;

const RATE: BusRate = BusRate::Fixed(BitRate::K250);

/// Measures the computing time; only a release build is meaningful: `cargo test --release --test bus_cost -- --ignored
/// --nocapture`.
#[test]
#[ignore = "a measurement"]
fn measure_computing_time_of_bus() {
    let mut bus = Bus::new(RATE);
    bus.attach(device(&FIXED, 1));
    let start = std::time::Instant::now();
    (0..10_000).for_each(|step| bus.run_until(ms(step)));
    println!("a lone device: {:?} for a second", start.elapsed() / 10);

    let mut bus = Bus::new(RATE);
    for serial in 1..=3 {
        bus.attach(device(&FIXED, serial));
    }
    let plc = bus.adapter();
    bus.open(plc, None, false);
    (0..100_000).for_each(|_| bus.send(plc, frame(0x7FF, &[0x55; 8])));
    let start = std::time::Instant::now();
    (0..10_000).for_each(|step| bus.run_until(ms(step)));
    assert!(bus.queued(plc) > 0);
    // The assistant is the fifth.
    let rate = 5.0 * 10.0 * 250e3 / start.elapsed().as_secs_f64() / 1e6;
    println!("a full bus: {rate:.1} million station-bits per second");
}
