//! Descriptions of the products for tools and documents, generated from the tables of the products.

mod dbc;
mod devicenet;
mod eds;
mod j1939;
mod markdown;
mod number;
mod objects;
pub mod unit;

pub use dbc::dbc;
pub use eds::eds;
pub use j1939::scale as signal_scale;
pub use markdown::{Table, table};

use plumbline::model::catalog::{Product, Protocol};
use plumbline::model::listing::canopen::Tables;
use plumbline::model::listing::canopen::Variant;

/// A description of a product in the format that its protocol uses.
pub struct File {
    /// Its name, for example `is2.dbc`.
    pub name: String,
    /// The text of the file, with the line ends that its format requires.
    pub text: String,
}

/// The description of a product: a CAN database (DBC) for FSC and J1939, or an Electronic Data Sheet (EDS) for CANopen and DeviceNet.
pub fn describe(product: &Product) -> File {
    match &product.protocol {
        Protocol::Fsc(tables) => File {
            name: format!("{}.dbc", product.name),
            text: dbc(product, tables),
        },
        Protocol::Canopen(tables) => data_sheet(product, tables, None),
        Protocol::Devicenet(tables) => File {
            name: format!("{}.eds", product.name),
            text: devicenet::eds(product, tables),
        },
        Protocol::J1939(tables) => File {
            name: format!("{}.dbc", product.name),
            text: j1939::dbc(product, &tables.j1939),
        },
    }
}

/// All descriptions of a product: [`describe`], an Electronic Data Sheet of each variant, and a CAN database of its J1939 groups.
pub fn describe_all(product: &Product) -> Vec<File> {
    let mut files = vec![describe(product)];
    if let Protocol::Canopen(tables) = &product.protocol {
        let variants = tables.variants.iter();
        files.extend(variants.map(|variant| data_sheet(product, tables, Some(variant))));
        files.extend(tables.j1939.iter().map(|tables| File {
            name: format!("{}_j1939.dbc", product.name),
            text: j1939::dbc(product, tables),
        }));
    }
    files
}

fn data_sheet(product: &Product, tables: &Tables, variant: Option<&Variant>) -> File {
    let name = match variant {
        Some(variant) => format!("{}_{}", product.name, variant.name),
        None => product.name.to_owned(),
    };
    File {
        text: eds(&name, product, tables, variant),
        name: format!("{name}.eds"),
    }
}

/// What a product is, in a line.
fn description(product: &Product, name: &str) -> String {
    let maker = product.maker;
    match product.is_replacement() {
        true => format!("Inclination sensor, compatible with {maker} {name}"),
        false => format!("Inclination sensor {name} of {maker}"),
    }
}

/// The comment at the start of a description.
fn notice(product: &Product, name: &str) -> Vec<String> {
    let maker = product.maker;
    if !product.is_replacement() {
        return vec![format!("{maker} {name}, with Plumbline, open firmware.")];
    }
    vec![
        format!("Plumbline, open firmware that is compatible with {maker} {name}."),
        format!("Neither the firmware nor this file is made or endorsed by {maker}."),
    ]
}
