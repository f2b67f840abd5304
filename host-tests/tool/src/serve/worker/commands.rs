//! The commands of the command line, run with the adapter of the worker.

use super::which::{ASKS, Answers, on_request};
use super::{State, Worker, now};
use crate::adapter::Adapter;
use crate::backup::Backup;
use crate::command::{Sensor, run_on};
use crate::connect;
use crate::failure::{Failure, Kind as Refusal};
use crate::output::{Bar, Progress, Terminal};
use crate::scan::{Memory, SILENT};
use crate::serve::api::file::document;
use crate::serve::events::{Hub, Kind};
use crate::serve::job::parse;
use crate::serve::line::{self, Words};
use serde_json::{Value, json};
use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::Ordering;

impl Worker {
    /// Reads all settings into a file.
    pub(super) fn backup(&mut self) -> Result<Value, Failure> {
        // A folder of its own: the backup of a CANopen sensor is two files.
        let folder = tempfile::tempdir().map_err(unwritten)?;
        let file = folder.path().join("backup.toml");
        let path = file.to_string_lossy().into_owned();
        self.on_sensor(words(["backup", &path]), words(["backup", "FILE.toml"]))?;
        let sheet = self.sheet.as_ref().map(|kept| &kept.sheet);
        let backup = Backup::read_with(&file, sheet)?;
        Ok(document(&backup, &self.sheets))
    }

    /// Finds sensors. A question of the scan without a yes goes back to the page, which asks the user, and scans again from there: if the
    /// user wants to ask (`asks`), if there is no traffic, or if something was heard that can be a sensor.
    pub(super) fn scan(
        &mut self,
        port: &str,
        words: Words,
        yes: &[String],
        asks: bool,
    ) -> Result<Value, Failure> {
        self.error = None;
        self.close()?;
        self.lease(port)?;
        let asked = self.asked(&words, yes);
        let mut answers = Answers::new(yes);
        self.hub.publish(Kind::Found, &json!([]));
        let number = self.begin(&words);
        let mut notes = self.notes(number);
        let bar = self.steps(number);
        let mut confirm = |question: &str| answers.confirm(question);
        let result = self.execute(&words, &mut notes, bar, &asked.memory, &mut confirm);
        if let Some((_, lease)) = &self.port {
            lease.end();
        }
        let may_ask = match &result {
            Ok(_) => true,
            Err(failure) => failure.kind == Refusal::Silent && (asks || answers.has(SILENT)),
        };
        let result = match answers.question() {
            Some(question) if may_ask => {
                self.wait(asked, &question);
                Err(Failure::usage(ASKS, question))
            }
            _ => result,
        };
        self.end(number, &words, &result, notes.all);
        result
    }

    pub(super) fn command(&mut self, words: Words) -> Result<Value, Failure> {
        let name = words.first().cloned().unwrap_or_default();
        let new = words.last().cloned().unwrap_or_default();
        let result = self.on_sensor(words.clone(), words)?;
        match name.as_str() {
            "label" => self.named(&result),
            "rate" => {
                let target = self.target.take();
                self.again(|wanted| {
                    wanted.rate = new.parse().ok().or(wanted.rate);
                    // The restart has put a stored address into force.
                    if let Some(target) = target {
                        wanted.address = Some(target.address());
                    }
                })?;
            }
            _ => {}
        }
        Ok(result)
    }

    /// Shows the new name of the sensor.
    fn named(&mut self, result: &Value) {
        if let State::Active(live) = &mut self.state {
            live.found.label = result["label"].as_str().map(str::to_owned);
            let device = live.device(&self.sheets);
            self.hub.publish(Kind::Device, &device);
        }
    }

    pub(super) fn restore(
        &mut self,
        text: &str,
        name: &str,
        only: &[String],
        label: bool,
    ) -> Result<Value, Failure> {
        // The file is checked before the sensor is asked.
        let own = self.sheet.as_ref().map(|kept| kept.key.as_str());
        let read = self.sheets.backup(text, own);
        let backup = read.map_err(|why| Failure::usage("bad-file", why))?;
        let mut file = tempfile::NamedTempFile::new().map_err(unwritten)?;
        file.write_all(text.as_bytes()).map_err(unwritten)?;
        let path = file.path().to_string_lossy().into_owned();
        let with = |path: &str| {
            let mut words = words(["restore"]);
            line::positional(&mut words, &[path.to_owned()]);
            if !only.is_empty() {
                words.push("--only".to_owned());
                words.extend_from_slice(only);
            }
            words
        };
        if only.iter().any(|name| name.starts_with('-')) {
            return Err(Failure::usage(
                "unknown-name",
                "a name begins with a letter",
            ));
        }
        let restored = self.on_sensor(with(&path), with(name))?;
        if let Some(label) = backup.label.filter(|_| label) {
            let mut words = words(["label"]);
            line::positional(&mut words, &[label]);
            self.command(words)?;
        }
        Ok(restored)
    }

    /// Runs a command on the sensor of the session, which is released meanwhile.
    fn on_sensor(&mut self, words: Words, shown: Words) -> Result<Value, Failure> {
        let State::Active(live) = &mut self.state else {
            let message = "there is no sensor: connect to one first";
            return Err(Failure::usage("not-connected", message));
        };
        live.release()?;
        let with = |words: Words| [self.selection.clone(), words].concat();
        // The page has asked already.
        let result = self.logged(with(words), with(shown), &mut |_| true);
        // What follows shows the state of the sensor, also after a stop.
        self.stop.store(false, Ordering::Relaxed);
        if let Err(failure) = &result
            && failure.code == connect::OTHER
        {
            // The page shows it: it is told apart by its number.
            let _ = self.again(|_| {});
            return result;
        }
        if !self.port.as_ref().is_some_and(|(_, lease)| lease.is_kept()) {
            // The command has opened the adapter in another way: the caller connects again.
            return result;
        }
        if let (State::Active(live), Some(target)) = (&self.state, self.target.take())
            && live.session.target.address() != target.address()
        {
            let moved = self.again(|wanted| wanted.address = Some(target.address()));
            return result.and_then(|document| moved.map(|()| document));
        }
        if let State::Active(live) = &mut self.state {
            let resumed = live.resume();
            let device = live.device(&self.sheets);
            self.hub.publish(Kind::Device, &device);
            self.survive(resumed);
        }
        // A refused command can have changed a part.
        let refreshed = self.refresh();
        self.survive(refreshed);
        result
    }

    /// Reads all values for the page.
    pub(super) fn refresh(&mut self) -> Result<(), Failure> {
        let State::Active(live) = &mut self.state else {
            return Ok(());
        };
        live.release()?;
        let words = [self.selection.clone(), words(["get"])].concat();
        let memory = Memory::default();
        match self.execute(&words, &mut std::io::sink(), None, &memory, &mut |_| true) {
            Ok(values) => self.hub.publish(Kind::Values, &values),
            Err(failure) if failure.kind == Refusal::Bus => return Err(failure),
            Err(failure) if failure.code == connect::OTHER => {
                // It was exchanged. If that cannot be shown, the connection has ended.
                let _ = self.again(|_| {});
                return Ok(());
            }
            Err(_) => {}
        }
        match &mut self.state {
            State::Active(live) => live.resume(),
            _ => Ok(()),
        }
    }

    /// Runs a command; the page shows its line, notes and result.
    fn logged(
        &mut self,
        words: Words,
        shown: Words,
        confirm: &mut dyn FnMut(&str) -> bool,
    ) -> Result<Value, Failure> {
        let number = self.begin(&shown);
        let mut notes = self.notes(number);
        let bar = self.steps(number);
        let result = self.execute(&words, &mut notes, bar, &Memory::default(), confirm);
        self.end(number, &shown, &result, notes.all);
        result
    }

    /// The notes of an action.
    pub(super) fn notes(&self, number: u64) -> Notes {
        Notes {
            hub: self.hub.clone(),
            number,
            line: Vec::new(),
            all: Vec::new(),
        }
    }

    /// The progress of an action.
    pub(super) fn steps(&self, number: u64) -> Option<Box<dyn Bar>> {
        let hub = self.hub.clone();
        Some(Box::new(Steps { hub, number }))
    }

    pub(super) fn begin(&mut self, shown: &Words) -> u64 {
        let number = self.hub.number();
        let line = line::shown(shown);
        self.hub.publish(
            Kind::Action,
            &json!({"n": number, "at": now(), "line": line, "state": "running"}),
        );
        self.busy = Some(line);
        self.report();
        number
    }

    pub(super) fn end(
        &mut self,
        number: u64,
        shown: &Words,
        result: &Result<Value, Failure>,
        notes: Vec<String>,
    ) {
        self.busy = None;
        let mut event = json!({
            "n": number, "at": now(), "line": line::shown(shown), "notes": notes,
            "state": match result {
                Ok(_) => "done",
                Err(failure) if failure.code == ASKS => "asks",
                Err(_) => "failed",
            },
        });
        match result {
            Ok(document) => event["result"] = document.clone(),
            Err(failure) => event["error"] = failure.json()["error"].clone(),
        }
        self.hub.publish(Kind::Action, &event);
    }

    /// Runs a command of the command line with the adapter of the worker, and returns its document.
    fn execute(
        &mut self,
        words: &Words,
        notes: &mut dyn Write,
        bar: Option<Box<dyn Bar>>,
        memory: &Memory,
        confirm: &mut dyn FnMut(&str) -> bool,
    ) -> Result<Value, Failure> {
        let mut cli = parse(words)?;
        cli.options.config = self.config.clone();
        // The line has the name that the user knows; the server has a copy.
        if cli.options.eds.is_some() {
            let kept = self.sheet.as_ref();
            cli.options.eds = kept.map(|kept| kept.path().to_owned());
        }
        let lease = self.port.as_ref().map(|(_, lease)| lease.clone());
        let mut open = |_: &str| -> Result<Box<dyn Adapter>, Failure> {
            match &lease {
                Some(lease) => Ok(Box::new(lease.clone())),
                None => Err(Failure::bus(
                    "not-open",
                    "the adapter is gone: connect again",
                )),
            }
        };
        let mut out = Vec::new();
        let mut terminal = Terminal {
            json: true,
            out: &mut out,
            notes,
            confirm,
            stopped: self.stopped(),
            bar,
        };
        let mut sensor = Sensor {
            memory: memory.clone(),
            ..Sensor::default()
        };
        if let State::Active(live) = &self.state {
            sensor.expected = Some(live.found.identity());
        }
        let run = run_on(&cli, &mut terminal, &mut open, &mut sensor);
        self.target = sensor.target;
        run.map_err(on_request)?;
        let text = String::from_utf8_lossy(&out);
        let document = text.lines().last().map(serde_json::from_str);
        Ok(document.and_then(Result::ok).unwrap_or(Value::Null))
    }
}

fn words<const N: usize>(texts: [&str; N]) -> Words {
    texts.map(str::to_owned).to_vec()
}

fn unwritten(error: std::io::Error) -> Failure {
    Failure::bus("no-file", format!("cannot write a temporary file: {error}"))
}

/// The progress of a command: each step is an event.
pub(super) struct Steps {
    hub: Arc<Hub>,
    number: u64,
}

impl Bar for Steps {
    fn show(&mut self, Progress { done, total, text }: Progress) {
        let event = json!({"n": self.number, "done": done, "total": total, "text": text});
        self.hub.publish(Kind::Progress, &event);
    }

    /// The end of the action hides it.
    fn hide(&mut self) {}

    fn found(&mut self, rows: &Value) {
        self.hub.publish(Kind::Found, rows);
    }
}

/// The notes of a command: each line is an event.
pub(super) struct Notes {
    hub: Arc<Hub>,
    number: u64,
    line: Vec<u8>,
    pub(super) all: Vec<String>,
}

/// The maximum number of lines of notes that are kept.
const NOTES: usize = 200;

impl Write for Notes {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        for byte in bytes {
            if !matches!(byte, b'\n' | b'\r') {
                self.line.push(*byte);
                continue;
            }
            let text = String::from_utf8_lossy(&self.line).trim().to_owned();
            self.line.clear();
            if !text.is_empty() && self.all.len() < NOTES {
                self.hub
                    .publish(Kind::Note, &json!({"n": self.number, "text": text}));
                self.all.push(text);
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}
