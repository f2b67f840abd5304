//! The node in two halves: the CAN interrupts answer frames, the main loop measures and changes the bit rate. No frame gets lost
//! between them.

use crate::rig::*;
use bench::{BusRate, Source};
use can_wire::frame_length::{INTERMISSION, frame_bits};
use plumbline::can::{BitRate, Frame};
use stm32_sim::rcc::ResetCause;

/// The identifier with the highest priority, for the frames that occupy the bus.
const STRONGEST: u16 = 0x000;

const SECOND: u64 = 1_000_000_000_000;

/// More requests than the mailboxes and the transmit queue (3 and 16 frames) can answer. The others wait in the receive queue, which
/// has 32 places.
const REQUESTS: usize = 40;

/// The tester occupies the bus: each request is sent between two frames with identifier 000h, and a reply has a lower priority than both.
#[test]
pub fn requests_on_an_occupied_bus_are_answered_in_order_without_a_pause() {
    for rate in [BitRate::K125, BitRate::K500, BitRate::M1] {
        burst("is2", rate);
    }
}

fn burst(name: &str, rate: BitRate) {
    let mut rig = Rig::booted(name, rate);
    rig.bus.give_way(false);
    let codes: Vec<u8> = (0x10..=0x19).cycle().take(REQUESTS).collect();
    let first = rig.log.len();
    for code in &codes {
        rig.bus.send(rig.tester, data(STRONGEST, &[0; 8]));
        rig.send(&[*code]);
    }
    rig.bus.send(rig.tester, data(STRONGEST, &[0; 8]));
    rig.wait_until(1_000, 1_000, |rig| rig.bus.queued(rig.tester) == 0);
    rig.run(100);

    let sent = &rig.log[first..];
    let own = Source::Device(rig.sensor);
    let (held, replies) = sent.split_at(2 * REQUESTS + 1);
    assert!(
        held.iter().all(|logged| logged.source != own),
        "{name}: the sensor sends while the bus is occupied"
    );
    let answered: Vec<u8> = replies
        .iter()
        .map(|logged| logged.frame.bytes()[0])
        .collect();
    assert_eq!(answered, codes, "{name} at {rate:?}");
    let bit = SECOND / u64::from(rate.bits_per_second());
    for pair in sent[2 * REQUESTS..].windows(2) {
        let bits = u64::from(frame_bits(&pair[0].frame) + INTERMISSION);
        let pause = (pair[1].start - pair[0].start).saturating_sub(bits * bit);
        assert!(
            pause < bit,
            "{name} at {rate:?}: a pause of {pause} ps before {:?}",
            pair[1].frame
        );
    }
    assert_eq!(rig.microcontroller().can().overruns(), 0);
    rig.frames();
}

/// The period of the measurement in microseconds, and the steps of the sweep.
const PERIOD: u64 = 5_000;
const STEP: usize = 100;

/// Waits until the time is at this phase of the period.
fn wait_for_phase(rig: &mut Rig, phase: u64) {
    let now = rig.bus.now().ticks() % PERIOD;
    rig.run_us((phase + PERIOD - now) % PERIOD);
}

/// Two bit rates in turn.
fn rates(one: BitRate, other: BitRate) -> impl Iterator<Item = BitRate> {
    [one, other].into_iter().cycle()
}

/// Objects 2001h (bit rate in kbit/s) and 2002h (reset) of the JN2101.
#[test]
fn change_of_the_bit_rate_loses_no_sdo_reply_and_no_boot_up_message() {
    let boot_up = data(0x70A, &[0]);
    let reply = |object: u8| data(0x58A, &[0x60, object, 0x20, 0, 0, 0, 0, 0]);
    let mut rig = Rig::with("jn2101", BusRate::Wire, blank());
    let tester = rig.tester;
    rig.bus.open(tester, Some(BitRate::K125), false);
    assert_eq!(rig.expect(0x70A, 1_000), boot_up);
    let phases = (0..PERIOD).step_by(STEP);
    for (phase, rate) in phases.zip(rates(BitRate::K500, BitRate::K125)) {
        wait_for_phase(&mut rig, phase);
        let [low, high] = ((rate.bits_per_second() / 1000) as u16).to_le_bytes();
        let requests = [
            [0x2B, 0x01, 0x20, 0, low, high, 0, 0],
            [0x2F, 0x02, 0x20, 0, 1, 0, 0, 0],
        ];
        for request in requests {
            rig.bus.send(tester, data(0x60A, &request));
        }
        assert_eq!(rig.expect(0x58A, 50), reply(1), "{phase} us");
        assert_eq!(rig.expect(0x58A, 50), reply(2), "{phase} us");
        rig.bus.open(tester, Some(rate), false);
        assert_eq!(rig.expect(0x70A, 200), boot_up, "{phase} us");
        assert_eq!(rig.device().rate(), Some(rate));
    }
    assert_eq!(rig.device().boots(), 1);
    assert_eq!(rig.bus.disturbed(Source::Adapter(tester)), 0);
}

/// The requests follow each other without a pause, so that RESET is received while SAVE programs.
#[test]
fn restart_with_another_bit_rate_loses_no_reply_and_no_boot_up_message() {
    const RATES: [BitRate; 2] = [BitRate::K500, BitRate::K250];
    let mut rig = Rig::with("is2", BusRate::Wire, fixed("is2", RATES[0]));
    let tester = rig.tester;
    rig.bus.open(tester, Some(RATES[0]), false);
    rig.boot_up();
    let phases = (0..PERIOD).step_by(STEP);
    for (phase, rate) in phases.zip(rates(RATES[1], RATES[0])) {
        wait_for_phase(&mut rig, phase);
        rig.expect_reset(ResetCause::Software);
        rig.send(&[fsc::WRITE_BAUD_RATE, baud_rate_code(rate)]);
        rig.send(&fsc::SAVE);
        rig.send(&fsc::RESET);
        for code in [fsc::WRITE_BAUD_RATE, fsc::SAVE[0]] {
            let answer: Frame = rig.expect(REPLY, 600);
            assert_eq!(answer.bytes()[0], code, "{phase} us");
            assert_eq!(answer.bytes()[1] & status::CMD_PARAM_ERROR, 0);
        }
        rig.wait_until(1, 10, |rig| rig.bus.queued(rig.tester) == 0);
        rig.bus.open(tester, Some(rate), false);
        rig.boot_up();
        assert_eq!(rig.device().rate(), Some(rate));
    }
    assert_eq!(rig.bus.disturbed(Source::Adapter(tester)), 0);
}
