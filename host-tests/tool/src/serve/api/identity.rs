//! The identity of a unit from a file of the browser, and its store file. The page does not choose the store file: it comes from the
//! command line.

use super::file::log;
use super::{Answer, App, parse};
use crate::error::{Error, FileError, PageError};
use crate::ops::identity::SensorIdentity;
use crate::ops::identity::given;
use crate::serve::line::Words;
use axum::body::Bytes;
use axum::extract::State;
use host_tests::store_file;
use serde::Deserialize;
use serde_json::{Value, json};
use std::sync::Arc;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Given {
    text: String,
    /// The name of the file.
    name: String,
    /// The product; None: the sheet names it.
    #[serde(default)]
    product: Option<String>,
}

impl Given {
    fn unit(&self) -> Result<SensorIdentity, Error> {
        given(&self.text, &self.name, self.product.as_deref())
    }

    /// The arguments of the command line.
    fn words(&self, store: Option<&str>) -> Words {
        let product = self.product.iter();
        let mut words: Words = product.map(|name| format!("--product={name}")).collect();
        words.extend(["identity".to_owned(), format!("--from={}", self.name)]);
        words.extend(store.map(|store| format!("--store={store}")));
        words
    }
}

/// Reads the identity in a file.
pub(super) async fn read(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    let file: Given = parse(&body)?;
    let unit = file.unit();
    log(&app, &file.words(None), unit.as_ref().err());
    Ok(axum::Json(json!(unit?)))
}

/// Writes the identity in a file into the store file.
pub(super) async fn write(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    let file: Given = parse(&body)?;
    let Some(store) = &app.store else {
        return Err(Error::from(PageError::NoStore).into());
    };
    let written = file.unit().and_then(|SensorIdentity { product, unit }| {
        let written = store_file::identify(product, &unit, store);
        written.map_err(|why| FileError::Store(why).into())
    });
    let words = file.words(Some(&store.display().to_string()));
    log(&app, &words, written.as_ref().err());
    written?;
    Ok(axum::Json(Value::Null))
}
