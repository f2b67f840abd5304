//! Downloads of signed files.

use super::super::super::lms::PublicKey;
use super::super::super::simulated::{seal, sign};
use super::*;

/// The place of the body in a signed file.
const BODY: usize = SIZE + Signature::SIGNATURE;

#[test]
fn sensor_with_a_key_takes_only_files_with_its_signature() {
    let old = loaded(&file(OLD, 2048, 1));
    let unsigned = file(NEW, 3000, 2);
    let (signed, key) = sign(&unsigned);
    let (other, _) = sign(&file(NEW, 3000, 3));
    let mut wrong = signed.clone();
    wrong[SIZE + 1000] ^= 1;
    // The signature of another file.
    let mut swapped = other;
    swapped[SIZE..BODY].copy_from_slice(&signed[SIZE..BODY]);
    let with_key = |key| Flash {
        key: Some(key),
        ..old.clone()
    };
    let damaged = PublicKey::from_bytes([0x7F; PublicKey::SIZE]);
    for (name, key, file) in [
        ("unsigned", key, &unsigned),
        ("wrong", key, &wrong),
        ("of another file", key, &swapped),
        ("damaged key", damaged, &signed),
    ] {
        let mut flash = with_key(key);
        let mut loader = Loader::new();
        // The signature of the download before does not count.
        loader.clear();
        let mut program = Program::of(&flash);
        let start = &signed[..BODY];
        loader
            .take(&mut flash, &DEVICE, &mut program, start)
            .unwrap();
        let result = download(&mut flash, &mut loader, file, 217);
        assert_eq!(result, Err(Failure::Unsigned), "{name}");
        assert_eq!(loader.status(), Status::Secured, "{name}");
        assert_eq!(flash.bytes, old.bytes, "{name}");
    }
    for mut flash in [with_key(key), old.clone()] {
        for size in [1, 7, 10_000] {
            let result = download(&mut flash, &mut Loader::new(), &signed, size);
            assert_eq!(result, Ok(()), "pieces of {size}");
            assert_eq!(version(&flash), Some(NEW));
        }
    }
}

/// The last word makes the CRC equal.
#[test]
fn another_program_with_the_crc_of_a_signed_one_is_never_started_also_after_a_power_cut() {
    let old = loaded(&file(OLD, 2048, 1));
    let (signed, key) = sign(&file(NEW, 3000, 2));
    let mut forged = signed.clone();
    forged[BODY + 2000] ^= 1;
    let end = signed.len() - 4;
    let state = |file: &[u8]| crc(&body_parts(&file[BODY..end]));
    let correction = (state(&signed) ^ state(&forged)).to_le_bytes();
    for (byte, correction) in forged[end..].iter_mut().zip(correction) {
        *byte ^= correction;
    }
    assert_eq!(
        seal(signed[BODY..].to_vec(), NEW)[20..24],
        seal(forged[BODY..].to_vec(), NEW)[20..24]
    );
    let mut whole = Flash {
        key: Some(key),
        operations: 0,
        ..old
    };
    let before = whole.clone();
    let result = download(&mut whole, &mut Loader::new(), &forged, 217);
    assert_eq!(result, Err(Failure::Data));
    let operations = whole.operations;
    for power in operations - 500..=operations + 1 {
        let mut flash = before.clone();
        flash.power = Some(power);
        let _ = download(&mut flash, &mut Loader::new(), &forged, 217);
        flash.power = None;
        let started = Program::of(&flash).committed(&mut flash);
        assert_eq!(started, Program::None, "cut at {power} of {operations}");
    }
    let mut unlocked = Flash {
        key: None,
        ..before
    };
    let result = download(&mut unlocked, &mut Loader::new(), &forged, 217);
    assert_eq!(result, Ok(()), "without a key, the CRC counts");
}
