//! The explicit connection of a session, and the requests on it.

use crate::error::{Error, SensorError, Silence, What};
use crate::master::Program;
use crate::master::devicenet::explicit::{Path, Response, Slave};
use crate::session::{Session, unexpected};
use crate::sheet::{Address, Entry};
use plumbline::devicenet::{BOOT, service};
use plumbline::param::{DataType, number};
use plumbline::time::{Duration, Instant, after, millis};

/// How long a connection is certain to live after an answer; it ends after 10 s.
const FRESH: Duration = millis(5000);

/// The identity object.
pub(super) const IDENTITY: Path = Path {
    class: 1,
    instance: 1,
};

/// The attribute of the identity object with the serial number.
const SERIAL: u8 = 6;

/// The attribute of the identity object with the status, and its bits of a major fault, which can be recoverable or not.
const STATUS: u8 = 5;
const MAJOR_FAULT: u32 = 3 << 10;

/// The state of the connection.
#[derive(Debug, Default)]
pub struct Connection {
    /// It is allocated. Meanwhile nobody else can change the sensor, and another sensor does not answer.
    pub is_allocated: bool,
    /// The last answer on it.
    used: Option<Instant>,
}

impl Slave {
    /// Allocates the connection of a session, if it is not allocated.
    fn connect(self, session: &mut Session) -> Result<(), Error> {
        if session.connection.is_allocated {
            return Ok(());
        }
        session.forget_settings();
        self.allocate(&mut session.link)?;
        session.connection.is_allocated = true;
        if let Some(expected) = session.expected {
            let told = self.get(&mut session.link, IDENTITY, SERIAL)?;
            let told = number(&told.must(self.mac, What::Serial)?);
            if told != expected {
                session.release()?;
                let what = format!("serial {told} at MAC ID {}", self.mac);
                return Err(SensorError::Other(what).into());
            }
        }
        Ok(())
    }

    /// A request on the connection of a session. A pause of more than 10 s ends the connection; then it is allocated again.
    ///
    /// # Errors
    /// Another master owns the sensor, another sensor answers, or the adapter fails.
    pub(crate) fn request_in(
        self,
        session: &mut Session,
        code: u8,
        path: Path,
        data: &[u8],
    ) -> Result<Response, Error> {
        let was_allocated = session.connection.is_allocated;
        self.connect(session)?;
        let response = self.explicit(&mut session.link, code, path, data)?;
        if response != Response::Silent {
            session.connection.used = Some(session.link.now());
        }
        if response != Response::Silent || !was_allocated {
            return Ok(response);
        }
        session.connection.is_allocated = false;
        self.connect(session)?;
        self.explicit(&mut session.link, code, path, data)
    }

    /// Makes sure that the connection is still that to the expected sensor. A connection that has just been used is.
    pub(super) fn freshen(self, session: &mut Session) -> Result<(), Error> {
        let Connection { is_allocated, used } = session.connection;
        let used = used.filter(|_| is_allocated);
        if used.is_none_or(|used| session.link.now() >= after(used, FRESH)) {
            // A connection that has ended is allocated again, with the check.
            let told = self.request_in(session, service::GET, IDENTITY, &[SERIAL])?;
            told.must(self.mac, What::Serial)?;
        }
        Ok(())
    }

    pub(super) fn read_in(self, session: &mut Session, entry: &Entry) -> Result<Vec<u8>, Error> {
        let (path, attribute) = place(entry)?;
        let response = self.request_in(session, service::GET, path, &[attribute])?;
        let bytes = response.must(self.mac, What::Read(entry.name.clone()))?;
        Ok(match entry.data_type {
            DataType::Text => short_string(&bytes).to_vec(),
            _ => bytes,
        })
    }

    pub(super) fn write_in(
        self,
        session: &mut Session,
        entry: &Entry,
        bytes: &[u8],
    ) -> Result<(), Error> {
        let (path, attribute) = place(entry)?;
        let data = [&[attribute], bytes].concat();
        let response = self.request_in(session, service::SET, path, &data)?;
        let what = What::Write(entry.name.clone());
        response.must(self.mac, what).map(|_| ())
    }

    /// Whether the status has a major fault: the sensor cannot measure.
    pub(super) fn reports_defect_in(self, session: &mut Session) -> Result<bool, Error> {
        match self.request_in(session, service::GET, IDENTITY, &[STATUS])? {
            Response::Done(status) => Ok(number(&status) & MAJOR_FAULT != 0),
            Response::Refused(..) => Ok(false),
            Response::Silent => Err(Silence::MacId(self.mac).into()),
        }
    }

    /// What the program tells of itself.
    pub(super) fn program_in(self, session: &mut Session) -> Result<Option<Program>, Error> {
        let response = self.request_in(session, service::UPDATE, IDENTITY, &[])?;
        match response {
            Response::Refused(..) => Ok(None),
            response => Ok(Program::parse(&response.must(self.mac, What::Program)?)),
        }
    }

    /// The service that restarts the sensor into its bootloader. It ends the connection.
    pub(super) fn enter_bootloader_in(self, session: &mut Session) -> Result<(), Error> {
        let response = self.request_in(session, service::UPDATE, IDENTITY, BOOT)?;
        session.connection.is_allocated = false;
        response.must(self.mac, What::Program).map(|_| ())
    }

    /// The reset service of the identity object. It ends the connection.
    pub(super) fn reset(self, session: &mut Session, kind: u8) -> Result<(), Error> {
        let response = self.request_in(session, service::RESET, IDENTITY, &[kind])?;
        session.connection.is_allocated = false;
        response.must(self.mac, What::Reset).map(|_| ())
    }
}

/// The attribute of an entry.
fn place(entry: &Entry) -> Result<(Path, u8), Error> {
    match entry.address {
        Address::Attribute {
            class,
            instance,
            attribute,
        } => Ok((Path { class, instance }, attribute)),
        _ => Err(unexpected(What::Name(entry.name.clone()))),
    }
}

/// The letters of a text (SHORT_STRING), which begins with its length.
fn short_string(bytes: &[u8]) -> &[u8] {
    match bytes {
        [length, letters @ ..] => &letters[..letters.len().min(usize::from(*length))],
        [] => bytes,
    }
}
