//! The board of a test, and its images.

use host_tests::effort;
use plumbline::model::catalog::PRODUCTS;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::sync::OnceLock;
use stm32_sim::chip::Chip;
use stm32_sim::firmware;
use stm32_sim::silicon::Silicon;

/// The images that tests need: one of each family of products, one with another number of axes, one with a heater, and the program that
/// checks gyroscope and supply.
pub const IMAGES: [&str; 7] = [
    "is1",
    "is2",
    "is2tk",
    "jn2101",
    "ims360",
    "tiltix080",
    "sensing",
];

thread_local! {
    static CHIP: Cell<Chip> = const { Cell::new(Chip::F103) };
    static GENUINE: Cell<bool> = const { Cell::new(false) };
}

/// The microcontroller of this test: that of the Blue Pill, except within [`on`].
pub fn chip() -> Chip {
    CHIP.get()
}

/// The silicon of this test: the worst, except within [`on_genuine_silicon`].
pub fn silicon() -> Silicon {
    if GENUINE.get() {
        Silicon::genuine(chip())
    } else {
        Silicon::worst(chip())
    }
}

/// Restores the default, because the thread can run other tests afterwards.
struct Restore;

impl Drop for Restore {
    fn drop(&mut self) {
        CHIP.set(Chip::F103);
        GENUINE.set(false);
    }
}

/// Runs a test with the images for the Nucleo.
pub fn on_the_nucleo(test: impl FnOnce()) {
    let _restore = Restore;
    CHIP.set(Chip::F446);
    test();
}

/// Runs a test on a microcontroller of ST.
pub fn on_genuine_silicon(test: impl FnOnce()) {
    let _restore = Restore;
    GENUINE.set(true);
    test();
}

/// The ELF file of a product for the board. The first call builds all of them; in a long run, all products.
pub fn elf(model: &str) -> &'static [u8] {
    static FILES: [OnceLock<BTreeMap<String, Vec<u8>>>; Chip::ALL.len()] =
        [const { OnceLock::new() }; Chip::ALL.len()];
    let place = Chip::ALL.iter().position(|one| *one == chip());
    let files = FILES[place.expect("all microcontrollers")].get_or_init(|| {
        let products = PRODUCTS.iter().map(|product| product.name);
        let all = products.filter(|name| !IMAGES.contains(name));
        let all = all.take(effort::choose(0, usize::MAX));
        let images: Vec<_> = IMAGES.into_iter().chain(all).collect();
        let built = firmware::build(chip(), &images).unwrap_or_else(|error| panic!("{error}"));
        let read = |path| std::fs::read(path).expect("the image can be read");
        built
            .into_iter()
            .map(|(name, path)| (name, read(path)))
            .collect()
    });
    files.get(model).expect("an image of this name")
}
