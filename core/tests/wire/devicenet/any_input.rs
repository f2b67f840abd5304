//! DeviceNet: any frames at any times cause no panic, and the node stays responsive.

use crate::tester::canopen::frame;
use crate::tester::devicenet::{LevelTester, MAC_3, allocated, power_up};
use plumbline::can::{Frame, standard};
use plumbline::node::{BusEvent, BusState, Node};

/// A generator of random numbers (xorshift).
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

/// A frame that must change nothing: of another master, with a service that does not exist, of a wrong length, or without a meaning.
fn invalid_frame(random: &mut Random) -> Frame {
    let mut bytes = [0; 8];
    for byte in &mut bytes {
        *byte = random.next() as u8;
    }
    let mut length = 2 + random.below(7) as usize;
    let message = match random.below(7) {
        0 => {
            // Another master on the explicit connection.
            bytes[0] = random.pick(&[0x0B, 0x4B, 0x89, 0x3F, 0xCB, 0x00]);
            4
        }
        1 => {
            // Services that no object has, and responses.
            bytes[0] = random.pick(&[0x0A, 0x4A]);
            bytes[1] = random.pick(&[0x01, 0x0F, 0x55, 0x7F, 0x80, 0x90, 0xCB, 0xFF]);
            4
        }
        2 => {
            // Sets of what does not exist.
            bytes[..3].copy_from_slice(&[0x0A, 0x10, random.pick(&[0, 6, 7, 0x64, 0xFE])]);
            4
        }
        3 => {
            // Sets with three bytes: no attribute has them.
            bytes[..4].copy_from_slice(&[0x0A, 0x10, 0x65, 1]);
            length = 8;
            4
        }
        4 => {
            // Fragments without a first one.
            bytes[0] = 0x8A;
            bytes[1] = random.pick(&[0x40, 0x80, 0xC0]) | bytes[1] & 0x3F;
            4
        }
        5 => {
            // The port: other services, and another master.
            bytes[0] = random.pick(&[0x0A, 0x0B, 0x3F]);
            if bytes[0] == 0x0A {
                bytes[1] = random.pick(&[0x05, 0x0E, 0x10, 0x4A, 0x4D]);
            } else {
                let (choice, master) = (bytes[4], bytes[0]);
                bytes[1..6].copy_from_slice(&[0x4B, 3, 1, choice, master]);
                length = 6;
            }
            6
        }
        _ => random.pick(&[0, 1, 3, 5]),
    };
    Frame::data(standard(0x418 | message), &bytes[..length]).unwrap()
}

#[test]
fn invalid_frames_change_nothing() {
    for (choice, seed) in [(0x00, 1), (0x02, 2), (0x52, 3)] {
        let mut random = Random(0x9E37_79B9_7F4A_7C15 ^ seed);
        let mut tester = allocated(choice);
        tester.set_rate(1, 0);
        for (bit, instance) in [(0x02, "02"), (0x10, "04")] {
            if choice & bit != 0 {
                tester.exchange(&format!("41C#0A1005{instance}090000"));
            }
        }
        let read = |tester: &mut LevelTester| {
            let objects = [(0x65, 1, 0x71..=0x88), (3, 1, 1..=5), (5, 1, 1..=16)];
            let io = [(5, 2, 1..=16), (5, 4, 1..=17), (0x2B, 1, 1..=3)];
            let mut values = Vec::new();
            for (class, instance, attributes) in objects.into_iter().chain(io) {
                for attribute in attributes {
                    let request = format!("0E{class:02X}{instance:02X}{attribute:02X}");
                    values.push(tester.explicit(&request));
                }
            }
            values
        };
        let before = read(&mut tester);
        tester.actions.clear();
        for number in 0..4000 {
            let received = invalid_frame(&mut random);
            tester.receive(received);
            let sent = tester.sent_text();
            assert!(sent.len() <= 1, "{number} {received:?}: {sent:?}");
        }
        assert_eq!(read(&mut tester), before, "{choice:02X}");
        tester.wait(1000);
        assert_eq!(tester.actions, [], "nothing is stored");
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
