//! Writes descriptions of the products for other tools: a CAN database (DBC) or an Electronic Data Sheet (EDS) for each.

use clap::Parser;
use descriptors::describe_all;
use plumbline::model::catalog::PRODUCTS;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Writes the description of every product as PRODUCT.dbc or PRODUCT.eds, and of every variant as PRODUCT_VARIANT.eds
#[derive(Parser)]
struct Options {
    /// Folder to write to; it is created if it does not exist
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

fn main() -> ExitCode {
    let Options { out } = Options::parse();
    match write(&out) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{}: {error}", out.display());
            ExitCode::FAILURE
        }
    }
}

fn write(out: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(out)?;
    for file in PRODUCTS.iter().flat_map(describe_all) {
        let path = out.join(&file.name);
        std::fs::write(&path, file.text)?;
        println!("{}", path.display());
    }
    Ok(())
}
