//! Tests of the address claim.

use super::*;

const LOWER: Name = Name(5);
const OURS: Name = Name(1 << 63 | 100);
const HIGHER: Name = Name(1 << 63 | 200);
/// A NAME that is not arbitrary address capable.
const FIXED: Name = Name(100);

fn at(ms: u64) -> Instant {
    Instant::from_ticks(ms * 1000)
}

/// A node with this address.
fn claimed(name: Name, address: u8) -> Claim {
    let mut claim = Claim::OFF;
    claim.start(name, address, 1);
    claim.sent(at(0));
    assert!(claim.poll(at(250)));
    assert_eq!(claim.address(), Some(address));
    claim
}

#[test]
fn address_is_claimed_250_ms_after_the_claim_is_sent() {
    let mut claim = Claim::OFF;
    claim.start(OURS, 0x80, 1);
    assert!(claim.is_queued());
    assert!(!claim.poll(at(1000)), "the claim waits for the bus");
    claim.sent(at(1000));
    claim.sent(at(1100));
    assert!(!claim.poll(at(1249)));
    assert_eq!(claim.address(), None);
    assert!(claim.poll(at(1250)));
    assert_eq!(claim.address(), Some(0x80));
    assert_eq!(claim.deadline(), Deadline::NEVER);
}

#[test]
fn claim_has_the_name_in_a_frame_to_all() {
    let mut claim = Claim::OFF;
    claim.start(Name(0x8000_9100_FFE0_0001), 0x80, 1);
    let text = std::format!("{:?}", claim.frame());
    assert_eq!(text, "18EEFF80#0100E0FF00910080");
}

#[test]
fn address_is_kept_against_a_higher_name() {
    let mut claim = claimed(OURS, 0x80);
    assert_eq!(claim.hear(at(300), 0x80, HIGHER), Outcome::Defended);
    assert_eq!(claim.address(), Some(0x80));
    // A claim that waits for the bus is the answer.
    claim.take(0x90);
    assert_eq!(claim.hear(at(400), 0x90, HIGHER), Outcome::None);
    // While claiming, the silence begins again.
    claim.sent(at(400));
    assert_eq!(claim.hear(at(500), 0x90, HIGHER), Outcome::Defended);
    assert!(!claim.poll(at(700)));
    claim.sent(at(700));
    assert!(!claim.poll(at(949)) && claim.poll(at(950)));
}

#[test]
fn failed_claim_is_sent_again_after_a_random_delay_and_begins_the_silence() {
    let mut delays = std::vec::Vec::new();
    for seed in 1..=50 {
        let mut claim = Claim::OFF;
        claim.start(OURS, 0x80, seed);
        claim.failed(at(1000));
        assert!(!claim.is_queued());
        // The mailboxes are empty, but the claim was not sent.
        claim.sent(at(1000));
        let due = claim.deadline().time().unwrap();
        let delay = (due.ticks() - at(1000).ticks()) / 1000;
        assert!(delay <= 153);
        delays.push(delay);
        assert!(claim.poll(due) && claim.is_queued());
        assert_eq!((claim.state(), claim.source()), (State::Claiming, 0x80));
        claim.sent(at(2000));
        assert!(!claim.poll(at(2249)) && claim.poll(at(2250)));
        assert_eq!(claim.address(), Some(0x80));
    }
    delays.sort_unstable();
    delays.dedup();
    assert!(delays.len() > 30, "{delays:?}");
}

#[test]
fn claim_heard_in_the_delay_of_a_failed_one_decides() {
    let failed = || {
        let mut claim = Claim::OFF;
        claim.start(OURS, 0x80, 1);
        claim.failed(at(0));
        claim
    };
    let mut claim = failed();
    assert_eq!(claim.hear(at(0), 0x80, HIGHER), Outcome::Defended);
    assert!(claim.is_queued() && !claim.deadline().is_set());
    claim.sent(at(1));
    assert!(claim.poll(at(251)));
    assert_eq!(claim.address(), Some(0x80));
    let mut claim = failed();
    assert_eq!(claim.hear(at(0), 0x80, LOWER), Outcome::Left);
    assert_eq!((claim.state(), claim.source()), (State::Claiming, 0x81));
    assert!(claim.is_queued() && !claim.deadline().is_set());
    // A failure without a claim on its way changes nothing.
    let mut claim = claimed(OURS, 0x80);
    claim.failed(at(300));
    assert_eq!(claim.address(), Some(0x80));
    assert!(!claim.deadline().is_set());
}

#[test]
fn lower_name_takes_the_address() {
    let mut claim = claimed(OURS, 0x80);
    assert_eq!(claim.hear(at(300), 0x80, LOWER), Outcome::Left);
    assert_eq!((claim.state(), claim.source()), (State::Claiming, 0x81));
    assert!(claim.is_queued());
}

#[test]
fn next_address_skips_addresses_claimed_by_others() {
    let mut claim = claimed(OURS, 246);
    for source in [247, 128, 129, 0, 127, 254, 253] {
        assert_eq!(claim.hear(at(300), source, LOWER), Outcome::None);
    }
    assert_eq!(claim.hear(at(300), 246, LOWER), Outcome::Left);
    assert_eq!(claim.source(), 130);
    let mut claim = claimed(OURS, 10);
    claim.hear(at(300), 10, LOWER);
    assert_eq!(claim.source(), 128, "from an address outside the range");
}

#[test]
fn node_without_a_free_address_cannot_claim() {
    let mut claim = claimed(OURS, 200);
    for source in 128..=247 {
        if source != 200 {
            claim.hear(at(300), source, LOWER);
        }
    }
    assert_eq!(claim.hear(at(300), 200, LOWER), Outcome::Left);
    assert_eq!((claim.state(), claim.source()), (State::CannotClaim, 254));
}

#[test]
fn fixed_address_is_lost_with_a_random_delay() {
    let mut delays = std::collections::BTreeSet::new();
    for seed in 0..200 {
        let mut claim = Claim::OFF;
        claim.start(FIXED, 0x80, seed);
        assert_eq!(claim.hear(at(0), 0x80, LOWER), Outcome::Left);
        assert_eq!(claim.state(), State::CannotClaim);
        let due = claim.deadline().time().unwrap();
        assert!(due <= at(153));
        delays.insert(due);
        assert!(claim.poll(due));
        claim.sent(due);
        assert!(!claim.deadline().is_set());
        // A request is answered with a delay, too. Another one in this time does not extend it.
        assert!(!claim.requested(at(500)));
        let due = claim.deadline();
        assert!(!claim.requested(at(500)));
        assert!(due.is_set() && claim.deadline() == due);
    }
    assert!(delays.len() > 80, "{}", delays.len());
}

#[test]
fn request_is_answered_at_once_with_an_address() {
    let mut claim = claimed(OURS, 0x80);
    assert!(claim.requested(at(300)));
    claim.take(0x81);
    assert!(!claim.requested(at(300)), "the claim waits for the bus");
    claim.sent(at(300));
    assert!(claim.requested(at(300)));
    let mut off = Claim::OFF;
    assert!(!off.requested(at(300)));
}

#[test]
fn own_name_at_the_own_address_is_ignored() {
    let mut claim = claimed(OURS, 0x80);
    assert_eq!(claim.hear(at(300), 0x80, OURS), Outcome::None);
    assert_eq!(claim.address(), Some(0x80));
}

#[test]
fn same_address_is_claimed_again_after_bus_off() {
    let mut claim = claimed(OURS, 0x80);
    claim.suspend();
    assert!(claim.resume(at(9999)));
    assert_eq!((claim.state(), claim.source()), (State::Claiming, 0x80));
    claim.sent(at(400));
    claim.suspend();
    assert!(!claim.poll(at(9999)), "bus-off while claiming");
    assert!(claim.resume(at(9999)));
    let mut lost = claimed(FIXED, 0x80);
    lost.hear(at(300), 0x80, LOWER);
    // If the message was not sent before, it is sent now.
    for sent in [false, false, true] {
        lost.suspend();
        assert!(!lost.deadline().is_set());
        assert!(!lost.resume(at(400)));
        let due = lost.deadline().time().unwrap();
        assert!(due >= at(400) && due <= at(553) && lost.poll(due));
        assert!(lost.is_queued());
        if sent {
            lost.sent(due);
        }
    }
    lost.suspend();
    assert!(!lost.resume(at(400)));
    assert!(!lost.is_queued() && !lost.deadline().is_set());
}
