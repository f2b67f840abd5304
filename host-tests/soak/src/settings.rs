//! The settings that the sensor must have: those that were written, and those that it may have after a start.

use crate::random::Random;
use host_tests::fuzz;
use plumbline::param::Persistence;
use plumbline_tool::error::Error;
use plumbline_tool::master::{Roles, Storing};
use plumbline_tool::session::Session;
use plumbline_tool::sheet::{Address, Entry, Origin, Sheet};

/// Periods shorter than this many ms load the bus so much that a master cannot send any more.
const SHORTEST: u32 = 50;

/// The variant of the IMS360 (3120h): after the next start, the mapping of the PDOs follows it.
const VARIANT: Address = Address::Object {
    index: 0x3120,
    sub: 1,
};

/// A setting of the sensor.
#[derive(Clone, Debug)]
pub struct Setting {
    /// Its entry.
    pub entry: Entry,
    /// It is stored when it is written.
    pub is_stored_at_once: bool,
    /// A write changes other settings too: the resolution, or the zero point.
    pub changes_others: bool,
}

/// What is known of the settings of a sensor.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The settings that do not change how the sensor is reached.
    pub all: Vec<Setting>,
    /// Their numbers.
    pub now: Vec<u32>,
    /// The numbers that they can have after the next start, one list for each state that the memory can have.
    pub stored: Vec<Vec<u32>>,
}

impl Settings {
    /// The settings of a sensor as delivered.
    ///
    /// # Errors
    /// The sensor does not tell them.
    pub fn of(session: &mut Session) -> Result<Self, Error> {
        let all = all(&session.sheet);
        let now = read(session, &all)?;
        Ok(Self {
            all,
            stored: vec![now.clone()],
            now,
        })
    }

    /// Reads all of them.
    ///
    /// # Errors
    /// The sensor does not tell them.
    pub fn read(&self, session: &mut Session) -> Result<Vec<u32>, Error> {
        read(session, &self.all)
    }

    /// The settings that are stored when they are written are stored now.
    pub fn store_at_once(&mut self) {
        for state in &mut self.stored {
            let each = self.all.iter().zip(&self.now).zip(state);
            for ((setting, now), stored) in each {
                if setting.is_stored_at_once {
                    *stored = *now;
                }
            }
        }
    }

    /// A setting, and a number for it that is permitted mostly.
    pub fn any(&self, random: &mut Random, sheet: &Sheet) -> (usize, u32) {
        let at = random.below(self.all.len() as u32) as usize;
        let entry = &self.all[at].entry;
        let Origin::Parameter(id) = entry.origin else {
            return (at, random.number());
        };
        let parameter = &sheet.product.parameters[usize::from(id.0)];
        // As many bytes as the setting has.
        let number = fuzz::value(parameter, random);
        let number = number & u32::MAX >> (32 - 8 * u32::from(entry.data_type.size()));
        let is_short = parameter.unit == "ms" && (1..SHORTEST).contains(&number);
        (at, if is_short { SHORTEST } else { number })
    }
}

fn read(session: &mut Session, all: &[Setting]) -> Result<Vec<u32>, Error> {
    session.remember(true);
    let read = all.iter().map(|own| session.read(&own.entry)).collect();
    session.remember(false);
    read
}

/// The settings of a product without bit rate, addresses, identifiers, protocol and variant.
fn all(sheet: &Sheet) -> Vec<Setting> {
    let product = sheet.product;
    let roles: Vec<Roles> = plumbline_tool::master::PROTOCOLS
        .iter()
        .filter_map(|protocol| (protocol.roles)(product))
        .collect();
    let selector =
        plumbline_tool::master::j1939::tables(product).and_then(|tables| tables.selector);
    let kept = |entry: &&Entry| match entry.origin {
        Origin::Parameter(id) => {
            let is_role = |own: &Roles| own.is_rate(id) || own.is_address(id);
            entry.address != VARIANT
                && !roles.iter().any(is_role)
                && selector.is_none_or(|(own, _)| own != id)
        }
        _ => false,
    };
    let stores_itself = roles.iter().any(|own| own.storing == Storing::Itself);
    let zeros = product.guide.zero.iter().flat_map(|zero| zero.writes);
    let zeros: Vec<Origin> = zeros.map(|(id, _)| Origin::Parameter(*id)).collect();
    let setting = |entry: &Entry| Setting {
        changes_others: sheet.is_resolution(entry) || zeros.contains(&entry.origin),
        is_stored_at_once: match entry.origin {
            Origin::Parameter(id) => {
                let persistence = product.parameters[usize::from(id.0)].persistence;
                stores_itself || persistence == Persistence::AtOnce
            }
            _ => false,
        },
        entry: entry.clone(),
    };
    sheet.settings().filter(kept).map(setting).collect()
}
