//! A microcontroller with less memory than its name says, for example an STM32F103C6 that is sold as a C8: 10 KiB of RAM, 32 KiB of flash.

use crate::rig::*;
use bench::Flash;
use plumbline::can::BitRate;
use plumbline::node::Leds;
use stm32_sim::cortex_m::MemorySizes;
use stm32_sim::silicon::Silicon;

const RATE: BitRate = BitRate::K500;
const KIB: usize = 1024;

/// A sensor in a microcontroller with these memories.
fn rig(memories: MemorySizes) -> Rig {
    let silicon = Silicon {
        memories,
        ..silicon()
    };
    let rate: &[u8] = &[fsc::WRITE_BAUD_RATE, baud_rate_code(RATE)];
    let part = microcontroller("is2", saved("is2", &[rate])).with_silicon(&silicon);
    Rig::of(part, RATE)
}

fn sizes() -> MemorySizes {
    silicon().memories
}

/// Run LED and error LED are on, the node is off the bus, the stored parameters stay.
#[track_caller]
fn assert_refused(memories: MemorySizes) {
    let mut rig = rig(memories);
    let before: Vec<u8> = stored(rig.flash());
    rig.run(3_000);
    let expected = Leds {
        run: true,
        error: true,
        ..Leds::default()
    };
    assert_eq!(rig.device().leds(), expected, "{memories:?}");
    assert!(rig.frames().is_empty());
    assert!(!rig.device().is_dominant());
    assert_eq!(rig.device().boots(), 1);
    assert_eq!(stored(rig.flash()), before);
}

fn stored(flash: &Flash) -> Vec<u8> {
    flash.bytes().to_vec()
}

#[test]
pub fn too_small_ram_is_shown_by_run_and_error_led() {
    for ram in [6, 10, 12, 16, 19] {
        for ram_repeats in [false, true] {
            assert_refused(MemorySizes {
                ram: ram * KIB,
                ram_repeats,
                ..sizes()
            });
        }
    }
}

/// The image is larger than the flash of a part with 32 KiB, so a programmer refuses it. Here the parameters are missing.
#[test]
pub fn too_small_flash_is_shown_by_run_and_error_led() {
    assert_refused(MemorySizes {
        flash: sizes().flash / 2,
        ..sizes()
    });
}

#[test]
pub fn larger_memories_change_nothing() {
    let sizes = sizes();
    let mut rig = rig(MemorySizes {
        flash: 2 * sizes.flash,
        ram: sizes.ram + 10 * KIB,
        ..sizes
    });
    rig.boot_up();
}
