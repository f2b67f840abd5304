//! Faults of the program: the handlers of the image make CAN_TX recessive, switch the heater off and reset.

use crate::rig::*;
use plumbline::can::BitRate;
use stm32_sim::rcc::ResetCause;

const RATE: BitRate = BitRate::K500;

/// The maximum number of requests until the main loop runs while the sensor drives a dominant bit. On the Nucleo the processor sleeps
/// during most replies.
const REQUESTS: usize = 100;

/// The time from request to request in microseconds, longer than a reply. The period of the measurement, 5 ms, is no multiple of
/// it, so that the requests come at different phases of the measurement.
const PERIOD: u64 = 611;

/// Runs until the heater is on, and the sensor drives a dominant bit while its main loop runs.
fn busy(rig: &mut Rig) {
    rig.run(500);
    assert!(rig.microcontroller().heater() > 0);
    for _ in 0..REQUESTS {
        rig.send(&[fsc::INCLINATION]);
        for _ in 0..PERIOD {
            rig.run_us(1);
            if rig.device().is_dominant() && rig.runs_main_loop() {
                return;
            }
        }
    }
    panic!("the main loop never runs within a dominant bit");
}

/// After a fault of this code the bus is recessive, the heater is off and the sensor starts again, all within 20 us.
fn restarts(code: &[u16], registers: [u32; 2]) {
    let mut rig = Rig::booted("is2tk", RATE);
    busy(&mut rig);
    rig.execute(code, registers);
    rig.expect_reset(ResetCause::Software);
    rig.run_us(20);
    assert_eq!(rig.device().boots(), 2, "a reset within 20 us");
    rig.assert_safe_at_reset();
    assert!(!rig.device().is_dominant());
    assert_eq!(rig.microcontroller().heater(), 0);
    rig.frames();
    rig.boot_up();
    rig.poll();
}

#[test]
pub fn undefined_instruction_restarts_the_sensor() {
    restarts(&[0xDE00], [0; 2]);
}

#[test]
fn access_to_an_unmapped_address_restarts_the_sensor() {
    // LDR R0, [R1]
    restarts(&[0x6808], [0, 0x6000_0000]);
}

/// EXTI0, which the firmware does not use: enabled and pending.
#[test]
pub fn unexpected_interrupt_restarts_the_sensor() {
    // CPSIE i, because the code can begin while the firmware masks interrupts; STR R0, [R1]; ADDS R1, #80h; ADDS R1, #80h;
    // STR R0, [R1]; B .
    let code = [0xB662, 0x6008, 0x3180, 0x3180, 0x6008, 0xE7FE];
    restarts(&code, [1 << 6, 0xE000_E100]);
}

/// The linker removes the handler if no code panics.
#[test]
pub fn no_image_has_a_panic_path() {
    for name in images() {
        assert_eq!(image(name).address_of("rust_begin_unwind"), None, "{name}");
    }
}

#[test]
pub fn stack_overflow_restarts_the_sensor_without_overwriting_static_variables() {
    for name in ["is2", "jn2101"] {
        let flash = if name == "is2" {
            fixed(name, RATE)
        } else {
            blank()
        };
        let mut rig = Rig::with(name, bench::BusRate::Fixed(RATE), flash);
        rig.run(500);
        let statics = |rig: &Rig| {
            let microcontroller = rig.microcontroller();
            let image = microcontroller.image();
            let range = image.statics();
            let length = (range.end - range.start) as usize;
            let bytes = microcontroller.core().bytes(range.start, length);
            bytes.expect("RAM").to_vec()
        };
        // PUSH {R0-R7, LR}, and a branch back to it.
        rig.wait_until(1, 100, Rig::runs_main_loop);
        rig.execute(&[0xB5FF, 0xE7FD], [0xDEAD_BEEF; 2]);
        rig.expect_reset(ResetCause::Software);
        let mut last = statics(&rig);
        while rig.device().boots() == 1 {
            last = statics(&rig);
            rig.run_us(1);
        }
        let marked = last
            .windows(4)
            .filter(|it| **it == 0xDEAD_BEEF_u32.to_le_bytes());
        assert_eq!(marked.count(), 0, "{name}: overwritten static variables");
        assert_eq!(
            rig.microcontroller().faults().len(),
            1,
            "{:?}",
            rig.microcontroller().faults()
        );
        rig.assert_safe_at_reset();
        rig.run(1000);
        assert_eq!(rig.device().boots(), 2);
        rig.ignore_stack();
    }
}

/// Arm erratum 602117 in an image. The loop masks the interrupts except before its load. The first word of the data is an address in RAM, at
/// which the load starts again.
#[test]
fn load_over_its_base_goes_wrong_under_an_interrupt() {
    // LDRD R0, R1, [R0] and CMP R0, R5; LDRD R2, R3, [R0] and CMP R2, R5.
    for ([registers, compare], goes_wrong) in [([0x0100, 0x42A8], true), ([0x2300, 0x42AA], false)]
    {
        #[rustfmt::skip]
        let code = [
            0xA404,            // ADR R4, data
            0x6825,            // LDR R5, [R4]
            0x4620,            // again: MOV R0, R4
            0xB662,            // CPSIE i
            0xE9D0, registers, // LDRD
            0xB672,            // CPSID i
            compare,           // CMP
            0xD0F8,            // BEQ again
            0xE7FE,            // wrong: B wrong
            0x0000, 0x2000,    // data
            0x0000, 0x0000,
        ];
        let mut rig = Rig::booted("is2tk", RATE);
        rig.wait_until(1, 100, Rig::runs_main_loop);
        rig.execute(&code, [0; 2]);
        let start = rig.microcontroller().core().pc();
        // SysTick interrupts it each millisecond.
        rig.run(50);
        rig.wait_until(1, 100, Rig::runs_main_loop);
        let place = rig.microcontroller().core().pc() - start;
        let has_erratum = silicon().restarts_loads;
        assert_eq!(place == 18, goes_wrong && has_erratum, "at {place}");
        assert_eq!(rig.device().boots(), 1);
    }
}
