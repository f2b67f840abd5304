//! A board with two slots: the old program stays until the new one is complete, and is then copied.

use super::*;
use host_tests::effort;

/// The longest time of the copy of a program to its boot-up message in ms, with the longest times of the flash.
const COPY: u64 = 4500;

/// The length of the small programs.
const LENGTH: usize = 3072;

/// The place of the download.
fn second() -> usize {
    let second = layout().download.expect("two slots");
    (second - layout().start) as usize
}

/// Slots with an old program, which is an endless loop, and a record.
fn old_slots(rate: BitRate) -> Vec<u8> {
    let mut slots = slot(&loop_file(LENGTH, 0, 1));
    slots[record_place()..].copy_from_slice(&record_only(rate)[record_place()..]);
    slots
}

/// The place of a byte of the old program that a wrong bit makes invalid.
const BROKEN: usize = 2000;

/// Starts the bootloader as if the old program, which cannot ask for it, had asked: the program is not valid during the start.
fn enter(rig: &mut Rig) {
    flash(rig).flip_bit(8 * BROKEN).unwrap();
    rig.power_cycle();
    rig.run(50);
    assert_eq!(rig.frames(), [data(0x70A, &[0])], "the bootloader");
    flash(rig).flip_bit(8 * BROKEN).unwrap();
}

/// A sensor with an old program whose bootloader waits.
fn waiting(rate: BitRate) -> Rig {
    let mut rig = sensor("jn2101", Some(old_slots(rate)), rate);
    enter(&mut rig);
    rig
}

fn content(rig: &mut Rig) -> Vec<u8> {
    flash(rig).bytes().to_vec()
}

/// Some of these operations, and the last ones.
fn some(all: u64) -> impl Iterator<Item = u64> {
    let step = effort::choose(all as usize / 5, 1);
    (0..all - 4).step_by(step).chain(all - 4..all)
}

/// Switches the power off and on, and cuts it in this operation.
fn power_up(rig: &mut Rig, operation: Option<u64>) {
    let resets = rig.microcontroller().resets().len();
    rig.power_cycle();
    if let Some(operation) = operation {
        cut(rig, operation);
    }
    // A copy erases a page of an STM32F446, or three pages of an STM32F103.
    rig.run(500 + Times::typical(chip()).erase_of_slot[2] / 1_000_000_000);
    for _ in resets + 1..rig.microcontroller().resets().len() {
        // After a copy.
        rig.expect_reset(ResetCause::Software);
    }
}

/// After a power-up, a whole program starts: it sends nothing, and the bootloader says nothing. Returns whether it is the new one.
#[track_caller]
fn starts_new(rig: &mut Rig, cut: &str) -> bool {
    power_up(rig, None);
    assert_eq!(rig.frames(), [], "{cut}: the program");
    let content = content(rig);
    let [old, new] = [loop_file(LENGTH, 0, 1), loop_file(LENGTH, 0x5A, 2)].map(|it| slot(&it));
    let is_new = content[..LENGTH] == new[..LENGTH];
    assert!(
        is_new || content[..LENGTH] == old[..LENGTH],
        "{cut}: a mixture"
    );
    is_new
}

/// The power is cut in one operation of the download, and in one of the next download.
fn power_cut_in_a_download_leaves_a_whole_program() {
    let rate = BitRate::M1;
    let new = loop_file(LENGTH, 0x5A, 2);
    let mut whole = waiting(rate);
    let before = operations(&mut whole);
    Client::of_known(&mut whole, &known(rate))
        .download(&new)
        .unwrap();
    let all = operations(&mut whole) - before;
    let download = |rig: &mut Rig, operation| {
        cut(rig, operation);
        let result = Client::of_known(rig, &known(rate)).download(&new);
        assert_eq!(result, Err(None), "operation {operation}");
        starts_new(rig, &format!("operation {operation}"))
    };
    let mut cuts = 0;
    for first in some(all) {
        let mut rig = waiting(rate);
        let is_new = download(&mut rig, first);
        assert!(!is_new || first + 1 == all, "operation {first}");
        if !is_new {
            enter(&mut rig);
            download(&mut rig, (first * 7 + 3) % (all - 1));
        }
        cuts += 1;
    }
    println!("{cuts} cuts of {all} operations");
}

/// The power is cut in one operation of the copy, and in one of the next copy.
fn power_cut_in_a_copy_repeats_it() {
    let rate = BitRate::M1;
    let new = loop_file(LENGTH, 0x5A, 2);
    let downloaded = || {
        let mut rig = waiting(rate);
        Client::of_known(&mut rig, &known(rate))
            .download(&new)
            .unwrap();
        rig
    };
    let mut whole = downloaded();
    let before = operations(&mut whole);
    assert!(starts_new(&mut whole, "no cut"));
    let all = operations(&mut whole) - before;
    let mut cuts = 0;
    for first in some(all) {
        let mut rig = downloaded();
        for operation in [first, (first * 7 + 3) % (all - 1)] {
            power_up(&mut rig, Some(operation));
            // The second start has nothing to copy if only the end of the first copy was missing.
            let is_cut = !rig.device().is_on();
            assert!(is_cut || first + 1 == all, "operation {operation}");
        }
        let cut = format!("operation {first}");
        assert!(starts_new(&mut rig, &cut), "{cut}");
        let magic = &content(&mut rig)[second() + PLACE..][..4];
        assert_ne!(magic, b"PLUM", "{cut}: it is not copied again");
        cuts += 1;
    }
    println!("{cuts} cuts of {all} operations");
}

fn old_program_stays_until_the_new_one_is_copied() {
    let [old, new] = [file("jn2101", VERSION), file("jn2101", VERSION + 1)];
    let mut rig = sensor("jn2101", Some(slot(&old)), RATE);
    rig.io().0.flash.set_times(Times::longest(chip()));
    rig.expect(BOOT_UP, START);
    rig.bus
        .send(rig.tester, data(0x60A, &[0x2F, 0x51, 0x1F, 1, 0, 0, 0, 0]));
    rig.expect(0x58A, 60);
    rig.expect_reset(ResetCause::Software);
    rig.expect(BOOT_UP, 30);
    let contact = Contact {
        request: CanId::standard(0x60A),
        reply: CanId::standard(0x58A),
        ..known(RATE)
    };
    let crc_of = |file: &[u8]| u32::from_le_bytes(file[20..24].try_into().unwrap());
    let mut client = Client::of_known(&mut rig, &contact);
    assert_eq!(client.number(0x1F56, 1), crc_of(&old));
    client.leave_in_block(&new);
    client.rig.run(TIME_OUT.ticks() / 1000 + 50);
    client.rig.frames();
    assert_eq!(client.number(0x1F56, 1), crc_of(&old));
    client.download(&new).unwrap();
    assert_eq!(client.number(0x1F56, 1), crc_of(&new));
    let length = old.len() - SIZE;
    assert_eq!(content(client.rig)[..length], slot(&old)[..length]);
    client.control(1);
    // The restart of the client, and that after the copy.
    rig.expect_reset(ResetCause::Software);
    rig.expect_reset(ResetCause::Software);
    let start = rig.bus.now();
    rig.expect(BOOT_UP, COPY);
    println!(
        "copied and started after {} us",
        (rig.bus.now() - start).ticks()
    );
    let length = new.len() - SIZE;
    assert_eq!(content(&mut rig)[..length], slot(&new)[..length]);
    // The download is not copied again.
    rig.power_cycle();
    rig.expect(BOOT_UP, START);
}

fn image_for_another_product_element_or_board_is_refused_before_an_erase() {
    let rate = BitRate::M1;
    let mut rig = waiting(rate);
    let own = loop_file(LENGTH, 0x5A, 2);
    let (header, body) = own.split_at(SIZE);
    let own = header.first_chunk().and_then(Header::parse).expect("one");
    let (product, board, layout) = (own.product(), own.board(), own.layout());
    let (element, other) = (Element::Ism330dhcx, Element::Adxl355);
    let others = [
        (product + 1, element, board, layout),
        (product, other, board, layout),
        (product, element, board + 1, layout),
        (product, element, board, layout + 1),
    ];
    for (product, element, board, layout) in others {
        let contents = Contents {
            product,
            element,
            board,
            layout,
            key: 0,
            version: 2,
            hash: [0; 32],
        };
        let header = Header::new(&contents, body).expect("a first page");
        let file = [header.bytes(), body].concat();
        is_refused(&mut rig, rate, &file, 0x0609_0030);
    }
    assert!(!starts_new(&mut rig, "no cut"));
}

mod nucleo_f103 {
    on! {
        crate::rig::on_the_nucleo_f103:
        old_program_stays_until_the_new_one_is_copied,
        image_for_another_product_element_or_board_is_refused_before_an_erase,
        power_cut_in_a_download_leaves_a_whole_program,
        power_cut_in_a_copy_repeats_it
    }
}

mod nucleo_f446 {
    on! {
        crate::rig::on_the_nucleo:
        old_program_stays_until_the_new_one_is_copied,
        image_for_another_product_element_or_board_is_refused_before_an_erase,
        power_cut_in_a_download_leaves_a_whole_program,
        power_cut_in_a_copy_repeats_it
    }
}
