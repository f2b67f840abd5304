//! The board of a test, and its images.

use host_tests::effort;
use plumbline::model::catalog::PRODUCTS;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::sync::OnceLock;
use stm32_sim::board::Board;
use stm32_sim::chip::Chip;
use stm32_sim::firmware;
use stm32_sim::silicon::Silicon;

/// The images that tests need: one of each family of products, one with a heater, the program that checks gyroscope and supply, and one
/// with another number of axes.
const IMAGES: [&str; 7] = [
    "is2",
    "is2tk",
    "jn2101",
    "ims360",
    "tiltix080",
    "sensing",
    "is1",
];

/// The [`IMAGES`] for the board of this test: all only for the Blue Pill.
pub fn images() -> &'static [&'static str] {
    match board() {
        Board::BluePill => &IMAGES,
        _ => &IMAGES[..6],
    }
}

thread_local! {
    static BOARD: Cell<Board> = const { Cell::new(Board::BluePill) };
    static GENUINE: Cell<bool> = const { Cell::new(false) };
}

/// The board of this test: the Blue Pill, except within [`on_the_nucleo`] and [`on_the_nucleo_f103`].
pub fn board() -> Board {
    BOARD.get()
}

/// The microcontroller of this test.
pub fn chip() -> Chip {
    board().chip()
}

/// The silicon of this test: that of `PLUMBLINE_SILICON` (`.ci/long silicon`) or the worst, except within [`on_genuine_silicon`].
pub fn silicon() -> Silicon {
    let chosen = std::env::var("PLUMBLINE_SILICON").unwrap_or_default();
    match chosen.as_str() {
        _ if GENUINE.get() => Silicon::genuine(board()),
        "" => Silicon::worst(board()),
        "genuine" => Silicon::genuine(board()),
        "gd32" => Silicon::gd32(),
        other => panic!("no silicon {other}"),
    }
}

/// Restores the default, because the thread can run other tests afterwards.
struct Restore;

impl Drop for Restore {
    fn drop(&mut self) {
        BOARD.set(Board::BluePill);
        GENUINE.set(false);
    }
}

fn on(board: Board, test: impl FnOnce()) {
    let _restore = Restore;
    BOARD.set(board);
    test();
}

/// Runs a test with the images for the Nucleo-F446RE.
pub fn on_the_nucleo(test: impl FnOnce()) {
    on(Board::NucleoF446, test);
}

/// Runs a test with the images for the Nucleo-F103RB.
pub fn on_the_nucleo_f103(test: impl FnOnce()) {
    on(Board::NucleoF103, test);
}

/// Runs a test with the images for the Nucleo-F103RB, which has a microcontroller of ST.
pub fn on_the_genuine_nucleo_f103(test: impl FnOnce()) {
    on(Board::NucleoF103, || {
        GENUINE.set(true);
        test();
    });
}

/// Runs a test on a microcontroller of ST.
pub fn on_genuine_silicon(test: impl FnOnce()) {
    let _restore = Restore;
    GENUINE.set(true);
    test();
}

/// The ELF file of a product for the board. The first call builds all of them; in a long run, all products.
pub fn elf(model: &str) -> &'static [u8] {
    static FILES: [OnceLock<BTreeMap<String, Vec<u8>>>; Board::ALL.len()] =
        [const { OnceLock::new() }; Board::ALL.len()];
    let place = Board::ALL.iter().position(|one| *one == board());
    let files = FILES[place.expect("all boards")].get_or_init(|| {
        let products = PRODUCTS.iter().map(|product| product.name);
        let all = products.filter(|name| !images().contains(name));
        let all = all.take(effort::choose(0, usize::MAX));
        let images: Vec<_> = images().iter().copied().chain(all).collect();
        let built = firmware::build(board(), &images).unwrap_or_else(|error| panic!("{error}"));
        let read = |path| std::fs::read(path).expect("the image can be read");
        built
            .into_iter()
            .map(|(name, path)| (name, read(path)))
            .collect()
    });
    files.get(model).expect("an image of this name")
}
