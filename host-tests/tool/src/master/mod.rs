//! The master of each protocol, one folder for each.
//!
//! CONTRIBUTING says what a new protocol needs.

pub mod canopen;
mod command;
pub mod devicenet;
pub mod fsc;
pub mod j1939;
mod options;
mod protocol;
mod roles;

pub use canopen::Node;
pub use command::{AddressCommand, NewAddress};
pub use j1939::Ca;
pub use options::Addresses;
pub use protocol::Protocol;
pub(crate) use roles::factory;
pub use roles::{Codes, Roles, Storing, factory_rate, factory_target, factory_targets};

use crate::cyclic::{Source, Started};
use crate::error::{Error, SensorError};
use crate::identify::Found;
use crate::link::Link;
use crate::master::canopen::sdo::Server;
use crate::master::devicenet::explicit::Slave;
use crate::master::fsc::request::Sensor;
use crate::ops::identity::Values;
use crate::ops::report::Done;
use crate::output::Terminal;
use crate::sample::{Poller, Sampler};
use crate::scan::listen::{self, Frames};
use crate::session::Session;
use crate::sheet::Entry;
use plumbline::can::{BitRate, CanId, Frame};
use plumbline::model::catalog::Product;
use plumbline::param::number;
use plumbline::time::{Duration, millis};
use plumbline::update::Hardware;
use std::ops::Deref;

/// What the program of a sensor with a bootloader tells of itself.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Program {
    /// The CRC-32 of its body.
    pub crc: u32,
    /// The hardware for which it is built; None: it does not tell it.
    pub hardware: Option<Hardware>,
}

impl Program {
    /// The reply of a sensor that tells it in one message; None: it does not.
    fn parse(bytes: &[u8]) -> Option<Self> {
        let hardware = bytes.get(4..6).map(|bytes| number(bytes) as u16);
        Some(Self {
            crc: number(bytes.get(..4)?),
            hardware: hardware.map(Hardware::of),
        })
    }
}

/// The tool's side of a protocol, for the sensor at one address.
pub trait Master {
    /// The protocol.
    fn protocol(&self) -> &'static Protocol;

    /// The address as `scan` shows it and the command line takes it: 300, 10 or 63.
    fn address(&self) -> String;

    /// The address with its kind, for people.
    fn named(&self) -> String {
        format!("{} {}", self.protocol().kind, self.address())
    }

    /// The sensor at the address; None if nobody answers. Only reads, which change nothing. `time` is the wait for the first answer.
    ///
    /// # Errors
    /// The adapter fails.
    fn identify(&self, link: &mut Link, time: Duration) -> Result<Option<Found>, Error>;

    /// Reads the bytes with an entry; for GEMAC all data of the reply.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    fn read(&self, session: &mut Session, entry: &Entry) -> Result<Vec<u8>, Error>;

    /// Writes the bytes of an entry, also none (GEMAC: the sensor takes the value from the present position) or a text.
    ///
    /// # Errors
    /// See [`read`](Self::read).
    fn write(&self, session: &mut Session, entry: &Entry, bytes: &[u8]) -> Result<(), Error>;

    /// Writes raw numbers.
    ///
    /// # Errors
    /// See [`read`](Self::read).
    fn write_values(&self, session: &mut Session, values: &[(Entry, u32)]) -> Result<(), Error> {
        for (entry, raw) in values {
            let size = usize::from(entry.data_type.size());
            session.write_bytes(entry, &raw.to_le_bytes()[..size])?;
        }
        Ok(())
    }

    /// The serial number of the sensor, if its protocol tells it in one answer.
    ///
    /// # Errors
    /// See [`read`](Self::read).
    fn serial(&self, _session: &mut Session) -> Result<Option<u32>, Error> {
        Ok(None)
    }

    /// Whether the connection of the session shows that this is still the expected sensor.
    ///
    /// # Errors
    /// Another sensor answers, nobody answers, or the adapter fails.
    fn is_connected(&self, _session: &mut Session) -> Result<bool, Error> {
        Ok(false)
    }

    /// Stores the parameters. Returns a sentence about what happened.
    ///
    /// # Errors
    /// See [`read`](Self::read).
    fn save(&self, session: &mut Session) -> Result<Done, Error>;

    /// Whether the sensor takes its factory values at its next start, without storing them.
    fn loads_at_restart(&self, _session: &Session) -> bool {
        false
    }

    /// Loads the factory values, and says what follows.
    ///
    /// # Errors
    /// See [`read`](Self::read).
    fn load(&self, session: &mut Session) -> Result<Done, Error>;

    /// Restarts the sensor.
    ///
    /// # Errors
    /// See [`read`](Self::read).
    fn restart(&self, session: &mut Session) -> Result<(), Error>;

    /// Stores a bit rate and nothing else. False: the sensor does not have this service.
    ///
    /// # Errors
    /// See [`read`](Self::read).
    fn store_rate(&self, _session: &mut Session, _rate: BitRate) -> Result<bool, Error> {
        Ok(false)
    }

    /// What the program of the sensor tells of itself; None: it has no bootloader.
    ///
    /// # Errors
    /// Nobody answers, or the adapter fails.
    fn program(&self, _session: &mut Session) -> Result<Option<Program>, Error> {
        Ok(None)
    }

    /// A value of the diagnostic data of this project ([`plumbline::diagnosis`]); None: the sensor does not have it. Call it only
    /// for a sensor of this product that has answered.
    ///
    /// # Errors
    /// The adapter fails.
    fn diagnosis(
        &self,
        link: &mut Link,
        product: &Product,
        number: u8,
    ) -> Result<Option<u32>, Error>;

    /// Restarts the sensor into its bootloader.
    ///
    /// # Errors
    /// See [`read`](Self::read).
    fn enter_bootloader(&self, _session: &mut Session) -> Result<(), Error> {
        Err(SensorError::NoBootloader.into())
    }

    /// Whether the bootloader answers at the address in place of the sensor.
    ///
    /// # Errors
    /// The adapter fails.
    fn is_bootloader(&self, _link: &mut Link) -> Result<bool, Error> {
        Ok(false)
    }

    /// Whether a bootloader waits at an address at which no sensor has answered. Asked once, with this wait.
    ///
    /// # Errors
    /// The adapter fails.
    fn waits(&self, _link: &mut Link, _time: Duration) -> Result<bool, Error> {
        Ok(false)
    }

    /// The SDO server of the bootloader of the sensor; None: its identifiers are not known.
    ///
    /// # Errors
    /// The adapter fails.
    fn bootloader(&self, _link: &mut Link) -> Result<Option<Server>, Error> {
        Ok(None)
    }

    /// What the sensor tells about itself; what it does not have is left out.
    ///
    /// # Errors
    /// Nobody answers, or the adapter fails.
    fn identity(&self, session: &mut Session) -> Result<Values, Error>;

    /// Lets the sensor send its angles with a period of `every` ms. The sampler gets the values that the sensor sends.
    ///
    /// # Errors
    /// The sensor cannot do it, refuses it, nobody answers, or the adapter fails.
    fn stream(
        &self,
        session: &mut Session,
        sampler: &mut Sampler,
        every: u32,
        terminal: &mut Terminal,
    ) -> Result<Started, Error>;

    /// The messages in which the sensor sends its angles by itself; None: it does not, as it is set.
    ///
    /// # Errors
    /// Nobody answers, or the adapter fails.
    fn source(&self, _session: &mut Session, _sampler: &Sampler) -> Result<Option<Source>, Error> {
        Ok(None)
    }

    /// Whether another master can own the sensor, so that it is only listened to.
    fn can_be_owned(&self) -> bool {
        false
    }

    /// The sensor, if these frames show that another master owns it.
    fn owned(&self, _frames: &Frames) -> Option<Found> {
        None
    }

    /// Whether the sensor reports, in another message than its angles, an error with which these are not valid.
    ///
    /// # Errors
    /// Nobody answers, or the adapter fails.
    fn reports_defect(&self, _session: &mut Session) -> Result<bool, Error> {
        Ok(false)
    }

    /// The active bits of the status in a reply of a product.
    fn conditions(&self, _product: &Product, _status: u8) -> Vec<Condition> {
        Vec::new()
    }

    /// What reads all angles at once; None: each is read by itself.
    fn poller(&self) -> Option<Box<dyn Poller>> {
        None
    }

    /// Sends one request of the user, and returns the bytes of its answer.
    ///
    /// # Errors
    /// The request is not valid, the sensor refuses, nobody answers, or the adapter fails.
    fn raw(&self, link: &mut Link, request: &str) -> Result<Vec<u8>, Error>;

    /// Releases what the session has allocated in the sensor.
    ///
    /// # Errors
    /// The adapter fails.
    fn release(&self, _session: &mut Session) -> Result<(), Error> {
        Ok(())
    }

    /// The identifiers of requests to the address, and of their answers; none: other nodes have the same.
    fn identifiers(&self) -> Vec<CanId> {
        Vec::new()
    }

    /// Whether a request to the address can be a command to other devices, whatever was heard.
    fn is_reserved(&self) -> bool {
        false
    }

    /// The identifier of its answers and process data, if it has told it and the address does not contain it.
    fn reply(&self) -> Option<CanId> {
        None
    }

    /// How long a node is asked that has just been heard.
    fn patience(&self) -> Duration {
        PATIENCE
    }

    /// The node-ID that default identifiers contain.
    fn node_id(&self) -> Option<u8> {
        None
    }

    /// Whether parameters are written together.
    fn writes_together(&self) -> bool {
        false
    }

    /// Ends the operation of the node, in which it can refuse a write. False: it was not in operation.
    ///
    /// # Errors
    /// The adapter fails.
    fn suspend(&self, _link: &mut Link) -> Result<bool, Error> {
        Ok(false)
    }

    /// Begins the operation of the node again.
    ///
    /// # Errors
    /// The adapter fails.
    fn resume(&self, _link: &mut Link) -> Result<(), Error> {
        Ok(())
    }

    /// Whether a node has this address: listens for its messages, then asks several times. Identifiers of GEMAC are not checked.
    ///
    /// # Errors
    /// The adapter fails.
    fn is_used(&self, _link: &mut Link) -> Result<bool, Error> {
        Ok(false)
    }
}

/// An active bit of the status of a sensor.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Condition {
    /// Its name in the manual.
    pub name: &'static str,
    /// The sensor has an error.
    pub is_error: bool,
    /// An angle is not valid: outside its range, or not measured.
    pub spoils_angle: bool,
}

/// Makes [`Target`] and [`PROTOCOLS`] of a line for each protocol.
macro_rules! masters {
    ($($(#[$about:meta])* $name:ident($address:ty) of $protocol:path;)*) => {
        /// The address of a sensor.
        #[derive(Clone, Copy, PartialEq, Eq, Debug)]
        pub enum Target {
            $($(#[$about])* $name($address),)*
        }

        /// All protocols. The first one of a product with two is its own.
        pub const PROTOCOLS: [&Protocol; [$(stringify!($name)),*].len()] = [$(&$protocol),*];

        impl Deref for Target {
            type Target = dyn Master;

            fn deref(&self) -> &Self::Target {
                match self {
                    $(Self::$name(address) => address,)*
                }
            }
        }
    };
}

masters! {
    /// A GEMAC sensor, with its identifiers.
    Fsc(Sensor) of fsc::PROTOCOL;
    /// A CANopen node, with its node-ID.
    Canopen(Node) of canopen::PROTOCOL;
    /// A DeviceNet slave, with its MAC ID.
    Devicenet(Slave) of devicenet::PROTOCOL;
    /// A controller application (CA) of J1939, with its address. Its parameters are objects, as in CANopen.
    J1939(Ca) of j1939::PROTOCOL;
}

impl Target {
    /// Whether both are the same address. What the sensor has told besides does not count.
    pub fn is_at(self, other: Self) -> bool {
        self.protocol() == other.protocol() && self.address() == other.address()
    }
}

/// How long a node is asked that has just been heard.
const PATIENCE: Duration = millis(1000);

/// The number of times an address that must be free is asked.
const QUESTIONS: u8 = 3;

/// Whether one of these messages comes, or somebody answers.
fn is_there(
    link: &mut Link,
    messages: &[CanId],
    answers: impl Fn(&mut Link) -> Result<bool, Error>,
) -> Result<bool, Error> {
    let is_own = |frame: &Frame| messages.contains(&frame.can_id()).then_some(());
    let mut is_there = link.wait_for(listen::LONG, is_own)?.is_some();
    for _ in 0..QUESTIONS {
        is_there = is_there || answers(link)?;
    }
    Ok(is_there)
}
