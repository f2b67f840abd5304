//! Writes the models' descriptions for other tools: a CAN database (DBC) or, of CANopen models, a data sheet (EDS) of each.

use clap::Parser;
use descriptors::{dbc, eds};
use plumbline::model::is1::OneAxis;
use plumbline::model::is2::TwoAxes;
use plumbline::model::{is1tk, is2tk, jn2101};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Writes the description of every model, from its own table, as MODEL.dbc or MODEL.eds
#[derive(Parser)]
struct Options {
    /// Folder to write to; it is made if it does not exist.
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
    for (file, text) in [
        ("is1.dbc", dbc::<OneAxis>("is1")),
        ("is2.dbc", dbc::<TwoAxes>("is2")),
        ("is1d.dbc", dbc::<OneAxis>("is1d")),
        ("is2d.dbc", dbc::<TwoAxes>("is2d")),
        ("is1tk.dbc", dbc::<is1tk::OneAxis>("is1tk")),
        ("is2tk.dbc", dbc::<is2tk::TwoAxes>("is2tk")),
        (
            "jn2101.eds",
            eds::<jn2101::Application>("jn2101", "ifm electronic"),
        ),
    ] {
        let path = out.join(file);
        std::fs::write(&path, text)?;
        println!("{}", path.display());
    }
    Ok(())
}
