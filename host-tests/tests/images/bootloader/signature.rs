//! The bootloader that checks signatures, with a key in its flash.

use super::*;
use plumbline::update::PublicKey;
use plumbline::update::lms::Signature;
use stm32_sim::image_file;

/// A file with a signature, and its key.
fn sign(file: &[u8]) -> (Vec<u8>, PublicKey) {
    image_file::sign(file, &[1; 16]).expect("an image file")
}

/// The bootloader of the board that checks signatures.
fn checking() -> &'static str {
    match board() {
        Board::NucleoF446 => "bootloader",
        _ => SIGNED,
    }
}

/// A sensor with this bootloader and this key, without a program.
fn sensor(bootloader: &str, key: Option<&PublicKey>, rate: BitRate) -> Rig {
    let bootloader = image(bootloader);
    let bootloader = match key {
        Some(key) => bootloader.with_key(key).expect("a board with a bootloader"),
        None => bootloader,
    };
    let slot = Some(record_only(rate));
    let mut rig = sensor_of(bootloader, "jn2101", slot, rate, blank());
    rig.run(100);
    rig.frames();
    rig
}

#[test]
fn sensor_with_a_key_takes_only_the_file_with_its_signature() {
    let rate = BitRate::M1;
    let unsigned = loop_file(8 * 1024, 0, VERSION);
    let (signed, key) = sign(&unsigned);
    let mut wrong = signed.clone();
    wrong[SIZE + 2000] ^= 1;
    let mut rig = sensor(checking(), Some(&key), rate);
    is_refused(&mut rig, rate, &unsigned, 0x0800_0021);
    is_refused(&mut rig, rate, &wrong, 0x0800_0021);
    let (foreign, _) = image_file::sign(&unsigned, &[2; 16]).expect("an image file");
    is_refused(&mut rig, rate, &foreign, 0x0800_0021);
    let start = rig.bus.now();
    let mut client = Client::of_known(&mut rig, &known(rate));
    client.download(&signed).unwrap();
    println!(
        "8 KiB with a signature: {} us, the longest answer after {} us",
        (client.rig.bus.now() - start).ticks(),
        client.slowest
    );
    // On the Blue Pill the time-out of python-canopen, 300 ms. An erase on the Nucleo-F446RE takes 1 s.
    let limit = 270_000 + Times::typical(chip()).erase_of_slot[2] / 1_000_000;
    assert!(client.slowest <= limit);
    let place = layout().download.unwrap_or(layout().start) - layout().start;
    let content = &flash(&mut rig).bytes()[place as usize..];
    let body = [&signed[..SIZE], &signed[SIZE + Signature::SIGNATURE..]].concat();
    assert!(content[..8 * 1024] == slot(&body)[..8 * 1024]);
}

#[test]
fn sensor_without_a_key_takes_files_with_and_without_a_signature() {
    let rate = BitRate::M1;
    let unsigned = loop_file(4 * 1024, 0, VERSION);
    let (signed, _) = sign(&unsigned);
    let mut rig = sensor(checking(), None, rate);
    let mut client = Client::of_known(&mut rig, &known(rate));
    client.download(&unsigned).unwrap();
    client.download(&signed).unwrap();
}

/// To it, the signature is the first page of a damaged program.
#[test]
fn bootloader_without_signatures_refuses_a_image_file() {
    let rate = BitRate::M1;
    let (signed, _) = sign(&loop_file(4 * 1024, 0, VERSION));
    let mut rig = sensor("bootloader", None, rate);
    is_refused(&mut rig, rate, &signed, 0x0800_0020);
}

mod nucleo_f446 {
    on! {
        crate::rig::on_the_nucleo:
        sensor_with_a_key_takes_only_the_file_with_its_signature,
        sensor_without_a_key_takes_files_with_and_without_a_signature
    }
}
