//! Descriptions of the products for tools and documents, generated from the tables of the products.

mod dbc;
mod eds;
mod markdown;
mod number;
mod objects;

pub use dbc::dbc;
pub use eds::eds;
pub use markdown::{Table, table};

use plumbline::model::catalog::{Product, Protocol};

/// A description of a product in the format that its protocol uses.
pub struct File {
    /// Its name, for example `is2.dbc`.
    pub name: String,
    /// Its content.
    pub text: String,
}

/// The description of a product: a CAN database (DBC), or an Electronic Data Sheet (EDS) for CANopen.
pub fn describe(product: &Product) -> File {
    let (extension, text) = match &product.protocol {
        Protocol::Fsc(tables) => ("dbc", dbc(product, tables)),
        Protocol::Canopen(tables) => ("eds", eds(product, tables)),
    };
    File {
        name: format!("{}.{extension}", product.name),
        text,
    }
}
