//! The memory functions of the firmware (`firmware-stm32/src/mem.rs`) as they are in an image: with random arguments they do what
//! C and the ABI for ARM (run-time ABI, 4.3.4) say, and change nothing else.

use proptest::prelude::*;
use std::cell::RefCell;
use std::sync::LazyLock;
use stm32_sim::cortex_m::{CortexM3, Pause};
use stm32_sim::elf::Image;
use stm32_sim::io::NoPeripherals;

const RAM: u32 = 0x2000_0000;
/// The part of RAM that the functions work on.
const AREA: usize = 256;
/// The initial stack pointer.
const STACK: u32 = RAM + 0x1000;

/// The image of a product that uses all of the functions.
static IMAGE: LazyLock<Image> = LazyLock::new(|| {
    let board = stm32_sim::board::Board::BluePill;
    let images = stm32_sim::firmware::build(board, &["jn2101"]).expect("the image builds");
    let elf = std::fs::read(&images["jn2101"]).expect("an image");
    Image::parse(&elf).expect("an image")
});

thread_local! {
    /// A processor with the image, at its reset vector.
    static PROCESSOR: RefCell<CortexM3> = RefCell::new({
        let mut processor = CortexM3::new();
        for segment in IMAGE.segments() {
            assert!(processor.load(segment.load_address, &segment.bytes));
        }
        processor.reset();
        processor
    });
}

/// Calls a function of the image with these arguments and this content of RAM; its result and the content afterwards.
fn call(function: &str, arguments: [u32; 3], ram: &[u8; AREA]) -> (u32, Vec<u8>) {
    PROCESSOR.with_borrow(|processor| call_on(&mut processor.clone(), function, arguments, ram))
}

fn call_on(
    processor: &mut CortexM3,
    function: &str,
    arguments: [u32; 3],
    ram: &[u8; AREA],
) -> (u32, Vec<u8>) {
    assert!(processor.load(RAM, ram));
    // The function returns to where the processor stands, and stops there.
    let end = processor.pc();
    processor.add_breakpoint(end);
    let entry = IMAGE.address_of(function).expect("a function of the image");
    let preserved =
        [4, 5, 6, 7, 8, 9, 10, 11].map(|register| (register, 0x1111 * u32::from(register)));
    for (register, value) in preserved {
        processor.set_register(register, value);
    }
    for (register, value) in (0..).zip(arguments) {
        processor.set_register(register, value);
    }
    processor.set_register(13, STACK);
    processor.set_register(14, end | 1);
    processor.set_register(15, entry);
    let limit = processor.cycle() + 10_000;
    assert_eq!(
        processor.run(&mut NoPeripherals, limit),
        Ok(Pause::Breakpoint)
    );
    assert_eq!(processor.register(13), STACK, "{function} changes SP");
    for (register, value) in preserved {
        assert_eq!(
            processor.register(register),
            value,
            "{function} changes R{register}"
        );
    }
    let after = processor.bytes(RAM, AREA).expect("RAM").to_vec();
    (processor.register(0), after)
}

/// A length, and two places that are so far apart that the regions do not overlap, aligned to `alignment`.
fn regions(alignment: usize) -> impl Strategy<Value = (usize, usize, usize)> {
    let half = AREA / 2;
    (0..half - 8, 0..8_usize, 0..8_usize, any::<bool>()).prop_map(move |(length, a, b, swapped)| {
        let [a, b] = [a, half + b].map(|place| place / alignment * alignment);
        if swapped {
            (length, b, a)
        } else {
            (length, a, b)
        }
    })
}

fn content() -> impl Strategy<Value = [u8; AREA]> {
    proptest::collection::vec(any::<u8>(), AREA)
        .prop_map(|bytes| bytes.try_into().expect("an array"))
}

fn address(place: usize) -> u32 {
    RAM + place as u32
}

proptest! {
    #[test]
    fn memcpy_copies_the_source_and_returns_the_destination((length, to, from) in regions(1), ram in content()) {
        let mut expected = ram.to_vec();
        expected.copy_within(from..from + length, to);
        let (result, after) = call("memcpy", [address(to), address(from), length as u32], &ram);
        prop_assert_eq!(after, expected);
        prop_assert_eq!(result, address(to));
    }

    #[test]
    fn aligned_memcpy_copies_the_source((length, to, from) in regions(4), ram in content()) {
        let mut expected = ram.to_vec();
        expected.copy_within(from..from + length, to);
        let (_, after) = call("__aeabi_memcpy4", [address(to), address(from), length as u32], &ram);
        prop_assert_eq!(after, expected);
    }

    #[test]
    fn memset_fills_the_region_and_returns_it((length, to, _) in regions(1), value in any::<u32>(), ram in content()) {
        let mut expected = ram.to_vec();
        expected[to..to + length].fill(value as u8);
        let (result, after) = call("memset", [address(to), value, length as u32], &ram);
        prop_assert_eq!(&after, &expected);
        prop_assert_eq!(result, address(to));
        // The ABI has the length before the value.
        let (_, after) = call("__aeabi_memset4", [address(to), length as u32, value], &ram);
        prop_assert_eq!(after, expected);
    }

    #[test]
    fn memclr_fills_the_region_with_zeros((length, to, _) in regions(1), rest in any::<u32>(), ram in content()) {
        let mut expected = ram.to_vec();
        expected[to..to + length].fill(0);
        let (_, after) = call("__aeabi_memclr", [address(to), length as u32, rest], &ram);
        prop_assert_eq!(after, expected);
    }

    #[test]
    fn memcmp_has_the_sign_of_the_first_difference(
        (length, a, b) in regions(1),
        ram in content(),
        difference in any::<Option<(prop::sample::Index, u8)>>(),
    ) {
        let mut ram = ram;
        ram.copy_within(b..b + length, a);
        if let Some((index, value)) = difference && length > 0 {
            ram[a + index.index(length)] = value;
        }
        let (result, after) = call("memcmp", [address(a), address(b), length as u32], &ram);
        prop_assert_eq!(&after, &ram);
        let expected = ram[a..a + length].cmp(&ram[b..b + length]) as i32;
        prop_assert_eq!((result as i32).signum(), expected);
    }
}
