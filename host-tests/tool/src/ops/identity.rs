//! The identity of a sensor: what it reports about itself.

use crate::eds::identity as data_sheet;
use crate::error::{Error, Fault, FileError, RequestError, SensorError};
use crate::identify;
use crate::note::Note;
use crate::output::Terminal;
use crate::session::Session;
use descriptors::unit::{self, Sheet, Value};
use plumbline::model::catalog::Product;
use plumbline::param::number;
use plumbline::store::Unit;
use serde::{Serialize, Serializer};
use serde_json::{Map, json};

/// The identity of a unit. As JSON: its values, and the sheet with them.
#[derive(Clone, Debug)]
pub struct SensorIdentity {
    /// What it is.
    pub product: &'static Product,
    /// The identity.
    pub unit: Unit,
}

impl Serialize for SensorIdentity {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let Self { product, unit } = self;
        let values = unit::fields(product).into_iter().map(|field| {
            let value = match field.value(unit) {
                Some(Value::Number(number)) => json!(number),
                Some(Value::Text(text)) => json!(text),
                None => json!(null),
            };
            (field.key.to_owned(), value)
        });
        let values: Map<_, _> = values.collect();
        json!({"product": product.name, "identity": values, "sheet": unit::sheet(product, unit)})
            .serialize(to)
    }
}

impl SensorIdentity {
    pub(super) fn lines(&self) -> Vec<String> {
        let fields = unit::fields(self.product).into_iter();
        let lines = fields.map(|field| {
            let value = field.shown(&self.unit);
            let value = value.as_deref().unwrap_or("as the product has it");
            format!("{:<17} {value:<34} {}", field.key, field.place)
        });
        lines.collect()
    }
}

/// Asks the sensor for its identity.
///
/// # Errors
/// The product is not known, nobody answers, or the adapter fails.
pub fn read(session: &mut Session, terminal: &mut Terminal) -> Result<SensorIdentity, Error> {
    let product = session.sheet.product;
    if session.sheet.data_sheet.is_some() {
        return Err(RequestError::NotInCatalogue.into());
    }
    let mut sheet = Sheet::default();
    for value in values(session, product)? {
        let one = Sheet {
            product: None,
            values: vec![value.clone()],
        };
        match one.unit(product) {
            Ok(_) => sheet.values.push(value),
            Err(why) => terminal.note(&Note::LeftOut(why)),
        }
    }
    let unit = sheet.unit(product);
    let unit = unit.map_err(SensorError::BadIdentity)?;
    Ok(SensorIdentity { product, unit })
}

/// Keys of a unit record with their values.
pub(crate) type Values = Vec<(&'static str, Value)>;

/// What the sensor reports; what it does not have is left out.
fn values(session: &mut Session, product: &Product) -> Result<Values, Error> {
    let target = session.target;
    let mut values = target.identity(session)?;
    let fields = unit::fields(product);
    values.retain(|(key, _)| fields.iter().any(|field| field.key == *key));
    Ok(values)
}

/// The values that are numbers.
pub(crate) fn numbers<const N: usize>(values: [(&'static str, Option<Vec<u8>>); N]) -> Values {
    let values = values.into_iter();
    let values = values.filter_map(|(key, bytes)| {
        let bytes = bytes.filter(|bytes| (1..=4).contains(&bytes.len()))?;
        Some((key, Value::Number(number(&bytes).into())))
    });
    values.collect()
}

/// The values that are texts.
pub(crate) fn texts<const N: usize>(values: [(&'static str, Option<Vec<u8>>); N]) -> Values {
    let values = values.into_iter();
    let values = values.filter_map(|(key, bytes)| {
        let text = String::from_utf8_lossy(&bytes?).into_owned();
        let text = text.trim_end_matches('\0').to_owned();
        (!text.is_empty()).then_some((key, Value::Text(text)))
    });
    values.collect()
}

/// The product and the identity in the text of a file. `name` is the wanted product.
///
/// # Errors
/// The product is not known, or cannot have this identity.
pub fn given(text: &str, shown: &str, name: Option<&str>) -> Result<SensorIdentity, Error> {
    let bad = |why: Fault| FileError::Identity(shown.to_owned(), why);
    let wanted = name.map(identify::product).transpose()?;
    let is_data_sheet = data_sheet::is_data_sheet(text);
    let mut sheet = Sheet::default();
    if !is_data_sheet {
        sheet = Sheet::parse(text).map_err(|why| bad(why.into()))?;
    }
    let product = wanted
        .or(sheet.product)
        .ok_or(RequestError::IdentityProduct)?;
    if is_data_sheet {
        sheet = data_sheet::sheet(text, product).map_err(bad)?;
    }
    let unit = sheet.unit(product).map_err(|why| bad(why.into()))?;
    Ok(SensorIdentity { product, unit })
}
