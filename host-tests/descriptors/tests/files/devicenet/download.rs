//! Downloads of all parameters in the order of the data sheet, as configuration tools and the configuration recovery of a scanner write
//! them: from any state to any other one, also while the sensor is polled.

use super::devicenet;
use super::master::{Master, value};
use super::sheet::{ENUMERATED, READ_ONLY, Sheet, TYPES, enumerated, number};
use descriptors::describe;

/// A parameter that a tool writes.
struct Setting {
    name: String,
    attribute: u8,
    size: usize,
    signed: bool,
    limits: (i64, i64),
    /// The named values; none for a range.
    named: Vec<i64>,
}

const RESOLUTION: u8 = 0x71;
const OFFSETS: [u8; 2] = [0x76, 0x7E];
const POLLED_ASSEMBLY: u8 = 0x81;
const CYCLIC_ASSEMBLY: u8 = 0x82;

/// The parameters of a data sheet that can be written, in its order.
fn settings(sheet: &Sheet) -> Vec<Setting> {
    let count = sheet.number("ParamClass", "MaxInst") as usize;
    let setting = |place: usize| {
        let fields = sheet.get("Params", &format!("Param{place}"));
        let descriptor = number(&fields[3]);
        let code = number(&fields[4]);
        let (_, size, signed) = *TYPES.iter().find(|(known, ..)| *known == code)?;
        let limits = (number(&fields[9]), number(&fields[10]));
        let setting = Setting {
            name: fields[6].clone(),
            attribute: u8::from_str_radix(&fields[2][15..], 16).ok()?,
            size,
            signed,
            limits,
            named: match descriptor & ENUMERATED {
                0 => Vec::new(),
                _ => enumerated(sheet, place, limits.0),
            },
        };
        (descriptor & READ_ONLY == 0).then_some(setting)
    };
    (1..=count).filter_map(setting).collect()
}

impl Setting {
    /// A permitted value. Limits of angles and of the COS delta are those at 0.01 deg.
    fn choose(&self, random: u64, resolution: i64) -> i64 {
        if !self.named.is_empty() {
            return self.named[random as usize % self.named.len()];
        }
        let follows = ["preset value", "Diff", "COS delta"];
        let unit = match follows.iter().any(|part| self.name.contains(part)) {
            true => resolution / 10,
            false => 1,
        };
        let (low, high) = (self.limits.0 / unit, self.limits.1 / unit);
        match random % 4 {
            0 => low,
            1 => high,
            _ => low + (random >> 2) as i64 % (high - low + 1),
        }
    }
}

/// The values of these parameters and of the offsets.
fn read(master: &mut Master, settings: &[Setting]) -> (Vec<i64>, [Vec<u8>; 2]) {
    let values = settings.iter().map(|setting| {
        let bytes = master.get(0x65, 1, setting.attribute);
        value(&bytes, setting.signed)
    });
    let values = values.collect();
    (values, OFFSETS.map(|it| master.get(0x65, 1, it)))
}

/// Writes all values in order. `choice` are the I/O connections.
fn download(master: &mut Master, settings: &[Setting], target: &[i64], choice: u8) {
    for (setting, target) in settings.iter().zip(target) {
        let result = master.set(0x65, setting.attribute, *target, setting.size);
        assert_eq!(result, Ok(()), "{} = {target}", setting.name);
        assert_eq!(master.poll().is_some(), choice & 2 != 0);
    }
}

#[test]
fn all_values_are_downloaded_in_order_from_any_state_to_any_other() {
    let rounds = host_tests::effort::choose(25, 500);
    for product in devicenet() {
        let sheet = Sheet::parse(&describe(product).text);
        let settings = settings(&sheet);
        assert_eq!(
            settings.len(),
            15,
            "22 attributes, of which 7 are read-only"
        );
        let mut random = 0x2026_1126_u64;
        let mut next = || {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            random >> 33
        };
        let mut master = Master::new(product);
        for round in 0..rounds {
            let choice = [0, 0x02, 0x50, 0x12, 0x62][round % 5];
            if choice != 0 {
                let poll = [2].into_iter().filter(|_| choice & 2 != 0);
                let producing = [4].into_iter().filter(|_| choice & 0x30 != 0);
                let instances: Vec<u8> = poll.chain(producing).collect();
                master.establish(choice, &instances);
            }
            let (before, _) = read(&mut master, &settings);
            let mut resolution = 0;
            let mut target = Vec::new();
            for (setting, before) in settings.iter().zip(before) {
                let keeps = setting.attribute == POLLED_ASSEMBLY && choice & 2 != 0
                    || setting.attribute == CYCLIC_ASSEMBLY && choice & 0x30 != 0;
                let chosen = match keeps {
                    true => before,
                    false => setting.choose(next(), resolution),
                };
                if setting.attribute == RESOLUTION {
                    resolution = chosen;
                }
                target.push(chosen);
            }
            download(&mut master, &settings, &target, choice);
            let written = read(&mut master, &settings);
            assert_eq!(written.0, target, "{}, round {round}", product.name);
            // The same again changes nothing, nor do the offsets of the presets.
            download(&mut master, &settings, &target, choice);
            assert_eq!(read(&mut master, &settings), written);
            // And once more by a scanner after a power cycle.
            master.power_cycle();
            assert_eq!(read(&mut master, &settings), written);
            download(&mut master, &settings, &target, 0);
            assert_eq!(read(&mut master, &settings), written);
        }
    }
}
