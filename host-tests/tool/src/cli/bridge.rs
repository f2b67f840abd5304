//! The options of `bridge`.

use clap::{Args, ValueEnum};
use std::net::SocketAddr;
use std::path::PathBuf;

/// Where the angles of all sensors go.
#[derive(Clone, Debug, Args)]
pub struct Bridge {
    /// The MQTT broker: mqtt://HOST, mqtts://HOST with TLS, or with :PORT
    #[arg(long, value_name = "URL")]
    pub mqtt: Option<String>,
    /// A TOML file with the lines username = "NAME" and password = "PASSWORD"
    #[arg(long, value_name = "FILE", requires = "mqtt")]
    pub credentials: Option<PathBuf>,
    /// The certificate of the authority of the broker, in PEM [default: those of this computer]
    #[arg(long, value_name = "FILE", requires = "mqtt")]
    pub ca: Option<PathBuf>,
    /// The certificate of this computer, in PEM
    #[arg(long, value_name = "FILE", requires = "mqtt", requires = "key")]
    pub certificate: Option<PathBuf>,
    /// The private key of this computer, in PEM
    #[arg(long, value_name = "FILE", requires = "certificate")]
    pub key: Option<PathBuf>,
    /// The first part of all topics, for example the number of the machine
    #[arg(long, value_name = "NAME", default_value = "plumbline")]
    pub site: String,
    /// The second part of all topics [default: the name of the port]
    #[arg(long, value_name = "NAME")]
    pub bus: Option<String>,
    /// The first part of the topics for the discovery by Home Assistant; empty: none
    #[arg(long, value_name = "NAME", default_value = "homeassistant")]
    pub discovery: String,
    /// The folder for what the broker has not acknowledged yet [default: one for each site and bus in the folder for settings]
    #[arg(long, value_name = "DIR")]
    pub buffer: Option<PathBuf>,
    /// The maximum length of the files in this folder, in MiB
    #[arg(long, value_name = "MIB", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..))]
    pub buffer_size: u32,
    /// Send the roll to AgOpenGPS as this module
    #[arg(long, value_name = "MODULE")]
    pub agopengps: Option<Module>,
    /// Where AgOpenGPS is
    #[arg(
        long,
        value_name = "ADDRESS:PORT",
        requires = "agopengps",
        default_value = "192.168.5.255:9999"
    )]
    pub agopengps_to: SocketAddr,
    /// The angle that is the roll, by the names of `watch` [default: the first one]
    #[arg(long, value_name = "NAME", requires = "agopengps")]
    pub axis: Option<String>,
    /// The shortest pause between two samples of a sensor in ms
    #[arg(long, default_value_t = 200, value_name = "MS", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=60_000))]
    pub every: u32,
    /// Find sensors with requests on a bus without traffic, without a question to the user
    #[arg(long)]
    pub active: bool,
    /// End after this time
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub seconds: Option<f64>,
}

/// A module of AgOpenGPS.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum Module {
    /// PGN 211, whose heading is always 0: for a heading from two antennas
    Imu,
    /// PGN 253, which says that there is no heading: without another steering module
    Steer,
}
