//! The bootloader: it takes a program over CAN and starts it, whenever the power is cut.

/// Tests on another board than the Blue Pill.
macro_rules! on {
    ($on:path: $($test:ident),+) => {
        $(#[test]
        #[ignore = "another board or other silicon: `.ci/long ignored`"]
        fn $test() {
            $on(super::$test);
        })+
    };
}

mod client;
mod entering;
mod ims360;
mod power;
mod signature;
mod two_slots;

use crate::rig::{Rig, SERIAL, blank, board, chip, data, node_type, silicon, tilt};
use bench::Flash;
use client::Client;
use plumbline::can::{BitRate, CanId, Frame};
use plumbline::canopen::sdo::TIME_OUT;
use plumbline::model::catalog;
use plumbline::store::ImageId;
use plumbline::update::header::{PLACE, SIZE, crc};
use plumbline::update::layout::LAYOUTS;
use plumbline::update::{Contact, Contents, Element, Header, Layout, Record};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::OnceLock;
use stm32_sim::Microcontroller;
use stm32_sim::board::Board;
use stm32_sim::elf::Image;
use stm32_sim::firmware::{BuildError, build, build_behind_bootloader, build_with_signatures};
use stm32_sim::flash::Times;
use stm32_sim::rcc::ResetCause;

/// The version of the programs.
const VERSION: u32 = 0x0001_0000;

/// The name of the image of the bootloader that checks signatures, if the one without it does not.
const SIGNED: &str = "bootloader with signatures";

/// The memory of the board of this test.
fn layout() -> &'static Layout {
    let name = board().facts().name;
    let layout = LAYOUTS.iter().find(|layout| layout.name == name);
    layout.expect("a board with a bootloader")
}

/// The images of the bootloader and of some programs behind it.
fn image(name: &str) -> Image {
    static FILES: [OnceLock<BTreeMap<String, Vec<u8>>>; Board::ALL.len()] =
        [const { OnceLock::new() }; Board::ALL.len()];
    let place = Board::ALL.iter().position(|one| *one == board());
    let files = FILES[place.expect("all boards")].get_or_init(|| {
        let files = || -> Result<_, BuildError> {
            let mut built = build(board(), &["bootloader"])?;
            if board() == Board::BluePill {
                built.extend(build_behind_bootloader(
                    board(),
                    &["is2", "jn2101", "tiltix080"],
                )?);
                let signed = build_with_signatures(board(), &["bootloader"])?;
                built.extend(signed.into_values().map(|it| (SIGNED.to_owned(), it)));
            } else {
                // The IMS360 is too large for the other boards.
                let large = (board() == Board::NucleoF446).then_some("ims360");
                let names: Vec<&str> = ["jn2101"].into_iter().chain(large).collect();
                built.extend(build_behind_bootloader(board(), &names)?);
            }
            Ok(built)
        };
        let built = files().unwrap_or_else(|error| panic!("{error}"));
        let read = |path| std::fs::read(path).expect("the image can be read");
        let files = built.into_iter().map(|(name, path)| (name, read(path)));
        files.collect()
    });
    Image::parse(&files[name]).expect("an ELF file")
}

/// The image file of a program with this version.
fn file(name: &str, version: u32) -> Vec<u8> {
    let image = image(name).behind(&image("bootloader"));
    let slot = image.expect("it is behind the bootloader").slot();
    let mut body = slot.expect("a slot");
    // Without the erased rest.
    let end = body.iter().rposition(|byte| *byte != 0xFF).expect("code") + 1;
    body.truncate(end.next_multiple_of(4));
    body[PLACE..PLACE + SIZE].fill(0xFF);
    let product = catalog::find(name).expect("a product");
    seal(product.image.number(), version, &body)
}

/// The image file with this body.
fn seal(product: u16, version: u32, body: &[u8]) -> Vec<u8> {
    let contents = Contents {
        product,
        element: Element::Ism330dhcx,
        board: layout().board,
        layout: layout().number,
        key: 0,
        version,
        hash: [0; 32],
    };
    let header = Header::new(&contents, body).expect("a first page");
    [header.bytes(), body].concat()
}

/// The place of the page of the boot record.
fn record_place() -> usize {
    (layout().record - layout().start) as usize
}

/// What is in the slot after the update with a file.
fn slot(file: &[u8]) -> Vec<u8> {
    let (header, body) = file.split_at(SIZE);
    let mut slot = body.to_vec();
    let header = header.first_chunk().and_then(Header::parse);
    header.expect("a header").commit(&mut slot);
    slot.resize(board().facts().slot.len(), 0xFF);
    slot
}

/// A refused file, with its abort code. Nothing was erased.
#[track_caller]
fn is_refused(rig: &mut Rig, rate: BitRate, file: &[u8], code: u32) {
    let refused = Client::of_known(rig, &known(rate)).download(file);
    let [a, b, c, d] = code.to_le_bytes();
    assert_eq!(refused, Err(Some([0x80, 0x50, 0x1F, 1, a, b, c, d])));
    assert_eq!(operations(rig), 0);
}

/// A sensor with a bootloader and this content of its slot, on a bus at this rate.
fn sensor(name: &str, slot: Option<Vec<u8>>, rate: BitRate) -> Rig {
    sensor_with(name, slot, rate, blank())
}

/// The same with this memory.
fn sensor_with(name: &str, slot: Option<Vec<u8>>, rate: BitRate, memory: Flash) -> Rig {
    sensor_of(image("bootloader"), name, slot, rate, memory)
}

/// The same with this bootloader.
fn sensor_of(
    bootloader: Image,
    name: &str,
    slot: Option<Vec<u8>>,
    rate: BitRate,
    memory: Flash,
) -> Rig {
    let image = Rc::new(bootloader.as_bootloader());
    let scene = tilt(name, 10.0, 5.0);
    let mut part = Microcontroller::new(node_type(name).name, image, SERIAL, memory, scene)
        .with_silicon(&silicon())
        .quiet();
    if let Some(slot) = slot {
        part.io_mut().flash.open_slot(slot);
        part.slot();
    }
    Rig::of(part, rate)
}

/// The boot-up message of the jn2101 with the factory node-ID, at 125 kbit/s.
const BOOT_UP: u16 = 0x70A;
const RATE: BitRate = BitRate::K125;

/// The longest time from power-up to the boot-up message in ms.
const START: u64 = 130;

fn jn2101() -> ImageId {
    catalog::find("jn2101").expect("a product").image
}

/// The sensor that a boot record describes.
fn known(rate: BitRate) -> Contact {
    Contact {
        rate,
        request: CanId::extended(0x0C0A_0B00),
        reply: CanId::extended(0x0C0A_0B01),
        boot_up: CanId::standard(0x70A),
        vendor: 0x0069_6666,
        product_code: 2101,
        serial: 7,
    }
}

/// Pages without a program, with a boot record.
fn record_only(rate: BitRate) -> Vec<u8> {
    let mut slot = vec![0xFF; board().facts().slot.len()];
    let record = Record::new(jn2101(), Element::Ism330dhcx, &known(rate), crc);
    slot[record_place()..][..record.bytes().len()].copy_from_slice(record.bytes());
    slot
}

/// The flash that the bootloader can change.
fn flash(rig: &mut Rig) -> &mut Flash {
    rig.microcontroller_mut().slot().expect("a bootloader")
}

/// The operations of the flash so far.
fn operations(rig: &mut Rig) -> u64 {
    flash(rig).operations()
}

/// Cuts the power in the operation of the flash after `operation` others.
fn cut(rig: &mut Rig, operation: u64) {
    flash(rig).cut_in_operation_after(operation, operation);
}

/// An image file for the jn2101 with a body of this length, whose program is an endless loop.
fn loop_file(length: usize, seed: u8, version: u32) -> Vec<u8> {
    let noise = (0..length).map(|place| (place as u8).wrapping_mul(31) ^ (place >> 8) as u8 ^ seed);
    let mut body: Vec<u8> = noise.collect();
    let (stack, entry) = (0x2000_3000_u32, layout().start + 0x241);
    body[..4].copy_from_slice(&stack.to_le_bytes());
    body[4..8].copy_from_slice(&entry.to_le_bytes());
    body[PLACE..PLACE + SIZE].fill(0xFF);
    // `b .` with Thumb state.
    body[0x240..0x242].copy_from_slice(&[0xFE, 0xE7]);
    seal(jn2101().number(), version, &body)
}

#[test]
fn sensor_without_a_program_takes_one_over_can() {
    let file = file("jn2101", VERSION);
    let mut rig = sensor("jn2101", None, RATE);
    rig.run(300);
    assert_eq!(rig.frames(), [], "it sends nothing before it is asked");
    let mut client = Client::of_unknown(&mut rig);
    client.wake();
    assert_eq!(client.number(0x1F57, 1), 1 << 1, "no program");
    client.download(&file).unwrap();
    assert_eq!(client.number(0x1F57, 1), 0);
    let body = u32::from_le_bytes(file[20..24].try_into().unwrap());
    assert_eq!(client.number(0x1F56, 1), body);
    client.control(1);
    rig.expect_reset(ResetCause::Software);
    rig.expect(BOOT_UP, START);
}

/// 0606 0000h: a hardware error.
#[test]
fn download_to_a_flash_that_fails_is_refused() {
    let file = file("jn2101", VERSION);
    let mut rig = sensor("jn2101", None, RATE);
    rig.run(300);
    flash(&mut rig).fail_writes(true);
    let mut client = Client::of_unknown(&mut rig);
    client.wake();
    let refused = Some([0x80, 0x50, 0x1F, 1, 0, 0, 6, 6]);
    assert_eq!(client.download(&file), Err(refused));
    flash(&mut rig).fail_writes(false);
    let mut client = Client::of_unknown(&mut rig);
    client.download(&file).unwrap();
}

/// With signatures it has 8 KiB, of which 64 bytes are the key.
#[test]
fn bootloader_has_at_most_6_kib_and_8_kib_with_signatures() {
    for (name, limit) in [("bootloader", 6 * 1024), (SIGNED, 8 * 1024 - 64)] {
        let image = image(name);
        let size: usize = image.segments().iter().map(|it| it.bytes.len()).sum();
        println!("{name}: {size} bytes");
        assert!(size <= limit, "{name}: {size} bytes");
    }
}

#[test]
fn program_behind_bootloader_starts_at_most_15_ms_later() {
    let first = |mut rig: Rig| {
        rig.expect(BOOT_UP, START);
        rig.log.last().expect("the message").start / 1_000_000
    };
    let alone = first(Rig::new("jn2101", RATE));
    let behind = first(sensor("jn2101", Some(slot(&file("jn2101", VERSION))), RATE));
    println!("boot-up message after {behind} us, without a bootloader after {alone} us");
    assert!(behind - alone <= 15_000, "{}", behind - alone);
}

#[test]
fn bootloader_answers_with_the_identifiers_and_the_bit_rate_of_its_record() {
    for rate in BitRate::ALL {
        let mut rig = sensor("jn2101", Some(record_only(rate)), rate);
        rig.run(100);
        let boot_up = rig.frames();
        assert_eq!(boot_up, [data(0x70A, &[0])], "{rate:?}");
        let mut client = Client::of_known(&mut rig, &known(rate));
        assert_eq!(client.number(0x1018, 1), known(rate).vendor);
        assert_eq!(client.number(0x1018, 2), known(rate).product_code);
        assert_eq!(client.number(0x1018, 4), known(rate).serial);
        // A program of another product.
        is_refused(&mut rig, rate, &file("is2", VERSION)[..2048], 0x0609_0030);
    }
}

/// Other nodes send to each other with a higher priority. One client leaves within a block, and another one begins anew.
#[test]
fn download_succeeds_beside_other_traffic_and_after_a_client_that_left() {
    let rate = BitRate::M1;
    let mut rig = sensor("jn2101", Some(record_only(rate)), rate);
    rig.run(100);
    rig.frames();
    let other = rig.bus.adapter();
    rig.bus.open(other, None, false);
    for number in 0..4000_u16 {
        rig.bus.send(
            other,
            data(0x100 + number % 16, &[0x2F, 0x51, 0x1F, 1, 2, 0, 0, 0]),
        );
    }
    let file = loop_file(8 * 1024, 0, VERSION);
    let mut client = Client::of_known(&mut rig, &known(rate));
    client.leave_in_block(&file);
    client.rig.run(TIME_OUT.ticks() / 1000 + 50);
    let abort = Frame::of(client.reply, [0x80, 0x50, 0x1F, 1, 0, 0, 4, 5], 8);
    assert_eq!(client.rig.frames(), [abort]);
    client.download(&file).unwrap();
    assert_eq!(flash(&mut rig).bytes()[..8 * 1024], slot(&file)[..8 * 1024]);
}

/// At most 3.3 s at 1 Mbit/s and 9.5 s at 125 kbit/s with the typical times of the flash, 4.2 s at 1 Mbit/s with the longest ones. The
/// Nucleo-F446RE erases its slot at once, which takes 1 s or 2 s.
#[test]
fn download_of_40_kib_takes_a_few_seconds() {
    let file = loop_file(40 * 1024, 0, VERSION);
    let all = [
        (BitRate::M1, Times::typical(chip()), 3_300_000),
        (BitRate::M1, Times::longest(chip()), 4_200_000),
        (BitRate::K125, Times::typical(chip()), 9_500_000),
    ];
    for (rate, times, limit) in all {
        let mut rig = sensor("jn2101", Some(record_only(rate)), rate);
        rig.io().0.flash.set_times(times);
        rig.run(100);
        rig.frames();
        let start = rig.bus.now();
        let mut client = Client::of_known(&mut rig, &known(rate));
        client.download(&file).unwrap();
        let took = (rig.bus.now() - start).ticks();
        println!("40 KiB at {rate:?}: {took} us");
        assert!(took <= limit, "{took} us at {rate:?}");
    }
}

mod nucleo_f446 {
    on! {
        crate::rig::on_the_nucleo:
        download_of_40_kib_takes_a_few_seconds,
        program_behind_bootloader_starts_at_most_15_ms_later
    }
}
