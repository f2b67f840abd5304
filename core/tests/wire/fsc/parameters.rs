//! The device parameters of each GEMAC product: limits, refusals, DefaultParam, identifiers, SAVE and LOAD (manual 9.8 and 9.10).

use crate::tester::gemac::*;
use plumbline::fsc::Product;
use plumbline::model::gemac::is2::TwoAxes;
use plumbline::node::ProductNode;

#[test]
fn values_up_to_the_limits_are_accepted_and_read_back() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        for (place, row) in sheet.parameters.iter().enumerate() {
            for value in row.accepted {
                unit.accepts(place, *value);
                // DefaultParam is set exactly with the factory values (G12). `accepts` compares the status.
                unit.keeps_values();
            }
            unit.accepts(place, row.factory);
        }
        // The value in force can be written again.
        for (place, row) in sheet.parameters.iter().enumerate() {
            unit.accepts(place, row.factory);
        }
    }
    each_product!(check);
}

#[test]
fn values_beyond_the_limits_are_refused() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        for (place, row) in sheet.parameters.iter().enumerate() {
            for value in row.refused {
                unit.refuses(&row.write(*value));
            }
            // Also when the parameter has another value than that of the factory.
            unit.accepts(place, row.accepted[0]);
            unit.refuses(&row.write(row.refused[0]));
            unit.accepts(place, row.factory);
        }
    }
    each_product!(check);
}

/// Only a zero offset can be written without data: the automatic adjustment (9.2).
#[test]
fn value_with_too_few_bytes_is_refused() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        for (place, row) in sheet.parameters.iter().enumerate() {
            let shortest = if place < ZERO_X { 1 } else { 2 };
            let request = row.write(0x0101_0101);
            for size in shortest..request.len() {
                unit.refuses(&request[..size]);
            }
        }
    }
    each_product!(check);
}

#[test]
fn bytes_after_the_value_are_ignored() {
    fn check<P: Product>(sheet: &'static Sheet) {
        for further in [0x00, 0xEE] {
            let mut unit = sheet.online::<P>();
            for (place, row) in sheet.parameters.iter().enumerate() {
                // Different values for the identifiers.
                let value = row.accepted[place % row.accepted.len()];
                unit.values[place] = value;
                let mut request = row.write(value);
                request.resize(8, further);
                unit.acknowledges(&request);
                unit.accepts(CYCLIC_MODE, 0);
                unit.keeps_values();
            }
        }
    }
    each_product!(check);
}

#[test]
fn load_and_save_with_another_signature_are_refused() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        unit.accepts(CYCLIC_TIME, 9);
        for (code, right, wrong) in [
            (
                0x40,
                b"LOAD",
                [&b"load"[..], b"DAOL", b"LOA\0", b"SAVE", b"SALO", b" LOAD"],
            ),
            (
                0x50,
                b"SAVE",
                [b"save", b"EVAS", b"SAV\0", b"LOAD", b"SALO", b" SAVE"],
            ),
        ] {
            let prefixes = (0..4).map(|size| &right[..size]);
            for signature in prefixes.chain(wrong) {
                unit.refuses(&[&[code], signature].concat());
            }
        }
        assert_eq!(unit.tester.memory, None);
    }
    each_product!(check);
}

/// An identifier must differ from those of the other frame types in number or format. The written values are compared (G15).
#[test]
fn identifier_of_another_frame_type_is_refused() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        let rows = sheet.parameters;
        for place in IDENTIFIERS {
            for other in IDENTIFIERS.into_iter().filter(|other| *other != place) {
                let value = rows[other].factory;
                unit.refuses(&rows[place].write(value));
                unit.accepts(place, EXTENDED | value);
                unit.accepts(place, rows[place].factory);
            }
        }
        let [set, reply, sync] = IDENTIFIERS;
        unit.accepts(set, 0x400);
        unit.refuses(&rows[reply].write(0x400));
        unit.refuses(&rows[sync].write(0x400));
        // 300h is free now, although it is in force.
        unit.accepts(reply, 0x300);
        unit.refuses(&rows[set].write(0x300));
        unit.accepts(sync, 0x301);
        unit.accepts(sync, EXTENDED | 0x1ABC_DEF0);
        unit.refuses(&rows[set].write(EXTENDED | 0x1ABC_DEF0));
    }
    each_product!(check);
}

/// From any state to any other one: the identifiers go through free ones, everything else has any order.
#[test]
fn all_values_are_accepted_in_any_order() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        let mut state = 0x2026_1125_u64;
        let mut below = |limit: usize| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as usize % limit
        };
        for _ in 0..200 {
            let rows = sheet.parameters;
            let mut target: Vec<u32> = rows
                .iter()
                .map(|row| match below(row.accepted.len() + 1) {
                    0 => row.factory,
                    place => row.accepted[place - 1],
                })
                .collect();
            // Often identifiers that another frame type has.
            let pool = [0x300, 0x301, 0x100, EXTENDED | 0x361];
            let first = below(pool.len());
            let step = [1, 3][below(2)];
            for place in IDENTIFIERS {
                target[place] = pool[(first + step * place) % pool.len()];
            }
            for place in IDENTIFIERS {
                unit.accepts(place, 0x123 + place as u32);
            }
            let mut places: Vec<usize> = (0..rows.len()).collect();
            while !places.is_empty() {
                let place = places.swap_remove(below(places.len()));
                unit.accepts(place, target[place]);
            }
            unit.keeps_values();
        }
    }
    each_product!(check);
}

/// A value of each parameter that is not the factory value.
fn other_values(sheet: &Sheet) -> Vec<u32> {
    let values = [
        0x555,
        EXTENDED | 0x0BAD_CAFE,
        0x001,
        7,
        1,
        0xABCD,
        1,
        filter(12_345, 1),
        7654,
        0xFB2E,
    ];
    values[..sheet.parameters.len()].to_vec()
}

#[test]
fn default_param_is_set_only_with_all_factory_values() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        let others = other_values(sheet);
        for (place, value) in others.iter().enumerate() {
            unit.accepts(place, *value);
        }
        for (place, row) in sheet.parameters.iter().enumerate() {
            unit.accepts(place, row.factory);
            unit.ask(&[0xFF], &unit.alive());
        }
        assert_eq!(unit.status() & 3, 3);
    }
    each_product!(check);
}

#[test]
fn saved_values_are_kept_and_others_are_lost() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        let (factory, others) = (unit.values.clone(), other_values(sheet));
        for (place, value) in others.iter().enumerate() {
            unit.accepts(place, *value);
        }
        unit.power_cycle(&factory);
        unit.wake();
        unit.keeps_values();

        for (place, value) in others.iter().enumerate() {
            unit.accepts(place, *value);
        }
        unit.saves();
        // A later change is not saved.
        unit.accepts(BUS_OFF_RECOVERY, 0);
        unit.power_cycle(&others);
        // With a fixed baud rate the sensor needs no traffic.
        unit.boots();
        unit.keeps_values();

        // LOAD saves the factory values. The identifiers stay in force until the restart (9.10.7, G8).
        unit.loads();
        unit.keeps_values();
        unit.ask(&[0xFF], &unit.alive());
        unit.ask(&[0x00], &unit.inclination(None));
        unit.power_cycle(&factory);
        unit.wake();
        unit.keeps_values();
    }
    each_product!(check);
}

#[test]
fn load_and_save_ignore_further_bytes() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        unit.accepts(CYCLIC_TIME, 30_000);
        unit.acknowledges(b"\x50SAVE\xFF\xFF\xFF");
        let saved = unit.values.clone();
        unit.power_cycle(&saved);
        unit.wake();
        unit.keeps_values();
        unit.values[CYCLIC_TIME] = 250;
        unit.acknowledges(b"\x40LOAD\0\x01\x02");
        unit.keeps_values();
        let factory = unit.values.clone();
        unit.power_cycle(&factory);
        unit.wake();
        unit.keeps_values();
    }
    each_product!(check);
}

/// Reads, DefaultParam and AutobaudDetection follow a written identifier or baud rate at once; frames use them after the restart
/// (G22).
#[test]
fn written_identifiers_and_baud_rate_act_after_the_restart() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        let factory = unit.values.clone();
        let steps: [[u32; 3]; 3] = [
            [0x400, EXTENDED | 0x1ABC_DEF1, EXTENDED | 0x100],
            [EXTENDED | 0x361, 0x7FF, 0x080],
            [0x000, 0x001, EXTENDED],
        ];
        for identifiers in steps {
            for (place, value) in IDENTIFIERS.into_iter().zip(identifiers) {
                unit.accepts(place, value);
            }
            unit.accepts(BAUD_RATE, 6);
            // `ask` uses the identifiers in force, and the alive message contains one of them.
            unit.ask(&[0xFF], &unit.alive());
            answers_sync(&mut unit);
            unit.saves();
            unit.ask(&[0x00], &unit.inclination(None));
            let values = unit.values.clone();
            unit.power_cycle(&values);
            unit.boots();
            unit.keeps_values();
            answers_sync(&mut unit);
            // Automatic detection acts after the restart.
            unit.accepts(BAUD_RATE, 0);
            unit.ask(&[0x00], &unit.inclination(None));
        }
        unit.loads();
        answers_sync(&mut unit);
        unit.power_cycle(&factory);
        unit.wake();
        answers_sync(&mut unit);
    }
    each_product!(check);
}

/// If the address changes and the filters do not, a driver restarts the sensor.
#[test]
fn address_of_the_node_depends_on_each_bit_of_the_identifiers() {
    let mut unit = IS2.online::<TwoAxes>();
    unit.accepts(BAUD_RATE, 6);
    let mut with = |identifiers: [u32; 3]| {
        for (place, value) in IDENTIFIERS.into_iter().zip(identifiers) {
            unit.accepts(place, value);
        }
        unit.saves();
        let values = unit.values.clone();
        unit.power_cycle(&values);
        unit.boots();
        unit.tester.node.halves().0.address()
    };
    let identifiers = [0x155, 0x6AA, 0x2F0];
    let address = with(identifiers);
    for place in IDENTIFIERS {
        for bit in 0..11 {
            let mut changed = identifiers;
            changed[place] ^= 1 << bit;
            assert_ne!(with(changed), address, "identifier {place}, bit {bit}");
        }
    }
}

fn answers_sync<P: Product>(unit: &mut Unit<P>) {
    unit.tester.receive(unit.frame(2, &[]));
    let reply = unit.frame(1, &unit.inclination(None));
    assert_eq!(unit.tester.sent(), [reply]);
}
