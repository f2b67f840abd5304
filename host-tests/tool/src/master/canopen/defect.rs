//! Whether a sensor reports that its measuring element is defective.
//!
//! A product can have a status bit for it. Without one, the error register (1001h) shows that an error is active, and the list of errors
//! (1003h) its code. Neither shows which error of the list has ended, so in doubt the element is taken as defective.

use super::Node;
use crate::error::Error;
use crate::link::Link;
use crate::master::canopen::sdo::Answer;
use crate::session::Session;
use plumbline::application::Faults;
use plumbline::canopen::emcy::{Cause, FaultBit};
use plumbline::model::listing::canopen::Defect;
use plumbline::param::number;

/// The list of errors.
const ERRORS: u16 = 0x1003;

/// Bit 0 of the error register: an error is active.
const ACTIVE: u32 = 1 << 0;

/// The faults of the measuring element.
const ELEMENT: Faults = Faults::SENSOR
    .and(Faults::X_DEFECTIVE)
    .and(Faults::Y_DEFECTIVE);

impl Node {
    pub(super) fn reports_defect_in(self, session: &mut Session) -> Result<bool, Error> {
        let tables = super::own(session)?;
        let link = &mut session.link;
        if let Some(Defect { index, sub, bits }) = tables.defect {
            let status = self.number(link, index, sub)?;
            return Ok(status.is_some_and(|status| status & bits != 0));
        }
        let register = self.number(link, 0x1001, 0)?;
        if register.is_none_or(|register| register & ACTIVE == 0) {
            return Ok(false);
        }
        let count = self.number(link, ERRORS, 0)?.unwrap_or(0);
        for sub in 1..=count as u8 {
            let error = self.number(link, ERRORS, sub)?;
            if error.is_some_and(|error| is_of_element(&tables.faults, error)) {
                return Ok(true);
            }
        }
        // A master has cleared the list: the error has no code.
        Ok(count == 0)
    }

    /// The number of an object; None: the sensor refuses the read.
    fn number(self, link: &mut Link, index: u16, sub: u8) -> Result<Option<u32>, Error> {
        match self.server().read(link, index, sub)? {
            Answer::Done(bytes) => Ok(Some(number(&bytes))),
            Answer::Aborted(_) => Ok(None),
            Answer::Silent => Err(crate::error::Silence::Node(self.0).into()),
        }
    }
}

/// Whether an entry of the list can be a fault of the measuring element. The first byte of a code is that of the maker.
fn is_of_element(faults: &[FaultBit], error: u32) -> bool {
    let class = |code: u32| code >> 8 & 0xFF;
    let mut faults = faults.iter();
    faults.any(|fault| {
        let is_element = matches!(fault.cause, Cause::Application(own) if own.intersects(ELEMENT));
        is_element && class(fault.code.into()) == class(error)
    })
}
