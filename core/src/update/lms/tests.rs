//! The test cases of RFC 8554, appendix F. Those of another implementation are in the tests of the tool.

use super::*;
use std::vec::Vec;

/// Key, message and signature of each signature in both test cases.
fn cases() -> Vec<[Vec<u8>; 3]> {
    let lines = include_str!("rfc8554.txt").lines();
    let lines = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
    let bytes = |line: &str| {
        let digits = line.as_bytes().chunks(2);
        let digits = digits.map(|digits| std::str::from_utf8(digits).unwrap());
        let bytes = digits.map(|digits| u8::from_str_radix(digits, 16).unwrap());
        bytes.collect()
    };
    let parts: Vec<Vec<u8>> = lines.map(bytes).collect();
    parts.as_chunks().0.to_vec()
}

/// Whether a signature with these parameters is correct.
fn verifies<const H: u32, const W: u32>([key, message, signature]: &[Vec<u8>; 3]) -> bool {
    let id = key[8..].first_chunk().unwrap();
    let root = Lms::<H, W>::root(id, message, signature);
    key[..8] == *Lms::<H, W>::TYPES.as_flattened() && root.is_some_and(|root| key[24..] == root)
}

#[test]
fn signatures_of_rfc_8554_are_correct() {
    let cases = cases();
    let [first, second, third, fourth] = &cases[..] else {
        panic!("{} signatures", cases.len())
    };
    assert!(verifies::<5, 8>(first));
    assert!(verifies::<5, 8>(second));
    assert!(verifies::<10, 4>(third));
    assert!(verifies::<5, 8>(fourth));
}

#[test]
fn any_wrong_bit_of_key_message_or_signature_is_refused() {
    let right = &cases()[2];
    let check = |[key, message, signature]: &[Vec<u8>; 3]| {
        let key = PublicKey::from_bytes(*key.first_chunk().unwrap());
        key.verifies(message, signature)
    };
    assert!(check(right));
    for part in 0..3 {
        // The types in the key are not compared: there is only one.
        let start = [8, 0, 0][part];
        for byte in (start..right[part].len()).step_by(7) {
            let mut wrong = right.clone();
            wrong[part][byte] ^= 1 << (byte % 8);
            assert!(!check(&wrong), "part {part}, byte {byte}");
        }
    }
    let [key, message, signature] = right;
    for length in [0, 3, 4, 40, signature.len() - 32, signature.len() - 1] {
        let cut = signature[..length].to_vec();
        assert!(
            !check(&[key.clone(), message.clone(), cut]),
            "{length} bytes"
        );
    }
    let longer = [&signature[..], &[0; 32]].concat();
    assert!(!check(&[key.clone(), message.clone(), longer]));
}

#[test]
fn key_is_told_from_erased_flash() {
    assert!(PublicKey::from_bytes([0xFF; PublicKey::SIZE]).is_erased());
    let mut damaged = [0xFF; PublicKey::SIZE];
    damaged[55] = 0x7F;
    for key in [
        PublicKey::new(&[1; 16], &[2; 32]),
        PublicKey::from_bytes([0; _]),
        PublicKey::from_bytes(damaged),
    ] {
        assert!(!key.is_erased());
    }
}
