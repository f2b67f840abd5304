//! From power-up to the first frame, restarts, and the watchdog.

use crate::rig::*;
use bench::{Bus, BusRate, Device, Flash};
use plumbline::can::BitRate;
use stm32_sim::chip::Chip;
use stm32_sim::ism330dhcx::Fault;
use stm32_sim::rcc::ResetCause;

const RATE: BitRate = BitRate::K500;

/// The boot-up message of table 16 with this status: the alive code, the Set-Parameter-ID, software version 3.44.
fn boot_up(status: u8) -> plumbline::can::Frame {
    data(REPLY, &[fsc::ALIVE, status, 0x00, 0x03, 0, 0, 0x44, 0x03])
}

/// An is2 with a fixed bit rate after power-up.
fn switched_on() -> Rig {
    Rig::with("is2", BusRate::Fixed(RATE), fixed("is2", RATE))
}

/// The boot-up messages wait for the first reading: the node is not on the bus before it. The first angle is right.
///
/// The Nucleo-F103RB is 3 ms later than the Blue Pill. Its clock from the ST-LINK is ready 2 ms before a crystal, so the driver tries 2 ms
/// earlier to find the accelerometer, every 5 ms. One more try falls in the boot of the accelerometer, which takes 10 ms.
#[test]
pub fn first_frame_is_sent_with_first_reading() {
    let mut rig = switched_on();
    // Another node acknowledges it. The sensor does not keep it.
    rig.send(&[fsc::ZERO_X]);
    rig.run(45);
    assert_eq!(rig.frames(), []);
    assert_eq!(rig.device().mode(), None);
    rig.run(20);
    let sent = rig.sent();
    let frames: Vec<_> = sent.iter().map(|logged| logged.frame).collect();
    assert_eq!(frames, [boot_up(0), boot_up(0)]);
    let start = sent[0].start / 1_000_000;
    println!("the first frame starts {start} us after power-up");
    assert!((50_000..66_000).contains(&start), "{start} us");
    // 10 and 5 deg; without the zero point that the tester has requested.
    let reply = rig.poll();
    for (at, expected) in [(2, 1000), (4, 500)] {
        let angle = i16::from_le_bytes([reply[at], reply[at + 1]]);
        assert!(angle.abs_diff(expected) <= 5, "{reply:02X?}");
    }
}

/// Reproduced: a zero point set behind the second boot-up message was 0.
#[test]
fn zero_point_set_after_boot_up_is_measured_position() {
    let mut rig = switched_on();
    rig.boot_up();
    rig.write(&[fsc::ZERO_X]);
    let reply = rig.poll();
    let x = i16::from_le_bytes([reply[2], reply[3]]);
    assert!(x.abs() <= 5, "{x} in 0.01 deg");
}

/// The accelerometer has failed if there is no measurement 100 ms after power-up: it is missing, or its line is also stuck at 0.
#[test]
fn accelerometer_without_an_answer_is_a_sensor_error_from_the_boot_up_messages_on() {
    let errors = status::SENSOR_ERROR_X | status::SENSOR_ERROR_Y;
    for line in [0xFF, 0x00] {
        let mut rig = switched_on();
        rig.io().0.imu.unmount();
        rig.io().0.imu.set_fault(0, Fault::Silent(line));
        rig.run(1000);
        let sent = rig.sent();
        let frames: Vec<_> = sent.iter().map(|logged| logged.frame).collect();
        assert_eq!(frames, [boot_up(errors), boot_up(errors)], "{line:02X}h");
        let start = sent[0].start / 1_000_000;
        println!("{line:02X}h: the first frame starts {start} us after power-up");
        assert!(
            (90_000..=100_000).contains(&start),
            "{line:02X}h: {start} us"
        );
        assert_eq!(rig.poll()[1], errors, "{line:02X}h");
    }
}

/// The larger images need longer until their node starts.
#[test]
pub fn each_image_without_accelerometer_starts_within_100_ms() {
    for name in ["is2tk", "jn2101", "ims360", "tiltix080"] {
        let rate = BitRate::K125;
        let memory = if name == "is2tk" {
            fixed(name, rate)
        } else {
            blank()
        };
        let mut rig = Rig::with(name, BusRate::Fixed(rate), memory);
        rig.io().0.imu.unmount();
        rig.run(200);
        let sent = rig.sent();
        let start = sent.first().expect("a frame").start / 1_000_000;
        println!("the first frame of the {name} starts {start} us after power-up");
        assert!((90_000..=100_000).contains(&start), "{name}: {start} us");
    }
}

/// The first reading of a sensor built for the PC comes at the same time as that of a board.
#[test]
fn image_and_sensor_built_for_the_pc_send_their_first_frame_at_the_same_time() {
    let rate = BitRate::K125;
    let fixed_rate = [fsc::WRITE_BAUD_RATE, baud_rate_code(rate)];
    for name in ["is2", "jn2101", "ims360", "tiltix080"] {
        let memories = if name == "is2" {
            [fixed(name, rate), saved_on_pc(name, &[&fixed_rate])]
        } else {
            [blank(), Flash::default()]
        };
        let [image, model] = memories;
        let mut rig = Rig::with(name, BusRate::Fixed(rate), image);
        rig.run(100);
        let mut bus = Bus::new(BusRate::Fixed(rate));
        let motion = tilt(name, 10.0, 5.0);
        bus.attach(Device::new(&node_type(name), SERIAL, model, motion));
        let tester = bus.adapter();
        bus.open(tester, None, false);
        bus.run_until(rig.bus.now());
        let starts = [rig.sent(), bus.take_log()].map(|log| {
            let first = log.first().expect("a frame");
            first.start / 1_000_000
        });
        println!("the first frame of the {name} starts at {starts:?} us");
        assert!(starts[0].abs_diff(starts[1]) < 4_000, "{name}: {starts:?}");
    }
}

#[test]
fn violations_of_one_kind_are_reported_once() {
    let mut controller = microcontroller("is2", blank());
    // Reserved bits of CAN_MCR and CAN_IER (RM0008, section 24.9.2) that read as 0 on this silicon.
    for (offset, value) in [(0x00, 0x0002_0001), (0x00, 0x0002_0001), (0x14, 0x1000)] {
        let written = controller.io_mut().can.write(0, offset, value);
        written.expect("registers that are there");
    }
    assert_eq!(controller.violations().len(), 3);
    let reported = controller.take_new_violations();
    assert!(
        matches!(&reported[..], [mcr, ier] if mcr.contains("CAN_MCR") && ier.contains("CAN_IER"))
    );
    assert!(controller.take_new_violations().is_empty());
}

#[test]
fn reset_command_restarts_the_microcontroller() {
    let mut rig = switched_on();
    rig.boot_up();
    rig.expect_reset(ResetCause::Software);
    rig.send(&fsc::RESET);
    rig.boot_up();
    assert_eq!(rig.device().boots(), 2);
    rig.poll();
}

/// The heater must not stay on during a restart.
#[test]
pub fn reset_command_switches_the_heater_off() {
    let mut rig = Rig::booted("is2tk", BitRate::K50);
    rig.run(500);
    assert!(rig.microcontroller().heater() > 0);
    rig.expect_reset(ResetCause::Software);
    rig.send(&[fsc::INCLINATION]);
    rig.send(&fsc::RESET);
    let mut last = u16::MAX;
    while rig.device().boots() == 1 {
        last = rig.microcontroller().heater();
        // The restart comes within some microseconds if no reply waits.
        rig.run_us(1);
    }
    assert_eq!(last, 0, "off before the reset");
    assert_eq!(rig.microcontroller().heater(), 0, "off after the reset");
    rig.expect(REPLY, 10);
    rig.boot_up();
}

#[test]
fn poll_before_a_reset_command_is_answered_before_the_reset() {
    let mut rig = switched_on();
    rig.boot_up();
    rig.expect_reset(ResetCause::Software);
    rig.send(&[fsc::INCLINATION]);
    rig.send(&fsc::RESET);
    assert_eq!(rig.expect(REPLY, 10).bytes()[0], fsc::INCLINATION);
    rig.boot_up();
}

/// RAM keeps its contents in a reset and loses them without power. The firmware must start with any contents.
#[test]
pub fn ram_is_kept_in_a_reset_and_lost_without_power() {
    let mut rig = switched_on();
    rig.boot_up();
    let place = (rig.microcontroller().image().end_of_statics() + 67) & !3;
    let mark = 0x1234_5678_u32;
    assert!(
        rig.microcontroller_mut()
            .core_mut()
            .load(place, &mark.to_le_bytes())
    );
    rig.expect_reset(ResetCause::Software);
    rig.send(&fsc::RESET);
    rig.boot_up();
    assert_eq!(rig.microcontroller().core().word(place), Some(mark));
    rig.power_cycle();
    rig.boot_up();
    assert_ne!(rig.microcontroller().core().word(place), Some(mark));
    rig.poll();
}

/// Stops the main loop in an endless loop; interrupts are still served.
fn hang(rig: &mut Rig) {
    rig.wait_until(10, 100, Rig::runs_main_loop);
    // CPSIE I; B to itself.
    rig.execute(&[0xB662, 0xE7FE], [0; 2]);
}

#[test]
pub fn watchdog_restarts_a_main_loop_that_hangs() {
    // The firmware sets two seconds at the typical frequency of LSI.
    let [lowest, typical, highest] = chip().facts().lsi;
    for lsi in [lowest, highest] {
        let mut rig = switched_on();
        rig.io().0.iwdg.set_lsi(lsi);
        rig.boot_up();
        rig.run(30);
        hang(&mut rig);
        let from = rig.bus.now().ticks();
        rig.expect_reset(ResetCause::Watchdog);
        rig.wait_until(1000, 4_000, |rig| rig.microcontroller().resets().len() == 2);
        let took = rig.microcontroller().resets()[1].at / 1_000_000 - from;
        let nominal = 2_000_000 * u64::from(typical) / u64::from(lsi);
        // The last sample reloaded it, at most 5 ms before. It counts in steps of at most 2 ms.
        let step = 3_000;
        assert!(
            (nominal - 5_000 - step..nominal + step).contains(&took),
            "{took} us at {lsi} Hz"
        );
        rig.boot_up();
        rig.poll();
    }
}

/// The byte in which the firmware keeps bits 24 to 31 of RCC_CSR.
fn reset_causes(rig: &Rig) -> u8 {
    let microcontroller = rig.microcontroller();
    let place = microcontroller.image().address_of("RESET_CAUSES");
    let place = place.expect("a variable of this name");
    microcontroller.core().bytes(place, 1).expect("RAM")[0]
}

/// The reset causes (`plumbline::diagnosis`): each start has only its own. The STM32F103 has no flag for a low supply: it is a power-on.
#[test]
pub fn cause_of_the_last_reset_is_reported() {
    let told = |rig: &mut Rig| {
        let reply = rig.request(&[0x61, 1]);
        assert_eq!((reply[0], reply[2]), (0x61, 1), "{reply:02X?}");
        u32::from_le_bytes(reply[3..7].try_into().expect("four bytes"))
    };
    let low_supply = match chip() {
        Chip::F103 => 1,
        Chip::F446 => 0x10,
    };
    let mut rig = switched_on();
    rig.boot_up();
    assert_eq!(told(&mut rig), 1, "power-on");
    rig.expect_reset(ResetCause::Software);
    rig.send(&fsc::RESET);
    rig.boot_up();
    assert_eq!(told(&mut rig), 4, "software");
    hang(&mut rig);
    rig.expect_reset(ResetCause::Watchdog);
    rig.boot_up_within(3_500);
    assert_eq!(told(&mut rig), 8, "watchdog");
    rig.expect_reset(ResetCause::Pin);
    rig.microcontroller_mut().reset_by_pin();
    rig.boot_up();
    assert_eq!(told(&mut rig), 2, "reset pin");
    rig.expect_reset(ResetCause::BrownOut);
    rig.microcontroller_mut().reset_by_low_supply();
    rig.boot_up();
    assert_eq!(told(&mut rig), low_supply, "low supply");
    rig.power_cycle();
    rig.boot_up();
    assert_eq!(told(&mut rig), 1, "power-on");
}

/// A disturbance at NRST, in each part of a reading of the accelerometer, which goes on measuring, and of a reply.
#[test]
pub fn sensor_starts_after_a_reset_by_its_pin_at_any_time() {
    let mut rig = switched_on();
    rig.boot_up();
    for phase in 0..25 {
        rig.run(300);
        let before = rig.poll();
        rig.send(&[fsc::INCLINATION]);
        rig.run_us(phase * 211);
        rig.expect_reset(ResetCause::Pin);
        rig.microcontroller_mut().reset_by_pin();
        // The reply can be on the bus before.
        rig.run(30);
        rig.frames();
        rig.boot_up();
        rig.run(300);
        assert_eq!(rig.poll(), before, "after {phase} * 211 us");
    }
}

/// Each reset shows only its own cause (RM0008, RCC_CSR): PINRSTF is 4, PORRSTF 8, SFTRSTF 10h, IWDGRSTF 20h.
#[test]
pub fn cause_of_the_last_reset_is_kept() {
    // BORRSTF is 2, only on the STM32F446.
    let brown_out = match chip() {
        Chip::F103 => 0,
        Chip::F446 => 2,
    };
    let mut rig = switched_on();
    rig.boot_up();
    assert_eq!(reset_causes(&rig), 0x0C | brown_out);
    rig.expect_reset(ResetCause::Software);
    rig.send(&fsc::RESET);
    rig.boot_up();
    assert_eq!(reset_causes(&rig), 0x14);
    hang(&mut rig);
    rig.expect_reset(ResetCause::Watchdog);
    rig.boot_up_within(3_500);
    assert_eq!(reset_causes(&rig), 0x24);
    rig.power_cycle();
    rig.boot_up();
    assert_eq!(reset_causes(&rig), 0x0C | brown_out);
}

/// DBGMCU_CR stops the timer of the heater, and the watchdog.
#[test]
pub fn heater_is_off_while_a_debugger_halts_the_processor() {
    let mut rig = Rig::booted("is2tk", BitRate::K50);
    rig.run(500);
    assert!(rig.microcontroller().heater() > 0);
    rig.microcontroller_mut().probe_connect();
    rig.run(200);
    rig.microcontroller_mut().halt();
    assert_eq!(rig.microcontroller().heater(), 0);
    rig.run(10_000);
    assert_eq!(rig.device().boots(), 1);
    let (_, now) = rig.io();
    rig.microcontroller_mut().resume(now);
    rig.run(100);
    rig.poll();
    assert!(rig.microcontroller().heater() > 0);
}

#[test]
pub fn watchdog_does_not_reset_a_working_sensor() {
    let mut rig = Rig::with("is2", BusRate::Fixed(RATE), blank());
    let [_, _, highest] = chip().facts().lsi;
    rig.io().0.iwdg.set_lsi(highest);
    // The sensor detects the bit rate, then it answers and saves with page changes.
    rig.run(3_000);
    rig.bus.lead_detection();
    rig.run(100);
    rig.send(&[fsc::INCLINATION]);
    rig.boot_up();
    let changes = match chip() {
        Chip::F103 => 3,
        Chip::F446 => 1,
    };
    while rig.flash().erased() < changes {
        rig.save();
        rig.run(50);
    }
}

#[test]
pub fn module_leds_are_outputs_and_off() {
    let mut rig = switched_on();
    rig.boot_up();
    let (io, _) = rig.io();
    // README, "Wiring": green and red, on when high.
    let pins = &board().facts().pins;
    for pin in [pins.module_green, pins.module_red] {
        assert_eq!(io.gpio.output(pin), Some(false), "{pin:?}");
    }
}

#[test]
fn image_does_not_contain_the_catalogue() {
    // Names of articles and parameters are for a PC; the image has the numbers of its own article only.
    for name in ["is2", "jn2101"] {
        let image = image(name);
        for text in [
            "IS2MA090",
            "Set-Parameter-ID",
            "Quadrant correction",
            "jn2101",
        ] {
            let contains = |bytes: &[u8]| {
                bytes
                    .windows(text.len())
                    .any(|part| part == text.as_bytes())
            };
            let mut segments = image.segments().iter();
            assert!(
                !segments.any(|segment| contains(&segment.bytes)),
                "{name}: {text}"
            );
        }
    }
}
