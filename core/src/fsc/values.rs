//! The values of the device parameters: range checks, factory values, and their bytes in the EEPROM image.
//!
//! In the image the values stand one behind the other in the order of [`Key`], each in its own size, little-endian:
//!
//! ```text
//!  byte 0       4         8        12   13    14    16   17       20       22       24
//!       Set-ID  Reply-ID  Sync-ID  BR   ABOR  CYT   CYM  CF, FT   zero X   zero Y   (2-axis)
//! ```

use super::key::{KEYS, Key};
use super::table::{Permitted, Rule};
use super::wire;
use crate::measure::low_pass::Kind;
use embedded_can::Id;

/// The three keys that are identifiers.
const IDENTIFIERS: [Key; 3] = [Key::SetId, Key::ReplyId, Key::SyncId];

/// The values of all parameters of one sensor, each as the little-endian number that its bytes make.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Values {
    values: [u32; KEYS],
    /// A bit for each row that does not have its factory value, so that a write need not compare them all.
    changed: u16,
}

impl Values {
    /// The factory values.
    pub fn factory(rules: &[Rule]) -> Self {
        let mut values = [0; KEYS];
        for (value, rule) in values.iter_mut().zip(rules) {
            *value = rule.factory;
        }
        Self { values, changed: 0 }
    }

    /// The value of one parameter; 0 for one that the model does not have.
    pub fn get(&self, key: Key) -> u32 {
        self.at(key as usize)
    }

    /// The value of the parameter in row `row`.
    pub fn at(&self, row: usize) -> u32 {
        self.values.get(row).copied().unwrap_or(0)
    }

    /// The identifier in force for `key`; None only for a value that [`permits`](Self::permits) would refuse.
    pub fn identifier(&self, key: Key) -> Option<Id> {
        wire::identifier(self.get(key))
    }

    /// Whether `value` may be written to the parameter in row `row`, the other parameters being what they are.
    pub fn permits(&self, row: usize, rule: &Rule, value: u32) -> bool {
        match rule.permitted {
            Permitted::Unsigned(min, max) => (min.into()..=max.into()).contains(&value),
            Permitted::Signed(min, max) => (min..=max).contains(&(value as i16)),
            Permitted::CutOff => filter(value).is_some(),
            Permitted::Identifier => {
                let free = |&key: &Key| key as usize == row || self.get(key) != value;
                wire::identifier(value).is_some() && IDENTIFIERS.iter().all(free)
            }
        }
    }

    /// Sets the parameter in row `row` to a value that [`permits`](Self::permits) has let pass.
    pub fn set(&mut self, row: usize, rule: &Rule, value: u32) {
        if let Some(place) = self.values.get_mut(row) {
            *place = value;
            let bit = 1 << row;
            self.changed &= !bit;
            if value != rule.factory {
                self.changed |= bit;
            }
        }
    }

    /// True when every parameter has its factory value.
    pub fn is_factory(&self) -> bool {
        self.changed == 0
    }

    /// The bytes of the image.
    pub fn encode(&self, rules: &[Rule]) -> impl Iterator<Item = u8> {
        self.values
            .into_iter()
            .zip(rules)
            .flat_map(|(value, rule)| value.to_le_bytes().into_iter().take(rule.size.into()))
    }

    /// The values in the bytes of an image; None unless every single one is permitted.
    pub fn decode(rules: &[Rule], mut bytes: &[u8]) -> Option<Self> {
        let mut values = Self::factory(rules);
        for (row, rule) in rules.iter().enumerate() {
            values.set(row, rule, wire::number(bytes, rule.size)?);
            bytes = bytes.get(rule.size.into()..)?;
        }
        let valid = |(row, rule)| values.permits(row, rule, values.at(row));
        (bytes.is_empty() && rules.iter().enumerate().all(valid)).then_some(values)
    }

    /// Whether automatic bus-off recovery is on (section 9.10.4).
    pub fn recovers(&self) -> bool {
        self.get(Key::BusOffRecovery) != 0
    }

    /// Whether cyclic mode is on.
    pub fn is_cyclic(&self) -> bool {
        self.get(Key::CyclicMode) != 0
    }

    /// The kind of filter and its cut-off frequency in mHz.
    pub fn filter(&self) -> (Kind, u16) {
        filter(self.get(Key::Filter)).unwrap_or((Kind::Off, 100))
    }
}

/// The kind of filter and its cut-off frequency in mHz that a written value stands for: CF in the lower two bytes, FT in the
/// third. None when they do not fit each other; the frequency counts even while the filter is off.
fn filter(value: u32) -> Option<(Kind, u16)> {
    let cutoff = value as u16;
    let kind = match value >> 16 {
        0 => Kind::Off,
        1 => Kind::Butterworth,
        2 => Kind::CriticallyDamped,
        _ => return None,
    };
    kind.cutoffs().contains(&cutoff).then_some((kind, cutoff))
}
