//! Replays each recorded trace on the images of Blue Pill and Nucleo-F446RE. `tests/sensor/traces.rs` replays them on the core.

use crate::rig::*;
use bench::{Bus, BusRate, Device, Flash, NodeType, Sensor};
use host_tests::effort;
use host_tests::trace::{Trace, recorded};
use plumbline::model::catalog::PRODUCTS;
use plumbline::time::{Duration, Instant};
use stm32_sim::cortex_m::interruption::Interruptions;

/// Maximum additional delay of an image: it handles a deadline at the next tick of its clock, and an event in the next run of its main
/// loop. In a message of five packets, the deadline of each packet follows from the packet before, and that of the second check of a MAC ID
/// from the first.
fn delay(product: &str) -> Duration {
    ms(match product {
        "ims360" => 5,
        "tiltix080" => 2,
        _ => 1,
    })
}

/// The noise of the gyroscope in the mean of a reading, which has 4 values: 1.5 / 4.17 of a count of 35 mdps, in the finest unit of the outputs.
const NOISE: u16 = 13;

/// The time in which an image that detects the bit rate is ready.
const READY: Duration = ms(200);

/// The time of the first frame that a sensor sends by itself.
fn first_frame(sensor: Box<dyn Sensor>) -> Option<Instant> {
    let mut bus = Bus::new(BusRate::Follow);
    bus.attach_boxed(sensor);
    let tester = bus.adapter();
    bus.open(tester, None, false);
    for ms in 1..3_000 {
        bus.run_until(Instant::from_ticks(ms * 1_000));
        if let Some((time, _)) = bus.take_received(tester).first() {
            return Some(*time);
        }
    }
    None
}

/// The receive interrupt of the CAN controller on all boards.
const RECEIVE_INTERRUPT: u8 = 20;

/// The image of a product for the board passes the traces of the product. It boots later than the core. The receive interrupt, here without a
/// frame, comes within each load and store of several words that the main loop executes, after each of its words.
fn image_passes(product: &'static str) {
    let interruptions = Interruptions::default();
    let of_image = |node_type: &NodeType, serial, motion| -> Box<dyn Sensor> {
        let mut sensor = part(node_type.name, serial, blank(), motion);
        let core = sensor.core_mut();
        core.interrupt_within_instructions(RECEIVE_INTERRUPT, &interruptions);
        Box::new(sensor)
    };
    let node_type = node_type(product);
    let core = Device::new(
        &node_type,
        SERIAL,
        Flash::default(),
        tilt(product, 0.0, 0.0),
    );
    let core = first_frame(Box::new(core));
    let own = first_frame(of_image(&node_type, SERIAL, tilt(product, 0.0, 0.0)));
    let boot = match (core, own) {
        (Some(core), Some(own)) => own - core,
        _ => READY,
    };
    recorded::check(product, |mut trace: Trace| {
        trace.loosen(delay(product), NOISE);
        trace.replay_on(&node_type, &recorded::scene, boot, &of_image)
    });
    let places = interruptions.places();
    let count: usize = places.values().sum();
    let instructions = places.len();
    println!("{product}: {count} interrupts within {instructions} loads and stores");
    assert!(count > instructions && instructions > 50, "{product}");
}

/// Those that differ from the tested images by constants. Only in a long run.
#[test]
fn images_of_the_other_products_pass_their_traces() {
    let tested = ["is2", "jn2101", "ims360", "tiltix080"];
    let others = PRODUCTS.iter().map(|product| product.name);
    let others = others.filter(|name| !tested.contains(name));
    for product in others.take(effort::choose(0, usize::MAX)) {
        image_passes(product);
        on_the_nucleo(|| image_passes(product));
    }
}

macro_rules! image_passes {
    ($($test:ident: $product:literal;)+) => {
        $(#[test]
        pub fn $test() {
            image_passes($product);
        })+
    };
}

image_passes! {
    image_of_the_is1_passes_its_traces: "is1";
    image_of_the_is2_passes_its_traces: "is2";
    image_of_the_jn2101_passes_its_traces: "jn2101";
    image_of_the_ims360_passes_its_traces: "ims360";
    image_of_the_tiltix080_passes_its_traces: "tiltix080";
}
