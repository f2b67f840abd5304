//! Writes descriptions of the products for other tools: a CAN database (DBC) or an Electronic Data Sheet (EDS) for each.

use clap::Parser;
use descriptors::{describe_all, unit};
use plumbline::model::catalog::{PRODUCTS, Product};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Writes the description of every product, or of one unit, as PRODUCT.dbc or PRODUCT.eds, and of every variant as PRODUCT_VARIANT.eds
#[derive(Parser)]
struct Options {
    /// Folder to write to; it is created if it does not exist
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Write only the descriptions of one product, with the identity of a unit: a sheet of `plumbline identity --output`
    #[arg(long, value_name = "FILE")]
    unit: Option<PathBuf>,
}

fn main() -> ExitCode {
    let Options { out, unit } = Options::parse();
    let products = match unit {
        None => Ok(PRODUCTS.to_vec()),
        Some(path) => product_of(&path).map(|product| vec![product]),
    };
    let written = products.and_then(|products| {
        write(&out, &products).map_err(|error| format!("{}: {error}", out.display()))
    });
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// The product of a unit, with the identity of the unit.
fn product_of(path: &Path) -> Result<Product, String> {
    let name = path.display();
    let text =
        std::fs::read_to_string(path).map_err(|error| format!("cannot read {name}: {error}"))?;
    let read = || {
        let sheet = unit::Sheet::parse(&text)?;
        let product = sheet
            .product
            .ok_or("the line product = \"NAME\" is missing")?;
        Ok(unit::with_unit(product, &sheet.unit(product)?))
    };
    read().map_err(|why: String| format!("{name}: {why}"))
}

fn write(out: &Path, products: &[Product]) -> std::io::Result<()> {
    std::fs::create_dir_all(out)?;
    for file in products.iter().flat_map(describe_all) {
        let path = out.join(&file.name);
        std::fs::write(&path, file.text)?;
        println!("{}", path.display());
    }
    Ok(())
}
