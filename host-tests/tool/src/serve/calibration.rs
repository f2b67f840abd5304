//! The calibration in the page. A thread leads through the six positions; each one waits for the answer of the page.
//!
//! The page chooses no file and no command: both come from the command line of `serve`. A page that can start programs is a larger risk
//! than a page that can move a zero point.

use super::events::{Hub, Kind, tell};
use super::line;
use crate::calibrate::host::{Host, Question, State, Step};
use crate::calibrate::log::Source;
use crate::calibrate::rest::Average;
use crate::error::{CalibrationError, Error, RequestError};
use crate::ops::calibrate;
use serde::Deserialize;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use texts::Text;

/// The longest wait without a check for a stop.
const SLICE: Duration = Duration::from_millis(100);

/// The line of a unit with a probe.
const EXAMPLE: &str =
    "plumbline --product is2 calibrate positions.csv --store is2.bin -- cargo bluepill is2";

/// The unit of the command line.
#[derive(Clone, Debug)]
pub struct Unit {
    /// The file of the measurement.
    pub file: PathBuf,
    /// The store file into which the calibration is written.
    pub store: Option<PathBuf>,
    /// The serial number of the unit.
    pub serial: Option<u32>,
    /// The name of its product.
    pub product: Option<String>,
    /// Its log; None: the measurement is complete.
    pub source: Option<Source>,
}

impl Unit {
    /// The virtual unit of the demonstration, with its measurement in this folder.
    pub fn demonstration(folder: &Path) -> Self {
        Self {
            file: folder.join("positions.csv"),
            store: None,
            serial: None,
            product: None,
            source: Some(Source::Demonstration),
        }
    }

    /// Refuses a store file without a product.
    ///
    /// # Errors
    /// That.
    pub fn check(&self) -> Result<(), Error> {
        match (&self.store, &self.product) {
            (Some(_), None) => Err(RequestError::StoreProduct.into()),
            _ => Ok(()),
        }
    }

    /// The line of the command line; an example for the demonstration.
    fn line(&self) -> String {
        if self.source == Some(Source::Demonstration) {
            return EXAMPLE.to_owned();
        }
        let mut words = Vec::new();
        if let Some(product) = &self.product {
            words.extend(["--product".to_owned(), product.clone()]);
        }
        words.extend(["calibrate".to_owned(), self.file.display().to_string()]);
        if let Some(store) = &self.store {
            words.extend(["--store".to_owned(), store.display().to_string()]);
        }
        if let Some(serial) = self.serial {
            words.extend(["--serial".to_owned(), serial.to_string()]);
        }
        if let Some(Source::Command(log)) = &self.source {
            words.push("--".to_owned());
            words.extend_from_slice(log);
        }
        line::shown(&words)
    }
}

/// What the page asks for.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Wanted {
    /// Begin, or go on with the positions that are missing.
    Start,
    /// Take the measurement of this question.
    Take(u64),
    /// Measure the position of this question again.
    Again(u64),
    /// End; the positions that were taken stay in the file.
    Stop,
}

/// The calibration, for all tabs.
pub struct Calibration {
    unit: Option<Unit>,
    hub: Arc<Hub>,
    inner: Mutex<Inner>,
}

#[derive(Default)]
struct Inner {
    running: Option<Running>,
}

struct Running {
    thread: JoinHandle<()>,
    answers: Sender<Answer>,
    shared: Arc<Mutex<Shared>>,
}

/// What thread and requests share.
#[derive(Default)]
struct Shared {
    /// The number of the question that waits.
    question: Option<u64>,
    stopped: bool,
}

/// An answer of the page.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Answer {
    Take,
    Again,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Calibration {
    /// The calibration of a unit. Tells the page what can be done.
    pub fn new(unit: Option<Unit>, hub: Arc<Hub>) -> Self {
        let state = match &unit {
            Some(unit) => json!({"state": "idle", "line": unit.line(), "demo": is_demo(unit)}),
            None => json!({"state": "off", "line": EXAMPLE}),
        };
        hub.publish(Kind::Calibration, &state);
        Self {
            unit,
            hub,
            inner: Mutex::default(),
        }
    }

    /// Does what the page asks for.
    ///
    /// # Errors
    /// There is no unit, it runs already, or the question is an old one.
    pub fn handle(&self, wanted: Wanted) -> Result<(), Error> {
        let mut inner = locked(&self.inner);
        let running = inner.running.as_ref();
        let running = running.filter(|running| !running.thread.is_finished());
        match (wanted, running) {
            (Wanted::Start, None) => {
                let Some(unit) = &self.unit else {
                    return Err(CalibrationError::NoUnit.into());
                };
                inner.running = Some(self.start(unit.clone())?);
                Ok(())
            }
            (Wanted::Start, Some(_)) => Err(CalibrationError::Running.into()),
            (Wanted::Stop, Some(running)) => {
                locked(&running.shared).stopped = true;
                Ok(())
            }
            (Wanted::Stop, None) => Ok(()),
            (Wanted::Take(number), Some(running)) => running.answer(number, Answer::Take),
            (Wanted::Again(number), Some(running)) => running.answer(number, Answer::Again),
            (Wanted::Take(_) | Wanted::Again(_), None) => Err(old()),
        }
    }

    fn start(&self, unit: Unit) -> Result<Running, Error> {
        let (answers, receiver) = channel();
        let shared = Arc::new(Mutex::new(Shared::default()));
        let (hub, own) = (self.hub.clone(), shared.clone());
        let thread = thread::Builder::new().name("calibration".to_owned());
        let thread = thread
            .spawn(move || {
                let number = hub.number();
                if is_demo(&unit) {
                    // Each demonstration begins with the first position.
                    let _ = std::fs::remove_file(&unit.file);
                }
                let mut page = Page {
                    document: json!({"line": unit.line(), "demo": is_demo(&unit), "taken": []}),
                    notes: Vec::new(),
                    hub,
                    shared: own,
                    answers: receiver,
                };
                page.run(&unit, number);
            })
            .map_err(|error| CalibrationError::NoThread(error.to_string()))?;
        Ok(Running {
            thread,
            answers,
            shared,
        })
    }

    /// Stops, and waits for the end.
    pub fn end(&self) {
        if let Some(running) = locked(&self.inner).running.take() {
            locked(&running.shared).stopped = true;
            let _ = running.thread.join();
        }
    }
}

fn is_demo(unit: &Unit) -> bool {
    unit.source == Some(Source::Demonstration)
}

fn old() -> Error {
    CalibrationError::OldQuestion.into()
}

impl Running {
    /// A question takes one answer: a second click, or one in another tab, never takes the next position.
    fn answer(&self, number: u64, answer: Answer) -> Result<(), Error> {
        let mut shared = locked(&self.shared);
        if shared.question != Some(number) {
            return Err(old());
        }
        shared.question = None;
        self.answers.send(answer).map_err(|_| old())
    }
}

/// The page as the interface that leads the user.
struct Page {
    hub: Arc<Hub>,
    shared: Arc<Mutex<Shared>>,
    answers: Receiver<Answer>,
    /// The document that the page shows.
    document: Value,
    notes: Vec<Value>,
}

impl Page {
    fn run(&mut self, unit: &Unit, number: u64) {
        let line = unit.line();
        let action = |state: &str| json!({"n": number, "at": super::worker::now(), "line": line, "state": state});
        self.hub.publish(Kind::Action, &action("running"));
        let names = calibrate::Unit {
            product: unit.product.as_deref(),
            serial: unit.serial,
            store: unit.store.as_deref(),
        };
        let result = calibrate::run(&unit.file, unit.source.as_ref(), names, self);
        let mut event = action(if result.is_ok() { "done" } else { "failed" });
        for name in ["measured", "question", "side", "place"] {
            self.document[name] = Value::Null;
        }
        match result {
            Ok(done) => {
                self.document["result"] = json!(done);
                self.document["next"] = done.next.texts();
                self.notes.push(done.next.texts());
                self.show("done");
            }
            Err(failure) => {
                self.document["error"] = failure.texts();
                tell(&mut event, &failure);
                self.show("failed");
            }
        }
        event["notes"] = json!(self.notes);
        self.hub.publish(Kind::Action, &event);
    }

    fn show(&mut self, state: &str) {
        self.document["state"] = json!(state);
        self.hub.publish(Kind::Calibration, &self.document);
    }

    fn measured(&mut self, state: State, average: &Average) {
        let up = average.side().map(|side| side.to_string());
        self.document["measured"] = json!({
            "state": state.name(),
            "up": up,
            "acceleration": average.acceleration.map(|value| value * 1e3),
            "spread": average.spread * 1e3,
            "temperature": average.temperature,
        });
    }
}

impl Host for Page {
    fn report(&mut self, step: &Step) {
        let mut state = "measuring";
        match step {
            Step::Waiting(_) => state = "waiting",
            Step::Serial(serial) => self.document["serial"] = json!(serial),
            Step::Complete => {}
            Step::Place(place, side) => {
                self.document["place"] = json!(place);
                self.document["side"] = json!(side.to_string());
                self.document["measured"] = Value::Null;
            }
            Step::Measured(state, average) => self.measured(*state, average),
            Step::Taken(side, _) => {
                if let Some(taken) = self.document["taken"].as_array_mut() {
                    taken.push(json!(side.to_string()));
                }
            }
        }
        if !matches!(step, Step::Measured(..)) {
            self.notes.push(step.texts());
        }
        self.show(state);
    }

    fn ask(&mut self, question: &Question) -> bool {
        let Question::Take(_, average) = question else {
            // The answer was "Measure again", so this is a yes. A stop ends the calibration.
            return !self.is_stopped();
        };
        self.measured(State::Ready, average);
        let number = self.hub.number();
        self.document["question"] = json!(number);
        locked(&self.shared).question = Some(number);
        self.show("asking");
        let answer = loop {
            match self.answers.recv_timeout(SLICE) {
                Ok(answer) => break Some(answer),
                Err(RecvTimeoutError::Timeout) if !self.is_stopped() => {}
                Err(_) => break None,
            }
        };
        locked(&self.shared).question = None;
        for name in ["question", "measured"] {
            self.document[name] = Value::Null;
        }
        self.show("measuring");
        answer == Some(Answer::Take)
    }

    fn is_stopped(&self) -> bool {
        locked(&self.shared).stopped
    }
}
