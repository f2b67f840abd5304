//! SAVE (manual, section 9.8) with the real flash driver: power cuts, page changes, broken flash, and frames that are received
//! while the processor is stalled.

use crate::rig::*;
use plumbline::can::BitRate;
use stm32_sim::chip::Chip;
use stm32_sim::flash::Times;

const RATE: BitRate = BitRate::M1;

/// The number of bytes that are programmed together.
fn unit() -> u64 {
    match chip() {
        Chip::F103 => 2,
        Chip::F446 => 4,
    }
}

/// The maximum time of a save in ms, with these times of the flash. The save erases a page and programs a record in units.
fn save_time(times: Times) -> u64 {
    let programs = RECORD as u64 / unit() * times.program;
    // PSIZE is that of a word on the Nucleo; on the Blue Pill all times are equal.
    (times.erase[2] + programs).div_ceil(1_000_000_000) + 10
}

/// The size of a record of is2 in bytes.
const RECORD: usize = 40;

/// Saves until a save has erased a page; returns the number of saves.
pub fn save_until_erased(rig: &mut Rig) -> u32 {
    let before = rig.flash().erased();
    let mut saves = 0;
    while rig.flash().erased() == before {
        rig.save();
        saves += 1;
    }
    saves
}

/// Saves `new` over `old` and cuts the power in the flash operation after `others` operations. Returns the parameter after the
/// next power-up, or None if the save ended before.
fn save_with_cut(rig: &mut Rig, old: u16, new: u16, others: u64) -> Option<u16> {
    rig.write_time(new);
    rig.flash().cut_in_operation_after(others, others);
    rig.send(&fsc::SAVE);
    rig.run(save_time(Times::longest(chip())));
    if rig.device().is_on() {
        assert_eq!(rig.expect(REPLY, 1).bytes()[0], fsc::SAVE[0]);
        rig.flash().power_on();
        return None;
    }
    assert!(rig.frames().is_empty(), "a reply before the save has ended");
    rig.power_cycle();
    rig.boot_up();
    let value = rig.read_time();
    assert!(
        value == old || value == new,
        "{value} after a cut in operation {others}"
    );
    Some(value)
}

#[test]
pub fn power_cut_at_any_half_word_keeps_the_old_or_the_new_parameters() {
    for times in [Times::shortest(chip()), Times::longest(chip())] {
        power_cut_at_any_half_word(times);
    }
}

fn power_cut_at_any_half_word(times: Times) {
    let mut rig = Rig::booted("is2", RATE);
    rig.io().0.flash.set_times(times);
    let (mut old, mut new) = (250, 1000);
    let mut operations = 0;
    while let Some(value) = save_with_cut(&mut rig, old, new, operations) {
        (old, new) = (value, new + 1);
        operations += 1;
    }
    println!("a save takes {operations} operations");
    // A header, more than 20 bytes of parameters and a checksum.
    assert!(operations >= 34 / unit());
    assert_eq!(rig.read_time(), new);
}

#[test]
pub fn power_cut_in_a_save_that_erases_keeps_the_old_or_the_new_parameters() {
    let mut rig = Rig::booted("is2", RATE);
    save_until_erased(&mut rig);
    let places = save_until_erased(&mut rig);
    let (mut old, mut new) = (250, 1000);
    let last = RECORD as u64 / unit() - 1;
    for operation in [0, 0, 0, 0, 1, 2, last / 2, last] {
        save_until_erased(&mut rig);
        for _ in 1..places {
            rig.save();
        }
        let erased = rig.flash().erased();
        let value =
            save_with_cut(&mut rig, old, new, operation).expect("a save has more operations");
        if operation > 0 {
            assert!(rig.flash().erased() > erased, "this save erases a page");
        }
        (old, new) = (value, new + 1);
    }
}

/// Blue Pill, DS5319: 40 to 70 us for a half-word, 20 to 40 ms for a page. Nucleo, DS10693: 16 to 100 us for a word, 250 to 500 ms
/// for a sector.
#[test]
pub fn saves_work_across_page_changes_with_any_times_of_the_flash() {
    for times in [Times::shortest, Times::typical, Times::longest] {
        let times = times(chip());
        let mut rig = Rig::booted("is2", RATE);
        rig.io().0.flash.set_times(times);
        let erased = rig.flash().erased();
        let page = chip().facts().geometry.page_size;
        let changes = match chip() {
            Chip::F103 => 5,
            Chip::F446 => 2,
        };
        let saves = (changes * page).div_ceil(RECORD) as u16 + 32;
        for value in 1..=saves {
            rig.write_time(value);
            rig.save();
            if value % 32 == 0 && (chip() == Chip::F103 || value > saves - 64) {
                rig.power_cycle();
                rig.boot_up();
                assert_eq!(rig.read_time(), value);
            }
        }
        assert!(rig.flash().erased() - erased >= changes as u64 - 1);
        assert_eq!(rig.request(&[fsc::STATUS])[1], 0);
    }
}

#[test]
pub fn broken_flash_sets_cmd_param_error_and_eeprom_error() {
    let mut rig = Rig::booted("is2", RATE);
    rig.flash().fail_writes(true);
    rig.flash().fail_erases(true);
    rig.write_time(777);
    let errors = status::CMD_PARAM_ERROR | status::EEPROM_ERROR;
    assert_eq!(rig.request(&fsc::SAVE), [fsc::SAVE[0], errors]);
    // Table 14: the bits stay until the status is read.
    assert_eq!(rig.request(&[fsc::STATUS])[1], errors);
    assert_eq!(rig.request(&[fsc::STATUS])[1], 0);
    assert_eq!(rig.read_time(), 777);
    rig.flash().fail_writes(false);
    rig.flash().fail_erases(false);
    rig.save();
    rig.power_cycle();
    rig.boot_up();
    assert_eq!(rig.read_time(), 777);
}

/// A board that was used before can have the option bytes of another program.
#[test]
pub fn save_to_write_protected_pages_is_an_error_and_keeps_the_stored_parameters() {
    let mut rig = Rig::booted("is2", RATE);
    rig.write_time(250);
    rig.save();
    let stored = rig.flash().bytes().to_vec();
    rig.io().0.flash.protect_parameters(true);
    for _ in 0..2 {
        rig.write_time(777);
        let errors = status::CMD_PARAM_ERROR | status::EEPROM_ERROR;
        assert_eq!(rig.request(&fsc::SAVE), [fsc::SAVE[0], errors]);
        assert_eq!(rig.flash().bytes(), stored);
        rig.power_cycle();
        rig.boot_up();
        assert_eq!(rig.read_time(), 250);
    }
    rig.io().0.flash.protect_parameters(false);
    rig.write_time(777);
    rig.save();
    rig.power_cycle();
    rig.boot_up();
    assert_eq!(rig.read_time(), 777);
}

#[test]
pub fn erase_of_a_page_loses_only_frames_beyond_the_fifo() {
    for times in [Times::shortest(chip()), Times::longest(chip())] {
        erase_of_a_page(times);
    }
}

fn erase_of_a_page(times: Times) {
    let mut rig = Rig::booted("is2", RATE);
    rig.io().0.flash.set_times(times);
    save_until_erased(&mut rig);
    let places = save_until_erased(&mut rig);
    for _ in 1..places {
        rig.save();
    }
    rig.frames();
    assert_eq!(rig.microcontroller().can().overruns(), 0);

    let erased = rig.flash().erased();
    rig.send(&fsc::SAVE);
    rig.run(2);
    // The processor is stalled for 20 ms and more; the CAN controller acknowledges.
    for code in 0x10..=0x15 {
        rig.send(&[code]);
    }
    rig.run(10);
    assert_eq!(rig.flash().erased(), erased + 1, "this save erases a page");
    assert_eq!(rig.bus.queued(rig.tester), 0, "all frames are acknowledged");
    assert!(rig.frames().is_empty());
    rig.run(save_time(times) + 40);
    let replies: Vec<u8> = rig.frames().iter().map(|frame| frame.bytes()[0]).collect();
    // RM0008, section 24.7.3: without FIFO lock a new message overwrites the last one, so the first two and the newest are kept.
    assert_eq!(replies, [0x10, 0x11, 0x15, fsc::SAVE[0]]);
    assert_eq!(rig.microcontroller().can().overruns(), 3);
    // The controller has one flag for all lost frames (`plumbline::diagnosis`, value 10).
    assert_eq!(rig.request(&[0x61, 10])[3..7], [1, 0, 0, 0]);
    for code in 0x10..=0x15 {
        rig.request(&[code]);
    }
}
