//! The rows of a data sheet before its texts have an owner.

use crate::number::Scale;
use crate::sheet::Entry;
use crate::sheet::rows::Row;
use plumbline::param::Meaning;
use std::collections::HashSet;

/// The greatest factor and the maximum number of decimals of a scale. Others are shown as the numbers of the protocol.
pub(crate) const GREATEST: i64 = 1_000_000_000;
pub(crate) const DECIMALS: u8 = 9;

/// A row whose texts have no owner yet.
pub(crate) struct Draft {
    pub row: Row,
    /// Its texts, if they are not those of the tables of a product.
    pub texts: Option<Texts>,
}

impl From<Row> for Draft {
    fn from(row: Row) -> Self {
        Self { row, texts: None }
    }
}

/// The texts of a sheet that stay until the end of the program, each once.
#[derive(Default)]
pub(super) struct Owner(HashSet<&'static str>);

impl Owner {
    pub(super) fn keep(&mut self, text: &str) -> &'static str {
        if let Some(own) = self.0.get(text) {
            return own;
        }
        let own: &'static str = String::leak(text.to_owned());
        self.0.insert(own);
        own
    }
}

/// The texts of a parameter, and its scale.
pub(crate) struct Texts {
    pub unit: String,
    pub scale: Factor,
    pub meanings: Vec<(u32, String)>,
}

impl Texts {
    /// Gives them to the entry.
    pub(super) fn give(self, entry: &mut Entry, owner: &mut Owner) {
        entry.scale = scale(owner.keep(&self.unit), self.scale);
        let meanings = self.meanings.iter();
        let meanings: Vec<Meaning> = meanings
            .map(|(number, name)| (*number, owner.keep(name)))
            .collect();
        entry.meanings = meanings.leak();
    }
}

/// The factor of a number: multiplier / 10^decimals.
#[derive(Clone, Copy)]
pub(crate) struct Factor {
    pub multiplier: i64,
    pub decimals: u8,
}

impl Factor {
    pub(crate) const ONE: Self = Self {
        multiplier: 1,
        decimals: 0,
    };
}

/// The scale of a number with this factor in a unit, which can begin with a number: `0.001 deg`.
fn scale(unit: &'static str, factor: Factor) -> Scale {
    let Factor {
        multiplier,
        decimals,
    } = factor;
    let scale = Scale::of(unit, decimals);
    let is_sensible = (1..=GREATEST).contains(&scale.multiplier) && scale.decimals <= DECIMALS;
    match multiplier {
        1 if is_sensible => scale,
        _ => Scale {
            multiplier,
            decimals,
            unit,
        },
    }
}
