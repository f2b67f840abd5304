//! Reads, writes and commands in a session.

use super::tables;
use crate::error::{Error, What};
use crate::link::Link;
use crate::master::Program;
use crate::master::fsc::request::{self as fsc, Sensor};
use crate::note::Note;
use crate::ops::identity::{Values, numbers};
use crate::session::{Session, unexpected};
use crate::sheet::{Address, Entry};
use plumbline::can::{CanId, Frame};
use plumbline::fsc::table::{Function, Operation};
use plumbline::fsc::{FLASH, UPDATE};
use plumbline::model::listing::fsc::Tables;
use plumbline::param::number;
use plumbline::time::Duration;

/// The code of the article.
const ARTICLE: u8 = 0x03;

/// The number of times a bootloader is asked whose replies have an unknown identifier.
const BOOTLOADER_TRIES: u8 = 15;

/// The code of the serial number.
const SERIAL: u8 = 0x04;

/// The identifier of the replies of a bootloader that waits at this identifier of requests.
pub(super) fn bootloader_reply(link: &mut Link, request: CanId) -> Result<Option<CanId>, Error> {
    for _ in 0..BOOTLOADER_TRIES {
        let reply = bootloader_reply_within(link, request, fsc::ANSWER)?;
        if reply.is_some() {
            return Ok(reply);
        }
    }
    Ok(None)
}

/// The same, asked once.
pub(super) fn bootloader_reply_within(
    link: &mut Link,
    request: CanId,
    time: Duration,
) -> Result<Option<CanId>, Error> {
    // Reads 1F51h:01, which is 0.
    let question = Frame::of(request, [0x40, 0x51, 0x1F, 1, 0, 0, 0, 0], 8);
    let answer = [0x4F, 0x51, 0x1F, 1, 0, 0, 0, 0];
    link.ask(&question, time, |frame| {
        (frame.bytes() == answer).then(|| frame.can_id())
    })
}

impl Sensor {
    /// All data of the reply with an entry.
    pub(super) fn read_in(self, session: &mut Session, entry: &Entry) -> Result<Vec<u8>, Error> {
        let Address::Fsc { read, .. } = entry.address else {
            return Err(unexpected(What::Name(entry.name.clone())));
        };
        let reply = fsc::once(&mut session.link, self, read, &[], fsc::ANSWER)?;
        Ok(reply.data)
    }

    /// Parameters with the same code are written together: those that are not given keep their values.
    pub(super) fn write_together(
        self,
        session: &mut Session,
        values: &[(Entry, u32)],
    ) -> Result<(), Error> {
        let mut done = Vec::new();
        for (entry, _) in values {
            let code = write_code(entry)?;
            if !done.contains(&code) {
                done.push(code);
                let data = data_of(session, code, values)?;
                self.command(session, code, &data, fsc::WRITTEN)?;
            }
        }
        Ok(())
    }

    pub(super) fn write_in(
        self,
        session: &mut Session,
        entry: &Entry,
        bytes: &[u8],
    ) -> Result<(), Error> {
        self.command(session, write_code(entry)?, bytes, fsc::WRITTEN)
    }

    /// A request that changes something. The request for the status clears its errors, which the user is told.
    fn command(
        self,
        session: &mut Session,
        code: u8,
        data: &[u8],
        time: Duration,
    ) -> Result<(), Error> {
        let tables = own(session)?;
        // There is nothing to clear if the reply before this request had no error.
        let is_clean = session.known().is_some_and(|known| known.is_clean);
        let earlier = match is_clean {
            true => Vec::new(),
            false => fsc::earlier(&mut session.link, self, tables)?,
        };
        if let Some(known) = session.known() {
            known.read.clear();
        }
        fsc::command(&mut session.link, self, tables, code, data, time)?;
        for name in earlier {
            session.note(Note::Cleared(name));
        }
        Ok(())
    }

    pub(super) fn serial_in(self, session: &mut Session) -> Result<Option<u32>, Error> {
        let errors = fsc::errors(own(session)?);
        let reply = fsc::must(&mut session.link, self, SERIAL, fsc::ANSWER)?;
        if let Some(known) = session.known() {
            known.is_clean = reply.status & errors == 0;
        }
        Ok(reply.data.get(..4).map(number))
    }

    pub(super) fn read_identity(self, session: &mut Session) -> Result<Values, Error> {
        let article = fsc::must(&mut session.link, self, ARTICLE, fsc::ANSWER)?.data;
        let serial = fsc::must(&mut session.link, self, SERIAL, fsc::ANSWER)?.data;
        let part = |data: &[u8], from: usize, to: usize| data.get(from..to).map(<[u8]>::to_vec);
        Ok(numbers([
            ("article", part(&article, 0, 4)),
            ("revision", part(&article, 4, 6)),
            ("serial", part(&serial, 0, 4)),
        ]))
    }

    /// The function with a signature.
    pub(super) fn signed(self, session: &mut Session, operation: Operation) -> Result<(), Error> {
        let function = function(own(session)?, operation)?;
        self.command(session, function.code, function.signature, fsc::SAVED)
    }

    /// What the program tells of itself. Another sensor refuses the code, and tells it in its status, which is read to clear it.
    pub(super) fn program_in(self, session: &mut Session) -> Result<Option<Program>, Error> {
        let reply = fsc::must(&mut session.link, self, UPDATE, fsc::ANSWER)?;
        let program = Program::parse(&reply.data);
        if program.is_none() {
            let tables = own(session)?;
            for name in fsc::earlier(&mut session.link, self, tables)? {
                session.note(Note::Cleared(name));
            }
        }
        Ok(program)
    }

    pub(super) fn enter_bootloader_in(self, session: &mut Session) -> Result<(), Error> {
        self.command(session, UPDATE, FLASH, fsc::SAVED)
    }

    pub(super) fn restart_in(self, session: &mut Session) -> Result<(), Error> {
        let function = function(own(session)?, Operation::Alive)?;
        // There is no answer, so the sensor must be there before.
        fsc::must(&mut session.link, self, function.code, fsc::ANSWER)?;
        fsc::send(&mut session.link, self, function.code, function.signature)
    }
}

fn own(session: &Session) -> Result<&'static Tables, Error> {
    tables(session.sheet.product).ok_or_else(|| unexpected(What::Request))
}

fn write_code(entry: &Entry) -> Result<u8, Error> {
    match entry.address {
        Address::Fsc {
            write: Some(write), ..
        } => Ok(write),
        _ => Err(unexpected(What::Name(entry.name.clone()))),
    }
}

/// The data of a write code: the given values, and the present ones of the other parameters.
fn data_of(session: &mut Session, code: u8, values: &[(Entry, u32)]) -> Result<Vec<u8>, Error> {
    let is = |entry: &&Entry| matches!(entry.address, Address::Fsc { write: Some(own), .. } if own == code);
    let parts: Vec<Entry> = session.sheet.entries.iter().filter(is).cloned().collect();
    let mut data = Vec::new();
    for part in parts {
        let given = values.iter().find(|(entry, _)| entry.name == part.name);
        let raw = match given {
            Some((_, raw)) => *raw,
            None => session.read(&part)?,
        };
        data.extend_from_slice(&raw.to_le_bytes()[..usize::from(part.data_type.size())]);
    }
    Ok(data)
}

fn function(tables: &Tables, operation: Operation) -> Result<Function, Error> {
    let mut functions = tables.functions.iter();
    let function = functions.find(|function| function.operation == operation);
    function.copied().ok_or_else(|| unexpected(What::Function))
}
