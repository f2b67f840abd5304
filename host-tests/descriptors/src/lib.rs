//! Descriptions of the models for other tools, written from the models' own tables.

mod dbc;
mod eds;
mod markdown;
mod objects;

pub use dbc::dbc;
pub use eds::eds;
pub use markdown::{object_table, parameters};

use plumbline::fsc::table::Field;

/// A field's name as one identifier: `Set-Parameter-ID` becomes `SetParameterID`.
fn identifier(name: &str) -> String {
    name.split([' ', '-']).map(capitalised).collect()
}

fn capitalised(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_ascii_uppercase().to_string() + letters.as_str()
    })
}

/// A number of a field as the value it stands for, for example -9000 with two decimals as `-90.00`.
fn value(field: &Field, number: i64) -> String {
    let decimals = usize::from(field.decimals);
    format!(
        "{:.decimals$}",
        number as f64 / 10f64.powi(field.decimals.into())
    )
}
