//! A run of the program.

use super::Rig;
use super::adapter::{Cyclic, Unplugged};
use adapter::Adapter;
use adapter::bench::{BenchAdapter, SharedBus};
use clap::Parser;
use plumbline::time::Instant;
use plumbline_tool::cli::Cli;
use plumbline_tool::command::run_with;
use plumbline_tool::error::Error;
use plumbline_tool::output::Terminal;
use plumbline_tool::question::Question;
use serde_json::Value;
use std::cell::Cell;
use std::io::{self, Write};
use std::rc::Rc;

/// Standard output, with the time of each line.
struct Output {
    bus: SharedBus,
    text: Vec<u8>,
    times: Vec<Instant>,
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let lines = bytes.iter().filter(|byte| **byte == b'\n').count();
        let now = self.bus.borrow().now();
        self.times.extend(std::iter::repeat_n(now, lines));
        self.text.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The end of a run of the program.
#[derive(Debug)]
pub struct Ended {
    pub code: u8,
    pub out: String,
    pub notes: String,
    /// The time of each line of the output.
    pub times: Vec<Instant>,
}

impl Rig {
    /// Runs the program with these arguments.
    pub fn tool(&mut self, arguments: &str) -> Ended {
        let words: Vec<&str> = arguments.split_whitespace().collect();
        self.tool_with(&words)
    }

    /// Runs the program with these arguments, which can have spaces.
    pub fn tool_with(&mut self, arguments: &[&str]) -> Ended {
        let fresh = tempfile::tempdir().expect("a folder");
        let config = self.config.as_deref().unwrap_or(fresh.path());
        let config = config.display().to_string();
        let mut all = vec!["plumbline", "--port", "bench", "--config", &config];
        let says_rate = arguments
            .iter()
            .any(|word| ["--rate", "--file", "scan"].contains(word));
        if let Some(rate) = self.rate.filter(|_| !says_rate) {
            all.extend(["--rate", rate]);
        }
        all.extend(arguments);
        let cli = Cli::try_parse_from(all).unwrap_or_else(|error| panic!("{error}"));
        let mut out = Output {
            bus: self.bus.clone(),
            text: Vec::new(),
            times: Vec::new(),
        };
        let mut notes = Vec::new();
        let (says_yes, yes_to) = (self.says_yes, self.yes_to);
        let (questions, asked_at, bus) = (&mut self.questions, &mut self.asked_at, &self.bus);
        let mut confirm = |question: &Question| {
            let question = question.to_string();
            asked_at.push(bus.borrow().now());
            let is_yes = says_yes && yes_to.is_none_or(|part| question.contains(part));
            questions.push(question);
            is_yes
        };
        let looks = Cell::new(self.stop.unwrap_or(u32::MAX));
        let stopped = move || {
            looks.set(looks.get().saturating_sub(1));
            looks.get() == 0
        };
        let mut terminal = Terminal {
            json: cli.options.json,
            out: &mut out,
            notes: &mut notes,
            confirm: &mut confirm,
            stopped: Rc::new(stopped),
            bar: self.bar.take(),
            yes: &cli.options.yes,
        };
        let bus = self.bus.clone();
        let (left, refused) = (self.cut.unwrap_or(usize::MAX), self.refused);
        let mut others = Vec::new();
        let (cyclic, deaf, lost) = (self.cyclic, self.deaf, self.lost);
        let (interface, opening) = (self.interface, self.opening);
        let rate = self.rate_of_bus;
        let (only_active, modes) = (self.only_active, self.modes.clone());
        let refuses_all = self.refuses_all;
        let (altered, events) = (self.altered, std::mem::take(&mut self.events));
        let (overruns, unread) = (self.overruns, self.unread.clone());
        let mut connect = |_: &str| {
            let cyclic = cyclic.map(|(cycle, frame)| {
                let id = bus.borrow_mut().adapter();
                bus.borrow_mut().open(id, rate, false);
                others.push(id);
                let next = bus.borrow().now();
                Cyclic {
                    bus: bus.clone(),
                    id,
                    frame,
                    cycle,
                    next,
                }
            });
            Ok(Box::new(Unplugged {
                adapter: BenchAdapter::new(&bus),
                left,
                refused,
                refuses_all,
                cyclic,
                deaf,
                lost,
                bus: bus.clone(),
                altered,
                events: events.clone(),
                overruns,
                unread: unread.clone(),
                only_active,
                modes: modes.clone(),
                interface,
                opening,
            }) as Box<dyn Adapter>)
        };
        let result = run_with(&cli, &mut terminal, &mut connect);
        for id in others {
            self.bus.borrow_mut().remove(id);
        }
        let mut ended = Ended {
            code: 0,
            out: String::from_utf8(out.text).expect("UTF-8"),
            notes: String::from_utf8(notes).expect("UTF-8"),
            times: out.times,
        };
        if let Err(failure) = result {
            ended.code = failure.kind().exit_code();
            if cli.options.json && !matches!(failure, Error::AfterDocument(_)) {
                ended.out.push_str(&failure.json().to_string());
            } else {
                ended.notes.push_str(&failure.to_string());
            }
        }
        ended
    }

    /// Runs the program, which must succeed, and returns its document.
    #[track_caller]
    pub fn json(&mut self, arguments: &str) -> Value {
        let ended = self.tool(&format!("--json {arguments}"));
        assert_eq!(ended.code, 0, "{arguments}: {ended:?}");
        serde_json::from_str(&ended.out).unwrap_or_else(|error| panic!("{error}: {}", ended.out))
    }

    /// Runs the program, which must succeed.
    #[track_caller]
    pub fn done(&mut self, arguments: &str) -> String {
        let ended = self.tool(arguments);
        assert_eq!(ended.code, 0, "{arguments}: {ended:?}");
        ended.out
    }

    /// Runs the program, which must fail, and returns its exit code and the code of the error.
    #[track_caller]
    pub fn fails(&mut self, arguments: &str) -> (u8, String) {
        let ended = self.tool(&format!("--json {arguments}"));
        let document: Value =
            serde_json::from_str(&ended.out).unwrap_or_else(|error| panic!("{error}: {ended:?}"));
        let code = document["error"]["code"]
            .as_str()
            .expect("a code")
            .to_owned();
        let message = document["error"]["message"].as_str().expect("a message");
        assert!(
            message.len() > 20,
            "the message names the next step: {message}"
        );
        (ended.code, code)
    }
}
