//! A debug probe on a running sensor: it connects while the processor sleeps, reads the log, and programs the sensor again.

use crate::memory::save_until_erased;
use crate::rig::*;
use plumbline::can::BitRate;
use std::rc::Rc;
use stm32_sim::chip::Chip;
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

/// A sensor with the program with the log.
fn sensor(elf: &[u8], silicon: &Silicon) -> Microcontroller {
    let image = Rc::new(Image::parse(elf).expect("an ELF file"));
    let memory = fixed("is2", BitRate::M1);
    let sensor = Microcontroller::new("is2", image, SERIAL, memory, tilt("is2", 10.0, 5.0));
    sensor.with_silicon(silicon).quiet()
}

fn wait_until_asleep(rig: &mut Rig) {
    rig.wait_until(1, 10, |rig| rig.microcontroller().core().is_asleep());
}

/// Connects a probe to a running sensor, waits until the processor sleeps, and reads the log.
fn connect(rig: &mut Rig, elf: &[u8]) -> Vec<Message> {
    rig.microcontroller_mut().probe_connect();
    rig.run(CONNECTION);
    wait_until_asleep(rig);
    let log = rtt::read(rig.microcontroller(), elf).expect("the probe reads the RAM");
    rig.frames();
    log
}

/// Runs the program with the log for 200 ms, then connects a probe.
fn log(elf: &[u8], silicon: &Silicon) -> (Rig, Vec<Message>) {
    let mut rig = Rig::of(sensor(elf, silicon), BitRate::M1);
    rig.run(200);
    let log = connect(&mut rig, elf);
    (rig, log)
}

/// True if the probe reads the RAM.
fn reads(rig: &Rig) -> bool {
    rig.microcontroller().probe_read(0x2000_3000, 4).is_some()
}

/// True if the log has a message with these words, and with this text in its values.
fn says(log: &[Message], words: &str, value: &str) -> bool {
    let mut messages = log.iter().filter(|message| message.text.contains(words));
    messages.any(|message| String::from_utf8_lossy(&message.values).contains(value))
}

#[test]
#[ignore = "an image with the log: `.ci/long ignored`"]
pub fn probe_reads_log_and_programs_sleeping_sensor_twice() {
    let elf = elf_with_log();
    let (mut rig, messages) = log(&elf, &silicon());
    assert!(says(&messages, "accelerometer found", ""), "{messages:?}");
    for _ in 0..2 {
        wait_until_asleep(&mut rig);
        assert!(rig.microcontroller_mut().probe_halt());
        // Longer than the watchdog.
        rig.run(3_000);
        rig.frames();
        rig.expect_reset(ResetCause::Software);
        let (_, now) = rig.io();
        let program = Rc::new(Image::parse(&elf).expect("an ELF file"));
        assert!(rig.microcontroller_mut().probe_program(now, program));
        rig.boot_up();
        rig.poll();
        rig.run(100);
        wait_until_asleep(&mut rig);
        let messages = rtt::read(rig.microcontroller(), &elf).expect("the probe reads the RAM");
        assert!(says(&messages, "accelerometer found", ""), "{messages:?}");
    }
}

#[test]
#[ignore = "an image with the log: `.ci/long ignored`"]
fn probe_reads_log_after_each_connection() {
    let elf = elf_with_log();
    let (mut rig, first) = log(&elf, &silicon());
    for _ in 0..3 {
        rig.microcontroller_mut().probe_disconnect();
        assert!(!reads(&rig), "without a connection");
        rig.run(300);
        assert_eq!(connect(&mut rig, &elf)[..first.len()], first);
    }
}

/// For longer than the watchdog. The flash goes on meanwhile.
#[test]
pub fn halt_in_an_erase_of_the_flash_only_delays_the_save() {
    let mut rig = Rig::booted("is2", BitRate::M1);
    for _ in 1..save_until_erased(&mut rig).max(save_until_erased(&mut rig)) {
        rig.save();
    }
    let erased = rig.flash().erased();
    rig.write_time(777);
    rig.microcontroller_mut().probe_connect();
    rig.run(CONNECTION);
    rig.send(&fsc::SAVE);
    rig.run(3);
    assert!(rig.microcontroller_mut().probe_halt());
    rig.run(3_000);
    assert_eq!(rig.flash().erased(), erased + 1, "this save erases a page");
    let (_, now) = rig.io();
    rig.microcontroller_mut().resume(now);
    assert_eq!(rig.expect(REPLY, 600).bytes()[..2], [fsc::SAVE[0], 0]);
    rig.power_cycle();
    rig.boot_up();
    assert_eq!(rig.read_time(), 777);
}

/// With a probe that is connected before the supply is on, and over a reset by the supply.
#[test]
#[ignore = "an image with the log: `.ci/long ignored`"]
pub fn probe_reads_from_the_start_on() {
    let mut microcontroller = sensor(&elf_with_log(), &silicon());
    microcontroller.probe_connect();
    let mut rig = Rig::of(microcontroller, BitRate::M1);
    for _ in 0..2 {
        let mut asleep = 0;
        for microseconds in (0..150_000).step_by(100) {
            rig.run_us(100);
            asleep += u32::from(rig.microcontroller().core().is_asleep());
            assert!(reads(&rig), "{microseconds} us after power-up");
        }
        assert!(asleep > 100, "{asleep}");
        rig.frames();
        rig.power_cycle();
    }
}

/// What keeps the port on in sleep mode: DBG_SLEEP in DBGMCU_CR, and the clock of the DMA controller.
#[test]
#[ignore = "an image with the log: `.ci/long ignored`"]
pub fn probe_does_not_read_without_the_clocks_that_the_program_restores() {
    let dma_clock = match chip() {
        Chip::F103 => (0x4002_1014, 1 << 0),
        Chip::F446 => (0x4002_3830, 1 << 21),
    };
    let (mut rig, _) = log(&elf_with_log(), &silicon());
    // With the longest time until it is restored, in ms.
    for ((address, bits), limit) in [((0xE004_2004, 1), 110), (dma_clock, 1_100)] {
        wait_until_asleep(&mut rig);
        assert!(reads(&rig), "{address:08X}h");
        assert!(rig.microcontroller_mut().disturb(address, bits));
        assert!(!reads(&rig), "{address:08X}h without its bit");
        rig.run(limit);
        wait_until_asleep(&mut rig);
        assert!(reads(&rig), "{address:08X}h is restored");
        rig.frames();
    }
}

#[test]
#[ignore = "an image with the log: `.ci/long ignored`"]
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
