//! The command line: the options of the bus, and those of each sensor.

use super::Failure;
use crate::server::Clock;
use bench::fault::FaultFrom;
use bench::scene::SceneArgument;
use clap::builder::PossibleValuesParser;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser};
use plumbline::can::BitRate;
use plumbline::model::catalog::{self, PRODUCTS, Product};
use std::ffi::OsString;
use std::path::PathBuf;

/// A CAN inclination sensor on a simulated bus. Clients speak slcan (LAWICEL ASCII) and share the bus.
///
/// Each further --model adds a sensor to the bus. The options of a sensor (--article, --elf, --bootloader, --key, --scene, --fault,
/// --store, --serial) follow its --model, all other options come before the second --model.
#[derive(Clone, Debug, Parser)]
#[command(name = "virtual-sensor", version)]
pub struct Program {
    #[command(flatten)]
    pub(super) model: Model,

    #[command(flatten)]
    pub(super) options: Options,

    #[arg(skip)]
    pub(super) others: Vec<Other>,
}

/// One more sensor on the bus.
#[derive(Clone, Debug, Parser)]
#[command(name = "virtual-sensor")]
pub(super) struct Other {
    #[command(flatten)]
    pub(super) model: Model,

    #[command(flatten)]
    pub(super) sensor: SensorOptions,
}

impl Other {
    /// Reads the part of the command line that begins with its --model.
    ///
    /// # Errors
    /// An option is not valid, or is one of the bus.
    fn of(words: Vec<OsString>) -> Result<Self, clap::Error> {
        Self::try_parse_from(words).map_err(|mut error| {
            let option = match error.get(ContextKind::InvalidArg) {
                Some(ContextValue::String(option)) => option.trim_start_matches('-').to_owned(),
                _ => return error,
            };
            let all = Program::command();
            let mut options = all.get_arguments().filter_map(clap::Arg::get_long);
            if error.kind() == ErrorKind::UnknownArgument && options.any(|own| own == option) {
                let tip = format!("write --{option} before the second --model");
                let tips = ContextValue::StyledStrs(vec![tip.into()]);
                error.insert(ContextKind::Suggested, tips);
            }
            error
        })
    }
}

/// The product of a sensor.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct Model {
    /// The sensor to simulate
    #[arg(long, default_value = "is2", ignore_case = true, value_parser = PossibleValuesParser::new(PRODUCTS.iter().map(|product| product.name)))]
    model: String,
}

impl Model {
    pub(super) fn product(&self) -> Result<&'static Product, Failure> {
        let unknown = || Failure::Usage(format!("there is no model {}", self.model));
        catalog::find(&self.model.to_lowercase()).ok_or_else(unknown)
    }
}

impl Program {
    /// Reads the command line. As usual, help and errors end the program.
    pub fn of_command_line(arguments: impl IntoIterator<Item = OsString>) -> Self {
        let mut sensors: Vec<Vec<OsString>> = vec![Vec::new()];
        let mut models = 0;
        for argument in arguments {
            let is_model = argument
                .to_str()
                .is_some_and(|text| text == "--model" || text.starts_with("--model="));
            models += usize::from(is_model);
            if is_model && models > 1 {
                // The name of the program, as on each command line.
                sensors.push(vec!["virtual-sensor".into()]);
            }
            sensors.last_mut().expect("one at least").push(argument);
        }
        let mut sensors = sensors.into_iter();
        let program = Self::parse_from(sensors.next().unwrap_or_default());
        let others = sensors.map(|words| Other::of(words).unwrap_or_else(|error| error.exit()));
        Self {
            others: others.collect(),
            ..program
        }
    }
}

/// A CAN inclination sensor on a simulated bus. Clients speak slcan (LAWICEL ASCII) and share the bus.
#[derive(Clone, Debug, Parser)]
pub struct Options {
    #[command(flatten)]
    pub(super) sensor: SensorOptions,

    /// Address to listen on for clients; port 0 picks a free one [default: 127.0.0.1:11898, or a free port if that one is in use]
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub(super) listen: Option<String>,

    /// Also create a pseudoterminal, for programs that need a serial port
    #[cfg(unix)]
    #[arg(long)]
    pub(super) pty: bool,

    /// The bit rate of the bus; clients and sensors with another rate are not connected [default: that of the first sensor, for clients
    /// with any rate]
    #[arg(long, value_name = "KBITS", value_parser = bench::bit_rate)]
    pub(super) bus_rate: Option<BitRate>,

    /// Also listen on this port of 127.0.0.1 (or at this address) for programs that move and break the sensor: lines of JSON, see the
    /// README of virtual-sensor. Port 0 picks a free one
    #[arg(long, value_name = "[ADDRESS:]PORT")]
    pub(super) control: Option<String>,

    /// Take part in the bus of this adapter, in real time: slcan:/dev/ttyACM0, slcan://HOST:PORT, can0 (Linux), usb or usb:SERIAL, pcan or
    /// pcan:USBBUS1. It is opened with the bit rate of the first sensor or of --bus-rate
    #[arg(long, value_name = "ADAPTER")]
    pub(super) on: Option<String>,

    /// Where the time comes from
    #[arg(long, value_enum, default_value_t)]
    pub(super) clock: Clock,

    /// Write the traffic to this file, in the format of candump -L
    #[arg(long, value_name = "FILE")]
    pub(super) log: Option<PathBuf>,
}

/// The options of one sensor.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct SensorOptions {
    /// The article of the sensor: its type name or order number [default: the first one]
    #[arg(long, value_name = "ARTICLE")]
    pub(super) article: Option<String>,

    /// Run this firmware image (an ELF file for one of the boards) on a simulated microcontroller, instead of the model
    /// built for the PC
    #[arg(long, value_name = "FILE")]
    pub(super) elf: Option<PathBuf>,

    /// The bootloader of the board (an ELF file), which starts the image of --elf, or waits for a program if there is none. Build the image
    /// with --features behind-bootloader
    #[arg(long, value_name = "FILE")]
    pub(super) bootloader: Option<PathBuf>,

    /// The public key in the flash of the bootloader, from `plumbline key show -o FILE`: it then takes only programs with a signature of
    /// this key
    #[arg(long, value_name = "FILE", requires = "bootloader")]
    pub(super) key: Option<PathBuf>,

    /// The motion of the sensor: tilt=X,Y (degrees, at rest; with one axis X is the angle, Y the cross slope) or a CSV file with
    /// the columns t_s,ax_g,ay_g,az_g[,gx_dps,gy_dps,gz_dps][,temp_c][,supply_v] [default: a slow sway]
    #[arg(long, allow_hyphen_values = true)]
    pub(super) scene: Option<SceneArgument>,

    /// A fault of the accelerometer: silent (it does not answer), stopped (it answers without values), frozen (its values do not
    /// change), zero (0 g in all axes), axis-x, axis-y, axis-z (0 g in this axis, also in the self-test) or clipping (an axis at
    /// the end of the range); SECONDS after the start, or from power-up. Repeatable: the one that began last counts
    #[arg(long, value_name = "accelerometer=FAULT[@SECONDS]")]
    pub(super) fault: Vec<FaultFrom>,

    /// Keep the nonvolatile memory in this file, so that a restart of the program is a power cycle
    #[arg(long, value_name = "FILE")]
    pub(super) store: Option<PathBuf>,

    /// The serial number, to which the records in the memory belong [default: the place of the sensor on the command line: 1, 2]
    #[arg(long, value_name = "NUMBER")]
    pub(super) serial: Option<u32>,
}

#[cfg(test)]
mod tests {
    use super::Other;

    #[test]
    fn option_of_the_bus_behind_the_second_model_is_followed_by_its_place() {
        let told = |option: &str| {
            let words = ["virtual-sensor", "--model", "is2", option, "125"];
            let error = Other::of(words.map(Into::into).to_vec()).expect_err(option);
            error.to_string()
        };
        for option in ["--bus-rate", "--listen", "--log"] {
            let place = format!("write {option} before the second --model");
            assert!(told(option).contains(&place), "{}", told(option));
        }
        assert!(!told("--nonsense").contains("before the second"));
    }
}
