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
use crate::master::{Roles, Target, factory_rate, factory_target};
use crate::sheet::{Origin, Sheet};
use plumbline::can::BitRate;
use plumbline::model::catalog::Product;
use plumbline::param::ParameterId;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use texts::shown;
use toml::{Spanned, Value};

/// What is to be commissioned.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Each sensor is switched off before the next one is switched on.
    pub alone: bool,
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
    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read, or is no plan: the line and the reason.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let name = || path.display().to_string();
        let text = read_text(path).map_err(|unread| match unread {
            Unread::Failed(error) => FileError::PlanUnread(name(), error.to_string()),
            Unread::Unfit(why) => FileError::Plan(name(), 1, why.into()),
        })?;
        Self::parse(&text).map_err(|(place, why)| {
            let before = text.get(..place).unwrap_or_default();
            let line = before.matches('\n').count() + 1;
            FileError::Plan(name(), line, why).into()
        })
    }

    fn parse(text: &str) -> Result<Self, Wrong> {
        let file: File = toml::from_str(text).map_err(|error| {
            let place = error.span().map_or(0, |span| span.start);
            (place, Fault::Told(shown(error.message())))
        })?;
        if file.sensor.is_empty() {
            return Err((0, Fault::EmptyPlan));
        }
        let mut plan = Self {
            alone: file.alone,
            sensors: Vec::new(),
        };
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
                let maker = item.settings.sheet.product.maker;
                other.serial == item.serial && other.settings.sheet.product.maker == maker
            };
            if let (Some(at), Some(serial)) = (serial_at, item.serial)
                && plan.sensors.iter().any(is_same)
            {
                return Err((at, Fault::SerialTwice(serial)));
            }
            plan.check(&item).map_err(|why| (place, why))?;
            plan.sensors.push(item);
        }
        Ok(plan)
    }

    /// The bit rate of the bus that the sensors share; None: each is alone, or all detect it.
    pub fn rate(&self) -> Option<BitRate> {
        let products = self.sensors.iter().filter(|_| !self.alone);
        let mut rates = products.filter_map(|item| factory_rate(item.settings.sheet.product));
        rates.next()
    }

    /// Checks a sensor against those before it, with which it shares the bus.
    fn check(&self, item: &Item) -> Result<(), Fault> {
        if self.alone {
            return Ok(());
        }
        let rate = item.rate();
        if rate.is_some() && rate != factory_rate(item.settings.sheet.product) {
            return Err(Fault::RateOnBus(item.name.clone()));
        }
        let is_at = |target: Option<Target>, other: &Item| matches!((target, other.target()), (Some(one), Some(other)) if one.is_at(other));
        for other in &self.sensors {
            if is_at(item.target(), other) {
                return Err(Fault::AddressTwice(other.name.clone()));
            }
            // The sensors that come later have the address as delivered until it is their turn.
            if is_at(factory_target(item.settings.sheet.product), other) {
                return Err(Fault::AddressDelivered(other.name.clone()));
            }
        }
        Ok(())
    }
}

impl Item {
    fn new(row: Row) -> Result<Self, Wrong> {
        let at = |place: usize| move |error: Error| (place, Fault::Product(Box::new(error)));
        let name = labels::checked(row.name.as_ref()).map_err(|error| {
            let place = row.name.span().start;
            (place, Fault::Told(error.to_string()))
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
        let is_delivered = match (item.target(), factory_target(product)) {
            (Some(own), Some(delivered)) => own.is_at(delivered),
            _ => false,
        };
        match find == Find::Fastscan && is_delivered {
            true => Err((name_at, Fault::FastscanAddress(item.name))),
            false => Ok(item),
        }
    }

    /// Whether it is of this product.
    pub fn is_of(&self, product: &Product) -> bool {
        self.settings.sheet.product.name == product.name
    }

    /// The number of a parameter in the plan.
    fn number(&self, id: ParameterId) -> Option<u32> {
        let mut values = self.settings.values.iter();
        let own = values.find(|(entry, _)| entry.origin == Origin::Parameter(id));
        own.map(|(_, raw)| *raw)
    }

    /// Where it is at the end.
    pub fn target(&self) -> Option<Target> {
        let product = self.settings.sheet.product;
        let roles = Roles::of(product)?;
        match self.number(roles.address) {
            Some(raw) => (roles.target)(raw).ok(),
            None => factory_target(product),
        }
    }

    /// The bit rate that it gets; None: it keeps the bit rate as delivered, or detects it.
    pub fn rate(&self) -> Option<BitRate> {
        let (id, codes) = Roles::of(self.settings.sheet.product)?.rate?;
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
mod tests {
    use super::*;

    /// The line and the text of the fault of a plan.
    fn fault(text: &str) -> (usize, String) {
        let (place, why) = Plan::parse(text).map(|_| ()).unwrap_err();
        (text[..place].matches('\n').count() + 1, why.to_string())
    }

    const ONE: &str = "[[sensor]]\nname = \"one\"\nproduct = \"jn2101\"\n";

    #[test]
    fn plan_has_sensors_of_several_products() {
        let text = format!(
            "{ONE}serial = 7\nparameters.node-id = 11\n[[sensor]]\nname = \"two\"\nproduct = \"IS2\"\nzero = true\n[sensor.parameters]\ncyclic-time = \"0.25 s\"\n"
        );
        let plan = Plan::parse(&text).unwrap_or_else(|why| panic!("{why:?}"));
        let [one, two] = &plan.sensors[..] else {
            panic!("{plan:?}");
        };
        assert_eq!((one.serial, one.zero), (Some(7), false));
        assert_eq!(
            one.target().map(|own| own.named()).as_deref(),
            Some("node-ID 11")
        );
        assert_eq!((two.serial, two.zero), (None, true));
        let texts: Vec<String> = two
            .settings
            .values
            .iter()
            .map(|(entry, raw)| two.settings.text_of(entry, *raw))
            .collect();
        assert_eq!(texts, ["250 ms"]);
    }

    #[test]
    fn fault_of_a_plan_has_line_and_reason() {
        let again = |more: &str| format!("{ONE}parameters.node-id = 11\n[[sensor]]\n{more}");
        for (text, line, reason) in [
            (String::new(), 1, "has no sensor"),
            ("[[sensor]]\nname = \"a\"\n".to_owned(), 1, "product"),
            (
                "[[sensor]]\nname = \"\"\nproduct = \"is2\"\n".to_owned(),
                2,
                "name",
            ),
            (format!("{ONE}colour = 1\n"), 4, "colour"),
            (format!("{ONE}serial = -1\n"), 4, "-1"),
            (ONE.replace("jn2101", "jn21"), 3, "there is no product"),
            (
                format!("{ONE}[sensor.parameters]\nnode-id = 200\n"),
                5,
                "node-id",
            ),
            (
                format!("{ONE}[sensor.parameters]\nno-such = 1\n"),
                5,
                "no-such",
            ),
            (
                format!("{ONE}[sensor.parameters]\nnode-id = [1]\n"),
                5,
                "quotes",
            ),
            (again("name = \"one\"\nproduct = \"is2\"\n"), 6, "twice"),
            (
                again("name = \"two\"\nproduct = \"jn2101\"\nparameters.node-id = 11\n"),
                5,
                "same address as one",
            ),
            (
                format!(
                    "{ONE}[[sensor]]\nname = \"two\"\nproduct = \"jn2101\"\nparameters.node-id = 11\n"
                ),
                4,
                "as delivered",
            ),
            (
                format!("{ONE}find = \"fastscan\"\n"),
                4,
                "jn2101 has no fastscan",
            ),
            (
                format!("{ONE}find = \"fastscan\"\n").replace("jn2101", "ims360"),
                2,
                "node-id",
            ),
            (
                format!("{ONE}parameters.baud-rate = \"500 kbit/s\"\n"),
                1,
                "alone",
            ),
        ] {
            let (own, why) = fault(&text);
            assert!(own == line && why.contains(reason), "{text}: {own} {why}");
        }
        let alone = format!(
            "alone = true\n{ONE}parameters.baud-rate = \"500 kbit/s\"\n[[sensor]]\nname = \"two\"\nproduct = \"jn2101\"\n"
        );
        assert!(Plan::parse(&alone).is_ok());
    }
}
