//! The command line.

pub mod bridge;
pub mod frames;
mod options;
pub mod replace;
mod words;

pub use options::{Options, command, time};
pub use words::parse;

use crate::known::{known, parameters, text};
use crate::ops::Request;
use clap::{Parser, Subcommand};
use clap_complete::Shell;
use std::net::SocketAddr;
use std::path::PathBuf;

/// Finds, sets, shows and records CAN inclination sensors: those of Plumbline and the makers' own.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "plumbline",
    version,
    after_help = "Exit codes: 0 done, 1 refused by the sensor, 2 usage, 3 no sensor answers, 4 bus, adapter, file or broker, 130 Ctrl-C.\nWithout hardware: plumbline --port demo:is2 get"
)]
pub struct Cli {
    /// The options of all commands
    #[command(flatten)]
    pub options: Options,
    /// The command
    #[command(subcommand)]
    pub command: Command,
}

/// A command.
#[derive(Clone, Debug, Subcommand)]
pub enum Command {
    /// Find sensors: listens at all bit rates, then sends requests
    Scan {
        /// Send requests on a bus without traffic, without a question to the user
        #[arg(long)]
        active: bool,
        /// Also send requests for GEMAC sensors to all 2048 identifiers of 11 bits; with all other addresses at least 50 s at 250 kbit/s
        #[arg(long)]
        search: bool,
    },
    /// List the names with range, unit and factory value
    Parameters,
    /// An operation on a sensor
    #[command(flatten)]
    Operation(Request),
    /// Store all settings of the sensor in a file
    Backup {
        /// A TOML file
        file: PathBuf,
    },
    /// Write the settings of a file that differ, store them, and read them back
    Restore {
        /// A TOML file of `backup`
        file: PathBuf,
        /// Only these parameters
        #[arg(long, value_name = "NAME", num_args = 1.., value_parser = known(text, parameters), hide_possible_values = true)]
        only: Vec<String>,
    },
    /// Show the settings of a file that differ from the sensor
    Diff {
        /// A TOML file of `backup`
        file: PathBuf,
        /// End with exit code 1 if a setting differs
        #[arg(long)]
        exit_code: bool,
    },
    /// Compensate the mounting offset: reads the angles at rest, asks to turn the sensor by 180 deg, reads again; the mean is the offset
    Align {
        /// Store it afterwards
        #[arg(long)]
        save: bool,
    },
    /// Show the angles
    Watch {
        /// Other values than the angles, by the names of `parameters`
        #[arg(value_name = "NAME", value_parser = known(text, parameters), hide_possible_values = true)]
        names: Vec<String>,
        /// The pause between two samples in ms
        #[arg(long, default_value_t = 200, value_name = "MS", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=60_000))]
        every: u32,
        /// The sensor sends the angles by itself (DeviceNet: answers to polls); its settings are put back afterwards
        #[arg(long, conflicts_with = "names")]
        cyclic: bool,
        /// End after this time
        #[arg(long, value_name = "S", allow_negative_numbers = true)]
        seconds: Option<f64>,
    },
    /// Record the angles as CSV
    Record {
        /// The file
        file: PathBuf,
        /// Other values than the angles, by the names of `parameters`
        #[arg(value_name = "NAME", value_parser = known(text, parameters), hide_possible_values = true)]
        names: Vec<String>,
        /// The pause between two samples in ms
        #[arg(long, default_value_t = 20, value_name = "MS", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=60_000))]
        every: u32,
        /// The sensor sends the angles by itself (DeviceNet: answers to polls); its settings are put back afterwards
        #[arg(long, conflicts_with = "names")]
        cyclic: bool,
        /// End after this time
        #[arg(long, value_name = "S", allow_negative_numbers = true)]
        seconds: Option<f64>,
    },
    /// Write all frames on the bus as `candump -L` does; only listens
    Log {
        /// The file; - is standard output
        file: PathBuf,
        /// Append the decoded meaning to each frame
        #[arg(long)]
        decode: bool,
        /// Which frames
        #[command(flatten)]
        filter: frames::Shown,
        /// End after this time
        #[arg(long, value_name = "S", allow_negative_numbers = true)]
        seconds: Option<f64>,
    },
    /// Decode the frames of a log: product, message, values with their units
    Decode {
        /// The log, as `log` and `candump -L` write it; - is standard input
        file: PathBuf,
        /// Which frames
        #[command(flatten)]
        filter: frames::Shown,
    },
    /// Send the frames of a log with their spacing. Devices on the bus can act on them: machines can move
    Replay(frames::Replay),
    /// Send frames, once or periodically. Devices on the bus can act on them: machines can move
    Send(frames::Sending),
    /// Calibrate a sensor of this project: guides through six positions with the log of the board, then computes the calibration
    Calibrate {
        /// The measurement, a CSV file. One that is not complete is continued
        file: PathBuf,
        /// Write the calibration into this store file of the unit; needs --product
        #[arg(long, value_name = "FILE")]
        store: Option<PathBuf>,
        /// The serial number of the unit [default: that in the log or in the measurement]
        #[arg(long, value_name = "N")]
        serial: Option<u32>,
        /// The command that prints the log, for example -- cargo bluepill is2; without it nothing is measured
        #[arg(last = true, value_name = "COMMAND")]
        log: Vec<String>,
    },
    /// Show the identity of the sensor (vendor, product code, revision, serial number, names), or give it to a unit of this project that replaces it
    Identity {
        /// Take the identity from this file instead of the connected sensor: an EDS, a DCF, or a sheet of --output; needs --product, unless the sheet names it
        #[arg(long, value_name = "FILE", conflicts_with = "from_sensor")]
        from: Option<PathBuf>,
        /// Take the identity of the connected sensor
        #[arg(long)]
        from_sensor: bool,
        /// Write a sheet of the values, which can be edited
        #[arg(long, value_name = "FILE")]
        output: Option<PathBuf>,
        /// Write the identity into this store file of the new unit
        #[arg(long, value_name = "FILE")]
        store: Option<PathBuf>,
    },
    /// Show a page in the browser that finds, shows and sets sensors
    Serve {
        /// Where to listen; only this computer reaches the default. Port 0 takes a free port
        #[arg(long, default_value = "127.0.0.1:8080", value_name = "ADDRESS:PORT")]
        listen: SocketAddr,
        /// Open the page in the browser; other users of this computer can read its address, with the secret, in the list of processes
        #[arg(long)]
        open: bool,
        /// Connect at once; without --port to a virtual sensor
        #[arg(long)]
        demo: bool,
        /// The measurement of a unit that the page calibrates, a CSV file as that of `calibrate`
        #[arg(long, value_name = "FILE")]
        calibrate: Option<PathBuf>,
        /// The store file of the unit, for its identity; with --calibrate also for its calibration, which needs --product
        #[arg(long, value_name = "FILE")]
        store: Option<PathBuf>,
        /// The serial number of the unit [default: that in the log or in the measurement]
        #[arg(long, value_name = "N", requires = "calibrate")]
        serial: Option<u32>,
        /// The command that prints the log of the unit, for example -- cargo bluepill is2
        #[arg(last = true, value_name = "COMMAND", requires = "calibrate")]
        log: Vec<String>,
    },
    /// Make the image file of an update from the ELF file of a program that is built behind a bootloader
    Image {
        /// The ELF file
        elf: PathBuf,
        /// The image file
        #[arg(long, short, value_name = "FILE")]
        output: PathBuf,
        /// The bootloader of the board (an ELF file), for --hex
        #[arg(long, value_name = "FILE", requires = "hex")]
        bootloader: Option<PathBuf>,
        /// Also write an Intel HEX file with bootloader and program, which a probe flashes first
        #[arg(long, value_name = "FILE", requires = "bootloader")]
        hex: Option<PathBuf>,
    },
    /// Create, show and use the key that signs image files
    Key {
        /// What it does
        #[command(subcommand)]
        command: KeyCommand,
    },
    /// Update the firmware of a sensor from an image file
    Update {
        /// The image file, from `image`
        file: PathBuf,
        /// Also load an older version
        #[arg(long)]
        downgrade: bool,
        /// Update all sensors of the product on the bus, one after the other
        #[arg(long)]
        all: bool,
        /// Do not write the settings into a file before
        #[arg(long)]
        no_backup: bool,
    },
    /// Commission the sensors of a plan (TOML) one after the other: name, settings, zero, store, compare. The same command continues where it stopped
    Commission {
        /// The plan
        plan: PathBuf,
        /// Write the report into this file
        #[arg(long, value_name = "FILE")]
        report: Option<PathBuf>,
        /// How long to wait for the next sensor, in seconds
        #[arg(long, value_name = "S", default_value_t = 600, value_parser = clap::value_parser!(u32).range(1..=86_400))]
        wait: u32,
    },
    /// Replace a sensor: save the old sensor to a file, then configure the new one and compare both
    Replace {
        /// The step
        #[command(subcommand)]
        step: replace::Replace,
    },
    /// Diagnose the bus: load, errors, duplicate identifiers, frames without acknowledgement, a missing terminator, a wrong bit rate
    Doctor {
        /// How long to listen [default: 5]
        #[arg(long, value_name = "S", allow_negative_numbers = true)]
        seconds: Option<f64>,
        /// Also send requests to the sensors; on a bus without traffic to the factory addresses
        #[arg(long)]
        active: bool,
    },
    /// Publish the angles, the status and the identity of the sensor at an address, or of all sensors on the bus: to an MQTT broker, or the roll to AgOpenGPS
    Bridge(Box<bridge::Bridge>),
    /// List the ports of this computer
    Ports,
    /// Print the completions for a shell
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print a manual page
    Man {
        /// The page of this command [default: that of the program]
        #[arg(conflicts_with = "out")]
        command: Option<String>,
        /// Write all pages into this folder
        #[arg(long, value_name = "FOLDER")]
        out: Option<PathBuf>,
    },
}

/// What `key` does.
#[derive(Clone, Debug, clap::Subcommand)]
pub enum KeyCommand {
    /// Create a private key for 1024 signatures
    New {
        /// The file of the key
        file: PathBuf,
    },
    /// Show the number of a key and how many signatures are left
    Show {
        /// The file of the key
        file: PathBuf,
        /// Write the public key, which a probe programs into the bootloader
        #[arg(long, short, value_name = "FILE")]
        output: Option<PathBuf>,
    },
    /// Sign an image file
    Sign {
        /// The image file, from `image`
        file: PathBuf,
        /// The file of the key
        #[arg(long, value_name = "FILE")]
        key: PathBuf,
        /// The signed image file
        #[arg(long, short, value_name = "FILE")]
        output: PathBuf,
    },
}

#[cfg(test)]
mod tests {
    use super::{Cli, Command};
    use clap::Parser;

    #[test]
    fn page_is_served_only_to_this_computer_by_default() {
        let cli = Cli::try_parse_from(["plumbline", "serve"]).unwrap();
        let Command::Serve { listen, .. } = cli.command else {
            panic!("{cli:?}");
        };
        assert!(listen.ip().is_loopback(), "{listen}");
    }
}
