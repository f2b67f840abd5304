//! The options of all commands, and which command uses them.

use super::Cli;
use crate::error::{Error, RequestError};
use crate::known::{known, products, rates, text};
use crate::master::{Addresses, NewAddress};
use crate::question::Name;
use clap::{Args, CommandFactory, Subcommand};
use plumbline::can::BitRate;
use plumbline::time::Duration;
use std::path::PathBuf;

/// The options of all commands.
#[derive(Clone, Debug, Default, Args)]
pub struct Options {
    /// The adapter: slcan://HOST:PORT, slcan:/dev/ttyACM0, can0 (Linux), usb or usb:SERIAL, pcan or pcan:USBBUS1, demo:PRODUCT
    #[arg(long, global = true, env = "PLUMBLINE_PORT", value_name = "PORT")]
    pub port: Option<String>,
    /// The bit rate in kbit/s [default: listens for it]
    #[arg(long, global = true, value_name = "KBITS", value_parser = known(bench::bit_rate, rates))]
    pub rate: Option<BitRate>,
    /// The address of the sensor
    #[command(flatten)]
    pub sensor: Addresses,
    /// The product, if the sensor does not report it
    #[arg(long, global = true, value_name = "NAME", value_parser = known(text, products))]
    pub product: Option<String>,
    /// The data sheet (EDS) of a CANopen or DeviceNet device that is not in the catalogue
    #[arg(long, global = true, value_name = "FILE", conflicts_with = "product")]
    pub eds: Option<PathBuf>,
    /// The folder with the names of sensors [default: plumbline in the folder for settings of the user]
    #[arg(
        long,
        global = true,
        env = "PLUMBLINE_CONFIG",
        value_name = "DIR",
        hide_env_values = true
    )]
    pub config: Option<PathBuf>,
    /// Print one JSON document
    #[arg(long, global = true)]
    pub json: bool,
    /// Answer all questions with yes, or those with these names: --yes=zero,overwrite
    #[arg(
        long,
        global = true,
        value_name = "QUESTIONS",
        num_args = 0..=1,
        require_equals = true,
        value_delimiter = ',',
        default_missing_value = "all"
    )]
    pub yes: Vec<Name>,
}

/// The command line, in which the help of a command shows only the options that it uses.
pub fn command() -> clap::Command {
    let mut command = Cli::command();
    // Gives the commands the options of all commands.
    command.build();
    command.mut_subcommands(|own| {
        let name = own.get_name().to_owned();
        hide(own, &name).mut_subcommands(|part| hide(part, &name))
    })
}

/// Hides the options in the help that the command with this name does not use.
fn hide(command: clap::Command, name: &str) -> clap::Command {
    let unused = unused(name);
    command.mut_args(|option| {
        let id = option.get_id().as_str();
        let is_unused = match Addresses::protocol(id) {
            // The command of another protocol.
            Some(protocol) => unused.contains(&ADDRESSES) || !protocol.permits(name),
            None => unused.contains(&id),
        };
        let is_hidden = option.is_hide_set() || is_unused;
        option.hide(is_hidden)
    })
}

/// The options with an address.
const ADDRESSES: &str = "addresses";

/// The options that a command does not use.
fn unused(command: &str) -> &'static [&'static str] {
    const ALL: [&str; 8] = [
        "json", "yes", "config", "port", "rate", ADDRESSES, "product", "eds",
    ];
    match command {
        "completions" | "man" | "help" => &ALL,
        "ports" => &ALL[1..],
        "image" | "key" => &ALL[2..],
        "calibrate" => &["config", "port", "rate", ADDRESSES, "eds"],
        "decode" => &["yes", "config", "port", "rate"],
        "log" | "replay" => &["config"],
        "commission" => &[ADDRESSES, "product", "eds"],
        "doctor" => &["config", "product", "eds"],
        "send" => &["config", ADDRESSES, "product", "eds"],
        "bridge" => &["product", "eds"],
        "scan" => &[ADDRESSES, "product", "eds"],
        "rate" | "zero" | "teach" | "align" => &["eds"],
        _ if NewAddress::has_subcommand(command) => &["eds"],
        _ => &[],
    }
}

/// The time of `--seconds`.
///
/// # Errors
/// It is out of range.
pub fn time(seconds: Option<f64>) -> Result<Option<Duration>, Error> {
    match seconds {
        None => Ok(None),
        Some(seconds) if (0.0..=1e9).contains(&seconds) => {
            let ticks = (seconds * 1e6) as u64;
            Ok(Some(Duration::from_ticks(ticks)))
        }
        Some(_) => Err(RequestError::Seconds.into()),
    }
}
