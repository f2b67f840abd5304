//! The J1939 address of the tool (SAE J1939-81): claimed when it is needed, and kept while the adapter is open.
//!
//! The NAME says: arbitrary address capable, function not available, manufacturer of nobody. It loses to every sensor.

use plumbline::can::Frame;
use plumbline::j1939::claim::{Claim, Outcome, State};
use plumbline::j1939::identifier::{ADDRESS_CLAIMED, GLOBAL, Identifier, REQUEST};
use plumbline::j1939::name::Name;
use plumbline::j1939::request::requested;
use plumbline::time::{Duration, Instant, millis};
use std::sync::LazyLock;
use std::time::SystemTime;

/// The addresses that SAE J1939 reserves for service tools, and the range of addresses that a node can take by itself. The tool tries this
/// range from its end.
const TOOLS: [u8; 2] = [249, 250];
const FIRST: u8 = 128;
const LAST: u8 = 247;

/// The longest time until an address is claimed, with contentions.
pub(super) const LONGEST: Duration = millis(5000);

/// The pause between two checks of the claim.
pub(super) const STEP: Duration = millis(10);

/// The identity number. Two tools on a bus have different NAMEs; all sessions of a process have the same NAME, because they are one node.
static SEED: LazyLock<u32> = LazyLock::new(|| {
    let time = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    time.map_or(0, |time| time.subsec_nanos()) ^ std::process::id() << 12
});

/// The fields of the NAME before the identity number: arbitrary address capable, function 255 (not available), manufacturer 2047.
const NAME: [u32; 8] = [1, 0, 0, 0, 255, 0, 0, 2047];

/// The address of the tool.
#[derive(Clone, Debug)]
pub struct Own {
    claim: Claim,
}

impl Own {
    /// Begins to claim an address that is not used. The [claim](Self::claim) must be sent now.
    pub(super) fn new(now: Instant, used: &[u8]) -> Self {
        let free = TOOLS.into_iter().chain((FIRST..=LAST).rev());
        let preferred = free
            .into_iter()
            .find(|address| !used.contains(address))
            .unwrap_or(LAST);
        let seed = *SEED;
        let mut claim = Claim::OFF;
        claim.start(Name::new(NAME, seed), preferred, seed);
        for address in used {
            // The NAME of the other node does not matter at another address.
            claim.hear(now, *address, Name(0));
        }
        claim.sent(now);
        Self { claim }
    }

    pub(super) fn claim(&self) -> Frame {
        self.claim.frame()
    }

    /// The address, if it is claimed.
    pub(super) fn address(&self) -> Option<u8> {
        self.claim.address()
    }

    /// Whether the tool cannot claim an address.
    pub(super) fn has_lost(&self) -> bool {
        self.claim.state() == State::CannotClaim
    }

    /// The address, as soon as the time for contentions is over.
    pub(super) fn poll(&mut self, now: Instant) -> Option<u8> {
        self.claim.poll(now);
        self.claim.address()
    }

    /// Takes a received frame. Returns the frame that must be sent at once.
    pub fn hear(&mut self, now: Instant, frame: &Frame) -> Option<Frame> {
        let id = Identifier::of(frame)?;
        let must_answer = match (id.pgn, frame.bytes().try_into()) {
            (ADDRESS_CLAIMED, Ok(name)) => {
                let outcome = self.claim.hear(now, id.source, Name::from_bytes(name));
                outcome != Outcome::None && !self.has_lost()
            }
            (REQUEST, _) if requested(frame.bytes()) == Some(ADDRESS_CLAIMED) => {
                let is_own = [GLOBAL, self.claim.source()].contains(&id.destination);
                is_own && self.claim.requested(now) && !self.has_lost()
            }
            _ => false,
        };
        must_answer.then(|| {
            self.claim.sent(now);
            self.claim.frame()
        })
    }
}
