//! An action of the page: its line, its steps and notes while it runs, and how it has ended.

use super::which::on_request;
use super::{Worker, now};
use crate::error::{Asks, Error};
use crate::output::{self, Bar, Progress, Terminal};
use crate::question::{Name, Question};
use crate::serve::events::{Hub, Kind, tell};
use crate::serve::line::{self, Words};
use serde_json::{Value, json};
use std::cell::RefCell;
use std::sync::Arc;
use texts::{Kind as Refusal, Text};

/// The questions of an action. A yes is for the question that was shown, not for another one.
#[derive(Default)]
pub(super) struct Answers<'a> {
    /// The questions that were answered with yes.
    pub(super) yes: &'a [Question],
    /// The questions that need none, because their name was answered with yes.
    pub(super) names: &'a [Name],
    asked: RefCell<Vec<Question>>,
}

impl<'a> Answers<'a> {
    pub(super) fn new(yes: &'a [Question], names: &'a [Name]) -> Self {
        Self {
            yes,
            names,
            ..Self::default()
        }
    }

    /// Yes to all questions: the page has asked before the request.
    pub(super) fn all() -> Self {
        Self {
            names: &[Name::All],
            ..Self::default()
        }
    }

    /// The questions that have no yes. The page asks the user, and repeats the request with each yes.
    pub(super) fn asked(&self) -> Vec<Question> {
        self.asked.borrow().clone()
    }

    fn confirm(&self, question: &Question) -> bool {
        let is_yes = self.yes.contains(question);
        if !is_yes {
            self.asked.borrow_mut().push(question.clone());
        }
        is_yes
    }

    /// The questions instead of the failure that follows from them.
    pub(super) fn instead<T>(&self, result: Result<T, Error>) -> Result<T, Error> {
        match (result, self.asked()) {
            (Err(failure), asked) if failure.kind() == Refusal::Usage && !asked.is_empty() => {
                Err(Asks(asked).into())
            }
            (result, _) => result,
        }
    }
}

impl Worker {
    /// Runs an action with these words; the page shows its line, steps, notes and end.
    pub(super) fn action<T>(
        &mut self,
        words: &Words,
        answers: &Answers,
        run: impl FnOnce(&mut Self, &mut Terminal) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let (number, line) = (self.hub.number(), line::shown(words));
        let running = json!({"n": number, "at": now(), "line": line, "state": "running"});
        self.hub.publish(Kind::Action, &running);
        self.busy = Some(line.clone());
        self.report();
        let hub = self.hub.clone();
        let mut notes = Notes {
            hub: hub.clone(),
            number,
            all: Vec::new(),
        };
        let mut terminal = Terminal {
            json: true,
            out: &mut std::io::sink(),
            notes: &mut notes,
            confirm: &mut |question| answers.confirm(question),
            yes: answers.names,
            stopped: self.stopped(),
            bar: Some(Box::new(Steps { hub, number })),
        };
        let result = run(self, &mut terminal).map_err(on_request);
        self.busy = None;
        let mut event = json!({"n": number, "at": now(), "line": line, "notes": notes.all});
        event["state"] = match &result {
            Ok(_) => "done",
            Err(failure) if !failure.questions().is_empty() => "asks",
            Err(_) => "failed",
        }
        .into();
        if let Err(failure) = &result {
            tell(&mut event, failure);
        }
        self.hub.publish(Kind::Action, &event);
        result
    }
}

/// The progress of a command: each step is an event.
struct Steps {
    hub: Arc<Hub>,
    number: u64,
}

impl Bar for Steps {
    fn show(&mut self, Progress { done, total, step }: Progress) {
        let event = json!({"n": self.number, "done": done, "total": total, "texts": step.texts()});
        self.hub.publish(Kind::Progress, &event);
    }

    /// The end of the action hides it.
    fn hide(&mut self) {}

    fn found(&mut self, rows: &Value) {
        self.hub.publish(Kind::Found, rows);
    }
}

/// The notes of a command: each one is an event.
struct Notes {
    hub: Arc<Hub>,
    number: u64,
    all: Vec<Value>,
}

/// The maximum number of notes that are kept.
const NOTES: usize = 200;

impl output::Notes for Notes {
    fn note(&mut self, text: &dyn Text) {
        if self.all.len() < NOTES {
            let texts = text.texts();
            self.hub
                .publish(Kind::Note, &json!({"n": self.number, "texts": texts}));
            self.all.push(texts);
        }
    }
}
