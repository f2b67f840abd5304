//! The data sheets (EDS) of a server: the data sheet of the command line, and the data sheets that a page has sent.
//!
//! A page uses the key of a data sheet, `eds:1`, where it uses the name of a product. The lines of commands have the name of
//! the file. The server keeps the data sheets until it ends.

use crate::backup::{Backup, sensor_in};
use crate::eds;
use crate::error::{Error, Fault, FileError, PageError};
use crate::identify;
use crate::master::Protocol;
use crate::sheet::Sheet;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The longest file of a page, in bytes.
pub const LONGEST: usize = 1 << 20;

/// The beginning of a key.
const KEY: &str = "eds:";

/// A data sheet that the user has opened.
#[derive(Debug)]
pub struct Kept {
    /// The key by which the page refers to it.
    pub key: String,
    /// The name of the file, as the user knows it.
    pub name: String,
    /// The entries of the data sheet.
    pub sheet: Sheet,
}

impl Kept {
    /// The option that names the file.
    pub fn option(&self) -> String {
        format!("--eds={}", self.name)
    }

    /// As a row of the page.
    pub fn row(&self) -> Value {
        let Sheet {
            product,
            entries,
            data_sheet,
        } = &self.sheet;
        json!({
            "sheet": self.key,
            "name": product.name,
            "maker": product.maker,
            "protocol": Protocol::of(product).name,
            "file": self.name,
            "entries": entries.len(),
            "leftOut": data_sheet.as_ref().map(|data_sheet| data_sheet.left_out),
        })
    }
}

/// The data sheets of a server.
#[derive(Default)]
pub struct Sheets(Mutex<Vec<Arc<Kept>>>);

impl Sheets {
    fn kept(&self) -> MutexGuard<'_, Vec<Arc<Kept>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds the file of the command line.
    ///
    /// # Errors
    /// The file cannot be read, or is not a data sheet with parameters.
    pub fn read(&self, path: &Path) -> Result<Arc<Kept>, Error> {
        let sheet = eds::read(path)?;
        Ok(self.keep(path.to_string_lossy().into_owned(), sheet))
    }

    /// Adds a file of a page.
    ///
    /// # Errors
    /// It is not a data sheet with parameters, or is too long.
    pub fn add(&self, name: &str, text: &str) -> Result<Arc<Kept>, Error> {
        let bad = |why: Fault| FileError::PageEds(shown(name), why);
        if text.len() > LONGEST {
            return Err(bad(Fault::LongerThan1MiB).into());
        }
        let sheet = eds::parse(text.as_bytes()).map_err(bad)?;
        Ok(self.keep(shown(name), sheet))
    }

    fn keep(&self, name: String, sheet: Sheet) -> Arc<Kept> {
        let mut kept = self.kept();
        // The same file has the same product.
        let is_same = |own: &&Arc<Kept>| std::ptr::eq(own.sheet.product, sheet.product);
        if let Some(own) = kept.iter().find(is_same) {
            return own.clone();
        }
        let new = Arc::new(Kept {
            key: format!("{KEY}{}", kept.len() + 1),
            name,
            sheet,
        });
        kept.push(new.clone());
        new
    }

    /// The data sheet with this key; None: it is the name of a product.
    ///
    /// # Errors
    /// There is no such data sheet.
    pub fn find(&self, key: &str) -> Result<Option<Arc<Kept>>, Error> {
        if !key.starts_with(KEY) {
            return Ok(None);
        }
        let kept = self.kept();
        let found = kept.iter().find(|own| own.key == key).cloned();
        found.map(Some).ok_or_else(|| PageError::SheetGone.into())
    }

    /// The sheet of a product, or the data sheet with this key.
    ///
    /// # Errors
    /// There is none.
    pub fn sheet(&self, key: &str) -> Result<Sheet, Error> {
        Ok(match self.find(key)? {
            Some(kept) => kept.sheet.clone(),
            None => Sheet::of(identify::product(key)?),
        })
    }

    /// The key of a sheet: the name of its product, or the key of its data sheet.
    pub fn key(&self, sheet: &Sheet) -> String {
        let kept = self.kept();
        let own = kept
            .iter()
            .find(|own| std::ptr::eq(own.sheet.product, sheet.product));
        own.map_or(sheet.product.name.to_owned(), |own| own.key.clone())
    }

    /// The data sheet of a file with settings, if its product is not in the catalogue. Several data sheets can have the name of the
    /// product, for example the data sheets of two revisions. Then it is the one with the key `own`, otherwise the newest one.
    pub fn of(&self, text: &str, own: Option<&str>) -> Option<Arc<Kept>> {
        let (product, _) = sensor_in(text)?;
        let kept = self.kept();
        let fitting = || {
            let newest = kept.iter().rev();
            newest.filter(|one| one.sheet.product.name == product)
        };
        let first = fitting().find(|one| Some(one.key.as_str()) == own);
        first.or_else(|| fitting().next()).cloned()
    }

    /// Reads the text of a file with settings. `own` is the key of its data sheet, see [`of`](Self::of).
    ///
    /// # Errors
    /// See [`Backup::parse`].
    pub fn backup(&self, text: &str, own: Option<&str>) -> Result<Backup, Fault> {
        let kept = self.of(text, own);
        Backup::parse_with(text, kept.as_ref().map(|kept| &kept.sheet))
    }

    /// The rows of the page.
    pub fn rows(&self) -> Vec<Value> {
        self.kept().iter().map(|kept| kept.row()).collect()
    }
}

/// The name of a file without control characters, for the page.
pub fn shown(name: &str) -> String {
    match texts::shown(name) {
        name if name.is_empty() => "FILE.eds".to_owned(),
        name => name,
    }
}
