//! Faults of the sensing element of the flashed IMS360, and a save that stalls the processor.

use crate::fusion::Rotation;
use crate::rig::ims360::EMCY;
use crate::rig::*;
use plumbline::can::Frame;
use stm32_sim::flash::Times;
use stm32_sim::ism330dhcx::{Fault, Noise};

/// The emergency messages (table 8): code, error register, no further bytes.
fn emergency(code: u16, register: u8) -> Frame {
    let [low, high] = code.to_le_bytes();
    data(EMCY, &[low, high, register, 0, 0, 0, 0, 0])
}

/// Axis X and Y defective.
const DEFECTIVE: [u16; 2] = [0xFF01, 0xFF02];

/// FF01h and FF02h within 200 ms, and the angles stay (core/src/model/ims360/README.md, S71). The accelerometer alone does not replace the
/// measurement of either filter.
#[test]
fn gyroscope_that_stops_is_a_defect_of_both_axes_until_it_works_again() {
    for fusion in [0, 1] {
        let mut rig = Rig::ims360(tilt("ims360", 10.0, 5.0));
        rig.download(0x3110, 2, [fusion]);
        rig.run(3_000);
        assert_eq!(rig.frames(), []);
        let (io, now) = rig.io();
        io.imu.set_fault(now, Fault::WithoutRate);
        rig.run(200);
        let expected = DEFECTIVE.map(|code| emergency(code, 0x81));
        assert_eq!(rig.frames(), expected, "filter {fusion}");
        rig.set_motion(tilt("ims360", 20.0, -20.0));
        rig.run(3_000);
        assert_eq!(rig.frames(), [], "once");
        assert_eq!(rig.upload(0x3000, 1) & 0b10, 0b10, "ST0 bit 1");
        assert_eq!(rig.upload(0x1001, 0), 0x81);
        let angles = [0x6110, 0x6120].map(|index| rig.upload(index, 0) as i32);
        assert!(angles[0].abs_diff(1000) <= 2, "{angles:?}");
        assert!(angles[1].abs_diff(500) <= 2, "{angles:?}");

        let (io, now) = rig.io();
        io.imu.set_fault(now, Fault::None);
        // The Kalman filter goes on with the direction before the gap.
        rig.run(if fusion == 1 { 15_000 } else { 4_000 });
        let expected = [emergency(0, 0x81), emergency(0, 0)];
        assert_eq!(rig.frames(), expected, "filter {fusion}");
        assert_eq!(rig.upload(0x3000, 1) & 0b10, 0);
        let angles = [0x6110, 0x6120].map(|index| rig.upload(index, 0) as i32);
        let limit = if fusion == 1 { 5 } else { 2 };
        assert!(angles[0].abs_diff(2000) <= limit, "{angles:?}");
        assert!(angles[1].abs_diff(-2000) <= limit, "{angles:?}");
    }
}

/// The values do not change, but the FIFO has new ones. Reported after 32 values (38 ms) and the time without readings (200 ms).
#[test]
fn stuck_angular_rate_is_a_defect_until_it_changes_again() {
    for (fusion, fault) in [
        (0, Fault::StuckRate(0, 0)),
        (1, Fault::StuckRate(2, -700)),
        (1, Fault::ZeroRates),
    ] {
        let mut rig = Rig::ims360(tilt("ims360", 10.0, 5.0));
        rig.download(0x3110, 2, [fusion]);
        rig.run(3_000);
        assert_eq!(rig.frames(), []);
        let (io, now) = rig.io();
        io.imu.set_fault(now, fault);
        rig.run(300);
        let expected = DEFECTIVE.map(|code| emergency(code, 0x81));
        assert_eq!(rig.frames(), expected, "{fusion} {fault:?}");
        let (io, now) = rig.io();
        io.imu.set_fault(now, Fault::None);
        rig.run(2_000);
        let expected = [emergency(0, 0x81), emergency(0, 0)];
        assert_eq!(rig.frames(), expected, "{fusion} {fault:?}");
    }
}

/// Each bit of a rate about the axis of an angle. The FIFO has each value once, without a checksum.
#[test]
fn wrong_bit_of_an_angular_rate_does_not_turn_the_angle() {
    let mut rig = Rig::ims360(tilt("ims360", 10.0, 5.0));
    rig.download(0x3110, 2, [1]);
    rig.io().0.imu.set_noise(Noise::Real);
    rig.run(4_000);
    for (axis, bit) in (0..2).flat_map(|axis| (0..16).map(move |bit| (axis, bit))) {
        let (io, now) = rig.io();
        io.imu.invert_rate(now, axis, bit);
        for _ in 0..15 {
            rig.run(4);
            let angles = [0x6110, 0x6120].map(|index| rig.upload(index, 0) as i32);
            // With the noise.
            let is_right = angles[0].abs_diff(1000) <= 5 && angles[1].abs_diff(500) <= 5;
            assert!(is_right, "axis {axis}, bit {bit}: {angles:?}");
        }
    }
    assert_eq!(rig.frames(), []);
}

/// A bit error costs values of both sensors, a reset of the part 70 ms. Neither is a defect, and the angle stays.
#[test]
fn momentary_disturbance_of_the_accelerometer_is_no_defect() {
    for fusion in [0, 1] {
        let mut rig = Rig::ims360(tilt("ims360", 10.0, 5.0));
        rig.download(0x3110, 2, [fusion]);
        rig.run(4_000);
        assert_eq!(rig.frames(), []);
        for disturbance in 0..3 {
            let (io, now) = rig.io();
            match disturbance {
                0 => io.imu.spoil(0x78, 1, 1),
                1 => io.imu.lose_words(now, 3),
                _ => io.imu.power_on(now),
            }
            for _ in 0..40 {
                rig.run(40);
                assert_eq!(rig.frames(), [], "filter {fusion}, {disturbance}");
                let angles = [0x6110, 0x6120].map(|index| rig.upload(index, 0) as i32);
                assert!(angles[0].abs_diff(1000) <= 2, "{angles:?}");
                assert!(angles[1].abs_diff(500) <= 2, "{angles:?}");
            }
        }
    }
}

/// Saves until a save has erased a page. Returns the number of saves.
fn save_until_erased(rig: &mut Rig) -> usize {
    let before = rig.flash().erased();
    let mut saves = 0;
    while rig.flash().erased() == before {
        rig.download_within(1_000, 0x1010, 1, *b"save");
        saves += 1;
    }
    saves
}

/// The time in s at which the save of the test begins.
const SAVED: f64 = 4.0;

/// An erase takes up to 0.5 s on the Nucleo, and the FIFO of the accelerometer has values for 0.28 s: the rotation is lost
/// (core/src/model/ims360/README.md, "Saves"). On the Blue Pill nothing is lost.
#[test]
pub fn angle_is_right_after_a_rotation_in_a_save_that_erases() {
    let motion = Rotation {
        angle: |time| 10.0 + 30.0 * ((time - SAVED - 0.01) / 0.15).clamp(0.0, 1.0),
        vibration: |_| 0.0,
        offset: 0.0,
    };
    let mut rig = Rig::ims360(Box::new(motion));
    rig.io().0.flash.set_times(Times::longest(chip()));
    rig.download(0x3110, 2, [1]);
    save_until_erased(&mut rig);
    let places = save_until_erased(&mut rig);
    for _ in 1..places {
        rig.download_within(1_000, 0x1010, 1, *b"save");
    }
    rig.run((SAVED * 1000.0) as u64 - rig.bus.now().ticks() / 1000);
    let erased = rig.flash().erased();
    rig.download_within(1_000, 0x1010, 1, *b"save");
    assert_eq!(rig.flash().erased(), erased + 1, "this save erases a page");
    // On the Nucleo, the Kalman filter corrects the lost rotation within 4 s to 0.2 deg.
    rig.run(4_250);
    for _ in 0..4 {
        let angle = rig.upload(0x6110, 0);
        assert!(angle.abs_diff(4000) <= 20, "{angle}");
        rig.run(500);
    }
    assert_eq!(rig.frames(), [], "no emergency message");
}
