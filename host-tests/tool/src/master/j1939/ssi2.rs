//! The angles in the J1939 group SSI2.

use crate::error::{Error, Silence};
use crate::link::Link;
use crate::master::j1939::groups as j1939;
use crate::number::Scale;
use crate::sample::{Poller, Read};
use crate::session::Session;
use crate::sheet::Entry;
use plumbline::can::Frame;
use plumbline::j1939::groups;
use plumbline::j1939::signal::{Contents, Source};
use plumbline::time::{Duration, millis};

/// The number of angles: pitch and roll.
pub const COUNT: usize = 2;

/// The scale of the angles.
pub const FINE: Scale = Scale {
    multiplier: 1,
    decimals: 4,
    unit: "deg",
};

/// The angles in the unit of [`FINE`], each None if it is not available.
pub type Angles = [Option<i64>; COUNT];

/// How long a broadcast is waited for before it is requested.
const BROADCAST: Duration = millis(50);

/// Polls the angles.
pub(super) struct Polled {
    address: u8,
    /// Nobody broadcasts the angles, so they are requested.
    requests: bool,
}

impl Polled {
    pub(super) fn new(address: u8) -> Self {
        Self {
            address,
            requests: false,
        }
    }

    fn read(&mut self, link: &mut Link) -> Result<Option<Angles>, Error> {
        if !self.requests {
            if let Some(angles) = broadcast(link, self.address, BROADCAST)? {
                return Ok(Some(angles));
            }
            self.requests = true;
        }
        request(link, self.address)
    }
}

impl Poller for Polled {
    fn begin(
        &mut self,
        session: &mut Session,
        angles: Vec<(Entry, Scale)>,
    ) -> Result<Vec<(Entry, Scale)>, Error> {
        let first = self.read(&mut session.link)?;
        // A sensor with one axis has one angle. A sensor that measures nothing now does not tell the number of its axes.
        let first = first.filter(|angles| angles.iter().any(Option::is_some));
        let measured = |place: usize| first.is_none_or(|angles| angles[place].is_some());
        let angles = angles.into_iter().zip(0..COUNT);
        let angles = angles.filter(|(_, place)| measured(*place));
        Ok(angles.map(|((entry, _), _)| (entry, FINE)).collect())
    }

    fn poll(&mut self, session: &mut Session, angles: &[(Entry, Scale)]) -> Result<Read, Error> {
        let silent = || Error::from(Silence::Angles);
        let read = self.read(&mut session.link)?.ok_or_else(silent)?;
        Ok((read.into_iter().take(angles.len()).collect(), None))
    }
}

/// The angles of the next broadcast; None: it did not come in this time.
///
/// # Errors
/// The adapter fails.
fn broadcast(link: &mut Link, address: u8, time: Duration) -> Result<Option<Angles>, Error> {
    link.wait_for(time, |frame| of(frame, address))
}

/// The angles in a broadcast of this node; None: the frame is another one.
pub fn of(frame: &Frame, address: u8) -> Option<Angles> {
    let [group, ..] = groups::GROUPS;
    j1939::group(frame, address, group.pgn).and_then(angles)
}

/// The angles on request; None: nobody answers.
///
/// # Errors
/// The errors of [`j1939::get`].
fn request(link: &mut Link, address: u8) -> Result<Option<Angles>, Error> {
    let [group, ..] = groups::GROUPS;
    Ok(match j1939::get(link, address, group.pgn)? {
        j1939::Answer::Data(data) => angles(&data),
        _ => None,
    })
}

/// The angles in the data of the group.
fn angles(data: &[u8]) -> Option<Angles> {
    let data = u64::from_le_bytes(data.try_into().ok()?);
    let [group, ..] = groups::GROUPS;
    Some([Source::Pitch, Source::Roll].map(|wanted| {
        let mut signals = group.signals.iter();
        signals.find_map(|signal| match signal.contents {
            Contents::Value {
                source,
                resolution: (dividend, divisor),
                offset,
                ..
            } if source == wanted => {
                let raw = data >> signal.start & ((1 << signal.bits) - 1);
                // Higher numbers are errors.
                let highest = (0xFB << (signal.bits - 8)) - 1;
                let unit = 10_i64.pow(FINE.decimals.into());
                let (dividend, divisor) = (dividend as i64 * unit, divisor as i64);
                let product = raw as i64 * dividend;
                let rounded = (2 * product + divisor).div_euclid(2 * divisor);
                (raw <= highest).then_some(rounded + i64::from(offset) * unit)
            }
            _ => None,
        })
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_have_the_scale_of_the_group() {
        for (data, expected) in [
            // 12.34 and -5 deg.
            (
                [0x85, 0x2B, 0x83, 0x00, 0x80, 0x7A],
                [Some(123_400), Some(-50_000)],
            ),
            ([0x00, 0x00, 0x7D, 0x00, 0x00, 0x7D], [Some(0), Some(0)]),
            // One axis, at -90 deg; the highest number; an error.
            ([0x00, 0x00, 0x50, 0xFF, 0xFF, 0xFF], [Some(-900_000), None]),
            (
                [0xFF, 0xFF, 0xFA, 0x00, 0x00, 0xFB],
                [Some(2_520_000), None],
            ),
        ] {
            let mut frame = [0xFF; 8];
            frame[..6].copy_from_slice(&data);
            assert_eq!(angles(&frame), Some(expected), "{data:X?}");
        }
        assert_eq!(angles(&[0; 7]), None);
    }
}
