//! Writes the plots of the fusion of accelerometer and gyroscope (SIKO IMS360) into the folder beside the model.

use host_tests::plots::{folder, plots};
use std::process::ExitCode;

fn main() -> ExitCode {
    let folder = folder();
    if let Err(error) = std::fs::create_dir_all(&folder) {
        eprintln!("cannot create {}: {error}", folder.display());
        return ExitCode::FAILURE;
    }
    for plot in plots() {
        let path = folder.join(&plot.file);
        if let Err(error) = std::fs::write(&path, plot.svg) {
            eprintln!("cannot write {}: {error}", path.display());
            return ExitCode::FAILURE;
        }
        println!("{}", path.display());
    }
    ExitCode::SUCCESS
}
