//! Changes values of a file.

use super::Backup;
use crate::error::NumberError;
use crate::sheet::Entry;

impl Backup {
    /// Sets a value from its text.
    ///
    /// # Errors
    /// The product has no such setting, or the value is not permitted.
    pub fn set(&mut self, name: &str, text: &str) -> Result<(), NumberError> {
        let entry = self
            .sheet
            .settings()
            .find(|entry| entry.name == name)
            .cloned();
        let entry = entry.ok_or_else(|| self.no_setting(name))?;
        if self.sheet.is_resolution(&entry) {
            return self.set_resolution(entry, text);
        }
        let raw = self.checked(&entry, text)?;
        self.put(entry, raw);
        Ok(())
    }

    /// Why a name is no setting of a file, with the next step.
    fn no_setting(&self, name: &str) -> NumberError {
        let mut entries = self.sheet.entries.iter();
        match entries.find(|entry| entry.name == name) {
            Some(entry) if entry.writable => NumberError::NotInFile(name.to_owned()),
            Some(entry) => entry.read_only(),
            None => NumberError::NoSetting(self.sheet.product.name, name.to_owned()),
        }
    }

    /// Sets the resolution. The values in its unit stay the same, so their raw numbers change.
    fn set_resolution(&mut self, entry: Entry, text: &str) -> Result<(), NumberError> {
        let raw = self.checked(&entry, text)?;
        let followers: Vec<(Entry, u32)> = self
            .values
            .iter()
            .filter(|(own, _)| self.sheet.follows_resolution(own))
            .cloned()
            .collect();
        let texts: Vec<(Entry, String)> = followers
            .into_iter()
            .map(|(own, raw)| {
                let text = self.text_of(&own, raw);
                (own, text)
            })
            .collect();
        let before = self.values.clone();
        self.put(entry, raw);
        for (own, text) in texts {
            match self.checked(&own, &text) {
                Ok(raw) => self.put(own, raw),
                Err(wrong) => {
                    self.values = before;
                    return Err(NumberError::First(Box::new(wrong)));
                }
            }
        }
        Ok(())
    }

    /// The raw number of a text, within the permitted values.
    fn checked(&self, entry: &Entry, text: &str) -> Result<u32, NumberError> {
        entry.accept(text, &self.scale_of(entry))
    }

    pub(super) fn put(&mut self, entry: Entry, raw: u32) {
        match self
            .values
            .iter_mut()
            .find(|(own, _)| own.name == entry.name)
        {
            Some((_, own)) => *own = raw,
            None => self.values.push((entry, raw)),
        }
    }
}
