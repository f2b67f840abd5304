//! A debug probe on a running sensor: it connects while the processor sleeps, reads the log, and programs the sensor again.

use crate::rig::*;
use plumbline::can::BitRate;
use std::rc::Rc;
use stm32_sim::elf::Image;
use stm32_sim::rcc::ResetCause;
use stm32_sim::rtt::{self, Message};
use stm32_sim::silicon::Silicon;
use stm32_sim::{Microcontroller, firmware};

/// The ELF file of is2 with the log.
fn elf_with_log() -> Vec<u8> {
    let built =
        firmware::build_with_log(board(), &["is2"]).unwrap_or_else(|error| panic!("{error}"));
    std::fs::read(&built["is2"]).expect("the image can be read")
}

/// The longest time in ms from the connection of a probe until it can read a sensor that sleeps.
const CONNECTION: u64 = 200;

/// Runs the program with the log for 200 ms, connects a probe, then runs until the processor sleeps, and reads the log.
fn log(elf: &[u8], silicon: &Silicon) -> (Rig, Vec<Message>) {
    let image = Rc::new(Image::parse(elf).expect("an ELF file"));
    let memory = fixed("is2", BitRate::M1);
    let sensor = Microcontroller::new("is2", image, SERIAL, memory, tilt("is2", 10.0, 5.0));
    let mut rig = Rig::of(sensor.with_silicon(silicon).quiet(), BitRate::M1);
    rig.run(200);
    rig.microcontroller_mut().probe_connect();
    rig.run(CONNECTION);
    rig.wait_until(1, 10, |rig| rig.microcontroller().core().is_asleep());
    let log = rtt::read(rig.microcontroller(), elf).expect("the probe reads the RAM");
    rig.frames();
    (rig, log)
}

/// True if the log has a message with these words, and with this text in its values.
fn says(log: &[Message], words: &str, value: &str) -> bool {
    let mut messages = log.iter().filter(|message| message.text.contains(words));
    messages.any(|message| String::from_utf8_lossy(&message.values).contains(value))
}

#[test]
#[ignore = "an image with the log: `.ci/run boards`"]
pub fn probe_reads_log_and_programs_sleeping_sensor_twice() {
    let elf = elf_with_log();
    let (mut rig, messages) = log(&elf, &silicon());
    assert!(says(&messages, "accelerometer found", ""), "{messages:?}");
    for _ in 0..2 {
        rig.wait_until(1, 10, |rig| rig.microcontroller().core().is_asleep());
        assert!(rig.microcontroller_mut().probe_halt());
        // Longer than the watchdog.
        rig.run(3_000);
        rig.frames();
        rig.expect_reset(ResetCause::Software);
        let (_, now) = rig.io();
        let program = image("is2");
        assert!(rig.microcontroller_mut().probe_program(now, program));
        rig.boot_up();
        rig.poll();
    }
}

#[test]
#[ignore = "an image with the log: `.ci/run boards`"]
fn log_names_the_microcontroller() {
    let elf = elf_with_log();
    let clone = "the microcontroller is not one of ST";
    let named = |silicon: &Silicon, name: &str| {
        let (_, messages) = log(&elf, silicon);
        assert!(says(&messages, "CPUID", ""), "{messages:?}");
        says(&messages, clone, name)
    };
    assert!(!named(&Silicon::genuine(board()), ""));
    assert!(named(&Silicon::gd32(), "a GD32F103"));
    assert!(named(&Silicon::worst(board()), "a clone (CS32F103"));
}
