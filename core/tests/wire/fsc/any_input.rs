//! GEMAC sensors with random frames: frames that are no valid requests change nothing, and valid ones never stop the sensor.

use crate::tester::fsc::CMD_PARAM_ERROR;
use crate::tester::gemac::*;
use plumbline::can::{CanId, Frame};
use plumbline::fsc::Product;

/// A generator of random numbers (xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % limit as u64) as usize
    }

    fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())]
    }

    fn bytes(&mut self, size: usize) -> Vec<u8> {
        (0..size).map(|_| self.below(256) as u8).collect()
    }
}

const IN_FORCE: [u32; 3] = [0x300, 0x301, 0x100];

fn data(bits: u32, data: &[u8]) -> Frame {
    Frame::data(CanId::from_bits(bits).into(), data).unwrap()
}

/// A frame that is not for the sensor, or a request that it must refuse.
fn invalid(random: &mut Random, sheet: &Sheet) -> Frame {
    let size = random.below(9);
    let mut bytes = random.bytes(size);
    match random.below(7) {
        0 => {
            let id = random.below(0x800) as u32;
            let used = [0x300, 0x100].contains(&id);
            data(id ^ (u32::from(used) << 1), &bytes)
        }
        1 => {
            let any = (random.below(1 << 29)) as u32;
            data(EXTENDED | random.pick(&[any, 0x300, 0x301, 0x100]), &bytes)
        }
        2 => {
            let id = CanId::from_bits(random.pick(&IN_FORCE));
            Frame::remote(id.into(), bytes.len()).unwrap()
        }
        3 => {
            bytes.resize(bytes.len().max(1), 0);
            data(0x100, &bytes)
        }
        4 => {
            bytes.resize(bytes.len().max(1), 0);
            while sheet.has(bytes[0]) {
                bytes[0] = random.below(256) as u8;
            }
            data(0x300, &bytes)
        }
        5 => {
            let row = &sheet.parameters[random.below(ZERO_X)];
            let request = row.write(random.pick(row.refused));
            let size = random.pick(&[request.len(), 1, request.len() - 1]);
            data(0x300, &request[..size])
        }
        _ => {
            let signatures = [
                &b"\x40LOAX"[..],
                b"\x50SAVF",
                b"\xFFRESEX",
                b"\x40",
                b"\x50",
                b"",
            ];
            data(0x300, random.pick(&signatures))
        }
    }
}

#[test]
fn frames_that_are_no_valid_requests_change_nothing() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut random = Random(0x2021_0730);
        let mut unit = sheet.online::<P>();
        for number in 0..2000 {
            unit.tester.receive(invalid(&mut random, sheet));
            unit.tester.sent();
            if number % 100 == 0 {
                unit.tester.ask(&[0x02]);
                unit.keeps_values();
            }
        }
        unit.tester.ask(&[0x02]);
        unit.keeps_values();
        unit.errors = CMD_PARAM_ERROR;
        unit.acknowledges(&[0x01]);
        unit.clears_errors();
        assert_eq!(unit.tester.memory, None);
    }
    each_product!(check);
}

/// RESET is left out, after which the sensor would use random identifiers.
#[test]
fn sensor_answers_and_loads_after_any_requests() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut random = Random(0x4915_2000);
        let mut unit = sheet.online::<P>();
        let codes: Vec<u8> = (0..=0xFF).filter(|code| sheet.has(*code)).collect();
        for _ in 0..4000 {
            let mut bytes = random.bytes(8);
            bytes[0] = random.pick(&codes);
            bytes.truncate(random.pick(&[1, 2, 3, 4, 5, 8]));
            let small = [bytes[0], 1, 0, 0];
            let request = random.pick(&[&bytes[..], b"\x50SAVE", &small]);
            unit.tester
                .receive(data(random.pick(&[0x300, 0x300, 0x100]), request));
            unit.tester.wait(random.pick(&[0, 0, 1, 20]));
        }
        unit.tester.receive(data(0x300, &[0x26, 0]));
        unit.tester.receive(data(0x300, &[0x02]));
        unit.tester.sent();
        unit.loads();
        unit.keeps_values();
        unit.ask(&[0x00], &unit.inclination(None));
    }
    each_product!(check);
}
