//! What the abort codes mean, and what a user can do then.

use crate::master::refusal;
use plumbline::canopen::Abort;

/// The meanings of the abort codes of the core.
const REASONS: [(Abort, &str); 23] = [
    (Abort::Toggle, "toggle bit not alternated"),
    (Abort::TimeOut, "time-out of the protocol"),
    (Abort::Command, "unknown command"),
    (Abort::BlockSize, "the block size is not permitted"),
    (
        Abort::SequenceNumber,
        "the sequence number is not permitted",
    ),
    (Abort::Crc, "the CRC is wrong"),
    (Abort::Access, "unsupported access"),
    (Abort::WriteOnly, "the object can only be written"),
    (Abort::ReadOnly, "the object can only be read"),
    (Abort::NoObject, "there is no such object"),
    (Abort::NotMappable, "the object cannot be mapped"),
    (Abort::TooManyMapped, "the mapping is too long for a PDO"),
    (Abort::Hardware, "a hardware error"),
    (Abort::Length, "the length does not match the type"),
    (Abort::TooLong, "the value is too long"),
    (Abort::TooShort, "the value is too short"),
    (Abort::NoSubIndex, "there is no such sub-index"),
    (Abort::Value, "the value is not permitted"),
    (Abort::TooHigh, "the value is too high"),
    (Abort::TooLow, "the value is too low"),
    (Abort::Signature, "the value cannot be stored"),
    (Abort::DeviceState, "not in the present state of the device"),
    (Abort::NoData, "there is no data"),
];

/// The meaning of an abort code (CiA 301, table 22).
pub(crate) fn reason(code: u32) -> &'static str {
    let own = REASONS.iter().find(|(abort, _)| *abort as u32 == code);
    match (own, code) {
        (Some((_, text)), _) => text,
        (None, 0x0504_0005) => "out of memory",
        (None, 0x0604_0043) => "parameters do not fit each other",
        (None, _) => "general error",
    }
}

/// What to do after an abort with this code.
pub(super) fn next_step(code: u32) -> &'static str {
    let is = |abort: Abort| abort as u32 == code;
    match code {
        _ if is(Abort::DeviceState) => refusal::WRONG_STATE,
        _ if is(Abort::Hardware) || is(Abort::Signature) => refusal::FAILED,
        // General errors, protocol errors.
        0x0500_0000..=0x05FF_FFFF | 0x0800_0000 => refusal::REPEAT,
        _ => refusal::LIST,
    }
}
