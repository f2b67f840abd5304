//! Tests of the broadcast groups.

use super::super::signal::{Measured, Merit};
use super::*;
use std::string::String;

const fn good(number: i32) -> Measured {
    Measured {
        number,
        merit: Merit::Good,
    }
}

/// An angle of this many 0.01 deg in 1/32768 deg.
fn angle_of(centidegrees: i64) -> Measured {
    let scaled = centidegrees * 32_768 * 2 / 100;
    good(((scaled + scaled.signum()) / 2) as i32)
}

/// A level sensor at rest.
fn level() -> Motion {
    let mut motion = Motion {
        values: [good(0); 8],
        latency: 0x60,
    };
    motion.values[Source::ForceZ as usize] = good(1000);
    motion
}

fn with(changes: &[(Source, Measured)]) -> Motion {
    let mut motion = level();
    for (source, value) in changes {
        motion.values[*source as usize] = *value;
    }
    motion
}

/// The data of a group as hexadecimal digits.
fn data(name: &str, motion: &Motion) -> String {
    let place = NAMES.iter().position(|own| *own == name).unwrap();
    let bytes = [ssi2, ssi, ari, accs][place](motion);
    bytes
        .iter()
        .map(|byte| std::format!("{byte:02X}"))
        .collect()
}

#[test]
fn groups_of_a_level_sensor() {
    assert_eq!(data("SSI2", &level()), "00007D00007D3360");
    assert_eq!(data("SSI", &level()), "007D007D007DC060");
    assert_eq!(data("ARI", &level()), "007D007D007DC0FF");
    assert_eq!(data("ACCS", &level()), "007D007DD580C0FF");
}

#[test]
fn angles_have_their_resolution_and_offset() {
    let motion = with(&[
        (Source::Pitch, angle_of(12_34)),
        (Source::Roll, angle_of(-5_00)),
    ]);
    assert_eq!(data("SSI2", &motion), "852B8300807A3360");
    assert_eq!(data("SSI", &motion), "1A953C73007DC060");
}

#[test]
fn angle_beyond_the_range_of_a_group_is_not_available_there() {
    let motion = with(&[
        (Source::Pitch, angle_of(-89_50)),
        (Source::Roll, angle_of(20)),
    ]);
    assert_eq!(data("SSI2", &motion), "0040509A197D3360");
    assert_eq!(data("SSI", &motion), "FFFF647D007DC360");
    // The last valid numbers, and the first ones beyond.
    for (pitch, valid) in [
        (1_00, true),
        (-25_000, true),
        (-25_001, false),
        (25_200, false),
    ] {
        let motion = with(&[(Source::Pitch, angle_of(pitch))]);
        let is_valid = !data("SSI2", &motion).starts_with("FFFFFF");
        assert_eq!(is_valid, valid, "{pitch}");
    }
    let last = with(&[(Source::Pitch, good(0xFA_FFFF - 250 * 32_768))]);
    assert_eq!(data("SSI2", &last), "FFFFFA00007D3360");
    let beyond = with(&[(Source::Pitch, good(0xFB_0000 - 250 * 32_768))]);
    assert_eq!(data("SSI2", &beyond), "FFFFFF00007D3F60");
    let extreme = with(&[
        (Source::Pitch, good(i32::MIN)),
        (Source::Roll, good(i32::MAX)),
    ]);
    assert_eq!(data("SSI2", &extreme), "FFFFFFFFFFFFFF60");
    assert_eq!(data("SSI", &extreme), "FFFFFFFF007DCF60");
}

#[test]
fn quality_follows_the_values() {
    let pitch = |merit| {
        let pitch = Measured {
            number: angle_of(10_000).number,
            merit,
        };
        with(&[(Source::Pitch, pitch)])
    };
    assert_eq!(data("SSI2", &pitch(Merit::Degraded)), "0000AF00007D3760");
    assert_eq!(data("SSI", &pitch(Merit::Degraded)), "FFFF007D007DC360");
    assert_eq!(data("SSI2", &pitch(Merit::Error)), "FEFEFE00007D3B60");
    assert_eq!(data("SSI2", &pitch(Merit::Unavailable)), "FFFFFF00007D3F60");
    let defective = Measured {
        number: 0,
        merit: Merit::Error,
    };
    let motion = Motion {
        values: [defective; 8],
        latency: 0xFF,
    };
    assert_eq!(data("SSI", &motion), "FEFEFEFEFEFEEAFF");
    assert_eq!(data("ACCS", &motion), "FEFEFEFEFEFEEAFF");
    assert_eq!(data("SSI2", &Motion::default()), "FFFFFFFFFFFFFFFF");
}

#[test]
fn roll_of_a_sensor_with_one_axis_is_not_available() {
    let motion = with(&[
        (Source::Pitch, angle_of(-90_00)),
        (Source::Roll, Measured::default()),
    ]);
    assert_eq!(data("SSI2", &motion), "000050FFFFFFF360");
    assert_eq!(data("SSI", &motion), "FFFFFFFF007DCF60");
    let motion = with(&[
        (Source::Pitch, angle_of(30_00)),
        (Source::Roll, Measured::default()),
    ]);
    assert_eq!(data("SSI2", &motion), "00008CFFFFFFF360");
    assert_eq!(data("SSI", &motion), "98B7FFFF007DCC60");
}

#[test]
fn rates_and_forces_have_their_places() {
    let motion = with(&[
        (Source::PitchRate, good(20_000)),
        (Source::RollRate, good(-15_000)),
        (Source::YawRate, good(-1_000)),
        (Source::ForceX, good(1000)),
        (Source::ForceY, good(-1000)),
    ]);
    assert_eq!(data("SSI", &motion), "007D007D10A4C060");
    assert_eq!(data("ARI", &motion), "00878075807CC0FF");
    assert_eq!(data("ACCS", &motion), "2B79D580D580C0FF");
}

#[test]
fn signals_of_a_group_fill_its_frame() {
    for group in GROUPS {
        let mut used = 0_u64;
        for signal in group.signals {
            let bits = (u64::MAX >> (64 - signal.bits)) << signal.start;
            assert_eq!(used & bits, 0, "{}", signal.name);
            used |= bits;
        }
        assert_eq!(used, u64::MAX, "{}", group.name);
        assert_eq!(place(group.pgn).map(|place| NAMES[place]), Some(group.name));
    }
    assert_eq!(place(0xFECA), None);
}
