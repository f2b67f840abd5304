//! What the abort codes mean, and what a user can do then.

use crate::error::{Next, Reason};
use plumbline::canopen::Abort;

/// The meanings of the abort codes of the core.
const REASONS: [(Abort, Reason); 23] = [
    (Abort::Toggle, Reason::Toggle),
    (Abort::TimeOut, Reason::TimeOut),
    (Abort::Command, Reason::Command),
    (Abort::BlockSize, Reason::BlockSize),
    (Abort::SequenceNumber, Reason::SequenceNumber),
    (Abort::Crc, Reason::Crc),
    (Abort::Access, Reason::Access),
    (Abort::WriteOnly, Reason::WriteOnly),
    (Abort::ReadOnly, Reason::ReadOnly),
    (Abort::NoObject, Reason::NoObject),
    (Abort::NotMappable, Reason::NotMappable),
    (Abort::TooManyMapped, Reason::TooManyMapped),
    (Abort::Hardware, Reason::Hardware),
    (Abort::Length, Reason::Length),
    (Abort::TooLong, Reason::TooLong),
    (Abort::TooShort, Reason::TooShort),
    (Abort::NoSubIndex, Reason::NoSubIndex),
    (Abort::Value, Reason::Value),
    (Abort::TooHigh, Reason::TooHigh),
    (Abort::TooLow, Reason::TooLow),
    (Abort::Signature, Reason::Signature),
    (Abort::DeviceState, Reason::State),
    (Abort::NoData, Reason::NoData),
];

/// The meaning of an abort code (CiA 301, table 22).
pub(crate) fn reason(code: u32) -> Reason {
    let own = REASONS.iter().find(|(abort, _)| *abort as u32 == code);
    match (own, code) {
        (Some((_, own)), _) => own.clone(),
        (None, 0x0504_0005) => Reason::Memory,
        (None, 0x0604_0043) => Reason::Together,
        (None, _) => Reason::General,
    }
}

/// What to do after an abort with this code.
pub(super) fn next_step(code: u32) -> Next {
    let is = |abort: Abort| abort as u32 == code;
    match code {
        _ if is(Abort::DeviceState) => Next::State,
        _ if is(Abort::Hardware) || is(Abort::Signature) => Next::Failed,
        // General errors, protocol errors.
        0x0500_0000..=0x05FF_FFFF | 0x0800_0000 => Next::Repeat,
        _ => Next::List,
    }
}
