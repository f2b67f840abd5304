//! A disturbance inverts one bit of a static variable. The sensor heals or restarts: none stays mute while it feeds its watchdog.

use crate::rig::*;
use bench::script::LEVEL;
use bench::{BusRate, Source};
use host_tests::effort;
use plumbline::can::{BitRate, Frame, standard};
use std::ops::Range;

const RATE: BitRate = BitRate::M1;

/// The longest time without an answer in ms: of a sensor that continues to work or restarts, and after a reset by the watchdog with the slowest
/// oscillator.
const LONGEST: u64 = 2_000;
const WITH_WATCHDOG: u64 = 3_600;

/// A sensor that runs.
fn running() -> Rig {
    let mut rig = Rig::booted("is2", RATE);
    rig.microcontroller_mut().take_faults();
    rig.io().0.be_lenient();
    rig
}

/// The addresses of the variable whose name ends with this.
fn variable(rig: &Rig, name: &str) -> Range<u32> {
    let image = rig.microcontroller().image();
    let start = image.address_of(name).expect("a variable");
    let (name, _) = image.name_of(start).expect("its name");
    let is_of_it = |address: &u32| image.name_of(*address).is_some_and(|it| it.0 == name);
    let length = (start..).take_while(is_of_it).count() as u32;
    start..start + length
}

fn bits(addresses: Range<u32>) -> impl Iterator<Item = (u32, u32)> {
    addresses.flat_map(|at| (0..8).map(move |bit| (at, bit)))
}

/// Inverts this bit of the RAM. Returns its byte before.
fn invert(rig: &mut Rig, (address, bit): (u32, u32)) -> u8 {
    let core = rig.microcontroller_mut().core_mut();
    let byte = core.bytes(address, 1).expect("RAM")[0];
    assert!(core.load(address, &[byte ^ 1 << bit]));
    byte
}

/// Whether there is a frame with an inclination.
fn has_inclination(frames: &[Frame]) -> bool {
    let mut own = frames.iter().filter(|frame| frame.id() == standard(REPLY));
    own.any(|frame| frame.bytes().first() == Some(&fsc::INCLINATION))
}

/// Waits until a restart by an earlier bit is over: the firmware compares with an address that it notes after the start, 0.35 s later.
fn settle(rig: &mut Rig) {
    loop {
        let starts = rig.device().boots();
        rig.run(107);
        if rig.device().boots() == starts {
            return;
        }
        rig.run(500);
    }
}

/// Inverts this bit back if it still has its wrong value: the firmware compares some variables only when it uses them, and is not made for two
/// disturbances at once.
fn revert(rig: &mut Rig, (address, bit): (u32, u32), before: u8) {
    let core = rig.microcontroller_mut().core_mut();
    let byte = core.bytes(address, 1).expect("RAM")[0];
    if byte == before ^ 1 << bit {
        assert!(core.load(address, &[before]));
    }
}

/// The variable at this place.
fn named(rig: &Rig, (address, bit): (u32, u32)) -> String {
    let image = rig.microcontroller().image();
    let name = image
        .name_of(address)
        .map(|it| format!("{}+{}", it.0, it.1));
    format!("{name:?}, bit {bit}")
}

/// Polls until there is an answer.
fn assert_answers(rig: &mut Rig, place: &str) {
    let starts = rig.device().boots();
    let time = (0..WITH_WATCHDOG).step_by(20).find(|_| {
        rig.frames();
        rig.send(&[fsc::INCLINATION]);
        rig.run(20);
        has_inclination(&rig.frames())
    });
    let restarted = rig.device().boots() > starts;
    let in_time = time.is_some_and(|time| time <= LONGEST || restarted);
    assert!(in_time, "{place}: {time:?}");
}

#[test]
#[ignore = "sweeps over faults of the chip: `.ci/long ignored`"]
pub fn inverted_bit_of_a_static_variable_leaves_no_mute_sensor() {
    let mut rig = running();
    let statics = rig.microcontroller().image().statics();
    // The identifiers of the requests and replies, and the addresses of the node and of its frames.
    let node = variable(&rig, "::NODE").start;
    let known = [node + 32..node + 40, variable(&rig, "::LINK")];
    let known = known.into_iter().flat_map(bits);
    let step = effort::choose((89, 7), (1, 1));
    for place in bits(statics).step_by(step.0) {
        settle(&mut rig);
        let before = invert(&mut rig, place);
        let starts = rig.device().boots();
        let name = named(&rig, place);
        assert_answers(&mut rig, &name);
        if rig.device().boots() == starts {
            revert(&mut rig, place, before);
        }
    }
    std::mem::forget(rig);
    // In a sensor without an earlier disturbance, which could have changed what the firmware compares with.
    for place in known.step_by(step.1) {
        let mut rig = running();
        rig.run(500);
        invert(&mut rig, place);
        let name = named(&rig, place);
        assert_answers(&mut rig, &name);
        std::mem::forget(rig);
    }
}

/// The firmware notes the address 5 ms after it has joined the bus, and compares it ten times a second.
#[test]
pub fn inverted_bit_of_the_address_after_a_start_leaves_no_mute_sensor() {
    let mut rig = running();
    let node = variable(&rig, "::NODE").start;
    // Bit 30 of the identifier of the replies: a remote frame. Bits of the one of the requests.
    let places = [(node + 39, 6), (node + 35, 5), (node + 34, 3)];
    for wait in (6..112).step_by(15) {
        for place in places {
            rig.power_cycle();
            rig.frames();
            rig.boot_up();
            rig.run(wait);
            invert(&mut rig, place);
            assert_answers(&mut rig, &format!("{place:?} after {wait} ms"));
        }
    }
    std::mem::forget(rig);
}

/// Otherwise the next frame would come after hours.
#[test]
#[ignore = "sweeps over faults of the chip: `.ci/long ignored`"]
pub fn inverted_bit_of_the_time_does_not_stop_the_cyclic_frames() {
    let parameters: [&[u8]; 3] = [
        &[fsc::WRITE_BAUD_RATE, baud_rate_code(RATE)],
        &[fsc::WRITE_CYCLIC_TIME, 20, 0],
        &[fsc::WRITE_CYCLIC_MODE, 1],
    ];
    let mut rig = Rig::with("is2", BusRate::Fixed(RATE), saved("is2", &parameters));
    rig.run(500);
    rig.io().0.be_lenient();
    for place in bits(variable(&rig, "clock::TICKED")) {
        invert(&mut rig, place);
        rig.run(LONGEST);
        rig.frames();
        rig.run(100);
        assert!(has_inclination(&rig.frames()), "{place:?}");
    }
    std::mem::forget(rig);
}

/// The controller repeats a disturbed frame again after the next frame of the sensor.
#[test]
fn inverted_bit_of_the_single_attempt_loses_no_frame() {
    let mut rig = Rig::ims360(Box::new(LEVEL));
    rig.io().0.be_lenient();
    let single = variable(&rig, "transmit::SINGLE").start;
    rig.run(500);
    invert(&mut rig, (single, 0));
    rig.run(500);
    let device_type = rig.upload(0x1000, 0);
    rig.bus.corrupt(1, Some(Source::Device(rig.sensor)));
    assert_eq!(rig.upload(0x1000, 0), device_type);
    std::mem::forget(rig);
}

/// A bit that is not used changes nothing.
#[test]
pub fn inverted_bit_of_the_outputs_restarts_the_sensor() {
    let mut rig = Rig::booted("is2tk", RATE);
    rig.io().0.be_lenient();
    let mut restarts = 0;
    for place in bits(variable(&rig, "::OUTPUTS")) {
        rig.run(300);
        let boots = rig.device().boots();
        let outputs = |rig: &Rig| (rig.device().leds(), rig.microcontroller().terminated());
        let before = outputs(&rig);
        assert!(rig.microcontroller().heater() > 0, "{place:?}");
        invert(&mut rig, place);
        rig.run(10);
        if rig.device().boots() > boots {
            restarts += 1;
            rig.assert_safe_at_reset();
        } else {
            assert_eq!(outputs(&rig), before, "{place:?}");
        }
    }
    // Twice four LEDs and the resistor in a byte each, and 16 bits.
    assert_eq!(restarts, 2 * (5 * 8 + 16));
    std::mem::forget(rig);
}
