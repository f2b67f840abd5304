//! The command line.

use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use plumbline::can::BitRate;
use std::path::PathBuf;

/// Finds, sets, shows and records CAN inclination sensors: those of Plumbline and the makers' own.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "plumbline",
    version,
    after_help = "Exit codes: 0 done, 1 refused by the sensor, 2 usage, 3 nobody answers, 4 bus or adapter.\nWithout hardware: plumbline --port demo:is2 get"
)]
pub struct Cli {
    /// The options of all commands
    #[command(flatten)]
    pub options: Options,
    /// The command
    #[command(subcommand)]
    pub command: Command,
}

/// The options of all commands.
#[derive(Clone, Debug, Default, Args)]
pub struct Options {
    /// The adapter: slcan://HOST:PORT, slcan:/dev/ttyACM0, can0 (Linux), demo:PRODUCT
    #[arg(long, global = true, env = "PLUMBLINE_PORT", value_name = "PORT")]
    pub port: Option<String>,
    /// The bit rate in kbit/s [default: listens for it]
    #[arg(long, global = true, value_name = "KBITS", value_parser = bit_rate)]
    pub rate: Option<BitRate>,
    /// The Set-Parameter-ID of a GEMAC sensor, hexadecimal: 300, or 8 digits for 29 bits
    #[arg(long, global = true, value_name = "HEX")]
    pub id: Option<String>,
    /// The node-ID of a CANopen sensor
    #[arg(long, global = true, value_name = "N")]
    pub node: Option<u8>,
    /// The MAC ID of a DeviceNet sensor
    #[arg(long, global = true, value_name = "N")]
    pub mac: Option<u8>,
    /// The product, if the sensor does not say it
    #[arg(long, global = true, value_name = "NAME")]
    pub product: Option<String>,
    /// Print one JSON document
    #[arg(long, global = true)]
    pub json: bool,
    /// Answer all questions with yes
    #[arg(long, global = true)]
    pub yes: bool,
}

/// What to zero.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum Axis {
    /// The first axis
    X,
    /// The second axis
    Y,
}

impl Axis {
    /// The name in the guide of a product.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
        }
    }
}

/// A command.
#[derive(Clone, Debug, Subcommand)]
pub enum Command {
    /// Find sensors: listens at all bit rates, then asks
    Scan {
        /// Ask at a silent bus without a question
        #[arg(long)]
        active: bool,
        /// Also ask for GEMAC sensors at all 2048 identifiers of 11 bits: 41 s at each rate
        #[arg(long)]
        search: bool,
    },
    /// List the names with range, unit and factory value
    Parameters,
    /// Read parameters and values; without a name all of them
    Get {
        /// Names, or beginnings of their words
        names: Vec<String>,
    },
    /// Write parameters, for example filter=2.5Hz,butterworth zero-x=1.25deg
    Set {
        /// NAME=VALUE; raw:N is the number of the protocol
        #[arg(required = true)]
        assignments: Vec<String>,
        /// Store them afterwards
        #[arg(long, conflicts_with = "file")]
        save: bool,
        /// Change a file of `backup` instead of a sensor
        #[arg(long, value_name = "FILE")]
        file: Option<PathBuf>,
    },
    /// Store the parameters in the sensor
    Save,
    /// Load the factory values
    LoadFactory,
    /// Make the present position zero
    Zero {
        /// One axis only
        axis: Option<Axis>,
        /// Store it afterwards
        #[arg(long)]
        save: bool,
    },
    /// Make the present position the reference frame of the machine (JN2101)
    Teach {
        /// Store it afterwards
        #[arg(long)]
        save: bool,
    },
    /// Restart the sensor
    Restart,
    /// Change the node-ID of a CANopen sensor: writes, stores, restarts, checks
    NodeId {
        /// The new node-ID, 1 to 127
        new: u8,
    },
    /// Change the MAC ID of a DeviceNet sensor and check it
    Mac {
        /// The new MAC ID, 0 to 63
        new: u8,
    },
    /// One request: code and data (GEMAC), INDEX:SUB[=DATA] (CANopen), service class instance data (DeviceNet), hexadecimal
    Raw {
        /// The request
        request: String,
    },
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
        #[arg(long, value_name = "NAME", num_args = 1..)]
        only: Vec<String>,
    },
    /// Show the settings of a file that differ from the sensor
    Diff {
        /// A TOML file of `backup`
        file: PathBuf,
    },
    /// Show the angles
    Watch {
        /// The pause between two samples in ms
        #[arg(long, default_value_t = 200, value_name = "MS", value_parser = clap::value_parser!(u32).range(1..=60_000))]
        every: u32,
        /// End after this time
        #[arg(long, value_name = "S")]
        seconds: Option<f64>,
    },
    /// Record the angles as CSV
    Record {
        /// The file
        file: PathBuf,
        /// The pause between two samples in ms
        #[arg(long, default_value_t = 20, value_name = "MS", value_parser = clap::value_parser!(u32).range(1..=60_000))]
        every: u32,
        /// End after this time
        #[arg(long, value_name = "S")]
        seconds: Option<f64>,
    },
    /// Write all frames on the bus as `candump -L` does; only listens
    Log {
        /// The file; - is standard output
        file: PathBuf,
        /// End after this time
        #[arg(long, value_name = "S")]
        seconds: Option<f64>,
    },
    /// Print the completions for a shell
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page
    Man,
}

/// One of the ten bit rates, in kbit/s.
fn bit_rate(text: &str) -> Result<BitRate, String> {
    let wanted = text.parse::<f64>().ok();
    let kbits = |rate: &BitRate| f64::from(rate.bits_per_second()) / 1000.0;
    let mut rates = BitRate::ALL.into_iter();
    rates
        .find(|rate| Some(kbits(rate)) == wanted)
        .ok_or_else(|| {
            let all: Vec<String> = BitRate::ALL
                .iter()
                .map(|rate| kbits(rate).to_string())
                .collect();
            format!("the bit rates are {} kbit/s", all.join(", "))
        })
}
