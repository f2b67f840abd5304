//! `log`: the frames on the bus, and `decode`: what the frames in a log are.

use super::written::unwritten;
use crate::cli::Options;
use crate::cli::frames::Shown;
use crate::connect;
use crate::counted::{Frames, Lines};
use crate::decode::database::Database;
use crate::decode::filter::Filter;
use crate::decode::list::List;
use crate::decode::log::{INPUT, INTERFACE, Line, each};
use crate::decode::{Bus, Decoded};
use crate::eds;
use crate::error::{Error, RequestError, Silence};
use crate::identify;
use crate::link::Link;
use crate::master::canopen;
use crate::note::Note;
use crate::output::{Terminal, closed};
use crate::sheet::Sheet;
use adapter::{Adapter, Mode};
use can_wire::text::log_line;
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, after, millis};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::Path;
use std::time::{self, SystemTime, UNIX_EPOCH};

/// The longest wait without a check for Ctrl-C.
const SLICE: Duration = millis(50);

/// The time between two renewals of a list on a terminal.
const RENEWAL: Duration = millis(500);

/// The control sequence that clears a terminal.
const CLEAR: &str = "\x1B[H\x1B[2J";

/// What is shown of the frames.
pub(super) struct View {
    /// Finds out what a frame is; None: nobody needs it.
    bus: Option<Bus>,
    /// The meaning is shown.
    decodes: bool,
    filter: Filter,
    /// The list by identifier, if it is wanted instead of lines.
    list: Option<List>,
    unclear: Unclear,
}

/// What was shown without its meaning.
#[derive(Debug, Default)]
struct Unclear {
    /// The frames that are in no table.
    frames: u64,
    /// The nodes whose product is not known.
    nodes: BTreeSet<String>,
}

impl Unclear {
    fn take(&mut self, decoded: Option<&Decoded>) {
        match decoded {
            None => self.frames += 1,
            Some(own) => {
                let node = own.node.as_deref().unwrap_or_default();
                let node = format!("{} {node}", own.protocol);
                if own.needs_product {
                    self.nodes.insert(node);
                } else if own.product.is_some() {
                    // It has told it meanwhile.
                    self.nodes.remove(&node);
                }
            }
        }
    }

    /// Says how the meaning can be told.
    fn told(&self, terminal: &mut Terminal) {
        if !self.nodes.is_empty() {
            let nodes: Vec<&str> = self.nodes.iter().map(String::as_str).collect();
            terminal.note(&Note::ProductUnknown(nodes.join(", ")));
        }
        if self.frames > 0 {
            terminal.note(&Note::FramesUnknown(self.frames));
        }
    }
}

impl View {
    /// The products that can be on the bus are that of the options, or all.
    ///
    /// # Errors
    /// There is no such product or address, or a data sheet or database cannot be read.
    pub(super) fn new(options: &Options, shown: &Shown, decodes: bool) -> Result<Self, Error> {
        let sensor = options.sensor.target()?;
        let filter = Filter {
            terms: shown.which.terms.clone(),
            sensor: sensor.map(|target| (target.protocol().name, target.address())),
        };
        let needs_bus = decodes || filter.needs_meaning();
        let databases = shown
            .which
            .databases
            .iter()
            .map(|path| Database::read(path));
        let databases = databases.collect::<Result<Vec<_>, _>>()?;
        let bus = needs_bus.then(|| bus(options)).transpose()?;
        Ok(Self {
            bus: bus.map(|bus| bus.with(databases)),
            decodes,
            filter,
            list: shown.by_id.then(List::default),
            unclear: Unclear::default(),
        })
    }

    /// Takes all frames of a log before the first one is shown, because a node can tell its product late. Standard input is read only once.
    ///
    /// # Errors
    /// The file cannot be read or has no frame.
    pub(super) fn learn(&mut self, path: &Path, terminal: &mut Terminal) -> Result<(), Error> {
        if self.bus.is_some() && path != Path::new(INPUT) {
            each(path, terminal, &mut |_, line| {
                self.take(&line.frame);
                Ok(())
            })?;
        }
        self.unclear = Unclear::default();
        Ok(())
    }

    /// The meaning of the next frame, if it is shown; None: the frame is not shown.
    pub(super) fn take(&mut self, frame: &Frame) -> Option<Option<Decoded>> {
        let decoded = self.bus.as_mut().and_then(|bus| bus.decode(frame));
        let takes = self.filter.takes(frame, decoded.as_ref());
        if takes && self.decodes {
            self.unclear.take(decoded.as_ref());
        }
        takes.then(|| decoded.filter(|_| self.decodes))
    }
}

/// The products that can be on the bus.
fn bus(options: &Options) -> Result<Bus, Error> {
    if let Some(path) = &options.eds {
        let sheet = eds::read(path)?;
        return Ok(match canopen::tables(sheet.product) {
            Some(_) => Bus::beside(&sheet),
            None => Bus::of(sheet),
        });
    }
    Ok(match &options.product {
        Some(name) => Bus::of(Sheet::of(identify::product(name)?)),
        None => Bus::new(),
    })
}

/// A line of a log with the meaning of its frame.
fn shown(line: &str, decoded: Option<&Decoded>) -> String {
    match decoded {
        Some(decoded) => format!("{line}  {decoded}"),
        None => line.to_owned(),
    }
}

/// The same as a document.
fn document(line: &Line, decoded: Option<&Decoded>) -> Value {
    let mut document = Map::new();
    let time = line.time.parse::<f64>().ok();
    document.insert("time".to_owned(), time.into());
    document.insert("frame".to_owned(), format!("{:?}", line.frame).into());
    document.extend(decoded.map(Decoded::json).unwrap_or_default());
    document.into()
}

/// Says what the frames of a log are.
///
/// # Errors
/// The file cannot be read, or has no frame.
pub(super) fn decode(path: &Path, mut view: View, terminal: &mut Terminal) -> Result<(), Error> {
    view.learn(path, terminal)?;
    let others = each(path, terminal, &mut |terminal, line| {
        print(&line, &mut view, terminal)
    })?;
    if let Some(list) = &view.list {
        print_list(list, terminal)?;
    }
    if others > 0 {
        terminal.note(&Note::OtherLines(Lines(others)));
    }
    view.unclear.told(terminal);
    Ok(())
}

/// Prints the list by identifier.
fn print_list(list: &List, terminal: &mut Terminal) -> Result<(), Error> {
    terminal.document(&list.json())?;
    terminal.line(list.to_string().trim_end())
}

fn print(line: &Line, view: &mut View, terminal: &mut Terminal) -> Result<(), Error> {
    let Some(decoded) = view.take(&line.frame) else {
        return Ok(());
    };
    if let Some(list) = &mut view.list {
        list.take(line.micros(), &line.frame, decoded);
        return Ok(());
    }
    terminal.document(&document(line, decoded.as_ref()))?;
    terminal.line(shown(&line.to_string(), decoded.as_ref()))
}

/// The bit rate of the options, or that of the bus if the adapter needs one.
///
/// # Errors
/// There is no traffic, or the adapter fails.
pub(super) fn rate_of(
    link: &mut Link,
    rate: Option<BitRate>,
    terminal: &mut Terminal,
) -> Result<Option<BitRate>, Error> {
    if rate.is_some() || !link.adapter().capabilities().needs_rate {
        return Ok(rate);
    }
    let heard = connect::traffic(link, terminal)?;
    Ok(heard.ok_or(Silence::Traffic)?.rate)
}

/// Writes all frames on the bus; only listens.
pub(super) fn log(
    adapter: Box<dyn Adapter>,
    rate: Option<BitRate>,
    path: &Path,
    seconds: Option<Duration>,
    mut view: View,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let mut link = Link::new(adapter, &terminal.stopped);
    let rate = rate_of(&mut link, rate, terminal);
    let rate = rate.map_err(|failure| only_listens(&mut link, failure))?;
    let opened = link.open(rate, Mode::Listen);
    opened.map_err(|failure| only_listens(&mut link, failure))?;
    let start = link.now();
    let epoch = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    let is_output = path == Path::new("-");
    let mut file = match is_output {
        true => None,
        false => Some(BufWriter::new(
            File::create(path).map_err(|error| unwritten(path, &error))?,
        )),
    };
    let end = seconds.map(|seconds| after(start, seconds));
    let mut count = 0_u64;
    // A list is renewed only where it is seen.
    let is_renewed = terminal.bar.is_some() && io::stdout().is_terminal();
    let mut renewed = start;
    while !(terminal.stopped)() {
        let until = after(link.now(), SLICE);
        let until = end.map_or(until, |end| until.min(end));
        if let Some((at, frame)) = link.receive(until)? {
            let passed = Duration::from_ticks(at.ticks().saturating_sub(start.ticks()));
            let time = epoch + time::Duration::from_micros(passed.ticks());
            let line = log_line(time, INTERFACE, &frame);
            let taken = view.take(&frame);
            count += u64::from(taken.is_some());
            if let (Some(list), Some(decoded)) = (&mut view.list, &taken) {
                list.take(passed.ticks(), &frame, decoded.clone());
            }
            match (&mut file, taken) {
                (_, None) => {}
                (None, Some(_)) if view.list.is_some() => {}
                (Some(file), Some(decoded)) => {
                    let text = shown(&line, decoded.as_ref());
                    writeln!(file, "{text}").map_err(|error| unwritten(path, &error))?;
                }
                (None, Some(decoded)) if terminal.json && view.decodes => {
                    let line = Line::parse(&line);
                    let document = line.map(|line| document(&line, decoded.as_ref()));
                    terminal.document(&document.unwrap_or_default())?;
                }
                (None, Some(decoded)) => {
                    let text = shown(&line, decoded.as_ref());
                    writeln!(terminal.out, "{text}").map_err(closed)?;
                }
            }
        }
        if let Some(list) = view.list.as_ref().filter(|_| is_renewed)
            && link.now() >= after(renewed, RENEWAL)
        {
            renewed = link.now();
            write!(terminal.out, "{CLEAR}{list}").map_err(closed)?;
        }
        if end.is_some_and(|end| link.now() >= end) {
            break;
        }
    }
    let lost = link.adapter().overruns();
    link.close();
    if let Some(list) = &view.list {
        if is_renewed {
            write!(terminal.out, "{CLEAR}").map_err(closed)?;
        }
        match file {
            Some(_) => terminal.line(list.to_string().trim_end())?,
            None => print_list(list, terminal)?,
        }
    }
    if let Some(mut file) = file {
        file.flush().map_err(|error| unwritten(path, &error))?;
        let frames = Frames(count);
        terminal.line(format!("recorded {frames} in {}", path.display()))?;
        let file = path.display().to_string();
        let mut document = json!({"file": file, "frames": count, "lost": lost});
        if let Some(list) = &view.list {
            document["list"] = list.json();
        }
        terminal.document(&document)?;
    }
    if let Some(lost @ 1..) = lost {
        terminal.note(&Note::LostFrames(Frames(lost)));
    }
    view.unclear.told(terminal);
    Ok(())
}

/// The next step if an adapter cannot listen. An interface of Linux says itself what to type.
fn only_listens(link: &mut Link, failure: Error) -> Error {
    let sets_rate = link.adapter().capabilities().sets_rate;
    match failure.lacks_listen_only() && sets_rate {
        true => RequestError::LogListens.into(),
        false => failure,
    }
}
