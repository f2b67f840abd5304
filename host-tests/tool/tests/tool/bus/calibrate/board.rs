//! A unit on a bench, its log, and its user.

use crate::bus::files::file;
use clap::Parser;
use plumbline_tool::cli::Cli;
use plumbline_tool::command::run_with;
use plumbline_tool::error::Error;
use plumbline_tool::output::Terminal;
use plumbline_tool::question::Question;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, Instant};

/// The offset of the accelerometer in g.
const OFFSET: [f64; 3] = [0.02, -0.03, 0.05];

/// Its response to 1 g along each axis.
const RESPONSE: [[f64; 3]; 3] = [[1.02, 0.01, 0.0], [-0.01, 0.97, 0.02], [0.005, 0.0, 1.01]];

/// The angular rate at rest in 0.001 deg/s.
pub const RATE: [i32; 3] = [310, -20, 5];

/// The raw acceleration in 10^-6 g with a side up.
pub fn raw(side: &str) -> [i32; 3] {
    let axis = ["x", "y", "z"].iter().position(|name| side.ends_with(name));
    let axis = axis.expect("an axis");
    let sign = if side.starts_with('-') { -1.0 } else { 1.0 };
    std::array::from_fn(|i| ((OFFSET[i] + sign * RESPONSE[axis][i]) * 1e6).round() as i32)
}

/// 3 s of the log at a temperature in 0.01 degC.
fn log(serial: u32, element: Option<&str>, side: &str, temperature: i32) -> String {
    let ([x, y, z], [gx, gy, gz]) = (raw(side), RATE);
    let mut text = format!("0.000012 [INFO ] serial number {serial}\nnot a message\n");
    if let Some(element) = element {
        text.insert_str(0, &format!("0.00001 [INFO ] measuring element {element}\n"));
    }
    for place in 0..600 {
        // Noise with a mean of 0.
        let noise = if place % 2 == 0 { 900 } else { -900 };
        let (x, y) = (x + noise, y - noise);
        text += &format!(
            "0.06 [DEBUG] acceleration {x} {y} {z} ug, {temperature} 0.01 degC, rate {gx} {gy} {gz} mdps (app.rs:330)\n"
        );
    }
    text
}

/// A unit on a bench: the sides to which it is turned, one after the other.
pub struct Board {
    pub serial: u32,
    /// The measuring element in the log.
    pub element: Option<&'static str>,
    pub temperature: i32,
    pub position: PathBuf,
    pub measurement: PathBuf,
    pub store: PathBuf,
    /// What the user does when a note contains a text, one after the other: the sides that the log prints from then on. With more than
    /// one side, the unit moves all the time.
    pub reactions: RefCell<VecDeque<(&'static str, &'static [&'static str])>>,
}

/// The file to which the log adds a byte each time that it has printed a position.
fn count(position: &Path) -> PathBuf {
    position.with_extension("count")
}

/// Waits until the log has printed the position this many more times.
pub fn wait_for_prints(position: &Path, times: u64) {
    let path = count(position);
    let printed = || std::fs::metadata(&path).map_or(0, |own| own.len());
    let end = printed() + times;
    let start = Instant::now();
    while printed() < end {
        assert!(start.elapsed() < PATIENCE, "the log has ended");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// How long the log can take.
const PATIENCE: Duration = Duration::from_secs(60);

/// The end of a run.
#[derive(Debug)]
pub struct Ended {
    pub result: Result<(), Error>,
    pub out: String,
    pub notes: String,
    pub questions: Vec<String>,
}

impl Board {
    pub fn new(name: &str) -> Self {
        Self {
            serial: 7,
            element: None,
            temperature: 25_10,
            position: file(&format!("calibrate-{name}.log")),
            measurement: file(&format!("calibrate-{name}.csv")),
            store: file(&format!("calibrate-{name}.bin")),
            reactions: RefCell::default(),
        }
    }

    /// The log prints this text from now on.
    fn print(&self, text: &str) {
        let part = self.position.with_extension("part");
        std::fs::write(&part, text).expect("a file");
        std::fs::rename(&part, &self.position).expect("a file");
    }

    /// Turns the unit so that this side is up.
    pub fn turn(&self, side: &str) {
        self.print(&log(self.serial, self.element, side, self.temperature));
    }

    /// Runs the program with a log. `answer` takes the question and its number, and turns the unit.
    pub fn run(
        &self,
        options: &[&str],
        answer: &mut dyn FnMut(&Self, &str, usize) -> bool,
    ) -> Ended {
        let script = format!(
            "while cat '{}' 2>/dev/null; do echo >>'{}'; sleep 0.02; done",
            self.position.display(),
            count(&self.position).display()
        );
        self.run_with(options, &["--", "sh", "-c", &script], answer)
    }

    pub fn run_with(
        &self,
        options: &[&str],
        log: &[&str],
        answer: &mut dyn FnMut(&Self, &str, usize) -> bool,
    ) -> Ended {
        let measurement = self.measurement.display().to_string();
        let mut all = vec!["plumbline", "calibrate", &measurement];
        all.extend(options);
        all.extend(log);
        let cli = Cli::try_parse_from(all).unwrap_or_else(|error| panic!("{error}"));
        let (mut out, mut questions) = (Vec::new(), Vec::new());
        let mut notes = Notes {
            board: self,
            text: String::new(),
        };
        let mut confirm = |question: &Question| {
            let question = question.to_string();
            questions.push(question.clone());
            answer(self, &question, questions.len())
        };
        let mut terminal = Terminal {
            json: cli.options.json,
            out: &mut out,
            notes: &mut notes,
            confirm: &mut confirm,
            stopped: Rc::new(|| false),
            bar: None,
            yes: &[],
        };
        let result = run_with(&cli, &mut terminal, &mut |_| panic!("no adapter is needed"));
        Ended {
            result,
            out: String::from_utf8(out).expect("UTF-8"),
            notes: notes.text,
            questions,
        }
    }

    /// The options that write the store file.
    pub fn store_options(&self) -> [String; 4] {
        let store = self.store.display().to_string();
        ["--product".into(), "is2".into(), "--store".into(), store]
    }

    /// Turns the unit; the log does not tell its serial number.
    pub fn turn_untold(&self, side: &str) {
        let told = log(self.serial, self.element, side, self.temperature);
        let (_, untold) = told.split_once('\n').expect("lines");
        self.print(untold);
    }

    pub fn rows(&self) -> Vec<String> {
        let text = std::fs::read_to_string(&self.measurement).unwrap_or_default();
        text.lines().map(str::to_owned).collect()
    }
}

/// The notes of a run, which the user of the board reads.
struct Notes<'a> {
    board: &'a Board,
    text: String,
}

impl Write for Notes<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.text += str::from_utf8(bytes).expect("UTF-8");
        let mut reactions = self.board.reactions.borrow_mut();
        if let Some((_, sides)) = reactions.pop_front_if(|(note, _)| self.text.contains(*note)) {
            let Board {
                serial,
                element,
                temperature,
                ..
            } = *self.board;
            let logs = sides
                .iter()
                .map(|side| log(serial, element, side, temperature));
            self.board.print(&logs.collect::<String>());
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
