//! The power is cut in an operation of the flash of the Blue Pill, and in one of the repair; in the boot record also on the Nucleo-F446RE. Afterwards there is the new program, or the
//! bootloader, which takes it again: never the old one with parts of the new one.

use super::entering::{ask, files};
use super::*;
use host_tests::effort;

const SMALL: usize = 3 * 1024;
const LARGE: usize = 40 * 1024;

const SPEED: BitRate = BitRate::M1;

/// An old program and its successor of this length.
fn programs(length: usize) -> [Vec<u8>; 2] {
    [loop_file(length, 0, 1), loop_file(length, 0x5A, 2)]
}

/// A sensor whose bootloader waits, with all of this old program but a wrong bit.
fn waiting(old: &[u8]) -> Rig {
    let mut old = slot(old);
    old[record_place()..].copy_from_slice(&record_only(SPEED)[record_place()..]);
    old[2000] ^= 1;
    let mut rig = sensor("jn2101", Some(old), SPEED);
    rig.run(50);
    rig.frames();
    rig
}

fn download(rig: &mut Rig, file: &[u8]) -> Result<(), Option<[u8; 8]>> {
    Client::of_known(rig, &known(SPEED)).download(file)
}

/// The operations of the flash in a download of this file.
fn count([old, new]: &[Vec<u8>; 2]) -> u64 {
    let mut rig = waiting(old);
    download(&mut rig, new).unwrap();
    operations(&mut rig)
}

/// Cuts the power in this operation of a download. Returns false if it has no more operations.
#[track_caller]
fn interrupt(rig: &mut Rig, file: &[u8], operation: u64) -> bool {
    cut(rig, operation);
    let is_cut = download(rig, file) == Err(None);
    assert!(is_cut || rig.device().is_on(), "operation {operation}");
    is_cut
}

/// Switches the power off and on. Returns whether the bootloader waits; otherwise the new program runs.
#[track_caller]
fn waits_after_power_up(rig: &mut Rig, new: &[u8], what: &str) -> bool {
    let resets = rig.microcontroller().resets().len();
    rig.power_cycle();
    rig.run(100);
    let frames = rig.frames();
    if frames == [data(0x70A, &[0])] {
        let status = Client::of_known(rig, &known(SPEED)).number(0x1F57, 1);
        assert_eq!(status, 1 << 1, "{what}: there is a program");
        return true;
    }
    assert_eq!(frames, [], "{what}: the program");
    for _ in resets + 1..rig.microcontroller().resets().len() {
        // The bootloader has committed the program, and starts it from a reset.
        rig.expect_reset(ResetCause::Software);
    }
    is_new(rig, new, what);
    false
}

/// The slot has the new program.
#[track_caller]
fn is_new(rig: &mut Rig, new: &[u8], what: &str) {
    let length = new.len() - SIZE;
    assert!(
        flash(rig).bytes()[..length] == slot(new)[..length],
        "{what}"
    );
}

/// Cuts the power in each of these operations of a download of this length, and repairs it.
fn power_cut_in(length: usize, step: u64) {
    let files = programs(length);
    let [old, new] = &files;
    let all = count(&files);
    // Always the last ones, with the commit.
    let operations = (step / 2..all - 2).step_by(step as usize);
    let operations = operations.chain(all - 2..all);
    let cuts = operations.clone().count();
    for operation in operations {
        let what = format!("operation {operation}");
        let mut rig = waiting(old);
        assert!(interrupt(&mut rig, new, operation), "{what}");
        if waits_after_power_up(&mut rig, new, &what) {
            download(&mut rig, new).unwrap();
            is_new(&mut rig, new, &what);
        }
    }
    println!("{cuts} cuts of {all} operations");
}

#[test]
fn power_cut_in_an_update_of_3_kib_leaves_the_bootloader_or_the_new_program() {
    power_cut_in(SMALL, effort::choose(211, 1));
}

#[test]
#[ignore = "sweeps over faults of the chip: `.ci/long ignored`"]
fn power_cut_in_an_update_of_40_kib_leaves_the_bootloader_or_the_new_program() {
    power_cut_in(LARGE, effort::choose(20_000, 97));
}

/// After a first cut in each kind of operation: the invalidation, the erase of the first page and of another one, the first, a middle and the
/// last half-word, the commit.
#[test]
#[ignore = "sweeps over faults of the chip: `.ci/long ignored`"]
fn power_cut_in_the_repair_leaves_the_bootloader_or_the_new_program() {
    let files = programs(SMALL);
    let [old, new] = &files;
    let all = count(&files);
    let mut cuts = 0;
    for first in [0, 1, 2, 3, all / 2, all - 2, all - 1] {
        for second in (0..all).step_by(effort::choose(1100, 1)) {
            let what = format!("operations {first} and {second}");
            let mut rig = waiting(old);
            assert!(interrupt(&mut rig, new, first), "{what}");
            if !waits_after_power_up(&mut rig, new, &what) {
                // The start has completed the commit.
                assert!(first + 2 >= all, "{what}");
                continue;
            }
            assert!(interrupt(&mut rig, new, second), "{what}");
            cuts += 1;
            if waits_after_power_up(&mut rig, new, &what) {
                download(&mut rig, new).unwrap();
                is_new(&mut rig, new, &what);
            }
        }
    }
    println!("{cuts} cuts in the repair");
}

/// The bootloader stores the record of the program that asks for it, in an empty page and in a full one, which it erases.
#[test]
fn power_cut_while_the_boot_record_is_stored_leaves_the_program_and_its_bootloader() {
    let [old, _] = files("jn2101");
    let empty = slot(&old);
    let mut full = empty.clone();
    let record = Record::new(jn2101(), Element::Ism330dhcx, &known(RATE), crc);
    for place in full[record_place()..].as_chunks_mut().0 {
        *place = *record.bytes();
    }
    let ids = (0x60A, 0x58A);
    let stop = [0x2F, 0x51, 0x1F, 1, 0, 0, 0, 0];
    let erase = Times::typical(chip()).erase_of_slot[2] / 1_000_000_000;
    for slot in [&empty, &full] {
        let mut whole = sensor("jn2101", Some(slot.clone()), RATE);
        whole.expect(BOOT_UP, START);
        ask(&mut whole, ids, &stop);
        whole.expect_reset(ResetCause::Software);
        whole.expect(BOOT_UP, 60 + erase);
        let all = operations(&mut whole);
        println!("{all} operations");
        for operation in (0..all).step_by(effort::choose(8, 1)) {
            let mut rig = sensor("jn2101", Some(slot.clone()), RATE);
            rig.expect(BOOT_UP, START);
            cut(&mut rig, operation);
            ask(&mut rig, ids, &stop);
            rig.expect_reset(ResetCause::Software);
            rig.run(100 + erase);
            assert!(!rig.device().is_on(), "operation {operation}");
            rig.power_cycle();
            rig.expect(BOOT_UP, START);
            ask(&mut rig, ids, &stop);
            rig.expect_reset(ResetCause::Software);
            rig.expect(BOOT_UP, 60 + erase);
            // It stays so without power, if there is no program.
            flash(&mut rig).flip_bit(8 * 2000).unwrap();
            rig.power_cycle();
            rig.expect(BOOT_UP, 60);
            let device_type = ask(&mut rig, ids, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]);
            assert_eq!(device_type[4..], [0; 4], "the bootloader");
        }
    }
}

mod nucleo_f446 {
    on! {
        crate::rig::on_the_nucleo:
        power_cut_while_the_boot_record_is_stored_leaves_the_program_and_its_bootloader
    }
}
