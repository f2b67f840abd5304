//! The options of the commands for frames.

use crate::decode::filter::Term;
use can_wire::text::parse;
use clap::Args;
use plumbline::can::Frame;
use std::path::PathBuf;
use std::str::FromStr;

/// Which frames are taken.
#[derive(Clone, Debug, Default, Args)]
pub struct Which {
    /// Only frames with this identifier (181, 18EEFF80), with an identifier under a mask (181:7F0; 181~7F0: all others), or with these words in their meaning (heartbeat, "canopen 10", is2); one of several is sufficient. With --id, --node, --mac or --address only those of this sensor
    #[arg(long = "filter", value_name = "TERM", value_delimiter = ',')]
    pub terms: Vec<Term>,
    /// A CAN database (DBC) of other devices on the bus; it can be given several times
    #[arg(long = "dbc", value_name = "FILE")]
    pub databases: Vec<PathBuf>,
}

/// Which frames are shown, and how.
#[derive(Clone, Debug, Default, Args)]
pub struct Shown {
    /// Which frames
    #[command(flatten)]
    pub which: Which,
    /// Show a list by identifier: count, mean period, newest data and meaning. On a terminal `log` renews it; otherwise it is printed at the end
    #[arg(long)]
    pub by_id: bool,
}

/// What `replay` sends.
#[derive(Clone, Debug, Args)]
pub struct Replay {
    /// The log, as `log` and `candump -L` write it, or the documents of `log - --decode --json`; - is standard input, which is first read to its end
    pub file: PathBuf,
    /// Which frames
    #[command(flatten)]
    pub which: Which,
    /// Only the frames of this interface of the log
    #[arg(long, value_name = "NAME")]
    pub interface: Option<String>,
    /// Speed factor of the replay, 0.01 to 100
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, allow_negative_numbers = true, value_parser = speed)]
    pub speed: f64,
    /// Begin again after the last frame, until Ctrl-C or --seconds
    #[arg(long = "loop")]
    pub repeats: bool,
    /// End after this time
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub seconds: Option<f64>,
}

/// The factor of a speed.
///
/// # Errors
/// It is not permitted.
pub fn speed(text: &str) -> Result<f64, String> {
    let speed = text.parse().ok();
    let speed = speed.filter(|speed| (0.01..=100.0).contains(speed));
    speed.ok_or_else(|| "it is 0.01 to 100".to_owned())
}

/// What `send` sends.
#[derive(Clone, Debug, Args)]
pub struct Sending {
    /// Frames as in a log (181#0102, 18EAFFFE#00EE00, 60A#R4), or a TOML file with a list: `[[send]]`, `frame = "181#0102"` and, for a periodic frame, `every = 100` (ms)
    #[arg(required = true, value_name = "FRAME or LIST")]
    pub what: Vec<Sent>,
    /// Send the frames of the command line repeatedly, with this period in ms
    #[arg(long, value_name = "MS", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=3_600_000))]
    pub every: Option<u32>,
    /// End after this time
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub seconds: Option<f64>,
}

/// A frame, or a file with frames.
#[derive(Clone, Debug)]
pub enum Sent {
    /// A frame.
    Frame(Frame),
    /// A list.
    List(PathBuf),
}

impl FromStr for Sent {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.contains('#') {
            true => frame(text).map(Self::Frame),
            false => Ok(Self::List(text.into())),
        }
    }
}

/// The frame of a text that a person writes: an identifier of 11 bits can have less than three digits.
///
/// # Errors
/// One sentence: the text is no frame.
pub fn frame(text: &str) -> Result<Frame, String> {
    let digits = text.find('#').unwrap_or(0);
    let padded = match digits {
        1 | 2 => format!("{text:0>width$}", width = text.chars().count() + 3 - digits),
        _ => text.to_owned(),
    };
    parse(&padded).map_err(|_| {
        format!("{text:?} is no frame: write identifier#data with up to 3 hexadecimal digits or 8, and up to 8 bytes, for example 181#0102")
    })
}
