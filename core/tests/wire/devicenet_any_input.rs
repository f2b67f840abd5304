//! DeviceNet: any frames at any times cause no panic, and the node stays responsive.

use crate::tester::canopen::frame;
use crate::tester::devicenet::{LevelTester, MAC_3, power_up};
use plumbline::can::{Frame, standard};
use plumbline::node::{BusEvent, BusState, Node};

/// Pseudo random numbers (xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, limit: u64) -> u64 {
        self.next() % limit
    }

    fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len() as u64) as usize]
    }
}

/// A frame that is often a valid one.
fn any_frame(random: &mut Random) -> Frame {
    let services = [0x0E, 0x0E, 0x10, 0x10, 0x05, 0x4B, 0x4C, 0x8E, 0x00];
    let classes = [1, 2, 3, 4, 5, 5, 0x2B, 0x65, 0x65, 0x99];
    let attributes = [1, 2, 3, 5, 7, 9, 12, 17, 0x71, 0x73, 0x81, 0x82, 0x88];
    let headers = [0x0A, 0x0A, 0x0A, 0x4A, 0x8A, 0x8A, 0x0B];
    let message = random.pick(&[2, 4, 4, 4, 4, 5, 6, 6]);
    let mut bytes = [0; 8];
    for byte in &mut bytes {
        *byte = random.next() as u8;
    }
    bytes[0] = random.pick(&headers);
    if bytes[0] & 0x80 != 0 {
        bytes[1] = random.pick(&[0x00, 0x41, 0x81, 0x82, 0xC0, 0xC1, 0xC2]);
        bytes[2] = random.pick(&services);
    } else {
        bytes[1] = random.pick(&services);
        bytes[2] = random.pick(&classes);
        bytes[3] = random.pick(&[0, 1, 1, 1, 2, 4, 101]);
        bytes[4] = random.pick(&attributes);
        if bytes[1] == 0x4B {
            bytes[2..6].copy_from_slice(&[3, 1, random.pick(&[1, 3, 0x13, 0x51, 0x21]), 0x0A]);
        }
        if bytes[1] == 0x10 && random.below(2) == 0 {
            bytes[6] = 0;
        }
    }
    let length = if message == 5 || message == 2 {
        random.pick(&[0, 0, 0, 1])
    } else {
        random.pick(&[0, 3, 4, 5, 5, 6, 6, 7, 8]) as usize
    };
    let id = 0x418 | message;
    Frame::data(standard(id), &bytes[..length]).unwrap()
}

fn step(tester: &mut LevelTester, random: &mut Random) {
    match random.below(40) {
        0..25 => {
            if tester.node.ready() {
                let received = any_frame(random);
                tester.receive(received);
            }
        }
        25..28 => tester.force_milli(random.below(2000) as i32, 0),
        28 => tester.acknowledged = random.below(4) != 0,
        29 => tester.memory_works = Some(random.below(4) != 0),
        30 if random.below(20) == 0 => {
            tester.bus(BusEvent::State(BusState::BusOff));
            tester.bus(BusEvent::State(BusState::Active));
        }
        31 if random.below(20) == 0 => tester.receive(frame("41F#00620102020304")),
        _ => {
            tester.wait(random.pick(&[0, 1, 1, 5, 16, 300, 1000, 10_000]));
        }
    }
}

#[test]
fn any_frames_at_any_times_cause_no_panic() {
    for seed in 1..40 {
        let mut random = Random(0x9E37_79B9_7F4A_7C15 ^ seed);
        let mut tester = power_up(Some(MAC_3));
        tester.wait(2001);
        for _ in 0..400 {
            step(&mut tester, &mut random);
            // The tester asserts that the deadline is in the future after each input.
            tester.sent();
            tester.actions.clear();
        }
        // After a power cycle it answers, whatever it has stored.
        tester.acknowledged = true;
        tester.memory_works = Some(true);
        tester.power_cycle();
        let sent = tester.wait_text(2001);
        assert_eq!(sent.len(), 2, "seed {seed}: {sent:?}");
    }
}
