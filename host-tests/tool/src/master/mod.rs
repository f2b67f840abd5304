//! The master of each protocol: one folder has all that the tool knows of the protocol.
//!
//! A new protocol is a folder and a line of [`masters`].

pub mod canopen;
pub mod devicenet;
pub mod fsc;
pub mod j1939;
mod roles;

pub use canopen::Node;
pub use j1939::Ca;
pub use roles::{Codes, Roles, Storing, factory_rate, factory_target, factory_targets};

use crate::client::Link;
use crate::client::devicenet::Slave;
use crate::client::fsc::Sensor;
use crate::client::sdo::Server;
use crate::error::Error;
use crate::scan::listen;
use plumbline::can::{CanId, Frame};
use plumbline::model::catalog::Product;
use std::ops::{Deref, RangeInclusive};

/// What the tool knows of a protocol without a sensor.
#[derive(Debug)]
pub struct Protocol {
    /// The name in documents.
    pub name: &'static str,
    /// The option of the command line with an address.
    pub option: &'static str,
    /// The sensor at the address of this option.
    pub target: fn(&str) -> Result<Target, Error>,
    /// The parameters of a product with a role in this protocol; None: the product does not have this protocol.
    pub roles: fn(&Product) -> Option<Roles>,
}

impl PartialEq for Protocol {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Protocol {
    /// The protocol with this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        PROTOCOLS.into_iter().find(|protocol| protocol.name == name)
    }

    /// The protocol of a product; of two, the first one of [`PROTOCOLS`].
    pub fn of(product: &Product) -> &'static Self {
        let mut all = PROTOCOLS.into_iter();
        let own = all.find(|protocol| protocol.is_of(product));
        own.unwrap_or(PROTOCOLS[0])
    }

    /// Whether a product can have this protocol.
    pub fn is_of(&self, product: &Product) -> bool {
        (self.roles)(product).is_some()
    }
}

/// The tool's side of a protocol, for the sensor at one address.
pub trait Master {
    /// The protocol.
    fn protocol(&self) -> &'static Protocol;

    /// The address as `scan` shows it and the command line takes it: 300, 10 or 63.
    fn address(&self) -> String;

    /// The address with its kind, for people.
    fn named(&self) -> String;

    /// The server of its objects, if it has one.
    fn server(&self) -> Option<Server> {
        None
    }

    /// Whether a node has this address: listens for its messages, then asks several times. Identifiers of GEMAC are not checked.
    ///
    /// # Errors
    /// The adapter fails.
    fn is_used(&self, _link: &mut Link) -> Result<bool, Error> {
        Ok(false)
    }
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

/// The address of an option of the command line, which is a number.
fn number(option: &str, text: &str, range: RangeInclusive<u8>, why: &str) -> Result<u8, Error> {
    let number = text.parse().ok().filter(|number| range.contains(number));
    number.ok_or_else(|| {
        let message = format!(
            "{option} {text}: {why}; `plumbline scan` shows the addresses of the sensors on the bus"
        );
        Error::usage("out-of-range", message)
    })
}
