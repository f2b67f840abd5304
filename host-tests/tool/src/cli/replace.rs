//! The steps of a replacement, on the command line.

use clap::Subcommand;
use std::path::PathBuf;

/// A step of a replacement.
#[derive(Clone, Debug, Subcommand)]
pub enum Replace {
    /// Read the old sensor: settings, identity, every reply, the angles at rest
    Read {
        /// The file, which `restore` takes too
        file: PathBuf,
    },
    /// Write the settings into the new sensor, store them, and compare both sensors
    Write {
        /// The file of `replace read`
        file: PathBuf,
        /// Write the report as a text to sign
        #[arg(long, value_name = "FILE")]
        report: Option<PathBuf>,
        /// Write the identity of the old sensor into this store file of the new unit
        #[arg(long, value_name = "FILE")]
        store: Option<PathBuf>,
    },
}
