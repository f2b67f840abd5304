//! The plan of a commissioning: a file that people write.
//!
//! ```toml
//! [[sensor]]
//! name = "boom"
//! product = "is2"
//! serial = 4711
//! zero = true
//!
//! [sensor.parameters]
//! cyclic-time = "250 ms"
//! ```

use crate::backup::{Backup, Unread, read_text};
use crate::error::{Error, Fault, FileError, NumberError};
use crate::identify;
use crate::labels;
use crate::master::canopen::tables;
use crate::master::{Roles, Target, factory, factory_rate, factory_target, j1939};
use crate::number::shown as shown_id;
use crate::sheet::{Origin, Sheet};
use plumbline::can::{BitRate, CanId};
use plumbline::model::catalog::Product;
use plumbline::param::ParameterId;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use texts::told;
use toml::{Spanned, Value};

/// What is to be commissioned.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Each sensor is switched off before the next one is switched on.
    pub alone: bool,
    /// The bit rate of the bus, which the user has selected.
    given: Option<BitRate>,
    /// The sensors, in their order.
    pub sensors: Vec<Item>,
}

/// How a sensor is found.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Find {
    /// It is switched on, and answers at the address as delivered.
    #[default]
    PowerUp,
    /// By layer setting services (CiA 305), also among other sensors with its address.
    Fastscan,
}

/// A sensor of the plan.
#[derive(Clone, Debug)]
pub struct Item {
    /// Its name, which it gets as its label.
    pub name: String,
    /// Its serial number; None: any.
    pub serial: Option<u32>,
    /// How it is found.
    pub find: Find,
    /// The present position becomes zero.
    pub zero: bool,
    /// Its product and its settings.
    pub settings: Backup,
    /// All of it as one line, which tells whether the plan was changed.
    pub text: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct File {
    #[serde(default)]
    alone: bool,
    #[serde(default)]
    sensor: Vec<Spanned<Row>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Row {
    name: Spanned<String>,
    product: Spanned<String>,
    serial: Option<Spanned<u32>>,
    find: Option<Spanned<Find>>,
    #[serde(default)]
    zero: Option<Spanned<bool>>,
    #[serde(default)]
    parameters: BTreeMap<String, Spanned<Value>>,
}

/// A fault at a place of the text.
type Wrong = (usize, Fault);

impl Plan {
    /// Reads a file, for a bus with this bit rate; None: the plan tells it.
    ///
    /// # Errors
    /// The file cannot be read, or is no plan: the line and the reason.
    pub fn read(path: &Path, rate: Option<BitRate>) -> Result<Self, Error> {
        let name = || path.display().to_string();
        let text = read_text(path).map_err(|unread| match unread {
            Unread::Failed(error) => FileError::PlanUnread(name(), error.to_string()),
            Unread::Unfit(why) => FileError::Plan(name(), 1, why.into()),
        })?;
        Self::parse(&text, rate).map_err(|(place, why)| {
            let before = text.get(..place).unwrap_or_default();
            let line = before.matches('\n').count() + 1;
            FileError::Plan(name(), line, why).into()
        })
    }

    fn parse(text: &str, rate: Option<BitRate>) -> Result<Self, Wrong> {
        let file: File = toml::from_str(text).map_err(|error| {
            let place = error.span().map_or(0, |span| span.start);
            (place, Fault::Reason(told(error.message())))
        })?;
        if file.sensor.is_empty() {
            return Err((0, Fault::EmptyPlan));
        }
        let mut plan = Self {
            alone: file.alone,
            given: rate,
            sensors: Vec::new(),
        };
        let mut places = Vec::new();
        for row in file.sensor {
            let place = row.span().start;
            let row = row.into_inner();
            let (name_at, serial_at) = (
                row.name.span().start,
                row.serial.as_ref().map(|own| own.span().start),
            );
            let item = Item::new(row)?;
            let mut others = plan.sensors.iter();
            if others.any(|other| other.name == item.name) {
                return Err((name_at, Fault::NameTwice(item.name)));
            }
            let is_same = |other: &Item| {
                let maker = item.product().maker;
                other.serial == item.serial && other.product().maker == maker
            };
            if let (Some(at), Some(serial)) = (serial_at, item.serial)
                && plan.sensors.iter().any(is_same)
            {
                return Err((at, Fault::SerialTwice(serial)));
            }
            plan.check(&item).map_err(|why| (place, why))?;
            plan.sensors.push(item);
            places.push(place);
        }
        let rate = plan.rate();
        let is_other =
            |item: &Item| !plan.alone && item.rate().is_some_and(|own| Some(own) != rate);
        let mut placed = plan.sensors.iter().zip(places);
        match placed.find(|(item, _)| is_other(item)) {
            Some((item, place)) => Err((place, Fault::RateOnBus(item.name.clone()))),
            None => Ok(plan),
        }
    }

    /// The bit rate of the bus that the sensors share: the selected one, that of a sensor as delivered, or the one that sensors get that
    /// detect it. None: each is alone, or all detect it.
    pub fn rate(&self) -> Option<BitRate> {
        let shared = || self.sensors.iter().filter(|_| !self.alone);
        let delivered = || shared().find_map(|item| factory_rate(item.product()));
        let detected = || shared().find_map(Item::rate);
        self.given.or_else(delivered).or_else(detected)
    }

    /// Checks a sensor against those before it, with which it shares the bus.
    fn check(&self, item: &Item) -> Result<(), Fault> {
        if self.alone {
            return Ok(());
        }
        let is_at = |target: Option<Target>, other: &Item| matches!((target, other.target()), (Some(one), Some(other)) if one.is_at(other));
        for other in &self.sensors {
            if is_at(item.target(), other) {
                return Err(Fault::AddressTwice(other.name.clone()));
            }
            // The sensors that come later have the address as delivered until it is their turn.
            if is_at(factory_target(item.product()), other) {
                return Err(Fault::AddressDelivered(other.name.clone()));
            }
            // Otherwise two sensors send one identifier, or one takes the messages of the other for requests.
            let own = item.identifiers(|id| item.number(id));
            let delivered = item.identifiers(|_| None);
            let mut others = other.identifiers(|id| other.number(id)).into_iter();
            let is_taken =
                |own: &[Identifier], used: &Identifier| own.iter().any(|own| own.collides(used));
            if let Some(used) =
                others.find(|used| is_taken(&own, used) || is_taken(&delivered, used))
            {
                let id = shown_id(CanId::from_bits(used.bits));
                return Err(Fault::IdentifierTwice(other.name.clone(), used.name, id));
            }
        }
        Ok(())
    }
}

/// An identifier that a sensor sends or takes, besides an address of its protocol.
struct Identifier {
    /// The name of its parameter.
    name: String,
    bits: u32,
    /// Several sensors can take it.
    is_shared: bool,
}

impl Identifier {
    fn collides(&self, other: &Self) -> bool {
        self.bits == other.bits && !(self.is_shared && other.is_shared)
    }
}

impl Item {
    fn new(row: Row) -> Result<Self, Wrong> {
        let at = |place: usize| move |error: Error| (place, Fault::Product(Box::new(error)));
        let name = labels::checked(row.name.as_ref()).map_err(|error| {
            let place = row.name.span().start;
            (place, Fault::Reason(error.to_string()))
        })?;
        let product = identify::product(row.product.as_ref());
        let product = product.map_err(at(row.product.span().start))?;
        let mut settings = Backup::of(&Sheet::of(product));
        // The resolution comes first: it is the unit of other values.
        let mut values: Vec<(String, Spanned<Value>)> = row.parameters.into_iter().collect();
        let sheet = settings.sheet.clone();
        let entry = |name: &str| sheet.entries.iter().find(|entry| entry.name == name);
        values.sort_by_key(|(name, _)| !entry(name).is_some_and(|own| sheet.is_resolution(own)));
        let zero = row.zero.as_ref().is_some_and(|zero| *zero.as_ref());
        let mut last = row.product.span().start;
        for (name, value) in &values {
            let place = value.span().start;
            last = last.max(place);
            let wrong = |why: NumberError| (place, why.into());
            let text = match value.as_ref() {
                Value::String(text) => text.clone(),
                Value::Integer(number) => number.to_string(),
                Value::Float(number) => number.to_string(),
                _ => return Err((place, Fault::NoQuotes(name.clone()))),
            };
            settings.set(name, &text).map_err(wrong)?;
            if zero && entry(name).is_some_and(|own| is_zero(&sheet, &own.origin)) {
                return Err((place, Fault::ZeroTwice(name.clone())));
            }
        }
        settings.constrain().map_err(|why| (last, why.into()))?;
        if let Some(zero_at) = row.zero.filter(|_| zero)
            && product.guide.zero.is_empty()
        {
            return Err((zero_at.span().start, Fault::NoZero(product.name)));
        }
        let find = row.find.as_ref().map(|own| *own.as_ref());
        let find = find.unwrap_or_default();
        let has_node_ids = tables(product).is_some_and(|own| own.lss);
        if let (Some(own), Find::Fastscan, false) = (&row.find, find, has_node_ids) {
            return Err((own.span().start, Fault::NoFastscan(product.name)));
        }
        let name_at = row.name.span().start;
        let values: Vec<String> = settings
            .values
            .iter()
            .map(|(entry, raw)| format!("{}={raw}", entry.name))
            .collect();
        let zeroed = if zero { " zero" } else { "" };
        let item = Self {
            name,
            serial: row.serial.map(Spanned::into_inner),
            find,
            zero,
            text: format!("{}{zeroed} {}", product.name, values.join(" ")),
            settings,
        };
        if find != Find::Fastscan {
            return Ok(item);
        }
        match (item.target(), factory_target(product)) {
            (Some(own), _) if own.node_id().is_none() => {
                Err((name_at, Fault::FastscanJ1939(item.name)))
            }
            (Some(own), Some(delivered)) if own.is_at(delivered) => {
                Err((name_at, Fault::FastscanAddress(item.name)))
            }
            _ => Ok(item),
        }
    }

    /// Its product.
    pub fn product(&self) -> &'static Product {
        self.settings.sheet.product
    }

    /// Whether it is of this product.
    pub fn is_of(&self, product: &Product) -> bool {
        self.product().name == product.name
    }

    /// Whether it is found in the same way, and answers at the same address and bit rate as delivered.
    pub fn is_found_as(&self, other: &Self) -> bool {
        let rates = [self, other].map(|item| factory_rate(item.product()));
        let targets = [self, other].map(|item| factory_target(item.product()));
        let is_at_same = matches!(targets, [Some(one), Some(two)] if one.is_at(two));
        self.find == other.find
            && rates[0] == rates[1]
            && (is_at_same || self.is_of(other.product()))
    }

    /// The number of a parameter in the plan.
    fn number(&self, id: ParameterId) -> Option<u32> {
        let mut values = self.settings.values.iter();
        let own = values.find(|(entry, _)| entry.origin == Origin::Parameter(id));
        own.map(|(_, raw)| *raw)
    }

    /// The roles in the protocol that it has at the end.
    fn roles(&self) -> Option<Roles> {
        let product = self.product();
        let selector = j1939::tables(product).and_then(|tables| tables.selector);
        let protocol = selector.and_then(|(id, canopen)| Some(self.number(id)? != canopen));
        match protocol {
            Some(true) => (j1939::PROTOCOL.roles)(product),
            _ => Roles::of(product),
        }
    }

    /// Its identifiers with these numbers; None: as delivered. Empty: they follow from its address.
    fn identifiers(&self, number: impl Fn(ParameterId) -> Option<u32>) -> Vec<Identifier> {
        let Some(roles) = self.roles().filter(|roles| !roles.identifiers.is_empty()) else {
            return Vec::new();
        };
        let ids = [roles.address].into_iter().chain(roles.identifiers);
        ids.filter_map(|id| {
            let mut entries = self.settings.sheet.entries.iter();
            let entry = entries.find(|own| own.origin == Origin::Parameter(id))?;
            Some(Identifier {
                name: entry.name.clone(),
                bits: number(id).or_else(|| factory(self.product(), id))?,
                is_shared: roles.shared == Some(id),
            })
        })
        .collect()
    }

    /// Where it is at the end.
    pub fn target(&self) -> Option<Target> {
        let roles = self.roles()?;
        let raw = self.number(roles.address);
        let raw = raw.or_else(|| factory(self.product(), roles.address))?;
        (roles.target)(raw).ok()
    }

    /// The bit rate that it gets; None: it keeps the bit rate as delivered, or detects it.
    pub fn rate(&self) -> Option<BitRate> {
        let (id, codes) = Roles::of(self.product())?.rate?;
        let raw = self.number(id)?;
        let (_, rate) = codes.into_iter().find(|(code, _)| *code == raw)?;
        rate
    }
}

/// Whether a parameter changes when the present position becomes zero.
fn is_zero(sheet: &Sheet, origin: &Origin) -> bool {
    let adjustments = sheet.product.guide.zero.iter();
    let mut ids = adjustments.flat_map(|adjustment| {
        let offset = adjustment.offset.map(|offset| offset.parameter);
        adjustment.writes.iter().map(|(id, _)| *id).chain(offset)
    });
    ids.any(|id| *origin == Origin::Parameter(id))
}

#[cfg(test)]
mod tests;
