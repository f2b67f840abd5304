//! What a sensor with an SDO server reports about itself.

use crate::error::{Error, What};
use crate::master::canopen::sdo::{Answer, Server};
use crate::ops::identity::{Values, numbers, texts};
use crate::session::Session;

/// The number of times a sensor is asked the same.
const TRIES: u8 = 3;

/// The values of the identity object, and the texts.
pub(super) fn read(session: &mut Session, server: Server) -> Result<Values, Error> {
    let mut read = |index, sub| {
        let mut answer = Answer::Silent;
        for _ in 0..TRIES {
            answer = server.read(&mut session.link, index, sub)?;
            if answer != Answer::Silent {
                break;
            }
        }
        match answer {
            Answer::Aborted(_) => Ok(None),
            answer => answer
                .must(server, What::Read(format!("{index:04X}h")))
                .map(Some),
        }
    };
    let mut values = numbers([
        ("vendor", read(0x1018, 1)?),
        ("product-code", read(0x1018, 2)?),
        ("revision", read(0x1018, 3)?),
        ("serial", read(0x1018, 4)?),
    ]);
    values.extend(texts([
        ("name", read(0x1008, 0)?),
        ("hardware-version", read(0x1009, 0)?),
        ("software-version", read(0x100A, 0)?),
    ]));
    Ok(values)
}
