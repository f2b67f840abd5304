//! How a scan recognises J1939 nodes. All messages have 29 bits and 8 bytes.
//!
//! | frames | node |
//! |---|---|
//! | PGN EE00h | address claim, which tells the maker |
//! | PGN FECAh, priority 6 | diagnostic message 1 |
//! | PGN F013h, F029h, F02Ah or F02Dh, twice | process data of an inclination sensor |

use super::Ca;
use crate::master::Target;
use crate::scan::signs::{Bus, Judge, Sign, Signs};
use plumbline::can::Frame;
use plumbline::j1939::groups;
use plumbline::j1939::identifier::{
    ACTIVE_CODES, ADDRESS_CLAIMED, Identifier, NO_ADDRESS, PRIORITY,
};

pub(super) const SIGNS: Signs = Signs {
    node,
    is_own: true,
    judge,
    process_data: |_| Vec::new(),
    twins: None,
};

fn node(frame: &Frame) -> Option<Sign> {
    let &[_, _, n2, n3, _, _, _, _] = frame.bytes() else {
        return None;
    };
    let id = Identifier::of(frame).filter(|id| id.source < NO_ADDRESS)?;
    let maker = match id.pgn {
        ADDRESS_CLAIMED => Some(u16::from(n3) << 3 | u16::from(n2 >> 5)),
        pgn if pgn == ACTIVE_CODES || groups::place(pgn).is_some() => None,
        _ => return None,
    };
    Some(Sign {
        text: maker.map(|maker| format!("manufacturer {maker}")),
        ..Target::J1939(Ca(id.source)).into()
    })
}

fn judge<'a>(bus: &'a Bus) -> Judge<'a> {
    let claims = bus.seen.iter().map(|seen| &seen.sign);
    let claims = claims.filter(|sign| sign.text.is_some());
    let claims: Vec<Target> = claims.map(|sign| sign.target).collect();
    Box::new(move |seen| match (&seen.sign, seen.times.len()) {
        (Sign { text: Some(_), .. }, _) => Some(true),
        // The claim tells more than the process data of the same node.
        (Sign { target, .. }, _) if claims.contains(target) => None,
        (Sign { target, .. }, count) => Some(count >= 2 || is_diagnosed(*target, bus)),
    })
}

/// Whether a node has sent its diagnostic message, which comes once a second.
fn is_diagnosed(node: Target, bus: &Bus) -> bool {
    let mut ids = bus.frames.iter();
    ids.any(|(_, frame)| {
        Identifier::of(frame).is_some_and(|id| {
            let is_message = id.pgn == ACTIVE_CODES && id.priority == PRIORITY;
            is_message && Target::J1939(Ca(id.source)) == node
        })
    })
}
