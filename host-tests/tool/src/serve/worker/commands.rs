//! What the worker does with the sensor of its session, and what the page shows of it.

use super::action::Answers;
use super::{Live, State, Worker};
use crate::error::{Asks, Error, FileError, PageError, RequestError, SensorError};
use crate::identify;
use crate::labels::Labels;
use crate::ops::align::Measured;
use crate::ops::report::{Adjusted, Values};
use crate::ops::{self, Report, Request};
use crate::output::Terminal;
use crate::question::Question;
use crate::scan;
use crate::serve::api::file::document;
use crate::serve::events::Kind;
use crate::serve::job::{Align, Scan};
use crate::serve::line::{self, Words};
use crate::sheet::Address;
use plumbline::param::DataType;
use serde_json::{Value, json};
use std::sync::atomic::Ordering;
use texts::Kind as Refusal;

impl Worker {
    /// Reads all settings into a file.
    pub(super) fn backup(&mut self) -> Result<Value, Error> {
        let read = self.on_sensor(
            words(["backup", "FILE.toml"]),
            &Answers::all(),
            |live, terminal| {
                identify::same(&mut live.session, &live.found)?;
                ops::backup::read(&mut live.session, &live.found, terminal)
            },
        );
        self.follow(&read)?;
        Ok(document(&read?, &self.sheets))
    }

    /// Finds sensors. A question of the scan without a yes goes back to the page, which asks the user, and scans again from there: if the
    /// user wants to ask, if there is no traffic, or if something was heard that can be a sensor.
    pub(super) fn scan(&mut self, wanted: &Scan) -> Result<Value, Error> {
        self.error = None;
        self.close()?;
        let lease = self.lease(&wanted.port)?;
        let words = wanted.words();
        let asked = self.asked(&words, &wanted.yes);
        let options = scan::Options {
            rate: wanted.rate,
            active: wanted.active,
            search: wanted.search,
            memory: asked.memory.clone(),
        };
        let labels = Labels::open(self.config.as_deref()).unwrap_or_default();
        let answers = Answers::new(&wanted.yes, &[]);
        self.hub.publish(Kind::Found, &json!([]));
        self.action(&words, &answers, |worker, terminal| {
            let result = scan::run(Box::new(lease.clone()), options, labels, terminal);
            let result = result.map(|rows| rows.json());
            lease.end();
            let asks = wanted.active || wanted.search;
            let questions = answers.asked();
            let may_ask = match &result {
                Ok(_) => true,
                Err(failure) => {
                    failure.kind() == Refusal::Silent
                        && (asks || questions.contains(&Question::Silent))
                }
            };
            if !may_ask || questions.is_empty() {
                return result;
            }
            worker.wait(asked, questions.clone());
            Err(Asks(questions).into())
        })
    }

    /// Performs an operation on the sensor.
    pub(super) fn perform(&mut self, request: &Request) -> Result<Value, Error> {
        let config = self.config.clone();
        let mut done = None;
        let result = self.on_sensor(request.words(), &Answers::all(), |live, terminal| {
            let next = match request {
                Request::Restart => ops::rate::next_target(&mut live.session).ok(),
                _ => None,
            };
            let next = next.filter(|next| next.address() != live.session.target.address());
            let mut labels = match request {
                Request::Label { .. } => Labels::open(config.as_deref())?,
                _ => Labels::default(),
            };
            let (session, found) = (&mut live.session, &live.found);
            let report = ops::perform(request, session, found, (&mut labels, true), terminal)?;
            if let Some(target) = next {
                // An address that was set before acts from the restart on.
                ops::address::arrive(session, target)?;
            }
            if let Report::Done { done } = &report {
                terminal.note(done);
            }
            let document = json!(report);
            done = Some(report);
            Ok(document)
        });
        if let Some(report) = &done {
            self.note_unsaved(request, report);
        }
        match done {
            Some(Report::Label { label, .. }) => {
                if let State::Active(live) = &mut self.state {
                    live.found.label = label;
                    let device = live.device(&self.sheets);
                    self.hub.publish(Kind::Device, &device);
                }
            }
            Some(Report::Identity(_)) => self.take(Values::default()),
            Some(Report::Values(values)) => self.take(values),
            Some(Report::Written { values, .. }) if self.is_plain(&values) => self.take(values),
            Some(Report::Adjusted(adjusted)) => self.adjusted(adjusted),
            Some(_) if *request == Request::Save => self.take(Values::default()),
            Some(_) if matches!(request, Request::Rate { .. }) => self.again()?,
            _ => self.follow(&result)?,
        }
        result
    }

    /// Whether these parameters change nothing else.
    fn is_plain(&self, values: &Values) -> bool {
        let State::Active(live) = &self.state else {
            return false;
        };
        let (session, names) = (&live.session, &values.0);
        let mut entries = session.sheet.entries.iter();
        session.target.address() == live.found.target.address()
            && !entries.any(|entry| {
                let is_pdo = matches!(
                    entry.address,
                    Address::Object {
                        index: 0x1800..=0x1BFF,
                        ..
                    }
                );
                let has_effect = entry.command
                    || is_pdo
                    || session.sheet.is_resolution(entry)
                    || entry.data_type == DataType::Text;
                has_effect && names.iter().any(|shown| shown.name == entry.name)
            })
    }

    /// Makes the offset of the mounting zero. A question without a yes goes back to the page, and what was measured is kept for its answer.
    pub(super) fn align(&mut self, wanted: &Align) -> Result<Value, Error> {
        let mut measured = std::mem::take(&mut self.measured);
        if wanted.yes.is_empty() {
            measured = Measured::default();
        }
        let mut shown = words(["align"]);
        if wanted.save {
            shown.push("--save".to_owned());
        }
        let answers = Answers::new(&wanted.yes, &[]);
        let result = self.on_sensor(shown, &answers, |live, terminal| {
            let (session, found) = (&mut live.session, &live.found);
            identify::same(session, found)?;
            let how = (&mut measured, wanted.save);
            answers.instead(ops::align::align(session, found, how, terminal))
        });
        self.follow(&result)?;
        match result {
            Ok(aligned) => {
                self.note_aligned(&aligned);
                Ok(json!(aligned))
            }
            Err(failure) => {
                if !failure.questions().is_empty() {
                    self.measured = measured;
                }
                Err(failure)
            }
        }
    }

    /// Shows the values that an operation has read.
    fn take(&mut self, values: Values) {
        if let State::Active(live) = &mut self.state {
            live.go_on();
        }
        if !values.0.is_empty() {
            let own = values.0.into_iter().map(|shown| (shown.name, shown.json));
            self.values.extend(own);
            self.hub.publish(Kind::Values, &json!(self.values));
        }
    }

    /// Shows the angles, and the parameters that a new reference has changed.
    fn adjusted(&mut self, adjusted: Adjusted) {
        let mut values = adjusted.angles;
        if let State::Active(live) = &mut self.state {
            let session = &mut live.session;
            session.remember(true);
            for entry in adjusted.what.written(session) {
                let written = adjusted
                    .written
                    .iter()
                    .find(|(own, _)| own.name == entry.name);
                let shown = match written {
                    Some((_, raw)) => {
                        let scale = session.scale_of(&entry);
                        scale.map(|scale| ops::get::shown(&entry, scale, *raw))
                    }
                    None => ops::get::show(session, &entry),
                };
                values.0.extend(shown.ok());
            }
            session.remember(false);
        }
        self.take(values);
        self.fill_unsaved();
    }

    pub(super) fn restore(
        &mut self,
        text: &str,
        name: &str,
        only: &[String],
        label: bool,
    ) -> Result<Value, Error> {
        // The file is checked before the sensor is asked.
        let own = self.sheet.as_ref().map(|kept| kept.key.as_str());
        let read = self.sheets.backup(text, own);
        let backup = read.map_err(FileError::Fault)?;
        let in_file = backup.label.clone();
        let mut shown = words(["restore"]);
        line::positional(&mut shown, &[name.to_owned()]);
        if !only.is_empty() {
            shown.push("--only".to_owned());
            shown.extend_from_slice(only);
        }
        if only.iter().any(|name| name.starts_with('-')) {
            return Err(RequestError::NoName.into());
        }
        let config = self.config.clone();
        let result = self.on_sensor(shown, &Answers::all(), |live, terminal| {
            let (session, found) = (&mut live.session, &live.found);
            identify::same(session, found)?;
            let (document, name) =
                ops::restore::restore(session, found, (backup, name.to_owned()), only, terminal)?;
            let mut labels = Labels::open(config.as_deref()).unwrap_or_default();
            ops::label::take_over(&mut labels, found, name.as_deref(), terminal);
            live.found.label = labels.name(&live.found);
            Ok(document)
        });
        if result.is_ok() {
            self.unsaved.clear();
        }
        self.follow(&result)?;
        let restored = result?;
        if let Some(label) = in_file.filter(|_| label) {
            self.perform(&Request::Label {
                name: Some(label),
                remove: false,
            })?;
        }
        Ok(restored)
    }

    /// Does something with the sensor of the session; the page shows its line, notes and result.
    pub(super) fn on_sensor<T>(
        &mut self,
        words: Words,
        answers: &Answers,
        run: impl FnOnce(&mut Live, &mut Terminal) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let State::Active(_) = &self.state else {
            return Err(PageError::NotConnected.into());
        };
        let shown = [self.selection.clone(), words].concat();
        let result = self.action(&shown, answers, |worker, terminal| {
            let State::Active(live) = &mut worker.state else {
                unreachable!("it is connected");
            };
            let result = run(live, terminal);
            for note in live.session.notes.drain(..) {
                terminal.note(&note);
            }
            result
        });
        // What follows shows the state of the sensor, also after a stop.
        self.stop.store(false, Ordering::Relaxed);
        result
    }

    /// Shows the sensor after something that can have changed all of it.
    pub(super) fn follow<T>(&mut self, result: &Result<T, Error>) -> Result<(), Error> {
        let State::Active(live) = &mut self.state else {
            return Ok(());
        };
        match result {
            Err(Error::Sensor(SensorError::Other(_))) => {
                // The page shows it: it is told apart by its number.
                let _ = self.again();
                return Ok(());
            }
            // Nothing was sent that changes something.
            Err(failure) if failure.kind() == Refusal::Usage && failure.questions().is_empty() => {
                live.go_on();
                return Ok(());
            }
            _ => {}
        }
        let is_kept = self.port.as_ref().is_some_and(|(_, lease)| lease.is_kept());
        if !is_kept || live.session.target.address() != live.found.target.address() {
            let moved = self.again();
            return if result.is_ok() { moved } else { Ok(()) };
        }
        let resumed = live.resume();
        let device = live.device(&self.sheets);
        self.hub.publish(Kind::Device, &device);
        self.survive(resumed);
        // A refused command can have changed a part.
        let refreshed = self.refresh();
        self.survive(refreshed);
        Ok(())
    }

    /// The sensor answers again after a silence.
    pub(super) fn returned(&mut self) -> Result<(), Error> {
        let State::Active(live) = &mut self.state else {
            return Ok(());
        };
        match identify::is_same(&mut live.session, &live.found) {
            Err(failure) if failure.kind() == Refusal::Bus => return Err(failure),
            Err(Error::Sensor(SensorError::Other(_))) => {
                // It was exchanged. If that cannot be shown, the connection has ended.
                let _ = self.again();
                return Ok(());
            }
            _ => live.resume()?,
        }
        self.refresh()
    }

    /// Reads all values for the page.
    pub(super) fn refresh(&mut self) -> Result<(), Error> {
        let State::Active(live) = &mut self.state else {
            return Ok(());
        };
        live.session.remember(true);
        let read = ops::get::get(&mut live.session, &[]);
        live.session.remember(false);
        match read {
            Ok(values) => {
                self.values.clear();
                self.take(values);
                self.forget_lost();
            }
            Err(failure) if failure.kind() == Refusal::Bus => return Err(failure),
            Err(_) => live.go_on(),
        }
        Ok(())
    }
}

fn words<const N: usize>(texts: [&str; N]) -> Words {
    texts.map(str::to_owned).to_vec()
}
