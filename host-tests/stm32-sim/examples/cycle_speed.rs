//! Prints how fast this computer simulates an image, with the cycles of the instructions and with one cycle for each, and the
//! ratio: `cargo run --release -p stm32-sim --example cycle_speed -- target/thumbv7m-none-eabi/release/is2`. The ratio must be at
//! least 0.5; otherwise the exit code is 1.
//!
//! - function: the processor alone, in the function that calculates the angle of an axis
//! - sensor: the complete sensor on a bus with 2000 SYNC frames a second, which includes the bus and the peripherals

use bench::{Bus, BusRate, Flash};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::measure::Reading;
use plumbline::time::{Duration, after};
use std::process::ExitCode;
use std::rc::Rc;
use std::time::Instant;
use stm32_sim::Microcontroller;
use stm32_sim::cortex_m::timing::Cycles;
use stm32_sim::cortex_m::{CortexM3, Pause};
use stm32_sim::elf::Image;
use stm32_sim::io::NoPeripherals;

/// The number of calls of the function.
const CALLS: usize = 200_000;
/// The function whose calls are measured.
const FUNCTION: &str = "plumbline::measure::definition::tilt";
/// The simulated time of the sensor in ms.
const TIME: u64 = 1_500;
/// Measurements of each; the fastest one counts, because other programs disturb the slower ones.
const ROUNDS: usize = 15;
/// The smallest permitted ratio.
const RATIO: f64 = 0.5;

fn main() -> ExitCode {
    let path = std::env::args().nth(1).expect("the path of an image");
    let elf = std::fs::read(&path).expect("the image can be read");
    let image = Rc::new(Image::parse(&elf).expect("it is an image"));
    let mut exit = ExitCode::SUCCESS;
    for (name, measure) in [
        ("function", function as fn(&Rc<Image>, _) -> f64),
        ("sensor", sensor),
    ] {
        let mut best = [0.0_f64; 2];
        for _ in 0..ROUNDS {
            for (best, cycles) in best.iter_mut().zip([Some(Cycles::default()), None]) {
                *best = best.max(measure(&image, cycles));
            }
        }
        let [with, without] = best;
        let ratio = with / without;
        println!(
            "{name}: {with:.1} million instructions per second with cycles, {without:.1} without: ratio {ratio:.2}"
        );
        if ratio < RATIO {
            eprintln!("{name}: the ratio is below {RATIO}");
            exit = ExitCode::FAILURE;
        }
    }
    exit
}

/// Million instructions per second of the processor alone.
fn function(image: &Rc<Image>, cycles: Option<Cycles>) -> f64 {
    const RAM: u32 = 0x2000_0000;
    let mut processor = CortexM3::new();
    for segment in image.segments() {
        assert!(processor.load(segment.load_address, &segment.bytes));
    }
    processor.set_cycles(cycles);
    processor.reset();
    let entry = image
        .address_of(FUNCTION)
        .expect("a function of a product that measures perpendicular angles");
    // The run after a breakpoint executes its instruction, so the calls return to two places in turn.
    let ends = [RAM + 0x4000, RAM + 0x4004];
    for end in ends {
        processor.add_breakpoint(end);
    }
    let begin = Instant::now();
    for end in ends.into_iter().cycle().take(CALLS) {
        for number in 0..4 {
            processor.set_register(number, RAM + 0x3000 + 0x100 * u32::from(number));
        }
        processor.set_register(13, RAM + 0x2000);
        processor.set_register(14, end | 1);
        processor.set_register(15, entry);
        let pause = processor.run(&mut NoPeripherals, u64::MAX);
        assert_eq!(pause, Ok(Pause::Breakpoint));
    }
    processor.instructions() as f64 / begin.elapsed().as_secs_f64() / 1e6
}

/// Million instructions per second of a complete sensor.
fn sensor(image: &Rc<Image>, cycles: Option<Cycles>) -> f64 {
    let mut bus = Bus::new(BusRate::Fixed(BitRate::M1));
    let motion = Box::new(Reading::default());
    let name = "sensor";
    let mut controller = Microcontroller::new(name, image.clone(), 1, Flash::default(), motion);
    controller.core_mut().set_cycles(cycles);
    let device = bus.attach(controller);
    let adapter = bus.adapter();
    bus.open(adapter, None, false);
    // The identifiers of the products with CANopen and with FSC.
    let sync = [0x080, 0x100].map(|id| Frame::data(standard(id), &[]).expect("it has no data"));
    let begin = Instant::now();
    for _ in 0..TIME {
        sync.iter().for_each(|sync| bus.send(adapter, *sync));
        let until = after(bus.now(), Duration::from_ticks(1_000));
        bus.run_until(until);
    }
    let controller = Microcontroller::of(bus.device(device)).expect("it was attached as one");
    controller.core().instructions() as f64 / begin.elapsed().as_secs_f64() / 1e6
}
