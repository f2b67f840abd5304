//! The speed of the state machine; only a release build is meaningful: `cargo test --release -- --ignored --nocapture speed`.

use super::*;
use std::time::Instant;

#[test]
#[ignore = "a measurement"]
fn simulation_speed_in_bits_per_second() {
    const FRAMES: u64 = 20_000;
    const STATIONS: u64 = 4;
    let mut wire = Wire::joined(STATIONS as usize);
    for number in 0..FRAMES {
        wire.send(0, data(0x123, &number.to_be_bytes()));
    }
    let start = Instant::now();
    let before = wire.now;
    while wire.count_of_sent() < FRAMES {
        wire.run(10_000 * BIT);
        wire.changes.clear();
    }
    let bits = (wire.now - before) / BIT * STATIONS;
    let rate = bits as f64 / start.elapsed().as_secs_f64() / 1e6;
    println!("{rate:.1} million station-bits per second");
}

impl Wire {
    fn count_of_sent(&self) -> u64 {
        self.stations[0]
            .events
            .iter()
            .filter(|(_, event)| *event == Event::Transmitted)
            .count() as u64
    }
}
