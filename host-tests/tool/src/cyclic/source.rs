//! The messages in which a sensor sends its angles by itself, whoever has asked it to. Nothing is sent for them, and no setting changes.
//!
//! | protocol | message |
//! |---|---|
//! | GEMAC | a value of cyclic mode: the reply to the code of the angles, with a counter |
//! | J1939 | a broadcast of the group SSI2 |
//! | CANopen | a TPDO that is on, with all angles |
//! | DeviceNet | none: the sensor sends I/O messages only to the master that owns it |

use super::{Layout, Message, canopen};
use crate::client::fsc::{self, Sensor};
use crate::error::Error;
use crate::master::Target;
use crate::sample::{Sampler, angles_in, ssi2};
use crate::session::Session;
use crate::sheet::Entry;
use plumbline::can::Frame;
use plumbline::param::number;
use plumbline::time::Instant;

/// How to recognise and decode the messages of a sensor.
pub struct Source {
    kind: Kind,
    /// The angles in them, if they are other entries than those that are polled.
    pub others: Option<Vec<Entry>>,
}

enum Kind {
    Fsc {
        sensor: Sensor,
        code: u8,
        angles: Vec<Entry>,
        /// The bytes of the angles. The counter is behind them.
        size: usize,
    },
    J1939 {
        address: u8,
        count: usize,
    },
    Canopen(Layout),
}

impl Source {
    /// The messages of the sensor of a session. None: it cannot send angles by itself as it is set.
    ///
    /// # Errors
    /// Nobody answers, or the adapter fails.
    pub fn of(session: &mut Session, sampler: &Sampler) -> Result<Option<Self>, Error> {
        let angles = sampler.entries();
        let kind = match (session.target, sampler.code()) {
            (Target::Fsc(sensor), Some(code)) => Kind::Fsc {
                sensor,
                code,
                size: sampler.size(),
                angles: angles.clone(),
            },
            (Target::J1939(node), _) => Kind::J1939 {
                address: node.0,
                count: angles.len(),
            },
            (Target::Canopen(node), _) => {
                let sent = canopen::sent(session, node.0, sampler)?;
                let is_own = |entries: &[Entry]| {
                    let own = angles.iter().map(|own| own.address);
                    own.eq(entries.iter().map(|own| own.address))
                };
                return Ok(sent.map(|(entries, layout)| Self {
                    kind: Kind::Canopen(layout),
                    others: Some(entries).filter(|entries| !is_own(entries)),
                }));
            }
            _ => return Ok(None),
        };
        Ok(Some(Self { kind, others: None }))
    }

    /// The angles in a frame that came at this time; None: it is another message.
    pub(crate) fn message(&self, at: Instant, frame: &Frame) -> Option<Message> {
        match &self.kind {
            Kind::Fsc {
                sensor,
                code,
                angles,
                size,
            } => {
                let reply = fsc::reply(frame, *sensor, *code)?;
                // A reply to a request has no counter.
                let counter = reply.data.get(*size..*size + 2).map(number)?;
                Some(Message {
                    status: Some(reply.status),
                    counter: Some(counter as u16),
                    ..Message::plain((at, angles_in(&reply, angles.iter())?))
                })
            }
            Kind::J1939 { address, count } => Some(Message {
                at,
                numbers: ssi2::of(frame, *address)?
                    .into_iter()
                    .take(*count)
                    .collect(),
                status: None,
                counter: None,
            }),
            Kind::Canopen(layout) => layout.decode(frame).map(|own| Message::plain((at, own))),
        }
    }
}
