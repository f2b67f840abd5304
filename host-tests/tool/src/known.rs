//! The names that the command line knows: completions offer them, and a message names the one that a user has probably meant.

use crate::connect::RATES;
use crate::error::Meant;
use crate::scan::kbits;
use crate::sheet::Sheet;
use clap::builder::{PossibleValue, TypedValueParser};
use clap::error::Error;
use clap::{Arg, Command};
use plumbline::model::catalog::PRODUCTS;
use std::collections::BTreeSet;
use std::convert::Infallible;
use std::ffi::OsStr;
use std::sync::LazyLock;

/// A parser of values whose names completions offer. It takes other values too.
#[derive(Clone)]
pub struct Known<P> {
    parser: P,
    names: fn() -> Vec<&'static str>,
}

/// A value that is only text.
///
/// # Errors
/// None.
pub fn text(value: &str) -> Result<String, Infallible> {
    Ok(value.to_owned())
}

/// A parser with these names.
pub fn known<P>(parser: P, names: fn() -> Vec<&'static str>) -> Known<P> {
    Known { parser, names }
}

impl<P: TypedValueParser> TypedValueParser for Known<P> {
    type Value = P::Value;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<Self::Value, Error> {
        self.parser.parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let names = (self.names)().into_iter();
        Some(Box::new(names.map(PossibleValue::new)))
    }
}

/// The products of the catalogue.
pub fn products() -> Vec<&'static str> {
    PRODUCTS.iter().map(|product| product.name).collect()
}

/// The bit rates in kbit/s.
pub fn rates() -> Vec<&'static str> {
    static TEXTS: LazyLock<Vec<String>> =
        LazyLock::new(|| RATES.map(|rate| kbits(rate).to_string()).to_vec());
    TEXTS.iter().map(String::as_str).collect()
}

/// The bit rates that a sensor can be given.
pub fn new_rates() -> Vec<&'static str> {
    [rates(), vec!["auto"]].concat()
}

/// The names of all products, of groups and parameters.
pub fn parameters() -> Vec<&'static str> {
    static NAMES: LazyLock<BTreeSet<String>> = LazyLock::new(|| {
        let sheets = PRODUCTS.iter().map(|product| (product, Sheet::of(product)));
        let names = sheets.flat_map(|(product, sheet)| {
            let groups = product.guide.groups.iter();
            let groups = groups.map(|(group, _)| (*group).to_owned());
            let entries = sheet.entries.into_iter().map(|entry| entry.name);
            groups.chain(entries).collect::<Vec<_>>()
        });
        names.collect()
    });
    NAMES.iter().map(String::as_str).collect()
}

/// The beginnings of assignments.
pub fn assignments() -> Vec<&'static str> {
    static TEXTS: LazyLock<Vec<String>> =
        LazyLock::new(|| parameters().iter().map(|name| format!("{name}=")).collect());
    TEXTS.iter().map(String::as_str).collect()
}

/// The least similarity of a name that a user can have meant.
const SIMILAR: f64 = 0.8;

/// The name that a user has probably meant: one that is similar as a whole, else one with a similar word.
pub fn meant<'a>(typed: &str, names: impl IntoIterator<Item = &'a str>) -> Meant {
    let small = typed.to_lowercase();
    let names: Vec<_> = names.into_iter().collect();
    let best = |similarity: &dyn Fn(&str) -> f64| {
        let rated = names.iter().map(|name| (similarity(name), *name));
        let best = rated.max_by(|one, other| one.0.total_cmp(&other.0));
        best.filter(|(similarity, _)| *similarity >= SIMILAR)
    };
    let whole = |name: &str| strsim::jaro_winkler(&small, &name.to_lowercase());
    let word = |name: &str| name.split(['-', ' ']).map(whole).fold(0.0, f64::max);
    match best(&whole).or_else(|| best(&word)) {
        Some((_, name)) => Meant::Name(name.to_owned()),
        None => Meant::Nothing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn similar_name_is_asked_about_and_another_one_is_not() {
        for (typed, names, expected) in [
            ("is22", products(), ". Did you mean is2?"),
            ("JN2110", products(), ". Did you mean jn2101?"),
            ("tiltix36", products(), ". Did you mean tiltix360?"),
            ("cyclictime", parameters(), ". Did you mean cyclic-time?"),
            ("filtre", parameters(), ". Did you mean filter?"),
            ("cuttoff", parameters(), ". Did you mean cut-off?"),
            (
                "temprature",
                vec!["filter", "mems-temperature"],
                ". Did you mean mems-temperature?",
            ),
            ("xyzzy", products(), ""),
            ("xyzzy", parameters(), ""),
            ("", products(), ""),
        ] {
            assert_eq!(meant(typed, names).to_string(), expected, "{typed}");
        }
    }
}
