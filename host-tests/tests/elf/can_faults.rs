//! Faults and delays of the real CAN controller: the sensor comes back by itself or is silent, and is never dominant.

use crate::rig::*;
use bench::{BusRate, Flash, Source};
use plumbline::can::BitRate;
use plumbline::node::{BusMode, BusState};
use stm32_sim::bxcan::Silicon;

/// The bit rate of the bus. The search begins at another one.
const RATE: BitRate = BitRate::K500;

/// The longest time of the detection in ms, with a frame every 20 ms.
const DETECTION_LIMIT: u32 = 1_000;

/// A sensor that detects the bit rate, on this chip. The tester sends at [`RATE`].
fn detecting(silicon: Silicon) -> Rig {
    let mut rig = Rig::with("is2", BusRate::Wire, Flash::default());
    rig.io().0.can.set_silicon(silicon);
    let tester = rig.tester;
    rig.bus.open(tester, Some(RATE), false);
    // Acknowledges the frames of the tester.
    let other = rig.bus.adapter();
    rig.bus.open(other, Some(RATE), false);
    rig.run(200);
    rig
}

/// Sends a frame every 20 ms until the sensor takes part. Until then it is recessive.
#[track_caller]
fn detect(rig: &mut Rig) {
    let disturbed = rig.bus.disturbed(Source::Adapter(rig.tester));
    for ms in 0.. {
        assert!(ms < DETECTION_LIMIT, "the bit rate is not detected");
        if rig.device().mode() == Some(BusMode::Normal) {
            break;
        }
        assert!(!rig.device().is_dominant(), "it is silent");
        if ms % 20 == 0 {
            rig.bus.send(rig.tester, data(0x1A5, &[ms as u8]));
        }
        rig.run(1);
    }
    rig.boot_up();
    assert_eq!(rig.bus.disturbed(Source::Adapter(rig.tester)), disturbed);
}

/// It answers each of a few polls once, and has disturbed nothing. The error LED was off since the start.
#[track_caller]
fn assert_works(rig: &mut Rig) {
    let disturbed = rig.bus.disturbed(Source::Adapter(rig.tester));
    for _ in 0..3 {
        rig.poll();
        rig.run(10);
    }
    assert!(rig.frames().is_empty(), "one answer for each poll");
    assert_eq!(rig.bus.disturbed(Source::Adapter(rig.tester)), disturbed);
    assert_eq!(rig.device().bus_state(), Some(BusState::Active));
    let lit = rig
        .device()
        .led_history()
        .iter()
        .any(|(_, leds)| leds.error);
    assert!(!lit, "the error LED");
}

#[test]
fn frame_is_received_once_when_release_of_mailbox_takes_time() {
    for release in [0, 1, 2, 3, 5, 10, 100] {
        println!("{release} cycles");
        let mut rig = detecting(Silicon {
            release,
            ..Silicon::default()
        });
        detect(&mut rig);
        assert_works(&mut rig);
        // Three frames back to back.
        for _ in 0..3 {
            rig.send(&[fsc::INCLINATION]);
        }
        rig.run(20);
        assert_eq!(rig.frames().len(), 3);
    }
}
