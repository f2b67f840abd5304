//! Files of settings, without a sensor. The browser keeps the text; the server only reads and changes it.

use super::{Answer, App, parse};
use crate::backup::Backup;
use crate::error::{Error, FileError, PageError};
use crate::master::factory_target;
use crate::serve::events::{Kind, tell};
use crate::serve::line::{self, Words};
use crate::serve::sheets::{self, Sheets};
use crate::serve::worker::now;
use crate::sheet::{Entry, Sheet};
use axum::body::Bytes;
use axum::extract::State;
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::sync::Arc;

/// The longest file, as for `restore`.
const LONGEST: usize = 1 << 20;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Open {
    #[serde(default)]
    text: Option<String>,
    #[serde(default)]
    product: Option<String>,
    /// The key of the data sheet of the text.
    #[serde(default)]
    sheet: Option<String>,
}

/// Reads a file, or makes one with the factory values of a product.
pub(super) async fn open(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    let backup = match parse(&body)? {
        Open {
            text: Some(text),
            product: None,
            sheet,
        } => read(&text, &app.sheets, sheet.as_deref())?,
        Open {
            text: None,
            product: Some(product),
            sheet: None,
        } => factory(&app.sheets.sheet(&product)?),
        _ => {
            return Err(Error::from(PageError::TextOrProduct).into());
        }
    };
    Ok(axum::Json(document(&backup, &app.sheets)))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DataSheet {
    name: String,
    text: String,
}

/// Takes a data sheet. The answer is its row, which the other tabs get too.
pub(super) async fn data_sheet(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    let DataSheet { name, text } = parse(&body)?;
    let added = app.sheets.add(&name, &text);
    let words = [
        format!("--eds={}", sheets::shown(&name)),
        "parameters".to_owned(),
    ];
    log(&app, &words, added.as_ref().err());
    let row = added?.row();
    app.hub.publish(Kind::Sheets, &app.sheets.rows().into());
    Ok(axum::Json(row))
}

/// Shows an action that needs no sensor.
pub(super) fn log(app: &App, words: &[String], failure: Option<&Error>) {
    let mut action = json!({
        "n": app.hub.number(), "at": now(), "line": line::shown(words),
        "state": if failure.is_none() { "done" } else { "failed" },
    });
    if let Some(failure) = failure {
        tell(&mut action, failure);
    }
    app.hub.publish(Kind::Action, &action);
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Set {
    text: String,
    name: String,
    value: String,
    /// The name of the file, for the line.
    #[serde(default)]
    file: Option<String>,
    /// The key of its data sheet.
    #[serde(default)]
    sheet: Option<String>,
}

/// Changes a value in a file.
pub(super) async fn set(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    let set: Set = parse(&body)?;
    let changed = changed(&set, &app.sheets);
    let file = set.file.unwrap_or_else(|| "FILE.toml".to_owned());
    let kept = app.sheets.of(&set.text, set.sheet.as_deref());
    let mut words: Words = kept.iter().map(|kept| kept.option()).collect();
    words.extend(["set", "--file", &file].map(str::to_owned));
    line::positional(&mut words, &[format!("{}={}", set.name, set.value)]);
    log(&app, &words, changed.as_ref().err());
    Ok(axum::Json(changed?))
}

fn changed(set: &Set, sheets: &Sheets) -> Result<Value, Error> {
    let mut backup = read(&set.text, sheets, set.sheet.as_deref())?;
    backup.assign(&[format!("{}={}", set.name, set.value)])?;
    Ok(document(&backup, sheets))
}

fn read(text: &str, sheets: &Sheets, own: Option<&str>) -> Result<Backup, Error> {
    if text.len() > LONGEST {
        return Err(FileError::PageTooLong.into());
    }
    let read = sheets.backup(text, own);
    read.map_err(|why| FileError::PageBackup(why).into())
}

/// A file with the factory values of a product.
fn factory(sheet: &Sheet) -> Backup {
    let node = factory_target(sheet.product).and_then(|target| target.node_id());
    // A data sheet does not say the node-ID.
    let value = |entry: &Entry| {
        let own = if entry.node_relative { node?.into() } else { 0 };
        Some((entry.clone(), entry.factory?.wrapping_add(own)))
    };
    Backup {
        values: sheet.settings().filter_map(value).collect(),
        sheet: sheet.clone(),
        article: None,
        serial: None,
        label: None,
        firmware: None,
        node_id: None,
        texts: Vec::new(),
        taken: Vec::new(),
    }
}

/// A file for the page: its text, and its values by name.
pub fn document(backup: &Backup, sheets: &Sheets) -> Value {
    let values = backup.values.iter();
    let values = values.map(|(entry, raw)| (entry.name.clone(), backup.json_of(entry, *raw)));
    json!({
        "product": backup.sheet.product.name,
        "sheet": sheets.key(&backup.sheet),
        "article": backup.article,
        "serial": backup.serial,
        "label": backup.label,
        "firmware": backup.firmware,
        "text": backup.text(),
        "values": values.collect::<Map<_, _>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::model::catalog::PRODUCTS;

    #[test]
    fn file_with_factory_values_of_every_product_is_read_again() {
        for product in PRODUCTS {
            let made = factory(&Sheet::of(product));
            let sheets = Sheets::default();
            assert!(!made.values.is_empty(), "{}", product.name);
            let read = read(&made.text(), &sheets, None)
                .unwrap_or_else(|error| panic!("{} {error}", product.name));
            let [made, read] = [made, read].map(|file| document(&file, &sheets));
            assert_eq!(made, read, "{}", product.name);
        }
    }
}
