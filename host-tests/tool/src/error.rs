//! Why a command failed: exit code, a code for programs, and one sentence for people that names the next step.

use crate::question::Question;
use serde_json::{Value, json};

/// The kind of a failure, which selects the exit code.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// The sensor refused: exit code 1.
    Refused,
    /// The command line, a name or a value is wrong: exit code 2.
    Usage,
    /// Nobody answers: exit code 3.
    Silent,
    /// The bus, the adapter or a file failed: exit code 4.
    Bus,
    /// The user pressed Ctrl-C: exit code 130.
    Stopped,
}

impl Kind {
    /// The exit code: 1 to 4, or 130.
    pub const fn exit_code(self) -> u8 {
        match self {
            Self::Refused => 1,
            Self::Usage => 2,
            Self::Silent => 3,
            Self::Bus => 4,
            Self::Stopped => 130,
        }
    }
}

/// The reason why a command failed.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("{message}")]
pub struct Error {
    /// Who or what has refused.
    pub kind: Kind,
    /// A short code for programs, for example `out-of-range`.
    pub code: &'static str,
    /// What happened, as one sentence for people.
    pub message: String,
    /// The document of the command is printed, so this failure is not a second document.
    pub has_document: bool,
    /// What the user must answer first. Only the page gets it: a terminal asks at once.
    pub questions: Vec<Question>,
}

impl Error {
    /// The sensor has refused a request.
    pub fn refused(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Kind::Refused, code, message)
    }

    /// The command line, a name or a value is wrong.
    pub fn usage(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Kind::Usage, code, message)
    }

    /// There is no answer in time.
    pub fn silent(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Kind::Silent, code, message)
    }

    /// The bus, the adapter or a file failed.
    pub fn bus(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Kind::Bus, code, message)
    }

    /// The user pressed Ctrl-C.
    pub fn stopped(message: impl Into<String>) -> Self {
        Self::new(Kind::Stopped, "stopped", message)
    }

    fn new(kind: Kind, code: &'static str, message: impl Into<String>) -> Self {
        Self {
            kind,
            code,
            message: message.into(),
            has_document: false,
            questions: Vec::new(),
        }
    }

    /// The page must answer one of these questions, and give the request again.
    pub fn asks(questions: Vec<Question>) -> Self {
        let texts: Vec<String> = questions.iter().map(Question::to_string).collect();
        Self {
            questions,
            ..Self::usage("asks", texts.join("\n"))
        }
    }

    /// The same after the document of the command was printed.
    pub fn after_document(self) -> Self {
        Self {
            has_document: true,
            ..self
        }
    }

    /// The document that `--json` prints.
    pub fn json(&self) -> Value {
        let mut error = json!({"code": self.code, "message": self.message});
        if !self.questions.is_empty() {
            error["questions"] = json!(self.questions);
        }
        json!({"error": error})
    }
}
