//! Runs the image `cyccnt`, which measures instruction sequences on a board, and prints the figures of the simulator:
//! `cargo test -p stm32-sim --test images cyccnt -- --nocapture`.

use bench::{Flash, Sensor};
use plumbline::measure::Reading;
use plumbline::time::Instant;
use std::rc::Rc;
use stm32_sim::Microcontroller;
use stm32_sim::board::Board;
use stm32_sim::cortex_m::CortexM3;
use stm32_sim::elf::Image;
use stm32_sim::firmware;

/// The first word of the results when all sequences are measured.
const FINISHED: u32 = 0x4359_4343;

/// The longest time of the program in ps.
const LIMIT: u64 = 1_000_000_000_000;

/// A sequence with its figures at 0 and 2 wait states.
type Row = (String, [u32; 2]);

fn word(core: &CortexM3, address: u32) -> u32 {
    core.word(address).expect("an address of flash or RAM")
}

/// The results of the program, after it has run.
fn results() -> Vec<Row> {
    let images =
        firmware::build(Board::BluePill, &["cyccnt"]).unwrap_or_else(|error| panic!("{error}"));
    let elf = std::fs::read(&images["cyccnt"]).expect("it has just been built");
    let image = Rc::new(Image::parse(&elf).expect("the linker writes ELF"));
    let results = image.address_of("CYCCNT_RESULTS").expect("the static");
    let motion = Box::new(Reading::default());
    let mut board = Microcontroller::new("cyccnt", image, 1, Flash::default(), motion);
    board.power_on(Instant::from_ticks(0));
    // It returns early when the CAN controller has changed.
    while board.advance(LIMIT) < LIMIT {}
    assert!(board.violations().is_empty(), "{:?}", board.violations());
    let core = board.core();
    assert_eq!(word(core, results), FINISHED, "the program has not ended");
    let (count, sequences) = (word(core, results + 4), word(core, results + 8));
    (0..count)
        .map(|number| {
            let sequence = sequences + 16 * number;
            let length = word(core, sequence + 4) as usize;
            let name = core.bytes(word(core, sequence), length);
            let name = String::from_utf8(name.expect("a text in flash").to_vec());
            let figures = results + 12 + 8 * number;
            let figures = [0, 4].map(|offset| word(core, figures + offset));
            (name.expect("the text is UTF-8"), figures)
        })
        .collect()
}

/// Sequences whose cycles without wait states the TRM gives (sections 3.3.1 and 3.3.2).
const BY_THE_TRM: [(&str, u32); 15] = [
    ("16 narrow nop", 16),
    ("16 wide add", 16),
    ("load", 1 + 2 + 1),
    ("4 loads", 1 + 2 + 1 + 1 + 1 + 1),
    ("load, load of its address", 1 + 1 + 2 + 2 + 1),
    ("add, load of its address", 1 + 1 + 3 + 1),
    ("store", 1 + 1 + 1),
    ("store by register", 1 + 2 + 1),
    ("store by register, load", 1 + 2 + 2 + 1),
    ("load, store by register", 1 + 2 + 1 + 1),
    ("load of 4 registers", 1 + 5 + 1),
    ("push and pop of 4 registers", 1 + 5 + 5 + 1),
    ("branch that is not taken", 1 + 1 + 1 + 1),
    ("MLA", 1 + 2 + 1),
    ("UMULL, large", 1 + 5 + 1),
];

/// Sequences whose cycles the manuals leave open: the slow end of a range, or an assumption of `cortex_m/timing.rs`.
const ASSUMED: [(&str, u32); 8] = [
    // Contention with the fetch unit.
    ("literal load", 1 + 3 + 1),
    // The longest refill of the pipeline.
    ("branch over 4 lines", 4 + 1),
    ("loop of 10", 1 + 10 + 9 * 4 + 1),
    // The TRM has 2 to 12 cycles; between them a cycle for each 4 bits of the quotient.
    ("UDIV, quotient of 32 bits", 1 + 1 + 12 + 1),
    ("UDIV, quotient of 16 bits", 1 + 1 + 8 + 1),
    // The waits of the bridges and of registers on the AHB.
    ("load from APB1", 1 + 7 + 1),
    ("load from APB2", 1 + 4 + 1),
    ("load from the AHB", 1 + 3 + 1),
];

/// The program accesses only what the chip has. Its figures without wait states are those of the two tables: the figure of a sequence,
/// minus that of the empty sequence, and minus the two NOP around it that separate the loads of CYCCNT.
#[test]
fn figures_of_the_simulator_are_those_of_the_tables() {
    let rows = results();
    println!("0 and 2 wait states");
    for (name, [none, two]) in &rows {
        println!("{none:4} {two:4}  {name}");
    }
    let figure = |name: &str| {
        let row = rows.iter().find(|(other, _)| other == name);
        row.unwrap_or_else(|| panic!("no row {name}")).1
    };
    let [empty, _] = figure("4 narrow nop").map(|figure| figure - 4);
    for (name, cycles) in BY_THE_TRM.into_iter().chain(ASSUMED) {
        assert_eq!(figure(name)[0], empty + cycles, "{name}");
    }
    for (name, [none, two]) in &rows {
        assert!(
            two >= none,
            "{name}: fewer cycles with 2 wait states than with 0"
        );
    }
}
